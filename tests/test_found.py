"""Right values of problems that once gave wrong ones (found.py)."""

import found
import numpy as np
import pytest
from helpers import computed, solve, well

import fsipetsc


@pytest.mark.parametrize("what", ["two gases", "air and water", "rest"])
def test_what_is_at_rest_stays(what, tmp_path):
    """Each gas has its own temperature; no energy is lost and nothing is noted."""
    words = "-found_what", what, "-ts_max_steps", 60, "-fsi_output", "rest.h5"
    assert "note: " not in well(solve(found.__file__, *words, cwd=tmp_path)).stdout
    with fsipetsc.open_run(tmp_path / "rest.h5") as run:
        for layer in run.layers:
            last = layer.frame(-1)
            assert np.abs(last["T"] - 300.0).max() < 1e-8 and np.abs(last["u"]).max() < 1e-8
        assert run.summary.get("lost_energy", 0.0) == 0.0


@pytest.mark.parametrize("law", ["log", "svk"])
def test_a_sound_loses_nothing_in_steel(law, tmp_path):
    words = "-found_what", "sound", "-found_law", law, "-ts_max_time", 4e-4
    run = computed(tmp_path, "a.h5", found.__file__, *words)
    assert 0.0 <= run.summary["lost_energy"] < 1e-6


@pytest.mark.parametrize("k", [1, 2])
def test_noh(k, tmp_path):
    """The shock goes out with 1/3; what is beside the centre is too warm."""
    words = "-found_what", "noh", "-found_k", k, "-fsi_shock", 1, "-fsi_dissipation", 1
    run = computed(tmp_path, "a.h5", found.__file__, *words, "-ts_max_time", 0.6)
    gas = run.layers[0]
    behind = (gas.X > 0.1) & (gas.X < 0.16)
    assert gas["rho"][-1][behind] == pytest.approx(4.0 ** (k + 1), rel=0.1)
    jump = np.interp(-0.5 * 4.0 ** (k + 1), -gas["rho"][-1][gas.X > 0.1], gas.X[gas.X > 0.1])
    assert jump == pytest.approx(0.2, abs=0.02)


def test_a_burst_in_a_liquid_is_no_shock(tmp_path):
    """Of 1e6 Pa, beside p_inf = 6e8 Pa."""
    words = "-found_what", "burst", "-ts_max_steps", 2, "-fsi_h", 0.05
    assert "changes by" not in well(solve(found.__file__, *words, cwd=tmp_path)).stdout
