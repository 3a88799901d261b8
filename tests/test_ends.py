"""Open ends with data: the right number of conditions for every viscosity, conduction and Mach number."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import BECKER_SPACINGS, ORDERS, VISCOUS_ORDERS

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from paper_parts import filled, gas_record

from fsipetsc.analysis.spectra import CENTRAL
from fsipetsc.boundaries import DIRICHLET, degree_of
from fsipetsc.boundaries import Dirichlet as DirichletEnd
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.operators import OPERATORS
from fsipetsc.paper.laws import Gas

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


# The linearised scheme between two such ends, around a uniform flow with rho = c = T = h = 1.

N, NEAR, STEP = 24, 7, 1e-3
GAMMA = 1.4
R, CV = 1 / GAMMA, 1 / GAMMA / (GAMMA - 1)
MACHS = (-2.0, -0.95, -0.5, 0.1, 1.5)
DELTAS = (0.0, 0.3, 0.5, 0.8, 0.999)
#: cell Peclet numbers nu/(c h)
PECLETS = (0.01, 0.1, 0.6, 2.0, 10.0)


def derivatives(order: int, side: int, mach: float, delta: float) -> np.ndarray:
    """Of (rho, u, T) of the ghost point and (u, T) that the gradients see, (5, 3, NEAR), by the values from there inwards."""
    gas, base = Gas(PerfectGas(GAMMA, R), ConstantTransport(), 0.0, 0.0, GAMMA, 0.0), np.array([1.0, mach, 1.0])
    layer = gas_record(N, h=1.0)
    layer["end_kind"], layer["end_data"][:, :3] = DIRICHLET, base
    layer["end_degree"] = degree_of(DirichletEnd(0.0, lambda t: tuple(base)), order)
    result = np.zeros((5, 3, NEAR))
    for v in range(3):
        for k in range(NEAR):
            for number, weight in enumerate(CENTRAL, 1):
                for sign in (1, -1):
                    values = np.repeat(base[:, None], N, 1)
                    values[v, k] += sign * number * STEP
                    result[:, v, k] += sign * weight / STEP * np.concatenate(filled(gas, layer, side, delta, values))
    return result


def jacobian(order: int, mach: float, delta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Derivatives, (3 N, 3 N), of the rates of (rho, u, T): of convection, and of a friction and a conduction of 1."""
    D, O = OPERATORS[order].matrix(N), np.zeros((N, N))
    fill, seen = np.eye(3 * N), np.eye(3 * N)[N:].reshape(2, N, 3 * N).copy()
    for side in range(2):
        points = np.arange(NEAR) if side == 0 else N - 1 - np.arange(NEAR)
        rows, of_ghost = points[0] + N * np.arange(3), derivatives(order, side, mach, delta).reshape(5, -1)
        columns = (N * np.arange(3)[:, None] + points).ravel()
        fill[rows], seen[:, points[0]] = 0.0, 0.0
        fill[np.ix_(rows, columns)], seen[:, points[0], columns] = of_ghost[:3], of_ghost[3:]
    A = np.block([[mach * D, D, O], [R * D, mach * D, R * D], [O, R / CV * D, mach * D]])
    nothing = np.zeros((N, 3 * N))
    friction = fill @ np.vstack([nothing, D @ D @ seen[0], nothing])
    return -fill @ A @ fill, friction, fill @ np.vstack([nothing, nothing, D @ D @ seen[1]])


@pytest.mark.long
@EVERY_ORDER
def test_no_mode_grows(order):
    """And the classical Runge-Kutta method is stable with the step that the solver takes at Courant number 0.8."""
    for mach in MACHS:
        for delta in DELTAS:
            inviscid, friction, conduction = jacobian(order, mach, delta)
            gases = [(mu * nu, kappa * nu) for nu in PECLETS for mu, kappa in ((1, 1), (1, 0), (0, 1))]
            for mu, kappa in [(0.0, 0.0), *gases]:
                values = np.linalg.eigvals(inviscid + mu * friction + kappa * conduction)
                grows = order > 4 and delta > 0.85  # slowly, as dirichlet.py says; a boundary that moves passes by
                assert values.real.max() < (1.0 / N if grows else 1e-8), (mach, delta, mu, kappa)
                z = 0.8 * values / ((1 + abs(mach)) ** 4 + (2 * max(mu, kappa)) ** 4) ** 0.25
                amplified = np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max()
                assert amplified < 1 + (0.01 if grows else 1e-8), (mach, delta, mu, kappa)
