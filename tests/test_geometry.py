"""A case before it runs: the command geometry, and -fsi_check without a value."""

import os
import re

import numpy as np
import pytest
from helpers import computed, message, run, solve, well

from fsipetsc import Block, BlockProblem, Fluid, Wall
from fsipetsc.blocks.conditions import Free, NoSlip, Open, Periodic, Slip
from fsipetsc.blocks.maps import annulus, rectangle, stretched
from fsipetsc.cases import load_case
from fsipetsc.options import InForce, defaults
from fsipetsc.output.geometry_picture import condition_text, outlines

AIR = Fluid(0.0, 0.0, 1.4, 287.0)


def still(*X):
    return 1.0, *(0.0 for _ in X), 300.0


def test_spacing_is_that_of_the_map():
    """Around a ring chords, along its radius and along a stretched axis differences of the map."""
    ring = Block("ring", AIR, annulus(1.0, 2.0), (8, 60), still, periodic=(False, True))
    (one,) = outlines(BlockProblem((ring,), {("ring", 0, 0): Slip(), ("ring", 0, 1): Slip()}), 0.1)
    chord = 2.0 * np.sin(np.pi / 60)
    assert np.allclose(one.spacing, [(0.125, 0.125), (chord, 2.0 * chord)], rtol=1e-12)
    assert one.shape == (9, 60) and list(one.sides) == [(0, 0), (0, 1)]
    square = stretched(rectangle(0.0, 3.0), lambda s: s * s)
    line = Block("line", AIR, square, (100,), still)
    (one,) = outlines(BlockProblem((line,), {("line", 0, 0): Slip(), ("line", 0, 1): Slip()}), 0.1)
    assert np.allclose(one.spacing, [(3e-4, 3.0 * (1.0 - 0.99**2))], rtol=1e-9)


def test_edges_of_a_face_in_space():
    """The face x = 2 of a box: its four edges, each along one axis at an end of the other."""
    box = Block("box", AIR, rectangle((0, 0, 0), (2, 3, 4)), (30, 4, 50), still)
    faces = {("box", axis, side): Slip() for axis in range(3) for side in (0, 1)}
    (one,) = outlines(BlockProblem((box,), faces), 0.1)
    edges = {tuple(map(tuple, line[:, [0, -1]].T)) for line in one.edges(0, 1)}
    low, high, far, near = (2, 0, 0), (2, 3, 4), (2, 0, 4), (2, 3, 0)
    assert edges == {(low, near), (far, high), (low, far), (near, high)}


def test_what_stands_at_faces():
    """Interfaces, joins, faces that are periodic through conditions, and data of these."""
    case = load_case("panel")
    found = {one.name: one for one in outlines(case.build(InForce(defaults(case))), 0.1)}
    assert found["gas 2"].sides[1, 0] == ("interface", "interface with panel")
    assert found["gas 2"].sides[0, 1] == ("join", "join with gas 3")
    assert found["panel"].sides[0, 0] == ("condition", "Clamped()")
    block = Block("gas", AIR, rectangle(0.0, 1.0), (16,), still)
    ends = {("gas", 0, 0): Periodic((1.0,)), ("gas", 0, 1): Periodic((-1.0,))}
    (one,) = outlines(BlockProblem((block,), ends), 0.1)
    assert one.sides[0, 0] == ("condition", "periodic with gas")
    assert condition_text(NoSlip(T=lambda X, t: 300.0)) == "NoSlip(T=f)"
    assert condition_text(Open(1.5, (2.0, 0.0), 300.0)) == "Open(rho=1.5, u=(2, 0), T=300)"
    assert [condition_text(end) for end in (Free(), Wall(0.5))] == ["Free()", "Wall(x=0.5)"]


@pytest.mark.parametrize("coupling", ["projection", "conservative"])
def test_layers_are_those_that_run(coupling, tmp_path):
    """Places of nodes, where the spacing does not divide a gas, too; the first step of the run."""
    line = f"rod -fsi_coupling {coupling} -fsi_h 0.0625 -rod_top 3.03 -ts_max_steps 1"
    result = computed(tmp_path, "a.h5", *line.split())
    done = well(solve(*line.split(), "-fsi_check", cwd=tmp_path))
    told = re.findall(r"(?:gas|solid), (\d+) nodes\n +axis 0 +spacing ([\d.]+) m", done.stdout)
    grids = [layer.X[np.isfinite(layer.x[0])] for layer in result.layers]
    assert told == [(str(X.size), f"{(X[-1] - X[0]) / (X.size - 1):.4g}") for X in grids]
    assert f"first step: {result.series['dt'][0]:.3g} s, by sound in " in done.stdout
    assert os.listdir(tmp_path) == ["a.h5"]


