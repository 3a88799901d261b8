"""Runs from Python, what differs between two results, and results as xarray Datasets."""

from __future__ import annotations

import importlib
import re
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import REPOSITORY, mpirun, solve

import fsipetsc
from fsipetsc.output.differences import (
    _common,
    _of_layers,
    _of_series,
    compare,
    difference,
    table,
)

pytest.importorskip("petsc4py")

PROGRAM = """
import sys
import numpy as np
import fsipetsc
from fsipetsc.boundaries import Wall
from fsipetsc.errors import ComputationError, InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.problem import FluidLayer, Problem

gas = Fluid(0.01, 0.02, 1.4, 1.0)
state = lambda X: (1 + 0 * X, 0 * X, 1 + 0.01 * np.cos(np.pi * X))
layer = FluidLayer("gas", gas, (0.0, 1.0), state)
problem = Problem((layer,), left=Wall(0.0), right=Wall(1.0), units="none")
words = list(sys.argv)

first = fsipetsc.run("rod", h=0.1, max_steps=5, output="rod.h5")
assert first.case == "rod" and first.options["fsi_h"] == 0.1 and len(first.series["t"]) == 5
own = fsipetsc.run(problem, h=0.05, max_time=0.1, output="own.h5", output_times=[0.03, 0.1])
assert list(own.time) == [0.0, 0.03, 0.1] and own.complete
for case, options, said in (
    (problem, {"h": 0.05, "max_tim": 1.0}, "did you mean"),
    ("rood", {}, "did you mean 'rod'"),
    (3, {}, "a Problem"),
):
    try:
        fsipetsc.run(case, **options)
    except InputError as error:
        assert said in str(error), error
    else:
        raise AssertionError(said)
try:
    wrong = FluidLayer("gas", gas, (0.0, 1.0), lambda X: 1 / 0)
    fsipetsc.run(Problem((wrong,), Wall(0.0), Wall(1.0)), h=0.1, max_time=1)
except InputError as error:
    assert "ZeroDivisionError" in str(error), error
else:
    raise AssertionError("it cannot have gone well")
try:
    fsipetsc.run("rod", h=0.1, cfl=100.0, output="bad.h5")
except ComputationError as error:
    assert "t = " in str(error)
else:
    raise AssertionError("it cannot have gone well")
saved = {"checkpoint": "half.ck.h5", "checkpoint_steps": 3}
half = fsipetsc.run("rod", h=0.1, max_steps=3, output="half.h5", **saved)
on = fsipetsc.run("rod", restart="half.ck.h5", max_steps=5)
assert on.path == half.path and len(half.series["t"]) == 3
assert np.array_equal(on.series["t"], first.series["t"])
assert sys.argv == words
"""


