"""Fused steps in two dimensions against the classical Runge-Kutta method written out, with the rates of PETSc's methods."""

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.boundaries.plane import Clamped, NoSlip, Open, Outflow, Slip
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem, PlaneSolid, PlaneSolidLayer
from fsipetsc.stepping.plane.state import PlaneState

STEPS, DT = 3, 2e-3


def sticking(X, Y):
    return 1 + 0.1 * np.sin(2 * np.pi * X + Y), 0.2 * Y * (1 - Y), 0.1 * np.sin(2 * np.pi * X), 1 + 0.1 * Y


def periodic(slips):
    """gas | solid, between a wall and where the solid is clamped."""
    gas = Fluid(0.0, 0.0, 1.4, 1.0) if slips else Fluid(0.02, 0.03, 1.4, 1.0)
    solid = PlaneSolid(1.0, 2.0, 0.05, 2.0, 1.5, p_ref=1.0)
    layers = (
        PlaneFluidLayer("gas", gas, (0.0, 1.0), sticking),
        PlaneSolidLayer("solid", solid, (1.0, 2.0), lambda X, Y: (0 * X, 0.1 * np.sin(2 * np.pi * X), 1 + 0 * X, X, Y)),
    )
    return PlaneProblem(layers, (0.0, 1.0), NoSlip(T=1.1) if not slips else Slip(), Clamped(), units="none")


def panel():
    """A flow over a panel in a wall."""
    gas, solid = Fluid(0.0, 0.0, 1.4, 1.0), PlaneSolid(5.0, 10.0, 0.0, 3.0, 1.0, p_ref=1.0, heat="elastic")
    outside = Open(1.0, 2.5, 0.0, 1.0)
    layers = (
        PlaneSolidLayer(
            *("panel", solid, (-0.5, 0.0), lambda X, Y: (0 * X, 0.1 * np.sin(np.pi * X), 1 + 0 * X, X, Y)),
            **{"X": (0.0, 1.0), "left": Clamped(), "right": Clamped()},
        ),
        PlaneFluidLayer(
            *("gas", gas, (0.0, 1.0), lambda X, Y: (1 + 0 * X, 2.5 + 0 * X, 0 * X, 1 + 0 * X)),
            **{"left": outside, "right": Outflow(), "beside": Slip()},
        ),
    )
    return PlaneProblem(layers, (-0.5, 1.5), Clamped(), outside, units="none")


def classical(state, y, dt):
    """A step of y, completed."""
    path, k, total = state.path, np.empty_like(y), y.copy()
    stage = y
    for a, b in ((0.5, 1 / 6), (0.5, 1 / 3), (1.0, 1 / 3), (0.0, 1 / 6)):
        path.rates(stage, k, 0.0)
        total, stage = total + b * dt * k, y + a * dt * k
    path.project(total, 0.0)
    return total


@pytest.mark.parametrize("problem", [periodic(False), periodic(True), panel()], ids=["sticks", "slips", "panel"])
def test_a_fused_step_is_the_classical_method(problem):
    with PlaneState(MPI.COMM_SELF, problem, 4, 1 / 12) as state:
        state.set_initial()
        state.finish()
        expected = state.solution.getArray().copy()
        for _ in range(STEPS):
            expected = classical(state, expected, DT)
        state.set_initial()
        state.finish()
        before = state.solution.getArray().copy()
        for step in range(STEPS):
            state.step(step * DT, DT, True)
        found = state.solution.getArray()
        assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
        assert np.abs(found - before).max() > 1e-3  # or it would be no test
        assert state.evaluations == 4 * STEPS
