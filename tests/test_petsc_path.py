"""The right-hand side of PETSc's own methods beside the fused one: the same numbers, by DMDA's
exchange.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers import mpirun

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.cases import load_case
from fsipetsc.options import defaults
from fsipetsc.paper.state import make_paper_state

#: half a step: a power of two, so that the product with a rate is exact
HALF = 2.0**-18


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("rod", {"fsi_order": 4, "fsi_coupling": "projection"}),
        ("rod", {"fsi_order": 8, "fsi_coupling": "energy", "solid_gruneisen": 0.2}),
        ("mms", {"fsi_order": 6, "fluid_mu": 0.1}),
        ("pulse", {"fsi_order": 2, "fsi_coupling": "traditional"}),
        ("pulse", {"fsi_viscous": "narrow", "fluid_mu": 0.5, "fluid_kappa": 0.7}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_both_make_the_same_rates(name, changed):
    """Of a state as a stage leaves it, before its conditions are applied: bit for bit, with
    forcing and given data, too.
    """
    case = load_case(name)
    opt = {**defaults(case), "fsi_h": 0.05, **changed}
    with make_paper_state(case.build(opt), opt, MPI.COMM_SELF) as state:
        state.set_initial()
        state.set_data(HALF)
        start = state.solution.getArray().copy()
        state._stage(0, 2 * HALF)
        stage = np.concatenate([layer.owned.ravel() for layer in state.layers])
        state._stage(1, 2 * HALF)
        fused = state.k.copy()
        kept, f = stage.copy(), np.full_like(stage, np.nan)
        state.right_hand_side(stage, f)
        assert np.array_equal(stage, kept), "the stage is PETSc's"
        assert np.array_equal(f, fused)
        for k in range(len(state.layout.grids)):
            rates, active = state.layout.local(k, f), state.active(k)
            assert np.abs(rates[active]).max() > 0
            assert not rates[: active.start].any() and not rates[active.stop :].any(), (
                "spare points stay as they are"
            )
        assert np.abs(start - stage).max() > 0


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
