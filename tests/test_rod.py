"""The rod of Sec. 5.2: positions and balances, and that nothing grows."""

import numpy as np
import pytest
from conftest import ORDERS
from helpers import computed

P0, T0, R = 1e5, 300.0, 8.3145 / 0.029
#: converged positions of the two interfaces at t = 0.4: lowest point of the fall nearly reached
CONVERGED = 0.72872, 1.49300


@pytest.mark.parametrize("order", [4, 8])
def test_to_the_third_bounce(order, tmp_path):
    """To t = 3 at h = 0.025."""
    words = f"rod -fsi_h 0.025 -fsi_order {order} -fsi_output_dt 0.1 -ts_max_time 3"
    run = computed(tmp_path, "rod.h5", *words.split())
    t, x = run.series["t"], run.series["x_interface"]
    assert run.complete and run.time[-1] == t[-1] == 3.0
    np.testing.assert_allclose(x[t == 0.4], [CONVERGED], rtol=0, atol=2e-4)
    assert 0.72 < x[:, 0].min() < 0.721
    assert x[t > 0.5, 0].max() < 0.98, "a bounce does not come back higher"
    length = x[:, 1] - x[:, 0]
    assert 0.74 < length.min() < 0.76 and length.max() < 1.002
    u = np.abs(run.series["u_interface"])
    cycles = [u[(a <= t) & (t < a + 0.9)].max(axis=0) for a in (0.0, 0.9, 1.8)]
    assert np.all(cycles[1] < cycles[0]) and np.all(cycles[2] < 1.01 * cycles[1])
    below, rod, _ = run.layers
    for frame in range(1, run.nframes):
        inside = np.isfinite(below.x[frame])
        at_wall = np.interp(0.0, below.x[frame][inside], below["u"][frame][inside])
        assert abs(at_wall) < 5e-3, "no velocity at x = 0; the rod moves with 1.9 m/s"
        assert np.abs(np.diff(rod["u"][frame], 4)).max() < 0.03, "no short waves in the rod"
        assert np.abs(np.diff(below["p"][frame][inside], 2)).max() < 50.0, "Pa; it rises by 6e4"
    drift = {4: 1.5e-4, 8: 8e-4}[order]
    np.testing.assert_allclose(run.series["mass"][:, 0], P0 / (R * T0), rtol=drift)


@pytest.mark.parametrize("order", ORDERS)
def test_what_is_at_rest_stays_at_rest(order, tmp_path):
    """Without gravity 1,700 steps add no more than round-off."""
    words = f"rod -fsi_h 0.05 -fsi_order {order} -rod_gravity 0 -ts_max_time 0.2"
    run = computed(tmp_path, "rest.h5", *words.split())
    at_rest = {"fluid": {"rho": P0 / (R * T0), "T": T0, "p": P0}, "solid": {"T": T0, "sigma": -P0}}
    for layer in run.layers:
        for name, value in at_rest[layer.kind].items():
            last = layer[name][-1]
            np.testing.assert_allclose(last[np.isfinite(last)], value, rtol=1e-11)
        assert np.nanmax(np.abs(layer["u"][-1])) < 1e-8
    np.testing.assert_allclose(run.series["x_interface"][-1], [1.0, 2.0], rtol=1e-11)
