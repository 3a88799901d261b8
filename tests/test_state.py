"""What a completed step, the error control and the phases make of a state and of time, asked for
directly.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.boundaries import Open, free
from fsipetsc.cases import rod
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import defaults
from fsipetsc.paper.state import PaperState
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
from fsipetsc.scheme.plan import RATE

H, T0 = 0.1, 300.0


def at_rest(**options: float) -> PaperState:
    """The initial state of the rod's case, without gravity."""
    opt = {**defaults(rod), "rod_gravity": 0.0, **options}
    state = PaperState(MPI.COMM_SELF, rod.build(opt), 4, H, "projection", "auto", 16)
    state.set_initial()
    return state


def test_the_rate_is_the_4_norm_of_convection_and_diffusion():
    """Where both are about equal, at a gas's wall, the larger one alone would let a step be a
    fifth too long.
    """
    with at_rest() as state:
        gas = state.problem.layers[0].material
        rho, sound = (
            state.layout.local(0, state.solution.getArray(readonly=True))[-1, 0],
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


@pytest.mark.parametrize("gruneisen", [0.0, 0.4])
@pytest.mark.parametrize("side", [0, 1])
def test_the_force_of_a_solids_end(gruneisen, side):
    """What pushes at the ends is what the momentum's integral takes for the force, with a pressure
    in the solid and without.
    """
    gas, bar = Fluid(0.0, 0.0, 1.4, 287.0), Solid(1e6, 0.0, 5.0, 800.0, gruneisen=gruneisen)

    def squeezed(X: np.ndarray) -> list[np.ndarray]:
        x_X, T = 0.8, 310.0
        stress = bar.pressure(T, x_X) - 1e5
        return [np.zeros(X.shape), np.full(X.shape, stress), np.full(X.shape, T), x_X * X]

    def still(X: np.ndarray) -> list[np.ndarray]:
        return [np.full(X.shape, value) for value in (1e5 / (gas.R * T0), 0.0, T0)]

    if side == 0:
        layers = (
            SolidLayer("bar", bar, (-2.0, 0.0), squeezed),
            FluidLayer("gas", gas, (0.0, 2.0), still),
        )
        problem = Problem(layers, free(-1.2e5), Open(2.0, 1e5, T0))
    else:
        layers = (
            FluidLayer("gas", gas, (-2.0, 0.0), still),
            SolidLayer("bar", bar, (0.0, 2.0), squeezed),
        )
        problem = Problem(layers, Open(-2.0, 1e5, T0), free(-1.2e5))
    with PaperState(MPI.COMM_SELF, problem, 4, H, "projection", "auto", 16) as state:
        state.set_initial()
        push = 1.2e5 - 1e5
        assert float(state.latest["force"]) == pytest.approx(push if side == 0 else -push, rel=1e-9)
