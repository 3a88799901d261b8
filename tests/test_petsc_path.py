"""The right-hand side of PETSc's own methods beside the fused one: the same numbers, by DMDA's
exchange.
"""

from __future__ import annotations

import re

import pytest
from helpers import mpirun

pytest.importorskip("petsc4py")




@pytest.mark.mpi
def test_the_log_shows_what_petsc_does(tmp_path):
    """An exchange for each layer and right-hand side among the events of the time loop, and the
    sums of PETSc's method.
    """
    line = "rod -fsi_h 0.1 -ts_max_steps 20 -ts_type rk -fsi_partition physics -fsi_output_dt 1 "
    line += "-log_view -ts_view"
    done = mpirun(2, "-m", "fsipetsc", *line.split(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    loop = re.split(
        r"Event Stage \d: ",
        done.stdout[re.search(r"Event Stage \d: time loop", done.stdout).end() :],
    )[0]
    counts = {
        words[0]: int(words[1])
        for words in map(str.split, loop.splitlines())
        if len(words) > 10 and words[1].isdigit()
    }
    assert counts["TSStep"] == 20 and counts["TSFunctionEval"] == 80
    assert counts["VecScatterBegin"] == 2 * (80 + 20), "rank 0 has both gases; steps are completed"
    assert counts["VecMAXPY"] >= 80
    for words in ("RK type 4", "maximum steps=20", "maximum time=3", "RHS function evaluations=80"):
        assert words in done.stdout, "what -ts_view says"
