"""The formulas at embedded boundaries and the conditions at the outer ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("numba")

from paper_parts import (
    AIR,
    GAS,
    ROD,
    STEEL,
    H,
    close_solid,
    closure,
    dirichlet_ghost,
    extrapolated,
    gas_record,
    insulated_slopes,
    lagrange,
    neumann_ghost,
    operator_of,
    solid_record,
    solid_state,
)
from paper_parts import filled as fill

from fsipetsc.boundaries import (
    ABSORBING,
    CLAMPED,
    DIRICHLET,
    FREE,
    OPEN,
    WALL,
    Dirichlet,
    Open,
    Wall,
    degree_of,
)
from fsipetsc.errors import InputError
from fsipetsc.materials.solid_pressure import Gruneisen
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.narrow import remainder
from fsipetsc.paper.ends import LEAST, NODES

ORDERS = pytest.mark.parametrize("order", OPERATORS)
DEGREES = pytest.mark.parametrize("degree", [2, 3, 4, 5])
#: second derivatives
NARROW = pytest.mark.parametrize("narrow", [0, 1], ids=["wide", "narrow"])
DELTAS = (0.0, 1e-6, 0.2, 0.5, 0.75, 0.999)


def weights_at(delta: float, degree: int) -> tuple[np.ndarray, np.ndarray]:
    weights, slopes = np.zeros(NODES), np.zeros(NODES)
    lagrange(delta, degree, weights, slopes)
    return weights, slopes


@DEGREES
def test_lagrange_weights(degree):
    """They reproduce polynomials and their slopes; so they sum to one, and the slopes to zero."""
    nodes = np.arange(degree + 1.0)
    for delta in DELTAS:
        weights, slopes = weights_at(delta, degree)
        for power in range(degree + 1):
            np.testing.assert_allclose(weights[: degree + 1] @ nodes**power, delta**power, rtol=1e-13, atol=1e-11)
            derivative = power * delta ** (power - 1) if power else 0.0
            np.testing.assert_allclose(slopes[: degree + 1] @ nodes**power, derivative, rtol=1e-13, atol=1e-11)


@DEGREES
def test_dirichlet_formula_is_exact_up_to_its_degree(degree):
    """One less where eta, which keeps it stable, is not zero."""
    for delta in DELTAS:
        weights, _ = weights_at(delta, degree)
        for power in range(degree + (weights[0] >= 0.25)):
            values = (np.arange(NODES) - 0.3) ** power
            ghost = dirichlet_ghost((delta - 0.3) ** power, values, weights, degree, LEAST)
            np.testing.assert_allclose(ghost, values[0], rtol=1e-12, atol=1e-11)


@DEGREES
def test_dirichlet_formula_never_divides_by_a_small_number(degree):
    for delta in np.linspace(0, 1, 101)[:-1]:
        weights, _ = weights_at(delta, degree)
        unit = np.eye(NODES)
        assert max(abs(dirichlet_ghost(0.0, row, weights, degree, LEAST)) for row in unit) <= 4 * 2**degree


@DEGREES
def test_neumann_formula_is_exact_up_to_its_degree(degree):
    for delta in DELTAS:
        _, slopes = weights_at(delta, degree)
        for power in range(2, degree + 1):
            values = (np.arange(NODES) - delta) ** power  # no slope at delta
            np.testing.assert_allclose(neumann_ghost(values, slopes, degree), values[0], rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(neumann_ghost(np.full(NODES, 7.0), slopes, degree), 7.0)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_extrapolation_is_exact_up_to_its_degree(degree):
    for power in range(degree + 1):
        values = (np.arange(NODES) + 2.0) ** power
        np.testing.assert_allclose(extrapolated(values, degree), values[0])
    assert extrapolated((np.arange(NODES) + 2.0) ** (degree + 1), degree) != 2.0 ** (degree + 1)


SIDES = pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])


def filled(kind: int, side: int, delta: float, data: tuple[float, ...] = (), degree: int = 2, new: bool = False):
    """(what the gradients see, rows of rho, u, T before, after) of a boundary fill."""
    layer = gas_record(40)
    layer["end_kind"][side], layer["end_degree"] = kind, degree
    layer["end_data"][side, : len(data)] = data
    k = np.arange(NODES)
    before = np.array([1.2 + 0.02 * k, 4 - 0.5 * k, 300 + 2 * k - 0.2 * k * k])
    after = before.copy()
    after[:, 0], seen = fill(GAS, layer, side, delta, before, new)
    return seen, before, after


def pressure(values: np.ndarray) -> float:
    return AIR.R * values[0] * values[2]


@SIDES
@pytest.mark.parametrize("delta", DELTAS)
def test_wall(side, delta):
    _, before, after = filled(WALL, side, delta)
    n, old, ghost = 2 * side - 1, before[:, 0], after[:, 0]
    weights, slopes = weights_at(delta, 2)
    degree = insulated_slopes(delta, 2, 0, slopes)
    impedance = old[0] * AIR.sound_speed(old[2])
    np.testing.assert_allclose(pressure(ghost) + n * impedance * ghost[1], pressure(old) + n * impedance * old[1], rtol=1e-13)
    assert abs(slopes[: degree + 1] @ after[2, : degree + 1]) < 1e-10, "the heat flux through the wall"
    if weights[0] >= 0.25:
        assert abs(weights[:3] @ after[1, :3]) < 2e-13, "the velocity at the wall"


def second_derivative(order: int, n: int, narrow: int) -> np.ndarray:
    """D twice, or the narrow one, h = 1."""
    op = OPERATORS[order]
    D = op.matrix(n)
    return D @ D - narrow * remainder(op.interior, np.ones(n)) / op.norm_weights(n)[:, None]


def near_the_wall(order: int, narrow: int) -> np.ndarray:
    """E of the wall's formula for h = 1, see docs/open-end.md."""
    op, n = OPERATORS[order], 80
    s, D, x = order // 2, op.matrix(n), np.arange(float(n))
    e = D @ x ** (s + 1) / math.factorial(s + 1) - x**s / math.factorial(s)
    if narrow:
        D = second_derivative(order, n, 1)
        e = D @ x ** (s + 1) / math.factorial(s + 1) - x ** (s - 1) / math.factorial(s - 1)
    e[op.rows + 2 * op.p :] = 0.0
    rows, known = [*D[narrow : n - op.rows]], [*-e[narrow : n - op.rows]]
    for j in range(n - 20, n - 2):  # bounded far inside: constant and the shortest wave
        rows.append(np.eye(n)[j + 2] - np.eye(n)[j])
        known.append(0.0)
    E = np.linalg.lstsq(np.array(rows), np.array(known), rcond=None)[0]
    np.testing.assert_allclose(np.array(rows) @ E, known, atol=1e-11)
    return E


