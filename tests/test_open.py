"""The open end of a gas: its conditions against the modes of the equations, and that nothing grows beside it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

pytest.importorskip("numba")

from paper_parts import filled as fill
from paper_parts import gas_record
from scipy.linalg import eig

from fsipetsc.analysis.spectra import CENTRAL
from fsipetsc.boundaries import OPEN, Open
from fsipetsc.errors import InputError
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, remainder
from fsipetsc.paper.laws import Gas

ORDERS = pytest.mark.parametrize("order", OPERATORS)

# rho = c = T = 1
GAMMA = 1.4
R, CV = 1 / GAMMA, 1 / GAMMA / (GAMMA - 1)
CP = GAMMA * CV
PRESSURE = np.array([R, 0.0, R])
SIDES = pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])


def gas_layer(mach: float, mu: float, kappa: float, order: int, n: int = 24, h: float = 1.0):
    """(gas, layer of it) between open ends, beyond which it flows with ``mach``; mu is 4/3 of the shear viscosity."""
    layer = gas_record(n, h=h)
    layer["end_kind"], layer["end_data"] = OPEN, Open(0.0, R, 1.0, mach, order).data(0.0)
    return Gas(PerfectGas(GAMMA, R), ConstantTransport(), mu, kappa, GAMMA, 0.0), layer


def filled(layer, side: int, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(rho, u, T) of the ghost point and (u, T) that the gradients see there, from values (3, nodes), the ghost point first."""
    return fill(*layer, side, 0.3, values)


def decaying_mode(mach: float, mu: float, kappa: float, s: complex, speed: float) -> tuple[complex, np.ndarray]:
    """(lambda, values of rho, u, T) of the solution e^(st + lambda x) of the linearised equations that moves with ``speed``."""
    A = np.array([[mach, 1, 0], [R, mach, R], [0, R / CV, mach]])
    B = np.diag([0, mu, kappa / CV])
    # (s + lambda A - lambda^2 B) U = 0 as a pencil for (U, lambda U)
    I, O = np.eye(3), np.zeros((3, 3))
    left, right = np.block([[O, I], [s * I, A]]), np.block([[I, O], [O, B]])
    values, vectors = eig(left, right)
    at = np.argmin(np.abs(np.where(np.isfinite(values), values, np.inf) + s / speed))
    return values[at], vectors[:3, at]


def misfit(mach: float, nu: float, order: int, speed: float, prandtl: float, side: int) -> tuple[float, float]:
    """(pressure of what comes in, error of the gradient of T in the heat flux) for a mode of frequency 1, relative to it.

    The pressure is what the gas beyond would have to differ by to make the same change.
    """
    s, h = 1j, 1e-4
    kappa = nu * CP / prandtl
    a, U = decaying_mode(mach, 4 / 3 * nu, kappa, s, speed)
    U = U / (PRESSURE @ U if speed > mach else U[2] - PRESSURE @ U / CP)
    n, amplitude, errors = 2 * side - 1, 1e-7, []
    # a layer so wide that q_nn = 0 is not faded out
    layer = gas_layer(n * mach, 4 / 3 * nu, kappa, order, n=10**7, h=h)
    for phase in (1, 1j):
        wave = amplitude * np.real(phase * U[:, None] * np.exp(a * -h * np.arange(4)))
        before = np.array([1.0, mach, 1.0])[:, None] + wave
        ghost, seen = filled(layer, side, before * np.array([[1], [n], [1]]))
        layer[1]["end_data"][side, 0] += amplitude
        other, _ = filled(layer, side, before * np.array([[1], [n], [1]]))
        layer[1]["end_data"][side, 0] -= amplitude
        p, changed, kept = (v[0] * v[2] for v in (ghost, other, before[:, 0]))
        errors.append([(p - kept) / (changed - p), (seen[1] - before[2, 0]) / (h * amplitude)])
    return tuple(np.hypot(*errors))


