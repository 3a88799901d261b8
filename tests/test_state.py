"""What a completed step, the error control and the phases make of a state and of time, asked for
directly.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.cases import rod
from fsipetsc.options import defaults
from fsipetsc.paper.state import PaperState
from fsipetsc.scheme.plan import RATE

H, T0 = 0.1, 300.0


def at_rest(**options: float) -> PaperState:
    """The initial state of the rod's case, without gravity."""
    opt = {**defaults(rod), "fsi_h": H, "rod_gravity": 0.0, **options}
    state = PaperState(MPI.COMM_SELF, rod.build(opt), opt)
    state.set_initial()
    return state


def test_the_rate_is_the_4_norm_of_convection_and_diffusion():
    """Where both are about equal, at a gas's wall, the larger one alone would let a step be a
    fifth too long.
    """
    with at_rest() as state:
        gas = state.problem.layers[0].material
        rho, sound = (
            state.layers[0].of(state.solution.getArray(readonly=True))[-1, 0],
            np.sqrt(gas.gamma * gas.R * T0),
        )
    convection = sound / H
    for share in (0.1, 1.0, 3.0):
        mu = 0.75 * share * convection * rho * H**2 / 2
        with at_rest(fluid_mu=mu) as state:
            diffusion = 2 * (4 / 3 * mu) / rho / H**2
            assert diffusion == pytest.approx(share * convection)
            assert state.results[RATE] == pytest.approx(
                (convection**4 + diffusion**4) ** 0.25, rel=1e-9
            )
