"""A case before it runs: the command geometry, and -fsi_check without a value."""

import os
import re

import numpy as np
import pytest
from helpers import computed, run, solve, well


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
