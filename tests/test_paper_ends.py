"""The formulas at embedded boundaries and at the ends of a solid: what they impose, what they keep,
and that nothing grows beside them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

pytest.importorskip("numba")

from helpers import from_python
from paper_parts import (
    H,
    closure,
    dirichlet_ghost,
    extrapolated,
    gas_record,
    insulated_slopes,
    lagrange,
    neumann_ghost,
    operator_of,
)
from paper_parts import filled as fill

from fsipetsc.analysis.spectra import CENTRAL
from fsipetsc.boundaries import (
    ABSORBING,
    CLAMPED,
    DIRICHLET,
    FREE,
    GIVEN_FLUX,
    GIVEN_T,
    INSULATED,
    OPEN,
    Dirichlet,
    Open,
    Wall,
    degree_of,
)
from fsipetsc.errors import InputError
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, remainder
from fsipetsc.paper.ends import LEAST, NODES
from fsipetsc.paper.ends import close_solid as close
from fsipetsc.paper.laws import Gas, law_of

ORDERS = pytest.mark.parametrize("order", OPERATORS)
DEGREES = pytest.mark.parametrize("degree", [2, 3, 4, 5])
SIDES = pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
ROD = Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, force=-10.0)
NARROW = pytest.mark.parametrize("narrow", [0, 1], ids=["wide", "narrow"])
DELTAS = (0.0, 1e-6, 0.2, 0.5, 0.75, 0.999)


def weights_at(delta, degree):
    weights, slopes = np.zeros(NODES), np.zeros(NODES)
    lagrange(delta, degree, weights, slopes)
    return weights, slopes


@DEGREES
def test_formulas_are_exact_up_to_their_degree(degree):
    """Lagrange's weights reproduce polynomials and slopes; a ghost point fits data or has no slope;
    where eta, which keeps it stable, is not zero it is one degree less."""
    nodes = np.arange(degree + 1.0)
    for delta in DELTAS:
        weights, slopes = weights_at(delta, degree)
        close = {"rtol": 1e-11, "atol": 1e-11}
        for power in range(degree + 1):
            slope = power * delta ** (power - 1) if power else 0.0
            values = nodes**power
            np.testing.assert_allclose(weights[: degree + 1] @ values, delta**power, **close)
            np.testing.assert_allclose(slopes[: degree + 1] @ values, slope, **close)
            if power != 1:
                values = (np.arange(NODES) - delta) ** power
                np.testing.assert_allclose(
                    neumann_ghost(values, slopes, degree), values[0], **close
                )
        for power in range(degree + (weights[0] >= 0.25)):
            values = (np.arange(NODES) - 0.3) ** power
            ghost = dirichlet_ghost((delta - 0.3) ** power, values, weights, degree, LEAST)
            np.testing.assert_allclose(ghost, values[0], **close)
        sizes = [dirichlet_ghost(0.0, row, weights, degree, LEAST) for row in np.eye(NODES)]
        assert np.abs(sizes).max() <= 4 * 2**degree, "it never divides by a small number"
    for power in range(degree):
        values = (np.arange(NODES) + 2.0) ** power
        np.testing.assert_allclose(extrapolated(values, degree - 1), values[0])


# wall


def second_derivative(order, n, narrow):
    """D twice, or the narrow one, h = 1."""
    op = OPERATORS[order]
    D = op.matrix(n)
    return D @ D - narrow * remainder(op.interior, np.ones(n)) / op.norm_weights(n)[:, None]


@ORDERS
@NARROW
def test_heat_beside_an_insulated_wall(order, narrow):
    """T_t = T_XX beside the formula: cos converges with order s + 1; undamped, with 1 at 2/1, 3 at
    6/3."""
    least = {2: 1.9, 4: 2.9, 6: 3.9, 8: 4.9 if narrow else 3.5}

    def error(cells, delta):
        n, h = cells + 1, 1 / (cells - delta)
        _, slopes = weights_at(delta, order // 2)
        degree = insulated_slopes(delta, order // 2, narrow, slopes)
        ghost, unit = np.eye(n), np.pad(np.eye(n), ((0, 0), (0, NODES)))[:, :NODES]
        ghost[0] = [neumann_ghost(row, slopes, degree) for row in unit]
        ghost[-1] = 0.0  # T = 0 at the other end
        diffusion = ghost @ second_derivative(order, n, narrow) @ ghost / h**2
        values, modes = np.linalg.eig(diffusion)
        assert values.real.max() < 1e-8
        cosine = np.cos(np.pi / 2 * (np.arange(n) - delta) * h)
        end = (modes * np.exp(values * 0.2)) @ np.linalg.solve(modes, ghost @ cosine)
        return np.abs(end.real - np.exp(-0.2 * np.pi**2 / 4) * cosine)[1:].max()

    for delta in (0.0, 0.4, 0.9):
        assert np.log2(error(32, delta) / error(64, delta)) > least[order]


def test_degrees():
    end = Dirichlet(0.0, lambda t: (1.0, 0.0, 1.0))
    assert [degree_of(end, order) for order in OPERATORS] == [2, 3, 4, 5]
    assert degree_of(Dirichlet(0.0, end.values, 4), 2) == 4
    with pytest.raises(InputError, match=r"Dirichlet\(degree=6\): expected 2, 3, 4, 5"):
        Dirichlet(0.0, end.values, 6)
    assert degree_of(Wall(0.0), 8) == Wall.degree
    for order in (2, 0.5, "1", None, True):
        with pytest.raises(InputError, match=r"Open\(order=.*expected 0 or 1"):
            Open(0.0, 1e5, 300.0, order=order)


# open ends, against the modes of the equations; rho = c = T = 1

GAMMA = 1.4
R, CV = 1 / GAMMA, 1 / GAMMA / (GAMMA - 1)
N, STEP = 24, 1e-3


def gas_layer(kind, mach, mu, kappa, order, n=N, h=1.0):
    """(gas, layer of it) between two ends beyond which it flows with ``mach``; mu is 4/3 of the
    shear viscosity, order that of open ends or of the operator."""
    layer = gas_record(n, h=h)
    layer["end_kind"] = kind
    if kind == OPEN:
        layer["end_data"] = Open(0.0, R, 1.0, mach, order).data(0.0)
    else:
        layer["end_data"][:, :3] = 1.0, mach, 1.0
        layer["end_degree"] = degree_of(Dirichlet(0.0, lambda t: ()), order)
    return Gas(PerfectGas(GAMMA, R), ConstantTransport(), mu, kappa, GAMMA, 0.0), layer


# the linearised scheme between two ends, around a uniform flow


@lru_cache(None)
def derivatives(kind, side, mach, mu, kappa, order, delta):
    """Of (rho, u, T) of the ghost point and (u, T) that the gradients see, (5, 3, nodes), with
    respect to the values from the ghost point inwards."""
    layer, near = gas_layer(kind, mach, mu, kappa, order), 3 if kind == OPEN else 7
    base = np.repeat(np.array([1.0, mach, 1.0])[:, None], N, 1)
    result = np.zeros((5, 3, near))
    for v, k in np.ndindex(3, near):
        for number, weight in enumerate(CENTRAL, 1):
            for sign in (1, -1):
                values = base.copy()
                values[v, k] += sign * number * STEP
                change = np.concatenate(fill(*layer, side, delta, values))
                result[:, v, k] += sign * weight / STEP * change
    return result


def jacobian(kind, order, mach, mu, kappa, end_order, delta, narrow=0):
    """Derivative, (3 N, 3 N), of the rates of (rho, u, T) with respect to them."""
    D, none = OPERATORS[order].matrix(N), np.zeros((N, N))
    D2 = second_derivative(order, N, narrow)
    ghost, seen = np.eye(3 * N), np.eye(3 * N)[N:].reshape(2, N, 3 * N).copy()
    of_gas = (mu, kappa) if kind == OPEN else (0.0, 0.0)  # given data do not depend on them
    for side in range(2):
        of_ghost = derivatives(kind, side, mach, *of_gas, end_order, delta)
        near = of_ghost.shape[2]
        points = np.arange(near) if side == 0 else N - 1 - np.arange(near)
        rows, of_ghost = points[0] + N * np.arange(3), of_ghost.reshape(5, -1)
        columns = (N * np.arange(3)[:, None] + points).ravel()
        ghost[rows], seen[:, points[0]] = 0.0, 0.0
        ghost[np.ix_(rows, columns)], seen[:, points[0], columns] = of_ghost[:3], of_ghost[3:]
    A = np.block([[mach * D, D, none], [R * D, mach * D, R * D], [none, R / CV * D, mach * D]])
    diffusion = np.vstack([np.zeros((N, 3 * N)), mu * D2 @ seen[0], kappa / CV * D2 @ seen[1]])
    return ghost @ (diffusion - A @ ghost)


def assert_stable(matrix, mach, nu, stiffness, bound):
    """No mode grows, and the classical method is stable with the step of Courant number 0.8."""
    values = np.linalg.eigvals(matrix)
    assert values.real.max() < bound
    z = 0.8 * values / ((1 + abs(mach)) ** 4 + (stiffness * nu) ** 4) ** 0.25
    assert np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max() < 1 + bound


#: whether the gas has viscosity, and whether it conducts
BOTH = ((1, 1), (1, 0), (0, 1))


@ORDERS
@NARROW
@pytest.mark.parametrize("of_open", [0, 1])
def test_no_mode_grows_between_open_ends(order, of_open, narrow):
    stiffness = STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE
    for mach in (0.01, 0.3, 0.95, 1.5):  # one end with outflow, one with inflow
        for nu in (0.0, 0.01, 0.1, 0.6, 2.0, 10.0):
            for mu, kappa in BOTH if nu > 0 else ((0, 0),):
                numbers = mach, mu * nu, kappa * CV * nu
                matrix = jacobian(OPEN, order, *numbers, of_open, 0.3, narrow)
                # without viscosity 2e-5 at most, near the speed of sound
                slow = narrow and (order, mach, mu, of_open) == (8, 0.95, 0, 1)
                assert_stable(matrix, mach, nu, stiffness, 5e-5 if slow else 1e-12)


@pytest.mark.long
@ORDERS
def test_no_mode_grows_between_given_data(order):
    for mach in (-2.0, -0.95, -0.5, 0.1, 1.5):
        for delta in (0.0, 0.3, 0.5, 0.8, 0.999):
            for nu in (0.0, 0.01, 0.1, 0.6, 2.0, 10.0):
                for mu, kappa in BOTH if nu > 0 else ((0, 0),):
                    numbers = mach, mu * nu, kappa * CV * nu
                    matrix = jacobian(DIRICHLET, order, *numbers, order, delta)
                    # slowly; a boundary that moves passes by
                    grows = order > 4 and delta > 0.85
                    assert_stable(matrix, mach, nu, STIFFNESS_OF_WIDE, 1 / N if grows else 1e-8)


def solid_state(n: int) -> np.ndarray:
    """(n, 4) of u, sigma, T, x, smooth with some noise."""
    X, noise = H * np.arange(n), np.random.default_rng(n).uniform(-1, 1, (4, n))
    smooth = (
        np.cos(2 * X),
        -1e5 + 1e4 * np.sin(3 * X),
        300 + 30 * np.sin(X),
        X + 0.1 * np.sin(2 * X),
    )
    noise = noise * np.array([1e-3, 1.0, 1e-3, 1e-5])[:, None]
    return np.stack([values + some for values, some in zip(smooth, noise, strict=True)], axis=-1)


def squared_wave_speed(gruneisen, x_X, T, sigma):
    """Of the equations (3.1) without conduction, linearised: an eigenvalue."""
    heat = ROD.alpha * ROD.m0
    p = gruneisen * heat * T / x_X
    A = np.zeros((4, 4))  # u, sigma, T, x_X
    A[0, 1:] = np.array([1.0, -gruneisen * heat / x_X, p / x_X]) / ROD.m0
    A[1:, 0] = ROD.K / x_X, (sigma - p) / heat, 1.0
    return float(np.max(np.linalg.eigvals(A).real) ** 2)


@SIDES
@pytest.mark.parametrize("kind", [CLAMPED, FREE, ABSORBING], ids=["clamped", "free", "absorbing"])
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
@ORDERS
def test_ends_of_a_solid(order, kind, side, gruneisen):
    n, layer, op = 2 * side - 1, gas_record(40), operator_of(order)
    close_solid, solid = from_python(close), law_of(ROD)._replace(law=Gruneisen(gruneisen))
    value = 0.7 if kind == CLAMPED else -9e4
    layer["end_kind"][side], layer["end_data"][side, 0] = kind, value
    q = solid_state(40) * [1.0, 1.0, 1.0, 0.4]
    before, at, inwards = q.copy(), 39 * side, 1 - 2 * side
    close_solid(op, solid, layer, q)
    rows = at + inwards * np.arange(len(closure(order)))
    d = -n / H * closure(order)
    x_X, T, p = d @ q[rows, 3], q[at, 2], solid.pressure(q[at, 2], d @ q[rows, 3])
    traction, old = q[at, 1] - p, before[at, 1] - p
    Z = ROD.m0 * np.sqrt(squared_wave_speed(gruneisen, x_X, T, value + p))
    # x_X is a sum of terms larger than itself, in an order of its own on each processor
    rounding = 2**-51 * p * (np.abs(d) @ np.abs(q[rows, 3])) / x_X
    assert abs(d @ q[rows, 2]) < 1e-9, "no heat through the end"
    if kind == CLAMPED:
        assert q[at, 0] == value
    elif kind == FREE:
        np.testing.assert_allclose(traction, value, rtol=1e-14, atol=rounding)
    else:
        np.testing.assert_allclose(traction - value + n * Z * q[at, 0], 0, atol=rounding + 1e-9)
        outgoing = [v - n * Z * u for v, u in ((traction, q[at, 0]), (old, before[at, 0]))]
        np.testing.assert_allclose(*outgoing, rtol=1e-13)
    once = q.copy()
    close_solid(op, solid, layer, q)
    np.testing.assert_allclose(q, once, rtol=1e-12, err_msg="a second application changes it")
    inside = np.arange(40) != at
    assert np.array_equal(q[inside], before[inside]) and q[at, 3] == before[at, 3]


@ORDERS
@pytest.mark.parametrize("kind", [CLAMPED, FREE, ABSORBING], ids=["clamped", "free", "absorbing"])
@pytest.mark.parametrize("thermal", [INSULATED, GIVEN_T, GIVEN_FLUX], ids=["none", "T", "flux"])
def test_a_right_end_of_a_solid_is_a_left_end_in_a_mirror(order, kind, thermal):
    close_solid = from_python(close)
    solid = law_of(Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, gruneisen=0.3))
    X, mirror = 0.01 * np.arange(40), np.array([-1.0, 1.0, 1.0, -1.0])
    fields = np.cos(2 * X), -1e5 + 1e4 * np.sin(3 * X), 300 + 30 * np.sin(X), X + 0.1 * np.sin(X)
    left = np.stack(fields, axis=-1)
    right, before = left[::-1] * mirror, left.copy()
    for side, q in enumerate((left, right)):
        layer, value = gas_record(40), 0.7 * (1 - 2 * side) if kind == CLAMPED else -9e4
        layer["end_kind"][side], layer["end_data"][side, 0] = kind, value
        layer["end_thermal"][side] = thermal
        layer["end_heat"][side] = {INSULATED: 0.0, GIVEN_T: 320.0, GIVEN_FLUX: 1e3}[thermal]
        close_solid(operator_of(order), solid, layer, q)
    np.testing.assert_allclose(right, left[::-1] * mirror, rtol=1e-13)
    assert np.array_equal(left[1:], before[1:]) and (left[0] != before[0]).any()
