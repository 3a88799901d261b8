"""Cases of the pages on channels, gravity and walls that move by a table, against theory."""

import numpy as np
import pytest
from helpers import REPOSITORY, compute, on_ranks
from scipy.interpolate import CubicSpline, PchipInterpolator

from fsipetsc import Piecewise
from fsipetsc.kernels.symbols import Record, derivatives, replay

RUNS = REPOSITORY / "runs"
CHANNEL, GRAVITY, MOVING = (
    str(RUNS / f"{name}.py") for name in ("channel", "gravity", "moving_wall")
)


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
    found = replay([place, velocity, rate], {now: at})
    for order, values in enumerate(found):
        np.testing.assert_allclose(values, known(at, order), rtol=1e-12, atol=1e-12)
    assert np.array_equal(found[0], made(at))
    assert np.allclose(made.derivative()(at), known(at, 1), rtol=1e-12, atol=1e-12)
    assert made(0.25) == made(np.array([0.25]))[0]


def pressure_error(run, A=0.1, P=0.01, p0=1e5):
    """Largest error of the pressure on the piston, of its greatest change: that of a simple wave"""
    gas, phase = run.layers[0], np.pi * run.time / P
    v = 4.0 * np.pi * A / P * np.sin(phase) ** 3 * np.cos(phase)
    exact = p0 * (1.0 + 0.2 * v / np.sqrt(1.4 * 287.0 * 300.0)) ** 7
    return np.abs(gas["p"][:, 0] - exact).max() / np.abs(exact - p0).max()


def test_a_wall_that_moves_by_a_table(tmp_path):
    """Splines come near the exact motion; lines are none: their velocity jumps."""
    runs = {f"spline{n}": (MOVING, f"-wall_samples {n}") for n in (13, 25, 101)}
    runs |= {way: (MOVING, f"-wall_way {way}") for way in ("exact", "pchip", "lines")}
    error = {name: pressure_error(run) for name, run in compute(1, tmp_path, runs).items()}
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


def test_a_floor_that_gets_its_weight_at_once(tmp_path):
    words = f"-options_file {RUNS}/gravity.opts"
    (run,) = compute(1, tmp_path, {"floor": (GRAVITY, words)}).values()
    top, t = run.series["x_interface"][:, 0], run.series["t"]
    assert top.min() == pytest.approx(-9.81 * 5e3**2 / 4e7, rel=1e-3)
    period = 4 * 5e3 / np.sqrt(4e7)
    back = np.abs(t - period) < 0.2  # where it falls freely
    bend, slope, _ = np.polyfit(t[back] - period, top[back], 2)
    assert abs(0.5 * slope / bend) < 1e-3 * period


def over_height(values):
    """The mean over Y of fields (ny, ...) in a channel of the height 1, order 4/2."""
    n = len(values)
    ends = np.array([17.0, 59.0, 43.0, 49.0]) / 48.0
    weights = np.concatenate([ends, np.ones(n - 8), ends[::-1]]) / (n - 1)
    return np.tensordot(weights, values, 1)


def alternating(p):
    """The part of a field that changes its sign from node to node along X: fourth differences."""
    return np.abs(np.diff(p, 4, axis=1)).max() / 16.0


def test_a_channel_with_ends(tmp_path):
    """The fall of the pressure in its middle; a profile at the inflow does not oscillate."""
    U, mu = 0.1, 0.005
    words = "-ts_max_time 40 -fsi_dissipation -1 -channel_inflow "
    runs = {name: (CHANNEL, words + name) for name in ("profile", "uniform", "slip", "given")}
    wrong = {}
    for name, run in compute(1, tmp_path, runs).items():
        entry, channel = run.blocks["entry"], run.blocks["channel"]
        middle = (channel.X > 1.99) & (channel.X < 3.01)
        rho, u, p = (channel[field][-1][:, middle] for field in ("rho", "u", "p"))
        wrong[name] = alternating(p) / U**2, alternating(entry["p"][-1]) / U**2
        if name == "profile":
            mean, total = over_height(u), over_height(p + rho * u * u)
            assert total[0] - total[-1] == pytest.approx(12.0 * mu * mean.mean(), rel=6e-3)
            exact = 6.0 * np.multiply.outer(channel.Y * (1.0 - channel.Y), mean)
            assert np.abs(u - exact).max() < 0.01 * U
    assert wrong["profile"][1] < 0.05 * wrong["uniform"][1] < 0.05
    assert all(wrong["profile"][0] < 0.5 * wrong[name][0] for name in ("uniform", "slip", "given"))
    assert wrong["slip"][1] < 0.2 * wrong["uniform"][1]
