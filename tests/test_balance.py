"""The ledgers of a run: mass, momentum, energy, entropy; and -fsi_check, which holds a run to them."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import mpirun, run

import fsipetsc
from fsipetsc.cases import box
from fsipetsc.stepping.balance import drifts


def ledger(path):
    """Name -> relative drift of each invariant of a result."""
    result = fsipetsc.open_run(path)
    series = {name: result.series[name] for name in result.series}
    initial = {k.removeprefix("initial_"): v for k, v in result.summary.items() if k.startswith("initial_")}
    return drifts(result.header["laws"], initial, series)


@pytest.mark.mpi
def test_box_keeps_all_balances(tmp_path):
    options = ("-fsi_order", "6", "-fsi_h", "0.025", "-fsi_check", "1e-4", "-fsi_quiet")
    done = mpirun(2, "-m", "fsipetsc", "box", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = ledger(tmp_path / "box.h5")
    assert set(found) == {"mass of 'left'", "mass of 'right'", "momentum", "energy", "entropy"}
    assert np.abs(found["energy"]).max() < 1e-5
    assert np.abs(found["momentum"]).max() < 1e-3
    assert found["entropy"].max() < 1e-9


def test_rod_momentum_is_the_impulse_of_gravity_and_ends(tmp_path):
    options = ("-fsi_h", "0.05", "-ts_max_time", "0.2", "-fsi_quiet")
    done = run("-m", "fsipetsc", "rod", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = ledger(tmp_path / "rod.h5")
    assert set(found) == {"mass of 'below'", "momentum"}  # the upper end is open
    assert np.abs(found["momentum"]).max() < 1e-4
    result = fsipetsc.open_run(tmp_path / "rod.h5")
    assert np.abs(result.series["momentum"]).max() > 1000  # of a rod of 2700 kg/m2 that falls


def test_check_stops_what_does_not_hold(tmp_path):
    options = ("-fsi_h", "0.05", "-ts_max_time", "0.3", "-fsi_check", "1e-7", "-fsi_quiet")
    done = run("-m", "fsipetsc", "rod", *options, cwd=tmp_path)
    assert done.returncode == 3
    assert "mass of 'below' has drifted" in done.stderr and "Traceback" not in done.stderr
    assert len(fsipetsc.open_run(tmp_path / "rod.h5").series["t"]) > 0


@pytest.mark.mpi
@pytest.mark.parametrize("n", [1, 2])
def test_check_holds_while_grids_grow(tmp_path, n):
    """The steps between the last frame and the growth are looked at before others take their place."""
    options = ("-fsi_h", "0.05", "-ts_max_time", "0.3", "-fsi_output_dt", "0.005", "-fsi_check", "1e-2", "-fsi_spare", "0")
    done = mpirun(n, "-m", "fsipetsc", "rod", *options, "-fsi_quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert len({len(layer.X) for layer in result.layers}) > 1 and result.complete


def test_entropy_must_not_decrease():
    """A series whose entropy falls short of the heating is found."""
    problem = box.build({option.name: option.default for option in box.OPTIONS} | dict(box.DEFAULTS))
    n = 10
    series = {name: np.zeros(n) for name in ("momentum", "force", "heating")}
    series |= {"dt": np.full(n, 0.1), "mass": np.ones((n, 2)), "energy": np.ones(n), "entropy": np.linspace(1.01, 1.1, n)}
    initial = {"mass": [1.0, 1.0], "momentum": 0.0, "force": 0.0, "energy": 1.0, "entropy": 1.0, "heating": 0.0}
    assert drifts(problem.laws, initial, series)["entropy"].max() == 0
    series["entropy"][5:] -= 0.2
    assert drifts(problem.laws, initial, series)["entropy"].max() == pytest.approx(0.19)
