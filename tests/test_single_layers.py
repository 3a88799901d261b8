"""A gas or a solid alone, in any form of the equations: there is no interface, and nothing asks for one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, solve

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

import fsipetsc

LAYERS = str(REPOSITORY / "tests" / "layers.py")
ENTROPY, *OTHERS = "-fsi_convection entropy", "-fsi_dissipation 1 -fsi_shock 1"
LONG = [(kind, options) for kind in "gs" for options in OTHERS]  # kernels that no other test needs


@pytest.mark.parametrize(("kind", "options"), [("g", ENTROPY), *(pytest.param(*one, marks=pytest.mark.long) for one in LONG)])
def test_it_runs_and_keeps_mass_and_energy(kind, options, tmp_path):
    words = *options.split(), "-layers", kind, "-fsi_h", "0.025", "-ts_max_time", "0.3", "-fsi_output", "alone.h5", "-fsi_quiet"
    done = solve(LAYERS, *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "alone.h5") as result:
        assert result.complete
        for name in ("mass", "energy"):
            values = result.series.get(name)
            if values is not None and values.size:
                assert np.abs(values / values[0] - 1).max() < 1e-8, name