@ORDERS
@NARROW
def test_temperature_at_the_wall(order, narrow):
    """The formula is exact on what has no slope at the wall up to degree s, and on what D makes of degree s + 1."""
    s, E = order // 2, near_the_wall(order, narrow)
    for delta in DELTAS:
        _, slopes = weights_at(delta, s)
        degree = insulated_slopes(delta, s, narrow, slopes)
        distance = np.arange(NODES) - delta
        for power in [0, *range(2, s + 1)]:
            values = distance**power
            np.testing.assert_allclose(neumann_ghost(values, slopes, degree), values[0], rtol=1e-10, atol=1e-10)
        if order < (4 if narrow else 8) or (narrow and order == 6):
            values = distance ** (s + 1) / math.factorial(s + 1) + E[:NODES]
            np.testing.assert_allclose(neumann_ghost(values, slopes, degree), values[0], rtol=1e-10, atol=1e-9)
        assert abs(slopes[0]) > 0.4 and np.abs(slopes[1 : degree + 1] / slopes[0]).max() < 1.35, "what damps"


@ORDERS
@NARROW
def test_waves_at_a_wall_that_passes_points(order, narrow):
    """T_t = T_X beside the formula: what leaves through the ghost point leaves, or grows little while the wall goes by."""
    n, rates = 40, []
    for delta in np.linspace(0.02, 0.98, 13):
        _, slopes = weights_at(delta, order // 2)
        degree = insulated_slopes(delta, order // 2, narrow, slopes)
        fill = np.eye(n)
        fill[0] = [neumann_ghost(row, slopes, degree) for row in np.pad(np.eye(n), ((0, 0), (0, NODES)))[:, :NODES]]
        inside = (OPERATORS[order].matrix(n) @ fill)[1:-1, 1:-1]
        rates.append(np.linalg.eigvals(inside).real.max())
    assert np.mean(rates) < 0.025


@ORDERS
@NARROW
def test_heat_beside_an_insulated_wall(order, narrow):
    """T_t = T_XX beside the formula: cos converges with order s + 1; undamped, with 1 at 2/1, 3 at 6/3."""
    least = {2: 1.9, 4: 2.9, 6: 3.9, 8: 4.9 if narrow else 3.5}

    def error(cells: int, delta: float) -> float:
        n, h = cells + 1, 1 / (cells - delta)
        x = (np.arange(n) - delta) * h
        fill = np.eye(n)
        _, slopes = weights_at(delta, order // 2)
        degree = insulated_slopes(delta, order // 2, narrow, slopes)
        fill[0] = [neumann_ghost(row, slopes, degree) for row in np.pad(np.eye(n), ((0, 0), (0, NODES)))[:, :NODES]]
        fill[-1] = 0.0  # T = 0 at the other end
        values, modes = np.linalg.eig(fill @ second_derivative(order, n, narrow) @ fill / h**2)
        assert values.real.max() < 1e-8
        start = fill @ np.cos(np.pi / 2 * x)
        end = (modes * np.exp(values * 0.2)) @ np.linalg.solve(modes, start)
        return float(np.abs(end.real - np.exp(-0.2 * np.pi**2 / 4) * np.cos(np.pi / 2 * x))[1:].max())

    for delta in (0.0, 0.4, 0.9):
        assert np.log2(error(32, delta) / error(64, delta)) > least[order]


@SIDES
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_open_end(side, speed):
    """What comes in is a simple wave of the gas at rest; what goes out stays."""
    p0, T0 = 1e5, 290.0
    layer = gas_record(40)
    layer["end_kind"][side] = OPEN
    layer["end_data"][side] = Open(0.0, p0, T0).data(0.0)
    n = 2 * side - 1
    rho, u, T = 1.25, n * speed, 295.0
    nodes = np.repeat(np.array([[rho], [u], [T]]), NODES, axis=1)
    ghost, _ = fill(GAS._replace(mu=0.0, kappa=0.0), layer, side, 0.4, nodes)
    c, gamma = AIR.sound_speed(T), AIR.gamma
    np.testing.assert_allclose(pressure(ghost) + n * rho * c * ghost[1], AIR.R * rho * T + n * rho * c * u, rtol=1e-13)
    compression = pressure(ghost) / p0
    wave = 2 * AIR.sound_speed(T0) / (gamma - 1) * (compression ** ((gamma - 1) / 2 / gamma) - 1)
    assert n * ghost[1] == pytest.approx(wave, rel=(compression - 1) ** 3)
    kept = rho + (pressure(ghost) - AIR.R * rho * T) / c**2
    at_rest = p0 / (AIR.R * T0) * compression ** (1 / gamma)
    np.testing.assert_allclose(ghost[0], kept if n * ghost[1] > 0 else at_rest, rtol=1e-13)


@SIDES
@pytest.mark.parametrize("outflow", [True, False])
@DEGREES
def test_dirichlet(side, outflow, degree):
    """The incoming characteristic, and on inflow the entropy, are those of the formula's values; the others stay."""
    n = 2 * side - 1
    data = (1.3, n * (5.0 if outflow else -5.0), 310.0)
    delta = 0.3
    _, before, after = filled(DIRICHLET, side, delta, data, degree)
    weights, _ = weights_at(delta, degree)
    given = np.array([dirichlet_ghost(g, row, weights, degree, LEAST) for g, row in zip(data, before, strict=True)])
    old, ghost = before[:, 0], after[:, 0]
    c = AIR.sound_speed(before[2, 1])
    Z = before[0, 1] * c
    np.testing.assert_allclose(pressure(ghost) + n * Z * ghost[1], pressure(old) + n * Z * old[1], rtol=1e-13)
    np.testing.assert_allclose(pressure(ghost) - n * Z * ghost[1], pressure(given) - n * Z * given[1], rtol=1e-13)
    kept = old if outflow else given
    np.testing.assert_allclose(ghost[0] - pressure(ghost) / c**2, kept[0] - pressure(kept) / c**2, atol=2e-13)


@SIDES
@DEGREES
def test_supersonic_dirichlet(side, degree):
    """Everything comes in: all three are imposed. Nothing does: none is."""
    n = 2 * side - 1
    for speed in (-400.0, 400.0):
        layer, k = gas_record(40), np.arange(NODES)
        layer["end_kind"][side], layer["end_degree"], layer["end_data"][side, :3] = DIRICHLET, degree, (1.3, n * speed, 310.0)
        before = np.array([1.2 + 0.02 * k, n * (speed + 2 * k), 300.0 + 2 * k])
        ghost, _ = fill(GAS, layer, side, 0.3, before)
        weights, _ = weights_at(0.3, degree)
        given = [dirichlet_ghost(g, row, weights, degree, LEAST) for g, row in zip(layer["end_data"][side], before)]
        np.testing.assert_allclose(ghost, before[:, 0] if speed > 0 else given, rtol=1e-13)


@SIDES
@DEGREES
def test_gradients_see_the_data(side, degree):
    """u and T at the boundary are those given."""
    data, delta = (1.3, 4.2, 311.0), 0.1
    seen, before, _ = filled(DIRICHLET, side, delta, data, degree)
    weights, _ = weights_at(delta, degree)
    assert weights[0] >= 0.3, "no eta: the formula is the interpolant"
    for row, value, given in zip(before[1:], seen, data[1:], strict=True):
        assert weights[: degree + 1] @ [value, *row[1 : degree + 1]] == pytest.approx(given, rel=1e-13)


@pytest.mark.parametrize("degree", [0, 1, 6, -1, 2.5, "3", True])
def test_degrees_that_there_are_not(degree):
    with pytest.raises(InputError, match=r"Dirichlet\(degree=.*from 2 to 5"):
        Dirichlet(0.0, lambda t: (1.0, 0.0, 1.0), degree)


def test_degree_follows_the_order():
    end = Dirichlet(0.0, lambda t: (1.0, 0.0, 1.0))
    assert [degree_of(end, order) for order in OPERATORS] == [2, 3, 4, 5]
    assert degree_of(Dirichlet(0.0, end.values, 4), 2) == 4
    assert degree_of(Wall(0.0), 8) == Wall.degree


@SIDES
@pytest.mark.parametrize("kind", [WALL, OPEN, DIRICHLET], ids=["wall", "open", "dirichlet"])
@pytest.mark.parametrize("delta", DELTAS)
def test_filling_twice_is_filling_once(kind, side, delta):
    """So the fused step, which fills a stage once, is PETSc's, which fills what is full."""
    data = (1e5, 300.0, 5.0, 1.0) if kind == OPEN else (1.2, 4.0, 300.0)
    _, _, once = filled(kind, side, delta, data, degree=2)
    layer = gas_record(40)
    layer["end_kind"][side], layer["end_degree"], layer["end_data"][side, : len(data)] = kind, 2, data
    twice, _ = fill(GAS, layer, side, delta, once)
    np.testing.assert_allclose(twice, once[:, 0], rtol=1e-12)


@SIDES
@pytest.mark.parametrize("kind", [WALL, OPEN, DIRICHLET], ids=["wall", "open", "dirichlet"])
def test_a_new_point_is_filled_without_its_own_value(kind, side):
    data = (1e5, 300.0, 5.0, 1.0) if kind == OPEN else (1.2, 4.0, 300.0)
    _, before, after = filled(kind, side, 0.9, data, new=True)
    assert np.all(np.isfinite(after))
    np.testing.assert_allclose(after[[0, 2], 0], before[[0, 2], 0], rtol=0.1)


@SIDES
@pytest.mark.parametrize("kind", [CLAMPED, FREE, ABSORBING], ids=["clamped", "free", "absorbing"])
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
@ORDERS
def test_ends_of_a_solid(order, kind, side, gruneisen):
    n, layer, op = 2 * side - 1, solid_record(40), operator_of(order)
    solid = STEEL._replace(law=Gruneisen(gruneisen))
    value = 0.7 if kind == CLAMPED else -9e4
    layer["end_kind"][side], layer["end_data"][side, 0] = kind, value
    q = solid_state(40) * [1.0, 1.0, 1.0, 0.4]
    before, at, inwards = q.copy(), 39 * side, 1 - 2 * side
    close_solid(op, solid, layer, q)
    rows = at + inwards * np.arange(len(closure(order)))
    d = -n / H * closure(order)
    x_X = d @ q[rows, 3]
    traction, old = (v[at, 1] - gruneisen * ROD.m0 * ROD.alpha * q[at, 2] / x_X for v in (q, before))
    T, p = q[at, 2], before[at, 1] - old
    Z = ROD.m0 * np.sqrt(squared_wave_speed(gruneisen, x_X, T, value + p))
    assert abs(d @ q[rows, 2]) < 1e-9, "no heat through the end"
    if kind == CLAMPED:
        assert q[at, 0] == value
    elif kind == FREE:
        np.testing.assert_allclose(traction, value, rtol=1e-14)
    else:
        np.testing.assert_allclose(traction - value + n * Z * q[at, 0], 0, atol=1e-9)
        np.testing.assert_allclose(traction - n * Z * q[at, 0], old - n * Z * before[at, 0], rtol=1e-13)
    once = q.copy()
    close_solid(op, solid, layer, q)
    np.testing.assert_allclose(q, once, rtol=1e-12, err_msg="a second application changes something")
    inside = np.arange(40) != at
    assert np.array_equal(q[inside], before[inside]) and q[at, 3] == before[at, 3]


def squared_wave_speed(gruneisen: float, x_X: float, T: float, sigma: float) -> float:
    """Of the equations (3.1) without conduction, linearised: an eigenvalue."""
    heat = ROD.alpha * ROD.m0
    p = gruneisen * heat * T / x_X
    A = np.zeros((4, 4))  # u, sigma, T, x_X
    A[0, 1:] = np.array([1.0, -gruneisen * heat / x_X, p / x_X]) / ROD.m0
    A[1:, 0] = ROD.K / x_X, (sigma - p) / heat, 1.0
    return float(np.max(np.linalg.eigvals(A).real) ** 2)