@SIDES
@pytest.mark.parametrize("mach", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("prandtl", [0.72, 0.1], ids=["more friction", "more conduction"])
def test_sound_that_leaves(side, mach, prandtl):
    """What comes in with a mode of viscous sound is of first order in the viscosity, and of second after the correction."""
    coarse, fine = (np.array([misfit(mach, nu, order, mach + 1, prandtl, side)[0] for order in (0, 1)]) for nu in (2e-2, 2e-3))
    np.testing.assert_allclose(np.log10(coarse / fine), [1, 2], atol=0.1)
    assert fine[1] < 0.06 * fine[0]


@SIDES
def test_heat_that_leaves(side):
    """The gradient that the heat flux sees of a mode that flows out: of order 1 without, of the viscosity with q_nn = 0."""
    zeroth, first = (misfit(0.3, 2e-4, order, 0.3, 0.72, side) for order in (0, 1))
    assert zeroth[1] > 1 and first[1] < 0.05
    assert first[0] < 0.05 * zeroth[0]


@SIDES
@pytest.mark.parametrize("mach", [-1.5, 1.5])
def test_faster_than_sound(side, mach):
    """Nothing comes in where gas flows out, all where it flows in."""
    n = 2 * side - 1
    values = np.array([1.1, n * mach * 1.05, 1.07])[:, None] * (1 + 0.01 * np.arange(4))
    ghost, _ = filled(gas_layer(n * mach, 0.0, 0.0, 1), side, values)
    np.testing.assert_allclose(ghost, values[:, 0] if mach > 0 else [1.0, n * mach, 1.0], rtol=1e-15)


@SIDES
@pytest.mark.parametrize("amplitude", [-0.3, -0.1, 0.1, 0.3, 1.0])
def test_finite_sound_leaves(side, amplitude):
    """A simple wave stays as it is, but for a fourth power of its amplitude; linear theory would reflect a second one."""
    n, p = 2 * side - 1, 1 + amplitude
    T = p ** ((GAMMA - 1) / GAMMA)
    wave = np.array([p / T, n * (0.25 + 2 / (GAMMA - 1) * (np.sqrt(T) - 1)), T])
    ghost, _ = filled(gas_layer(n * 0.25, 0.0, 0.0, 1), side, np.repeat(wave[:, None], 4, 1))
    error = abs(ghost[0] * ghost[2] - p)
    assert error < 0.1 * amplitude**4
    linear = abs(p - 1 - GAMMA * (n * wave[1] - 0.25)) / 2
    assert linear > 0.1 * amplitude**2


@SIDES
def test_a_hot_gas_flows_out_in_silence(side):
    n = 2 * side - 1
    hot = np.array([1 / 1.5, n * 0.2, 1.5])
    ghost, _ = filled(gas_layer(n * 0.2, 0.0, 0.0, 1), side, np.repeat(hot[:, None], 4, 1))
    np.testing.assert_allclose(ghost, hot, rtol=1e-15)


@pytest.mark.parametrize("order", [2, -1, 0.5, "1", None, True])
def test_orders_that_there_are_not(order):
    with pytest.raises(InputError, match=r"Open\(order=.*expected 0 or 1"):
        Open(0.0, 1e5, 300.0, order=order)


# The linearised scheme between two open ends, around a uniform flow.

N, STEP, NEAR = 24, 1e-3, 3
MULTIPLES = np.array([-4, -3, -2, -1, 1, 2, 3, 4]) * STEP
WEIGHTS = np.concatenate([-np.asarray(CENTRAL)[::-1], CENTRAL]) / STEP


@lru_cache(None)
def derivatives(side: int, mach: float, mu: float, kappa: float, of_open: int) -> np.ndarray:
    """Of what ``filled`` gives, (5,), with respect to the values (3, NEAR) from the ghost point inwards; of ``gas_layer``."""
    layer = gas_layer(mach, mu, kappa, of_open)
    base, result = np.repeat(np.array([1.0, mach, 1.0])[:, None], NEAR, 1), np.zeros((5, 3, NEAR))
    for v in range(3):
        for k in range(NEAR):
            for weight, step in zip(WEIGHTS, MULTIPLES, strict=True):
                values = base.copy()
                values[v, k] += step
                result[:, v, k] += weight * np.concatenate(filled(layer, side, values))
    return result


def jacobian(order: int, mach: float, mu: float, kappa: float, of_open: int, narrow: bool) -> np.ndarray:
    """Derivative, (3 N, 3 N), of the rates of (rho, u, T) with respect to them."""
    op, O = OPERATORS[order], np.zeros((N, N))
    D = op.matrix(N)
    D2 = D @ D - (remainder(op.interior, np.ones(N)) / op.norm_weights(N)[:, None] if narrow else O)
    fill, seen = np.eye(3 * N), np.eye(3 * N)[N:].reshape(2, N, 3 * N).copy()
    for side in range(2):
        points = np.arange(NEAR) if side == 0 else N - 1 - np.arange(NEAR)
        rows, of_ghost = points[0] + N * np.arange(3), derivatives(side, mach, mu, kappa, of_open).reshape(5, -1)
        columns = (N * np.arange(3)[:, None] + points).ravel()
        fill[rows], seen[:, points[0]] = 0.0, 0.0
        fill[np.ix_(rows, columns)], seen[:, points[0], columns] = of_ghost[:3], of_ghost[3:]
    A = np.block([[mach * D, D, O], [R * D, mach * D, R * D], [O, R / CV * D, mach * D]])
    return fill @ (np.vstack([np.zeros((N, 3 * N)), mu * D2 @ seen[0], kappa / CV * D2 @ seen[1]]) - A @ fill)


@ORDERS
@pytest.mark.parametrize("narrow", [False, True], ids=["wide", "narrow"])
@pytest.mark.parametrize("of_open", [0, 1])
def test_no_mode_grows(order, of_open, narrow):
    """And the classical Runge-Kutta method is stable with the step that the solver takes at Courant number 0.8."""
    stiffness = STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE
    for mach in (0.01, 0.3, 0.95, 1.5):  # one end with outflow, one with inflow
        for nu in (0.0, 0.01, 0.1, 0.6, 2.0, 10.0):
            for mu, kappa in ((1, 1), (1, 0), (0, 1)) if nu > 0 else ((0, 0),):
                values = np.linalg.eigvals(jacobian(order, mach, mu * nu, kappa * CV * nu, of_open, narrow))
                # without friction 2e-5 at most, near the speed of sound
                bound = 5e-5 if narrow and (order, mach, mu, of_open) == (8, 0.95, 0, 1) else 1e-12
                assert values.real.max() < bound, (mach, mu, kappa, nu)
                z = 0.8 * values / ((1 + mach) ** 4 + (stiffness * nu) ** 4) ** 0.25
                assert np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max() < 1 + bound, (mach, mu, kappa, nu)


@SIDES
def test_as_many_conditions_as_the_equations_need(side):
    """What the ghost point is given, and what the gradients are: of a gas that does not conduct or has no friction nothing."""
    n, own = 2 * side - 1, np.eye(3)[1:]
    for mach, count in ((-1.2, 3), (-0.5, 2), (0.5, 1), (1.2, 0)):
        for mu in (0.0, 0.3):
            for kappa in (0.0, 0.3):
                of_ghost = derivatives(side, n * mach, mu, kappa, 1)[:, :, 0]
                assert np.linalg.matrix_rank(of_ghost[:3] - np.eye(3), tol=1e-6) == count
                # those of u and T by the ghost point's values, which are what the fill has made of them
                of_u, of_T = np.abs(of_ghost[3:] - own @ of_ghost[:3]).max(axis=1) > 1e-6
                assert of_T == (kappa > 0) or count == 3
                assert not of_u or mu > 0
