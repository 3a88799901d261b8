"""The cases of bodies in a flow: balances, ranks, what holds a corner; the disk that spins."""

from functools import cache

import numpy as np
import pytest
from helpers import assert_same_fields, computed, kept

#: in 30 steps waves come to the bodies, and from them to blocks further on
RUNS = {
    "step": "step -fsi_h 0.04 -ts_max_steps 30",
    "fin": "fin -fsi_h 0.005 -ts_max_steps 30",
    "cylinder": "cylinder -fsi_h 0.1 -solid_density 1 -ts_max_steps 30",
    "disk": "disk -fsi_h 0.1 -ts_max_time 0.3 -fsi_output_dt 0.3",
}


@pytest.fixture(scope="module")
def bodies(tmp_path_factory):
    """bodies(name, ranks): a result, held to balances of mass, momentum and energy."""
    folder = tmp_path_factory.mktemp("bodies")

    @cache
    def result(name, ranks=2):
        run = computed(folder, f"{name}{ranks}.h5", *RUNS[name].split(), ranks=ranks)
        return kept(run, 1e-12)

    return result


@pytest.mark.parametrize("ranks", [3, pytest.param(1, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", RUNS)
def test_ranks_make_no_difference_and_balances_close(bodies, name, ranks):
    assert_same_fields(bodies(name), bodies(name, ranks))


def test_what_hits_a_cylinder_is_the_same_above_and_below(bodies):
    series = bodies("cylinder").series
    assert np.abs(series["momentum_y"]).max() < 1e-12 * np.abs(series["momentum_x"]).max()


def test_a_quarter_turn_of_the_disk_makes_no_difference(bodies):
    """Each block is the one before it, turned; the disk has turned, widened and is round."""
    layers = {layer.name: layer for layer in bodies("disk").layers}
    for kind in ("disk", "gas"):
        x, y = (layers[f"{kind} right"][name][-1] for name in "xy")
        for quarter in ("top", "left", "bottom"):
            x, y = -y, x
            layer = layers[f"{kind} {quarter}"]
            assert np.abs(layer["x"][-1] - x).max() < 1e-12, layer.name
            assert np.abs(layer["y"][-1] - y).max() < 1e-12, layer.name
    right = layers["disk right"]
    edge = np.hypot(right["x"][-1], right["y"][-1])[:, -1]
    turned = np.arctan2(right["y"][-1], right["x"][-1])[:, -1].mean()
    assert edge.min() > 1.01 and np.ptp(edge) < 2e-4  # measured: 1.1e-4
    assert 0.23 < turned < 0.8 * 0.3  # slower than at first, for it widens
