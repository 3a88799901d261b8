"""Panel flutter: theory without a grid, modes and limit cycles of a motion, and short runs on a coarse grid."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import message, solve

pytest.importorskip("scipy")

from fsipetsc.analysis.flutter_motion import Motion, crossing, fit_modes, limit_cycle
from fsipetsc.analysis.flutter_theory import Flow, panel, von_karman
from fsipetsc.errors import ComputationError

#: a thick and light panel on a coarse grid: a second or two each
COARSE = "-fsi_h 0.0625 -panel_thickness 0.1 -panel_height 0.5 -flutter_machs 2"


def test_modes_of_a_clamped_panel():
    """cos b cosh b = 1 for b^2 the frequency; Timoshenko's go there as the panel gets thin, and are lower."""
    thin = panel().squares[:4] ** 0.25
    assert np.abs(np.cos(thin) - 1 / np.cosh(thin)).max() < 1e-9
    assert np.abs(panel(1e-3).squares[:3] ** 0.25 / thin[:3] - 1).max() < 1e-4
    assert np.all(panel(0.04).squares[:4] < 0.98 * panel().squares[:4])


def test_the_known_onset_of_flutter():
    """636.57, with frequency 52.4 (Dowell 1975), whatever the mass; all theories agree for a heavy panel, in slow motion."""
    for mass in (1.0, 1e3):
        found, s = Flow(2.0, mass).critical("undamped")
        assert abs(found - 636.57) < 0.01
        assert abs(s.imag / Flow(2.0, mass).unit(found) - 52.36) < 0.05
    heavy = Flow(2.0, 1e4)
    assert abs(heavy.critical()[0] - 636.57) < 0.1 and abs(heavy.critical("potential")[0] - 636.57) < 0.1
    assert heavy.critical("potential")[0] < Flow(2.0, 10.0).critical("potential")[0] < 645


def test_the_potential_theory_is_quasi_steady_in_slow_motion():
    """Their difference is of second order in the frequency: a tenth of it for ten times the mass, relative to the frequency."""
    gaps = []
    for mass in (100.0, 1000.0):
        flow = Flow(2.0, mass)
        s = flow.potential(500.0)
        gaps.append(min(abs(s - flow.quasi_steady(500.0)[:2])) / flow.unit(500.0))
    assert gaps[0] < 0.05 and gaps[1] < 0.15 * gaps[0]
    with pytest.raises(ComputationError, match="no flutter between lambda = 100 and 200"):
        Flow(2.0, 10.0).critical(between=(100.0, 200.0))


def motion(s, a, t, noise=0.0):
    """Of two modes with the shapes sin(pi x), sin(2 pi x), and a mean that stays."""
    x = np.linspace(0, 1, 17)
    shapes = np.array([np.sin(np.pi * x) + 0.2j * np.sin(2 * np.pi * x), np.sin(2 * np.pi * x)]) * np.array(a)[:, None]
    e = np.exp(np.outer(t, s))
    random = np.random.default_rng(1).standard_normal((2, len(t), len(x)))
    return Motion(t, (e @ shapes).real + 1e-3 + noise * random[0], ((e * s) @ shapes).real + noise * random[1])


def test_two_modes_of_nearly_one_frequency_are_told_apart():
    """In a period and a quarter; with noise of 1e-4 to 1e-2."""
    s = np.array([-0.04 + 1.0j, 0.02 + 1.05j])
    for noise, most in ((0.0, 1e-9), (1e-4, 2e-3)):
        found, misfit = fit_modes(motion(s, (1.0, 0.5), np.arange(0, 8, 0.1), noise))
        assert np.abs(found[:2] - s).max() < most
        assert misfit < 1e-9 + 10 * noise


def test_what_does_not_oscillate_has_no_modes():
    t = np.arange(0, 5, 0.1)
    still = np.outer(np.exp(-0.1 * t), np.ones(9))
    with pytest.raises(ComputationError, match="0 modes oscillate"):
        fit_modes(Motion(t, still, -0.1 * still))


def test_the_crossing_from_a_few_dynamic_pressures():
    """Of the theory's own modes: their growth has a kink near 636, but what is interpolated is smooth."""
    flow = Flow(2.0, 10.0)
    dynamic = (500.0, 600.0, 700.0, 800.0)
    units = [flow.unit(d) for d in dynamic]
    pairs = [flow.quasi_steady(d)[:2] for d in dynamic]
    found, s = crossing(dynamic, units, pairs)
    exact, expected = flow.critical()
    assert abs(found - exact) < 3.0 and abs(s.imag * flow.unit(found) - expected.imag) < 0.01
    assert np.isnan(crossing(dynamic[:2], units[:2], pairs[:2])[0])


