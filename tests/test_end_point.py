"""The gas's point at an interface without conduction is a particle that keeps its entropy."""

from __future__ import annotations

import numpy as np
import pytest
from receding import gas

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.boundaries import Wall, free
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.kernels import BLOCK, scratch_size
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.solid import Solid
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
from fsipetsc.scheme.plan import SCRATCH
from fsipetsc.stepping.state import State

#: order -> (largest errors of rho and T on h = 0.00625, least order from 0.0125 on)
EXPECTED = {2: (4.6e-6, 3.7e-5, 1.85), 4: (3.3e-6, 3.9e-5, 1.8), 6: (3.3e-7, 3.7e-6, 2.5), 8: (7.1e-8, 7.9e-7, 3.1)}


def errors(run):
    """Largest errors of rho and T, away from the open end."""
    layer, t = run.layers[1], float(run.time[-1])
    inside = np.isfinite(layer["rho"][-1]) & (layer.X < 1.2)
    rho, _, T = gas(np.asarray(layer.X)[inside], t)
    return np.array([np.abs(layer["rho"][-1][inside] - rho).max(), np.abs(layer["T"][-1][inside] - T).max()])


@pytest.mark.parametrize("order", OPERATORS)
def test_receding_piston(computed, order):
    coarse, fine = (errors(computed("receding", f"order{order}_h{h}")) for h in (0.0125, 0.00625))
    *largest, least_order = EXPECTED[order]
    assert np.all(fine < largest), fine
    assert np.all(np.log2(coarse / fine) > least_order), (coarse, fine)


@pytest.mark.parametrize("order", OPERATORS)
def test_end_point_alone_in_a_block(order):
    """Its rate takes nothing that its block has not computed: what scratch held before, a NaN perhaps, does not count."""
    h = 0.01
    X = (-BLOCK * h, 0.0)
    layers = (
        FluidLayer("gas", Fluid(0.01, 0.0, 1.4, 1.0), X, lambda X: (1 + 0.1 * np.sin(X), 0.1 * X, 1 + 0.1 * np.cos(X))),
        SolidLayer("rod", Solid(1.0, 0.0, 1.0, 1.0), (0.0, 20 * h), lambda X: (0 * X, 0 * X, 1 + 0 * X, X)),
    )
    problem, rates = Problem(layers=layers, left=Wall(X[0]), right=free(), units="none"), []
    with State(MPI.COMM_SELF, problem, order, h, "energy", "rigid", "auto", 0) as state:
        state.set_initial()
        for held in (0.0, np.nan):
            y = state.solution.getArray(readonly=True)
            state.plan.part("scratch", scratch_size(SCRATCH))[:] = held
            rates.append(np.empty_like(y))
            state.right_hand_side(y, rates[-1])
    assert np.array_equal(*rates)