@pytest.mark.mpi
def test_runs_from_python(tmp_path):
    """A case by name, a Problem, faults as exceptions; nothing is left behind, nothing printed;
    one rank and two.
    """
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    done = mpirun(2, program, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert done.stderr == ""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    changes = {"a": (), "same": (), "other": ("-rod_T0", 301.0)}
    for name, more in changes.items():
        words = "rod -fsi_h 0.1 -ts_max_steps 4 -fsi_quiet".split()
        done = solve(*words, *more, "-fsi_output", folder / f"{name}.h5")
        assert done.returncode == 0, done.stderr
    return folder


def test_what_differs(results):
    found = compare(results / "a.h5", results / "same.h5")
    assert found.equal and not found.options and len(found.differences) > 15
    assert table(found).endswith("are equal, bit for bit")
    found = compare(results / "a.h5", results / "other.h5")
    assert not found.equal and found.options == {"rod_T0": (300.0, 301.0)}
    largest = {one.name: one.largest for one in found.differences}
    assert largest["below: T"] == pytest.approx(1.0, rel=0.1)
    assert "option -rod_T0: 300.0 and 301.0" in table(found)
    done = solve("diff", results / "a.h5", results / "other.h5")
    assert done.returncode == 0 and "below: T" in done.stdout and "ulp" in done.stdout


def grid(kind: str, n: int):
    """A layer with a field X + 3 Y on n steps an axis; the line begins at another place on each
    grid.
    """
    if kind == "line":
        X = np.arange(-(n // 8), n + 1) / n
        values, more = np.where(X < 0, np.nan, X), {"X": X, "h": 1 / n}
    else:
        X, Y = np.arange(n + 1) / n, np.arange(n) / n  # periodic along Y
        places = np.stack(np.meshgrid(X, Y), axis=-1)
        values, more = places[..., 0] + 3 * places[..., 1], {"periodic": (False, True)}
        more["places"] = places
    more |= {"name": "gas", "fields": ("T",), "size": f"{values.size} points"}
    layer = type("Grid", (dict,), {**more, "shape": values.shape})
    return SimpleNamespace(layers=(layer(T=values[None]),))


@pytest.mark.parametrize("kind, common", [("line", "5"), ("block", "5 by 4")])
@pytest.mark.parametrize("fine", [8, 12])
def test_fields_of_two_grids_are_compared_at_common_nodes(kind, common, fine):
    """Equal there, and found where they are not: 1e-3 at the last node, which both have."""
    a, b = grid(kind, 4), grid(kind, fine)
    frames, notes = (np.zeros(1), np.zeros(1, int), np.zeros(1, int)), []
    (found,) = _of_layers(a, b, frames, notes)
    assert found.largest < 1e-15 and len(notes) == 1
    assert f"compared at the {common} common nodes" in notes[0]
    last = (0, -1) if kind == "line" else (0, 0, -1)
    b.layers[0]["T"][last] += 1e-3
    (found,) = _of_layers(a, b, frames, [])
    assert found.largest == pytest.approx(1e-3) and found.place.endswith(
        "point 4" if kind == "line" else "point 0, 4"
    )


def test_as_many_nodes_at_other_places_are_another_grid():
    a, b = grid("block", 4), grid("block", 4)
    frames, notes = (np.zeros(1), np.zeros(1, int), np.zeros(1, int)), []
    assert [found.largest for found in _of_layers(a, b, frames, notes)] == [0.0] and not notes
    b.layers[0].places = a.layers[0].places + 0.1
    assert not [*_of_layers(a, b, frames, notes)]
    assert "no node of one is a node of the other" in notes[0]


def test_what_other_steps_bring_is_compared_as_a_sum():
    """Energy at a constant rate, in two steps and in four."""
    made = ({"t": np.arange(1, n + 1) / n, "energy_in": np.full(n, 1 / n)} for n in (2, 4))
    a, b = (SimpleNamespace(series=series) for series in made)
    steps = _common(a.series["t"], b.series["t"], "steps", [])
    assert [(one.name, one.largest) for one in _of_series(a, b, steps, [])][1] == ("energy_in", 0.0)


def test_units_in_the_last_place():
    a = np.array([[1.0, np.nan, 2.0], [4.0, 0.0, 1e300]])
    b = a.copy()
    b[0, 2] = np.nextafter(np.nextafter(2.0, 3.0), 3.0)
    found = difference("", a, b, np.array([0.0, 0.5]))
    told = found.largest, found.ulp, found.scale, found.place
    assert told == (2 * np.spacing(2.0), 2.0, 1e300, "t = 0, point 2")
    b[1, 1] = np.nan
    assert difference("", a, b, np.array([0.0, 0.5])).largest == np.inf
    assert difference("", a, a, np.array([0.0, 0.5])).largest == 0.0


def test_xarray(results):
    pytest.importorskip("xarray")
    with fsipetsc.open_run(results / "a.h5") as run:
        data = run.to_xarray()
        assert data["below.T"].dims == ("time", "X_below") and data["below.T"].attrs["units"] == "K"
        assert np.array_equal(data["below.T"], run.layers[0]["T"], equal_nan=True)
        assert np.array_equal(data["rod.x"].sel(X_rod=1.5, method="nearest"), run.layers[1].x[:, 5])
        assert data["series.x_interface"].dims == ("step", "interface")
        assert np.array_equal(data["t"], run.series["t"]) and data["t"].attrs["units"] == "s"
        for name, variable in data.variables.items():
            assert variable.attrs.get("units") or variable.dtype.kind == "U", name


def test_what_is_public_is_there_and_told():
    """In dir(), with a docstring, and in docs/commands.md; asking for nothing costs no import."""
    page = (REPOSITORY / "docs" / "commands.md").read_text()
    assert sorted(fsipetsc.__all__) == sorted(dir(fsipetsc))
    assert len({*fsipetsc.__all__}) == len(fsipetsc.__all__)
    for name in fsipetsc.__all__:
        found = getattr(fsipetsc, name)
        assert f"`{name}`" in page or f"`{name}(" in page, name
        assert found is ... or isinstance(found, str) or found.__doc__, name
    for name in re.findall(r"^\| `(fsipetsc\.[\w.]+)`", page, re.M):
        assert importlib.import_module(name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'Walls'"):
        fsipetsc.Walls  # noqa: B018
