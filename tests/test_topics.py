"""Cases of the pages on channels, gravity and walls that move by a table, against theory."""

import numpy as np
import pytest
from helpers import REPOSITORY, compute, computed, on_ranks
from scipy.interpolate import CubicSpline, PchipInterpolator

from fsipetsc import Piecewise
from fsipetsc.kernels.symbols import Record, derivatives, replay

RUNS = REPOSITORY / "runs"
GRAVITY, MOVING = (str(RUNS / f"{name}.py") for name in ("gravity", "moving_wall"))


@pytest.mark.parametrize("kind", [CubicSpline, PchipInterpolator])
def test_piecewise_is_the_interpolant_of_scipy(kind):
    """Called and recorded, with its first two derivatives; at the points, too."""
    t = np.linspace(0.0, 1.0, 12) ** 2
    known = kind(t, np.sin(3.0 * t))
    made, at = Piecewise(known), np.append(t, np.linspace(0.0, 1.0, 101))
    record = Record()
    now = record.given("t")
    place = made(now)
    (velocity,) = derivatives([place], now)
    (rate,) = derivatives([velocity], now)
    found = replay([place, velocity, rate])({now: at})
    for order, values in enumerate(found):
        np.testing.assert_allclose(values, known(at, order), rtol=1e-12, atol=1e-12)
    assert np.array_equal(found[0], made(at))
    assert np.allclose(made.derivative()(at), known(at, 1), rtol=1e-12, atol=1e-12)
    assert made(0.25) == made(np.array([0.25]))[0]


def test_a_wall_that_moves_by_a_table(tmp_path):
    """Splines come near the exact motion; lines are none: their velocity jumps."""
    runs = {f"spline{n}": (MOVING, f"-wall_samples {n}") for n in (13, 25, 101)}
    runs |= {way: (MOVING, f"-wall_way {way}") for way in ("exact", "pchip", "lines")}
    error, A, P, p0 = {}, 0.1, 0.01, 1e5
    for name, run in compute(1, tmp_path, runs).items():
        phase = np.pi * run.time / P
        v = 4.0 * np.pi * A / P * np.sin(phase) ** 3 * np.cos(phase)
        exact = p0 * (1.0 + 0.2 * v / np.sqrt(1.4 * 287.0 * 300.0)) ** 7  # of a simple wave
        error[name] = np.abs(run.layers[0]["p"][:, 0] - exact).max() / np.abs(exact - p0).max()
    assert error["exact"] < 3e-5 and error["spline101"] < 3e-5
    assert 0.05 < error["spline25"] / error["spline13"] < 0.2 and error["spline25"] < 1e-3
    assert error["spline25"] < 0.1 * error["pchip"] and error["pchip"] < 0.6 * error["lines"]


def test_air_on_a_floor_stays_at_rest(tmp_path):
    run = on_ranks(tmp_path, f"{GRAVITY} -gravity_wave 0 -fsi_h 500 -ts_max_time 9", 1, 2)
    assert all(np.abs(layer["u"]).max() < 1e-11 for layer in run.layers)


def test_a_wave_of_air_under_gravity(tmp_path):
    """Lamb's: errors fall with the third order; without gravity the period would be another one."""
    runs = {f"{h}": (GRAVITY, f"-fsi_h {h}") for h in (500, 250)}
    coarse, fine = (run.errors["fluid"]["u"] for run in compute(1, tmp_path, runs).values())
    assert fine < 5e-5 and coarse > 6.0 * fine


def test_a_flow_over_a_ramp(tmp_path):
    """Pressures are those of theory; wall heating and over-expansion as on finer grids."""
    run = computed(tmp_path, "a.h5", RUNS / "ramp.py", "-ramp_wall", "rigid", "-fsi_h", 0.0625)
    p_2, T_2, p_3 = 1.7065786, 1.1701513, 1.0026427
    on, behind = (run.blocks[f"gas {k}"] for k in (1, 2))
    middle = (on.X[0] > 0.5) & (on.X[0] < 0.9)
    p, T, p_behind = 1.4 * on["p"][-1], on["T"][-1], 1.4 * behind["p"][-1, 0]
    assert p[0, middle].mean() == pytest.approx(p_2, rel=2e-3)
    assert T[0, middle].mean() / T_2 - 1.0 == pytest.approx(0.0095, abs=0.001)
    assert T[3, middle].mean() == pytest.approx(T_2, rel=5e-3)
    assert p_behind.min() / p_3 - 1.0 == pytest.approx(-0.064, abs=0.002)
    assert p_behind[8:].mean() == pytest.approx(p_3, rel=0.01)
