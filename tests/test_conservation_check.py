"""The integrals of a run, and -fsi_check, which holds a run to them."""

import re

import numpy as np
import pytest
from helpers import message, solve

import fsipetsc
from fsipetsc.scheme.conservation_check import Drifts
from fsipetsc.stepping.integrator import CHECKED
from fsipetsc.stepping.soundness import Ledgers


def test_box_keeps_all_that_must_not_change(tmp_path):
    options = ("-fsi_order", "6", "-fsi_h", "0.025", "-fsi_check", "1e-4")
    done = solve("box", *options, cwd=tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
    for begin in ("interfaces ", "step bounded by ", "conserved ", "result in ", "next: "):
        assert f"\n{begin}" in done.stdout
    result = fsipetsc.open_run(tmp_path / "box.h5")
    series = {name: result.series[name] for name in result.series}
    initial = {key.removeprefix("initial_"): value for key, value in result.summary.items()}
    found = Drifts(result.header["laws"], initial).go_on(series)
    assert set(found) == {"mass of 'left'", "mass of 'right'", "momentum along x", "energy"}
    assert np.max([np.abs(drift).max() for drift in found.values()]) < 1e-13


def test_check_stops_near_the_fault(tmp_path):
    line = "box -fsi_coupling energy -fsi_mapping rigid -fsi_check 1e-8 -fsi_quiet"
    said = message(solve(*line.split(), cwd=tmp_path), 3)
    t, step = re.search(r"has drifted by .* at t = ([0-9.e-]+), step (\d+)", said).groups()
    with fsipetsc.open_run(tmp_path / "box.h5") as result:
        assert result.series["t"][int(step) - 1] == pytest.approx(float(t), rel=1e-5)
        assert result.summary["steps"] <= int(step) + CHECKED + 64
        assert result.summary["t"] < 0.5 * result.options["ts_max_time"]


INVARIANTS = {
    **{"masses": [["left", [0]], ["right", [1]]], "momentum": "x", "energy": True, "entropy": True},
    **{"inertia": 1.0, "heat_capacity": 1.0},
}
#: columns of records beside the masses
NAMES = "t", "dt", "momentum_x", "impulse_x", "energy", "energy_in", "entropy"
INITIAL = {name: 1.0 for name in NAMES} | {"mass": [1.0, 1.0]}


def recorded(n):
    masses = [(name, "f8", (2,)) for name in ("mass", "mass_in")]
    steps = np.zeros(n, [*((name, "f8") for name in NAMES), *masses])
    for name in steps.dtype.names:
        steps[name] = 0.0 if "_in" in name or "impulse" in name else 1.0
    steps["t"] = np.cumsum(steps["dt"])
    return steps


def drift(name, steps, **initial):
    columns = {column: steps[column] for column in steps.dtype.names}
    return Drifts(INVARIANTS, INITIAL | initial).go_on(columns)[name]


@pytest.mark.filterwarnings("error")
def test_the_first_step_at_fault_is_named():
    """As well after a restart; what is no number stays one."""
    steps, ledgers, again = recorded(100), Ledgers(INVARIANTS, 1e-3), Ledgers(INVARIANTS, 1e-3)
    loose = Ledgers(INVARIANTS, 0.1)
    ledgers.begin(INITIAL)
    loose.begin(INITIAL)
    ledgers.add(steps[:60])
    assert ledgers.fault is None
    again.begin(INITIAL, ledgers.memory())
    steps["mass"][80:, 1], steps["energy"][90], steps["momentum_x"][95] = 1.01, np.nan, -np.inf
    for one in (ledgers, again):
        one.add(steps[60:])
        when = f"t = {steps['t'][80]:.6g} s, step 81"
        assert one.fault == f"mass of 'right' has drifted by 0.01 (relative) at {when}"
    for step in range(100):
        loose.add(steps[step : step + 1])
    assert "energy has drifted by nan" in loose.fault
    assert np.isnan(loose.departures["energy"])
    assert loose.departures["momentum along x"] == np.inf
