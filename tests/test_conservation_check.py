"""The integrals of a run: mass, momentum, energy, entropy; and -fsi_check, which holds a run to
them.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers import REPOSITORY, run, solve

import fsipetsc
from fsipetsc.scheme.conservation_check import Drifts, drifts
from fsipetsc.stepping.integrator import CHECKED
from fsipetsc.stepping.ledgers import Ledgers


def largest_drifts(path):
    """Name -> relative drift of each invariant of a result."""
    result = fsipetsc.open_run(path)
    series = {name: result.series[name] for name in result.series}
    initial = {
        k.removeprefix("initial_"): v for k, v in result.summary.items() if k.startswith("initial_")
    }
    return drifts(result.header["laws"], initial, series)


@pytest.mark.mpi
def test_box_keeps_all_that_must_not_change(tmp_path):
    options = ("-fsi_order", "6", "-fsi_h", "0.025", "-fsi_check", "1e-4", "-fsi_quiet")
    done = solve("box", *options, cwd=tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
    found = largest_drifts(tmp_path / "box.h5")
    assert set(found) == {"mass of 'left'", "mass of 'right'", "momentum along x", "energy"}
    assert max(np.abs(drift).max() for drift in found.values()) < 1e-13


def test_check_stops_what_does_not_hold(tmp_path):
    options = ("-fsi_h", "0.05", "-ts_max_time", "0.3", "-fsi_check", "1e-7", "-fsi_quiet")
    done = solve("rod", *options, cwd=tmp_path)
    assert done.returncode == 3
    assert "mass of 'below' has drifted" in done.stderr and "Traceback" not in done.stderr
    assert len(fsipetsc.open_run(tmp_path / "rod.h5").series["t"]) > 0


def test_a_check_of_nothing_is_bad_input(tmp_path):
    done = solve("mms", "-fsi_h", "0.1", "-fsi_check", "1e-7", "-fsi_quiet", cwd=tmp_path)
    assert done.returncode == 2 and "-fsi_check: nothing is conserved here" in done.stderr


@pytest.mark.parametrize("lost", [0.0, 0.5])
def test_check_sees_the_loss_of_the_momentum_of_a_small_wave(lost, tmp_path):
    """Of 1e-5, half of whose force on an interface is left out of the right-hand side."""
    case = REPOSITORY / "tests" / "small_wave.py"
    words = "-ts_type rk -ts_rk_type 4 -fsi_check 1e-9 -fsi_quiet -wave_lost".split()
    done = run("-m", "fsipetsc", case, *words, lost, cwd=tmp_path)  # it changes a class
    assert done.returncode == (3 if lost else 0), done.stderr
    assert ("momentum along x has drifted" in done.stderr) == (lost > 0.0)


INVARIANTS = {
    **{"masses": [["left", [0]], ["right", [1]]], "momentum": "x", "energy": True, "entropy": True},
    **{"inertia": 1.0, "heat_capacity": 1.0},
}
#: columns of records beside the masses
NAMES = "t", "dt", "momentum_x", "impulse_x", "energy", "energy_in", "entropy"


def test_entropy_must_not_decrease():
    """A series whose entropy falls is found."""
    n = 10
    series = {"dt": np.full(n, 0.1), "energy": np.ones(n)}
    series["entropy"] = 19 + np.linspace(1.01, 1.1, n)
    only = {"masses": [], "energy": True, "entropy": True, "heat_capacity": 1.0}
    initial = {"energy": 1.0, "entropy": 20.0}
    assert drifts(only, initial, series)["entropy"].max() == 0
    series["entropy"][5:] -= 0.2
    assert drifts(only, initial, series)["entropy"].max() == pytest.approx(0.19 / 20)


def recorded(n: int) -> tuple[np.ndarray, dict[str, object]]:
    """Records of n steps with numbers that mean nothing, and what there was before."""
    rng = np.random.default_rng(0)
    masses = [(name, "f8", (2,)) for name in ("mass", "mass_in")]
    steps = np.zeros(n, [*((name, "f8") for name in NAMES), *masses])
    for name in steps.dtype.names:
        steps[name] = 1.0 + 0.1 * rng.random(steps[name].shape)
    steps["t"] = np.cumsum(steps["dt"])
    return steps, {name: 1.0 for name in NAMES} | {"mass": [1.0, 1.0]}


def test_drifts_piece_by_piece_are_those_of_the_whole():
    steps, initial = recorded(1000)
    whole, pieced = drifts(INVARIANTS, initial, as_dict(steps)), Drifts(INVARIANTS, initial)
    pieces = [pieced.go_on(as_dict(piece)) for piece in np.split(steps, [1, 2, 300, 300, 999])]
    assert len(whole) == 5
    for name, values in whole.items():
        assert np.array_equal(np.concatenate([piece[name] for piece in pieces if piece]), values), (
            name
        )


@pytest.mark.filterwarnings("error")
def test_a_departure_that_is_no_number_is_said_and_stays():
    steps, initial = recorded(9)
    steps["energy"][3], steps["momentum_x"][3], steps["mass"][3, 0] = np.nan, np.inf, -np.inf
    steps["impulse_x"][3], steps["mass_in"] = np.inf, 0.0
    ledgers = Ledgers(INVARIANTS)
    ledgers.begin(initial)
    for step in range(9):
        ledgers.add(steps[step : step + 1])
    found = ledgers.departures
    assert (
        np.isnan(found["energy"])
        and np.isnan(found["momentum along x"])
        and found["mass of 'left'"] == np.inf
    )
    assert 0 < found["mass of 'right'"] < 1


def as_dict(steps: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of records."""
    return {name: steps[name] for name in steps.dtype.names}


def begun(tolerance: float, initial: dict[str, object]) -> Ledgers:
    ledgers = Ledgers(INVARIANTS, tolerance)
    ledgers.begin(initial)
    return ledgers


def test_the_first_step_at_fault_is_named():
    steps, initial = recorded(100)
    for name in (*NAMES[2:], "mass", "mass_in"):
        steps[name] = 0.0 if name.endswith("_in") or name == "impulse_x" else 1.0
    ledgers, loose = begun(1e-3, initial), begun(0.1, initial)
    ledgers.add(steps[:60])
    assert ledgers.fault is None
    steps["mass"][80:, 1], steps["energy"][90:] = 1.01, np.nan
    ledgers.add(steps[60:])
    when = f"t = {steps['t'][80]:.6g} s, step 81"
    assert ledgers.fault == f"mass of 'right' has drifted by 0.01 (relative) at {when}"
    loose.add(steps)
    assert "energy has drifted by nan" in loose.fault
    again = begun(1e-3, initial)
    again.recall(ledgers.memory(), initial)
    assert again.departures.keys() == ledgers.departures.keys()


def test_check_stops_near_the_fault(tmp_path):
    line = "box -fsi_coupling energy -fsi_mapping rigid -fsi_check 1e-8 -fsi_quiet"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 3
    t, step = re.search(
        r"has drifted by .* at t = ([0-9.e-]+), step (\d+)", done.stderr
    ).groups()  # without a unit
    with fsipetsc.open_run(tmp_path / "box.h5") as result:
        assert result.series["t"][int(step) - 1] == pytest.approx(float(t), rel=1e-5)
        assert result.summary["steps"] <= int(step) + CHECKED + 64
        assert result.summary["t"] < 0.5 * result.options["ts_max_time"]
