"""Open ends with data: the right number of conditions for every viscosity, conduction and Mach number."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import BECKER_SPACINGS, ORDERS, VISCOUS_ORDERS

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from numba import njit
from paper_parts import conserved, gas_record, operator_of

from fsipetsc.analysis.stability_linear import CENTRAL
from fsipetsc.boundaries import DIRICHLET, INTERFACE_END, degree_of
from fsipetsc.boundaries import Dirichlet as DirichletEnd
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.paper import rates as loops
from fsipetsc.paper.ends import fill_ghost
from fsipetsc.paper.laws import Gas
from fsipetsc.paper.rates import gas_rates

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)


def rate(coarse, fine) -> float:
    return float(np.log2(coarse.errors["fluid"]["combined"] / fine.errors["fluid"]["combined"]))


@EVERY_ORDER
def test_becker(computed, order):
    """A viscous shock with supersonic inflow: imposing only what comes in below the speed of sound, T < 0 ends it."""
    coarse, fine = (computed("becker", f"order{order}_h{h}_M1.5") for h in BECKER_SPACINGS)
    assert rate(coarse, fine) >= {2: 1.9, 4: 3.8, 6: 5.5, 8: 6.9}[order]


@pytest.mark.parametrize(("order", "gas"), [(order, gas) for gas, orders in VISCOUS_ORDERS.items() for order in orders])
def test_orders_with_resolved_viscosity(computed, order, gas):
    coarse, fine = (computed("viscous", f"order{order}_h{h}_{gas}") for h in (0.05, 0.025))
    assert rate(coarse, fine) >= {2: 1.7, 4: 2.7, 6: 4.0, 8: 3.8}[order]


# The linearised scheme between two such ends, around a uniform flow with rho = c = T = h = 1, by the solver's own code.

N, STEP = 24, 1e-3
GAMMA = 1.4
NAVIER_STOKES = LAWS[0]
GAS = Fluid(0.0, 0.0, GAMMA, 1 / GAMMA)
MACHS = (-2.0, -0.95, -0.5, 0.1, 1.5)
DELTAS = (0.0, 0.3, 0.5, 0.8, 0.999)
#: cell Peclet numbers nu/(c h)
PECLETS = (0.01, 0.1, 0.6, 2.0, 10.0)


@njit(error_model="numpy")
def all_rates(layers, ops, delta, states, rates, memory, nodes):
    """rates[m] of (rho, rho u, e), (3, N), at the primitive states[m], their ghost points filled."""
    layer, op = layers[0], ops[0]
    for m in range(len(states)):
        q = states[m]
        for side in range(2):
            for k in range(NODES):
                nodes[:3, k] = q[:, k if side == 0 else N - 1 - k]
            fill_ghost(NAVIER_STOKES, layer, op, side, delta, nodes, False)
            q[:, 0 if side == 0 else N - 1] = nodes[:3, 0]
        for i in range(N):
            memory[8 + i], memory[8 + N + i] = q[0, i], q[0, i] * q[1, i]
            memory[8 + 2 * N + i] = q[0, i] * (layer.cv * q[2, i] + 0.5 * q[1, i] ** 2)
        memory[8 + 6 * N : 8 + 9 * N] = 0.0
        target = Target(8, 8 + 3 * N, 8 + 6 * N, 8 + 6 * N, -1, N, 0.0, 1.0, 1.0)
        sweep(NAVIER_STOKES, layer, op, memory, 8, 8 + 9 * N, target, 0, N)
        rates[m] = memory[8 + 6 * N : 8 + 9 * N].reshape((3, N))


def jacobian(order: int, mach: float, delta: float, mu: float, kappa: float) -> np.ndarray:
    """Derivative, (3 N, 3 N), of the rates of (rho, u, T) with respect to them."""
    layers, base = np.zeros(1, LAYER), np.array([1.0, mach, 1.0])
    layers["J"] = 1.0
    layer = layers[0]
    layer["n"], layer["hi"], layer["own_hi"], layer["h"], layer["stride"] = N, N - 1, N, 1.0, N
    layer["gamma"], layer["R"], layer["cv"], layer["mu"], layer["kappa"] = GAMMA, GAS.R, GAS.cv, mu, kappa
    layer["end_kind"], layer["end_apart"], layer["end_data"][:, :3] = DIRICHLET, 1, base
    layer["end_degree"] = degree_of(DirichletEnd(0.0, lambda t: tuple(base)), order)
    multiples = np.array([-4, -3, -2, -1, 1, 2, 3, 4]) * STEP
    states = np.repeat(base, N) + multiples[:, None, None] * np.eye(3 * N)
    rates = np.empty((len(multiples) * 3 * N, 3, N))
    memory = np.zeros(8 + 9 * N + scratch_size(16))
    all_rates(layers, np.array([packed(order)]), delta, states.reshape(-1, 3, N), rates, memory, np.zeros((5, NODES)))
    r, m, e = np.moveaxis(rates, 1, 0)  # rates at a uniform state are zero, so that this is linear, too
    u = m - mach * r
    T = (e - (GAS.cv + 0.5 * mach**2) * r - mach * u) / GAS.cv
    f = np.concatenate([r, u, T], axis=1).reshape(len(multiples), 3 * N, 3 * N)
    return np.tensordot(CENTRAL, f[4:] - f[3::-1], 1).T / STEP


@pytest.mark.long
@EVERY_ORDER
def test_no_mode_grows(order):
    """And the classical Runge-Kutta method is stable with the step that the solver takes at Courant number 0.8."""
    for mach in MACHS:
        for delta in DELTAS:
            inviscid = jacobian(order, mach, delta, 0.0, 0.0)
            friction = jacobian(order, mach, delta, 1.0, 0.0) - inviscid
            conduction = jacobian(order, mach, delta, 0.0, GAS.cv) - inviscid
            gases = [(mu * nu, kappa * nu) for nu in PECLETS for mu, kappa in ((1, 1), (1, 0), (0, 1))]
            for mu, kappa in [(0.0, 0.0), *gases]:
                values = np.linalg.eigvals(inviscid + mu * friction + kappa * conduction)
                grows = order > 4 and delta > 0.85  # slowly, as dirichlet.py says; a boundary that moves passes by
                assert values.real.max() < (1.0 / N if grows else 1e-8), (mach, delta, mu, kappa)
                z = 0.8 * values / ((1 + abs(mach)) ** 4 + (2 * max(mu, kappa)) ** 4) ** 0.25
                amplified = np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max()
                assert amplified < 1 + (0.01 if grows else 1e-8), (mach, delta, mu, kappa)
