"""Cases in one dimension: the rod of Sec. 5.2, the sound pulse, pistons."""

import numpy as np
import pytest
from helpers import computed, kept, solve, well

import fsipetsc
from fsipetsc.cases import load_case

# the rod: positions and balances, and that nothing grows

P0, T0, R = 1e5, 300.0, 8.3145 / 0.029
PAPER = "-fsi_coupling projection"


@pytest.mark.parametrize("order", [4, 8])
def test_to_the_third_bounce(order, tmp_path):
    words = f"rod {PAPER} -fsi_h 0.025 -fsi_order {order} -fsi_output_dt 0.1 -ts_max_time 3"
    run = computed(tmp_path, "rod.h5", *words.split())
    t, x = run.series["t"], run.series["x_interface"]
    assert run.complete and run.time[-1] == t[-1] == 3.0
    # converged positions, where the lowest point of the fall is nearly reached
    np.testing.assert_allclose(x[t == 0.4], [(0.72872, 1.49300)], rtol=0, atol=2e-4)
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


# the pulse against linear acoustics: what is reflected, what goes through, what leaves

AMPLITUDE = 0.01
#: where the pulse starts, in the gas or in the solid -> time at which both waves are inside
INSIDE = {0.75: 0.0035, -0.75: 0.003}
STARTS = pytest.mark.parametrize("start", INSIDE, ids=["from the fluid", "from the solid"])
#: density and modulus; the wave speed is 500 m/s in all. The gas: 1.16 kg/m3, 347 m/s
SOLIDS = {"light": (1.0, 2.5e5), "middle": (4.0, 1e6), "heavy": (4e4, 1e10)}


def pulsed(folder, start, end, words=""):
    line = f"pulse -pulse_amplitude {AMPLITUDE} -fsi_output_dt 1 -pulse_start {start} {words}"
    return computed(folder, "pulse.h5", *line.split(), "-ts_max_time", end)


@STARTS
@pytest.mark.parametrize("solid", SOLIDS)
def test_reflection_and_transmission(start, solid, tmp_path):
    """To a part in a thousand of what comes in."""
    words = "-fsi_order 6 -solid_density {} -solid_modulus {}".format(*SOLIDS[solid])
    run = pulsed(tmp_path, start, INSIDE[start], words)
    given = load_case("pulse").build(run.options).layers
    gas, m0 = given[1].material, given[0].material.m0
    of_gas = P0 / (gas.R * T0) * gas.sound_speed(T0)  # impedances; the solid's speed is 500 m/s
    Z1, Z2 = (of_gas, 500 * m0)[:: 1 if start > 0 else -1]
    for saved, layer, name, sign in zip(run.layers, given, ("sigma", "p"), (-1, 1), strict=True):
        exact = layer.exact(saved.X, run.time[-1])
        shape = exact[1] + P0 if name == "sigma" else exact[0] * gas.R * exact[2] - P0
        active = np.isfinite(saved[name][-1])
        wave, shape = saved[name][-1][active] - sign * P0, shape[active]
        if np.abs(shape).max() < 1e-3 * AMPLITUDE:
            assert np.abs(wave).max() < 2e-3 * AMPLITUDE
        else:
            first = (saved.kind == "fluid") == (start > 0)
            part = (Z2 - Z1) / (Z2 + Z1) if first else 2 * Z2 / (Z1 + Z2)
            assert np.abs(shape).max() == pytest.approx(abs(part) * AMPLITUDE, rel=5e-3)
            assert abs(wave @ shape / (shape @ shape) - 1) * abs(part) < 1e-3


@STARTS
def test_waves_leave_through_the_ends(start, tmp_path):
    solid, gas = pulsed(tmp_path, start, 0.01).layers
    assert np.abs(solid["sigma"][-1] + 1e5).max() < 0.01 * AMPLITUDE
    assert np.nanmax(np.abs(gas["p"][-1] - 1e5)) < 0.01 * AMPLITUDE
    counts = [np.isfinite(gas["p"][k]).sum() for k in (0, -1)]
    assert abs(counts[1] - counts[0]) <= 2 < counts[0], "points come and go with the gas's ends"


def test_the_piston_compresses_the_gas_adiabatically(tmp_path):
    """So slowly, before so heavy a layer, that p V^gamma stays; the energy grows by the work."""
    words = "piston -fsi_h 0.025 -fluid_mu 0 -fluid_kappa 0 -piston_time 0.1 -ts_max_time 0.1"
    run = computed(tmp_path, "piston.h5", *words.split(), "-solid_density", 1e8)
    mass = run.series["mass"] / np.array(run.summary["initial_mass"])
    assert np.abs(mass - 1).max() < 1e-14
    length = run.series["x_interface"][-1, 0] - 0.3
    assert run.layers[0]["p"][-1].mean() == pytest.approx(1e5 * length**-1.4, rel=2e-3)
    gained = run.series["energy"][-1] - run.summary["initial_energy"]
    assert gained == pytest.approx(1e5 / 0.4 * (length**-0.4 - 1), rel=1e-2)
    came, wall = run.series["energy_face"].sum(axis=0), "driven, axis 0, side 0"
    round_off = 1e-13 * run.series["energy"].max()  # of 6e12 J, that of the heavy layer
    assert dict(zip(run.faces, came, strict=True))[wall] == pytest.approx(gained, abs=round_off)
    assert np.count_nonzero(came) == 1 and not run.series["heat_face"].any()


def test_box_keeps_all_that_must_not_change(tmp_path):
    done = well(solve("box", "-fsi_order", 6, "-fsi_h", 0.025, cwd=tmp_path, ranks=2))
    for begin in ("interfaces ", "bound ", "departures ", "result in ", "next: "):
        assert f"\n{begin}" in done.stdout
    result = fsipetsc.open_run(tmp_path / "box.h5")
    held = set(kept(result, 1e-13).summary["departures"])
    assert held == {"mass of 'left'", "mass of 'right'", "momentum along x", "energy"}