def test_a_limit_cycle_is_measured():
    t = np.arange(0, 20, 0.05)
    wave = 0.3 + 2.0 * np.sin(2 * np.pi * 0.31 * t) + 0.1 * np.sin(6 * np.pi * 0.31 * t)
    X = np.linspace(0, 1, 5)
    shape = np.array([0, 0.5, 0.8, 1.0, 0])
    found = limit_cycle(Motion(t, np.outer(wave, shape), np.outer(wave, shape)), X)
    assert found.X == 0.75 and found.periods == 5
    assert found.frequency == pytest.approx(0.31, rel=1e-4)
    assert found.amplitude == pytest.approx(1.9, rel=2e-3) and found.mean == pytest.approx(0.3, abs=5e-3)
    assert found.spread < 2e-3
    with pytest.raises(ComputationError, match="0 periods"):
        limit_cycle(Motion(t[:40], np.outer(wave, shape)[:40], np.outer(wave, shape)[:40]), X)


def test_a_stretched_panel_has_a_limit_cycle():
    """Amplitude over thickness grows as sqrt(lambda / lambda_c - 1), whatever the thickness."""
    flow = Flow(2.0, 10.0)
    at = {d: limit_cycle(*von_karman(flow, d, 0.02, 200, 300)) for d in (700.0, 760.0)}
    assert all(cycle.spread < 1e-3 for cycle in at.values())
    onset = flow.critical()[0]
    expected = np.sqrt((760 - onset) / (700 - onset))
    assert at[760.0].amplitude / at[700.0].amplitude == pytest.approx(expected, rel=0.05)
    thicker = limit_cycle(*von_karman(flow, 700.0, 0.04, 200, 300))
    assert thicker.amplitude == pytest.approx(2 * at[700.0].amplitude, rel=1e-3)


@pytest.mark.mpi
def test_runs_decay_below_and_grow_above(tmp_path):
    """On two ranks, which share the runs; a thick panel, whose onset the theory has with shear and rotary inertia."""
    words = f"flutter {COARSE} -flutter_lambdas 350,430,650 -fsi_output some.csv".split()
    done = solve(*words, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    assert "onset of flutter" in done.stdout and (tmp_path / "some.png").stat().st_size > 10_000
    with (tmp_path / "some.csv").open() as file:
        runs = [{name: float(value) for name, value in row.items() if value} for row in csv.DictReader(file)]
    flow = Flow(2.0, 10.0, 0.1)
    assert [row["lambda"] for row in runs] == [350, 430, 650]
    assert runs[0]["growth"] < 0 < runs[2]["growth"]
    for row in runs[:2]:  # before they meet
        expected = [flow.potential(row["lambda"], start=s) for s in flow.quasi_steady(row["lambda"])[:2]]
        found = [complex(row[f"growth_{n}"], row[f"frequency_{n}"]) for n in (1, 2)]
        assert np.all(np.abs(np.subtract(found, expected)) < 0.05 * np.abs(expected)), (found, expected)
    assert abs(complex(runs[2]["growth"], runs[2]["frequency"]) - flow.potential(650.0)) < 0.05


def test_one_message_each(tmp_path):
    for words, said in {
        "-panel_lambda 700": "takes -flutter_lambdas, a list",
        "-flutter_machs 0.9": "Mach numbers above 1",
        "nothing.h5": "nothing.h5",
        "nothing.h5 -fsi_h 1": "one result file alone",
    }.items():
        done = solve("flutter", *words.split(), cwd=tmp_path)
        message(done, 4 if words == "nothing.h5" else 2, said)


def test_a_viscous_flow_over_the_panel_and_its_result(tmp_path):
    """Some steps; and a result too short for a limit cycle says so."""
    words = "panel -fsi_h 0.0625 -fluid_mu 0.01 -fsi_dissipation 0 -ts_max_time 0.05 -fsi_output_dt 0.01 -fsi_quiet"
    done = solve(*words.split(), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    message(solve("flutter", "panel.h5", cwd=tmp_path), 3, "periods of the panel's motion are seen")
