"""A case before it runs: the command geometry, and -fsi_check without a value."""

import os
import re

import numpy as np
import pytest
from helpers import computed, run, solve, well

from fsipetsc import Fluid

AIR = Fluid(0.0, 0.0, 1.4, 287.0)


def still(*X):
    return 1.0, *(0.0 for _ in X), 300.0


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
