"""The case disk, whose blocks meet in threes: integrals, symmetry, on any ranks the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import computed

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

QUARTERS = "right", "top", "left", "bottom"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """On one rank and on two."""
    folder = tmp_path_factory.mktemp("disk")
    words = "disk -fsi_h 0.1 -ts_max_time 0.3 -fsi_output_dt 0.3".split()
    return [computed(folder, f"{n}.h5", *words, ranks=n) for n in (1, 2)]


def test_ranks_make_no_difference(results):
    one, two = results
    for a, b in zip(one.layers, two.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)


def test_a_quarter_turn_makes_no_difference(results):
    """Each block beside the middle is the one before it, turned; the disk has turned, widened and is round."""
    layers = {layer.name: layer for layer in results[0].layers}
    for kind in ("disk", "gas"):
        x, y = (layers[f"{kind} right"][name][-1] for name in "xy")
        for quarter in QUARTERS[1:]:
            x, y = -y, x
            layer = layers[f"{kind} {quarter}"]
            assert np.abs(layer["x"][-1] - x).max() < 1e-12, layer.name
            assert np.abs(layer["y"][-1] - y).max() < 1e-12, layer.name
    right = layers["disk right"]
    edge = np.hypot(right["x"][-1], right["y"][-1])[:, -1]
    turned = np.arctan2(right["y"][-1], right["x"][-1])[edge.size // 2, -1]
    assert edge.min() > 1.01 and np.ptp(edge) < ROUND
    assert turned == pytest.approx(0.8 * 0.3, abs=0.01)


#: measured; the sum of what a grid of 8 cells a block makes of a circle
ROUND = 1e-3


def test_integrals_stay(results):
    series = results[0].series
    for name in ("mass", "energy"):
        assert np.abs(series[name] / series[name][0] - 1.0).max() < 1e-14, name
    for axis in "xy":
        change = series[f"momentum_{axis}"] - series[f"momentum_{axis}"][0]
        came = np.cumsum(series[f"impulse_{axis}"])
        assert np.abs(change - came).max() < 1e-13, axis