def test_a_check_says_the_same_on_any_ranks(tmp_path):
    """In the place of a value in an options file, too, and without a word if that is wanted."""
    (tmp_path / "a.opts").write_text("-fsi_check 1e-9\n-fsi_h 0.05\n")
    line = "ring -options_file a.opts -fsi_check"
    runs = (solve(*line.split(), cwd=tmp_path, ranks=ranks).stdout for ranks in (1, 1, 2))
    _, one, two = runs  # the first one may compile, and says so
    assert one.replace("on 1 rank", "on 2 ranks") == two
    assert "inside    gas, 13 x 32 nodes\n" in one and one.endswith("not run\n"), one
    assert solve(*line.split(), "-fsi_quiet", cwd=tmp_path).stdout == ""
    assert os.listdir(tmp_path) == ["a.opts"]


CASE = """
import numpy as np
from fsipetsc import Block, BlockProblem, Fluid, Option
from fsipetsc.blocks.conditions import NoSlip
from fsipetsc.blocks.maps import rectangle
OPTIONS = (Option("wrong", int, 0, "", "what is wrong"),)
DEFAULTS = {"fsi_h": 0.1, "ts_max_time": 1.0}
def hot(X, Y, t):
    return 300.0 - 600.0 * X
def build(opt):
    def still(X, Y):
        return 1.0, 0.0, 0.0, -300.0 if opt["wrong"] == 1 else 300.0
    gas = Block("gas", Fluid(1e-3, 1e-3, 1.4, 287.0), rectangle((0, 0), (1, 1)), (12, 12), still)
    faces = {("gas", axis, side): NoSlip() for axis in (0, 1) for side in (0, 1)}
    if opt["wrong"] == 2:
        del faces["gas", 1, 1]
    if opt["wrong"] == 3:
        faces["gas", 1, 1] = NoSlip(T=hot)
    return BlockProblem((gas,), faces)
"""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-wrong 1", "initial of block 'gas': T = -300"),
        ("-wrong 2", "face (axis 1, side 1), about (X, Y) = (0.5, 1), has no condition"),
        ("-wrong 3", "T of NoSlip at t = 0: T = "),
        ("-fsi_order 8", "axis 0: "),
        ("-fsi_output_times 2", "-fsi_output_times: 2 s would not be reached"),
        ("-fsi_oder 4", "did you mean -fsi_order?"),
    ],
)
def test_a_check_ends_as_the_run_would(words, said, tmp_path):
    (tmp_path / "mine.py").write_text(CASE)
    for ranks, check in ((1, ["-fsi_check"]), (2, ["-fsi_check"]), (1, [])):
        done = solve("mine.py", *words.split(), *check, cwd=tmp_path, ranks=ranks)
        message(done, 2, said)
    assert os.listdir(tmp_path) == ["mine.py"]


def test_the_command_draws_and_compiles_nothing(tmp_path):
    """In one, two and three dimensions; a table, and a picture that is no blank page."""
    from matplotlib.image import imread

    nowhere = {"CC": "no-compiler", "FSIPETSC_CACHE": str(tmp_path / "cache")}
    for line in ("rod -o a/rod.png", "nozzle", "box_mms -box_dimension 3"):
        done = well(run("-m", "fsipetsc", "geometry", *line.split(), cwd=tmp_path, env=nowhere))
        *_, summary, last = done.stdout.splitlines()
        path = re.fullmatch(r"picture in (\S+\.png)", last)[1]
        assert re.match(r"all +[\d,]+ nodes, spacing ", summary)
        picture = imread(tmp_path / path)[..., :3].reshape(-1, 3)
        assert len(np.unique(picture.round(1), axis=0)) > 20
    assert sorted(os.listdir(tmp_path)) == ["a", "box_mms-geometry.png", "nozzle-geometry.png"]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        ("", 2, "geometry: CASE is missing: python -m fsipetsc geometry CASE"),
        ("rod -o rod.txt", 2, "bad value 'rod.txt' for -o: expected a name with .png or"),
        ("rod -fsi_h 0.03", 2, "-fsi_h 0.03 misses an interface"),
        ("rod -o /proc/rod.png", 4, "/proc/rod.png: cannot write the picture"),
    ],
)
def test_what_the_command_cannot_do(words, status, said, tmp_path):
    message(solve("geometry", *words.split(), cwd=tmp_path, ranks=2), status, said)
