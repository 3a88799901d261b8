"""The compiled right-hand sides against plain matrices, and the formulas at embedded boundaries."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import from_python

pytest.importorskip("numba")

from fsipetsc.boundaries import ABSORBING, CLAMPED, DIRICHLET, FREE, NODES, OPEN, WALL, close_solid, fill_ghost
from fsipetsc.operators import OPERATORS, packed
from fsipetsc.operators.kernels import BLOCK, dirichlet_ghost, extrapolate, lagrange, neumann_ghost, scratch_size
from fsipetsc.physics.emission import Target
from fsipetsc.physics.fluid import Fluid, fluid_rhs, fluid_survey
from fsipetsc.physics.layer import LAYER
from fsipetsc.physics.solid import Solid, solid_bounds, solid_rhs, solid_survey
from fsipetsc.physics.survey import LEAST_RHO, LEAST_T, SIZE, SPEED, SUMS, begin_survey

fluid_rhs, solid_rhs, fluid_survey, solid_survey = map(from_python, (fluid_rhs, solid_rhs, fluid_survey, solid_survey))
begin_survey, solid_bounds, fill_ghost, close_solid = map(from_python, (begin_survey, solid_bounds, fill_ghost, close_solid))
lagrange, dirichlet_ghost, neumann_ghost, extrapolate = map(
    from_python, (lagrange, dirichlet_ghost, neumann_ghost, extrapolate)
)

GAS = Fluid(mu=0.5, kappa=0.7, gamma=1.4, R=287.0)
ROD = Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, force=-10.0)
H = 0.01
HALO = 14  # points; enough for two derivatives of any order
ROWS = 16  # of scratch

ORDERS = pytest.mark.parametrize("order", OPERATORS)


def fluid_record(n: int, lo: int, hi: int) -> np.void:
    """A fluid layer of n stored points, lo..hi of them active, all on this rank."""
    layer = np.zeros(1, LAYER)[0]
    layer["n"], layer["lo"], layer["hi"], layer["own_hi"], layer["h"] = n, lo, hi, n, H
    layer["gamma"], layer["R"], layer["cv"] = GAS.gamma, GAS.R, GAS.cv
    layer["mu"], layer["kappa"], layer["s"] = 4 / 3 * GAS.mu, GAS.kappa, -3.0
    return layer


def solid_record(n: int, gruneisen: float) -> np.void:
    """A solid layer of n points, all on this rank."""
    layer = np.zeros(1, LAYER)[0]
    layer["kind"], layer["n"], layer["hi"], layer["own_hi"], layer["h"] = 1, n, n - 1, n, H
    for name in ("K", "kappa_e", "m0", "alpha", "force"):
        layer[name] = getattr(ROD, name)
    layer["gruneisen"] = gruneisen
    return layer


def fluid_state(n: int) -> np.ndarray:
    """(n, 3) conserved variables, smooth with some noise."""
    X, rng = np.linspace(0, 3, n), np.random.default_rng(n)
    noise = 1e-3 * rng.uniform(-1, 1, (3, n))
    return GAS.conserved(1.2 + 0.2 * np.sin(X) + noise[0], 20 * np.cos(2 * X) + noise[1], 300 + 30 * np.sin(3 * X) + noise[2])


def solid_state(n: int) -> np.ndarray:
    """(n, 4) of u, sigma, T, x, smooth with some noise."""
    X, rng = H * np.arange(n), np.random.default_rng(n)
    noise = rng.uniform(-1, 1, (4, n))
    return np.stack(
        [
            np.cos(2 * X) + 1e-3 * noise[0],
            -1e5 + 1e4 * np.sin(3 * X) + noise[1],
            300 + 30 * np.sin(X) + 1e-3 * noise[2],
            X + 0.1 * np.sin(2 * X) + 1e-5 * noise[3],
        ],
        axis=-1,
    )


def fluid_reference(order: int, layer: np.void, q: np.ndarray) -> np.ndarray:
    """(4.20) with dense matrices."""
    active = slice(layer["lo"], layer["hi"] + 1)
    D = OPERATORS[order].matrix(layer["hi"] - layer["lo"] + 1, H)
    rho, u, T, p = GAS.primitive(q[active])
    tau = p - 4 / 3 * GAS.mu * (D @ u)
    v = u - layer["s"]
    f = np.zeros_like(q)
    f[active, 0] = -D @ (rho * v)
    f[active, 1] = -D @ (rho * u * v + tau)
    f[active, 2] = -D @ (q[active, 2] * v + u * tau - GAS.kappa * (D @ T))
    return f


def solid_reference(order: int, layer: np.void, q: np.ndarray) -> np.ndarray:
    """(4.19) with dense matrices."""
    D = OPERATORS[order].matrix(len(q), H)
    u, sigma, T, x = q.T
    x_X, u_X = D @ x, D @ u
    traction = sigma - layer["gruneisen"] * ROD.m0 * ROD.alpha * T / x_X
    heat = traction * u_X + D @ (ROD.kappa_e / x_X * (D @ T))
    return np.stack([D @ traction / ROD.m0 + ROD.force, ROD.K / x_X * u_X, heat / (ROD.alpha * ROD.m0), u], axis=-1)


def right_hand_side(
    kernel, layer: np.void, order: int, q: np.ndarray, begin: int, end: int, cuts: tuple[int, ...] = ()
) -> np.ndarray:
    """The kernel's result for a rank that owns the points begin..end-1 with halos, evaluated in parts."""
    n, dof = q.shape
    ranges = itertools.pairwise((begin, *(c for c in cuts if begin < c < end), end))
    layer["own_lo"], layer["own_hi"] = begin, end
    layer["halo_lo"], layer["halo_hi"] = min(HALO, begin), min(HALO, n - end)
    work = q[begin - layer["halo_lo"] : end + layer["halo_hi"]].T  # every unknown for itself
    count = work.shape[1]
    stride = layer["stride"] = count + 5
    areas = np.full((3, dof, stride), np.nan)  # nothing may come from beyond what a rank has
    areas[:, :, :count] = work, np.zeros_like(work), np.zeros_like(work)
    memory = np.concatenate([np.full(16, np.nan), areas.ravel(), np.full(scratch_size(ROWS), np.nan)])
    # a stage that adds dt k = k to a sum that is zero
    first = 16 + layer["halo_lo"] - begin
    area = dof * stride
    target = Target(first, first + area, first + 2 * area, first + 2 * area, -1, stride, 0.0, 1.0)
    for part in ranges:
        kernel(layer, packed(order), memory, first, 16 + 3 * area, target, *part)
    after = memory[16 : 16 + 3 * area].reshape(areas.shape)
    assert np.array_equal(after[0], areas[0], equal_nan=True), "the state is only read"
    outside = np.ones(stride, bool)
    outside[layer["halo_lo"] : layer["halo_lo"] + end - begin] = False
    assert np.array_equal(after[:, :, outside], areas[:, :, outside], equal_nan=True), "nothing else changes"
    return after[2][:, ~outside].T


def survey(kernel, layer: np.void, q: np.ndarray, cuts: tuple[int, ...] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Survey by fluid_survey or solid_survey of a rank that owns all points, cut into parts; the memory it stands in."""
    stride = layer["stride"] = len(q) + 5
    layer["own_lo"], layer["own_hi"] = 0, len(q)
    memory = np.full(16 + q.shape[1] * stride + SIZE, np.nan)
    memory[16:-SIZE].reshape(-1, stride)[:, : len(q)] = q.T
    at = memory.size - SIZE
    begin_survey(layer, memory, at)
    for begin, end in itertools.pairwise((0, *cuts, len(q))):
        kernel(layer, memory, 16, at, begin, end)
    return memory[at:], memory


def assert_close(got: np.ndarray, wanted: np.ndarray) -> None:
    """Equal up to round-off of the largest number in a column."""
    assert np.all(np.abs(got - wanted) <= 1e-10 * np.abs(wanted).max(axis=0)), np.abs(got - wanted).max(axis=0)


def sizes(order: int) -> list[int]:
    """Numbers of active points: the smallest, where the closures meet, and over the seams of blocks."""
    least = OPERATORS[order].min_points
    return [*range(least, least + 6), 60, BLOCK, BLOCK + 1, 2 * BLOCK + 5]


@ORDERS
@pytest.mark.parametrize("spare", [(0, 9), (9, 0), (0, 0)], ids=["spare right", "spare left", "no spare"])
def test_fluid_against_matrices(order, spare):
    for active in sizes(order):
        n = active + sum(spare)
        layer, q = fluid_record(n, spare[0], n - 1 - spare[1]), fluid_state(n)
        got = right_hand_side(fluid_rhs, layer, order, q, 0, n)
        assert_close(got, fluid_reference(order, layer, q))
        inactive = np.ones(n, bool)
        inactive[layer["lo"] : layer["hi"] + 1] = False
        assert np.all(got[inactive] == 0)


@ORDERS
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
def test_solid_against_matrices(order, gruneisen):
    for n in sizes(order):
        layer, q = solid_record(n, gruneisen), solid_state(n)
        assert_close(right_hand_side(solid_rhs, layer, order, q, 0, n), solid_reference(order, layer, q))


@ORDERS
@pytest.mark.parametrize("spare", [(0, 5), (5, 0)], ids=["spare right", "spare left"])
def test_fluid_is_the_same_bit_for_bit_wherever_it_is_cut(order, spare):
    n = 70
    layer, q = fluid_record(n, spare[0], n - 1 - spare[1]), fluid_state(n)
    whole = right_hand_side(fluid_rhs, layer, order, q, 0, n)
    for begin, end in itertools.combinations(range(n + 1), 2):
        assert np.array_equal(right_hand_side(fluid_rhs, layer, order, q, begin, end), whole[begin:end]), (begin, end)


@ORDERS
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
def test_solid_is_the_same_bit_for_bit_wherever_it_is_cut(order, gruneisen):
    n = 60
    layer, q = solid_record(n, gruneisen), solid_state(n)
    whole = right_hand_side(solid_rhs, layer, order, q, 0, n)
    for begin, end in itertools.combinations(range(n + 1), 2):
        assert np.array_equal(right_hand_side(solid_rhs, layer, order, q, begin, end), whole[begin:end]), (begin, end)


@pytest.mark.parametrize("begin", [BLOCK - 7, BLOCK, BLOCK + 3])
def test_cuts_near_the_seam_of_blocks(begin):
    n = 2 * BLOCK + 40
    layer, q = fluid_record(n, 3, n - 4), fluid_state(n)
    whole = right_hand_side(fluid_rhs, layer, 8, q, 0, n)
    for a, b in ((0, begin), (begin, n)):
        assert np.array_equal(right_hand_side(fluid_rhs, layer, 8, q, a, b), whole[a:b])


@ORDERS
@pytest.mark.parametrize("kind", ["fluid", "solid"])
def test_any_part_of_the_points_can_be_evaluated_alone(order, kind):
    n = 2 * BLOCK + 40
    if kind == "fluid":
        kernel, layer, q = fluid_rhs, fluid_record(n, 3, n - 4), fluid_state(n)
    else:
        kernel, layer, q = solid_rhs, solid_record(n, 0.3), solid_state(n)
    whole = right_hand_side(kernel, layer, order, q, 0, n)
    for cuts in ((1,), (7, 9), (BLOCK + 1, BLOCK + 2), (n - 9, n - 8), tuple(range(5, n, 37))):
        assert np.array_equal(right_hand_side(kernel, layer, order, q, 0, n, cuts), whole), cuts


CUTS = pytest.mark.parametrize("cuts", [(), (1,), (5, 6, 11), (40,)], ids=str)


@CUTS
def test_survey_of_the_fluid(cuts):
    n = 3 * BLOCK // 2 + 1
    layer, q = fluid_record(n, 2, n - 3), fluid_state(n)
    seen, _ = survey(fluid_survey, layer, q, cuts)
    rho, u, T, _ = GAS.primitive(q[2:-2])
    np.testing.assert_allclose(seen[SPEED], np.max(np.abs(u - layer["s"]) + GAS.sound_speed(T)), rtol=1e-13)
    np.testing.assert_allclose([seen[LEAST_RHO], seen[LEAST_T]], [rho.min(), T.min()], rtol=1e-13)
    np.testing.assert_allclose(seen[SUMS : SUMS + 3], q[2:-2].sum(axis=0), rtol=1e-12)
    for at, column, value in ((2, 0, -1.0), (n // 2, 2, 0.0), (n - 3, 1, np.nan)):
        broken = q.copy()
        broken[at, column] = value
        found, _ = survey(fluid_survey, layer, broken, cuts)
        assert not (found[LEAST_RHO] > 0 and found[LEAST_T] > 0 and found[SPEED] < np.inf)
    for at in (0, 1, n - 2, n - 1):  # outside the active part
        broken = q.copy()
        broken[at] = np.nan
        assert np.array_equal(survey(fluid_survey, layer, broken, cuts)[0], seen, equal_nan=True)


@CUTS
def test_survey_of_the_solid(cuts):
    n = 50
    layer, q = solid_record(n, 0.0), solid_state(n)
    x_X = np.diff(q[:, 3]).min() / H
    expected = [ROD.K / ROD.m0 / x_X, 1 / x_X, x_X, q[:, 2].min()]
    seen, memory = survey(solid_survey, layer, q, cuts)
    np.testing.assert_allclose(solid_bounds(layer, memory, memory.size - SIZE), expected, rtol=1e-12)
    sums = q[:, 0].sum(), np.sum(q[:, 0] ** 2), q[:, 2].sum()
    np.testing.assert_allclose(seen[SUMS : SUMS + 3], sums, rtol=1e-12)
    for at, column, value in ((0, 2, -1.0), (n - 1, 2, 0.0), (7, 0, np.nan), (n - 1, 0, np.nan), (4, 1, np.nan), (9, 3, 1e9)):
        broken = q.copy()
        broken[at, column] = value
        _, memory = survey(solid_survey, layer, broken, cuts)
        c2, _, x_X, T = solid_bounds(layer, memory, memory.size - SIZE)
        assert not (x_X > 0 and T > 0 and c2 >= 0)


# --- embedded boundaries ----------------------------------------------------------------------------------------------

DEGREES = pytest.mark.parametrize("degree", [2, 3, 4, 5])
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
            ghost = dirichlet_ghost((delta - 0.3) ** power, values, weights, degree)
            np.testing.assert_allclose(ghost, values[0], rtol=1e-12, atol=1e-11)


@DEGREES
def test_dirichlet_formula_never_divides_by_a_small_number(degree):
    for delta in np.linspace(0, 1, 101)[:-1]:
        weights, _ = weights_at(delta, degree)
        unit = np.eye(NODES)
        assert max(abs(dirichlet_ghost(0.0, row, weights, degree)) for row in unit) <= 4 * 2**degree


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
        np.testing.assert_allclose(extrapolate(values, degree), values[0])
    assert extrapolate((np.arange(NODES) + 2.0) ** (degree + 1), degree) != 2.0 ** (degree + 1)


SIDES = pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])


def filled(kind: int, side: int, delta: float, data: tuple[float, ...] = (), degree: int = 2, new: bool = False):
    """(layer, rows of rho, u, T before, after) of a boundary fill."""
    layer = fluid_record(40, 0, 39)
    layer["end_kind"], layer["end_degree"] = kind, degree
    layer["end_data"][side, : len(data)] = data
    k = np.arange(NODES)
    nodes = np.zeros((5, NODES))
    nodes[0], nodes[1], nodes[2] = 1.2 + 0.02 * k, 4 - 0.5 * k, 300 + 2 * k - 0.2 * k * k
    before = nodes[:3].copy()
    if new:
        nodes[:3, 0] = np.nan
    fill_ghost(layer, packed(4), side, delta, nodes, new)
    return layer, before, nodes[:3]


def pressure(values: np.ndarray) -> float:
    return GAS.R * values[0] * values[2]


@SIDES
@pytest.mark.parametrize("delta", DELTAS)
def test_wall(side, delta):
    _, before, after = filled(WALL, side, delta)
    n, old, ghost = 2 * side - 1, before[:, 0], after[:, 0]
    weights, slopes = weights_at(delta, 2)
    impedance = old[0] * GAS.sound_speed(old[2])
    np.testing.assert_allclose(pressure(ghost) + n * impedance * ghost[1], pressure(old) + n * impedance * old[1], rtol=1e-14)
    assert abs(slopes[:3] @ after[2, :3]) < 1e-11, "the heat flux through the wall"
    if weights[0] >= 0.25:
        assert abs(weights[:3] @ after[1, :3]) < 1e-13, "the velocity at the wall"
    assert np.array_equal(after[:, 1:], before[:, 1:])


@SIDES
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_open_end(side, speed):
    """What comes in is the state at rest; what goes out stays."""
    layer = fluid_record(40, 0, 39)
    p0, T0 = 1e5, 290.0
    layer["end_kind"] = OPEN
    layer["end_data"][side, :2] = p0, T0
    n = 2 * side - 1
    nodes = np.zeros((5, NODES))
    nodes[:3] = np.array([1.25, n * speed, 295.0])[:, None]
    rho, u, T = nodes[:3, 0].copy()
    fill_ghost(layer, packed(4), side, 0.4, nodes, False)
    ghost = nodes[:3, 0]
    c, rho0 = GAS.sound_speed(T0), p0 / (GAS.R * T0)
    Z = rho0 * c
    np.testing.assert_allclose(pressure(ghost) + n * Z * ghost[1], GAS.R * rho * T + n * Z * u, rtol=1e-14)
    np.testing.assert_allclose(pressure(ghost) - n * Z * ghost[1], p0, rtol=1e-14)
    entropy = rho - rho0 - (GAS.R * rho * T - p0) / c**2 if speed > 0 else 0.0
    np.testing.assert_allclose(ghost[0] - rho0 - (pressure(ghost) - p0) / c**2, entropy, atol=1e-13)


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
    given = np.array([dirichlet_ghost(g, row, weights, degree) for g, row in zip(data, before, strict=True)])
    old, ghost = before[:, 0], after[:, 0]
    c = GAS.sound_speed(before[2, 1])
    Z = before[0, 1] * c
    np.testing.assert_allclose(pressure(ghost) + n * Z * ghost[1], pressure(old) + n * Z * old[1], rtol=1e-14)
    np.testing.assert_allclose(pressure(ghost) - n * Z * ghost[1], pressure(given) - n * Z * given[1], rtol=1e-14)
    kept = old if n * given[1] >= 0 else given
    np.testing.assert_allclose(ghost[0] - pressure(ghost) / c**2, kept[0] - pressure(kept) / c**2, atol=1e-13)


@SIDES
@pytest.mark.parametrize("kind", [WALL, OPEN, DIRICHLET], ids=["wall", "open", "dirichlet"])
@pytest.mark.parametrize("delta", DELTAS)
def test_filling_twice_is_filling_once(kind, side, delta):
    """So the fused step, which fills a stage once, is PETSc's, which fills what is full."""
    data = (1e5, 300.0) if kind == OPEN else (1.2, 4.0, 300.0)
    layer, _, once = filled(kind, side, delta, data, degree=2)
    nodes = np.zeros((5, NODES))
    nodes[:3] = once
    fill_ghost(layer, packed(4), side, delta, nodes, False)
    np.testing.assert_allclose(nodes[:3], once, rtol=1e-13)


@SIDES
@pytest.mark.parametrize("kind", [WALL, OPEN, DIRICHLET], ids=["wall", "open", "dirichlet"])
def test_a_new_point_is_filled_without_its_own_value(kind, side):
    data = (1e5, 300.0) if kind == OPEN else (1.2, 4.0, 300.0)
    _, before, after = filled(kind, side, 0.9, data, new=True)
    assert np.all(np.isfinite(after))
    np.testing.assert_allclose(after[[0, 2], 0], before[[0, 2], 0], rtol=0.1)


@SIDES
@pytest.mark.parametrize("kind", [CLAMPED, FREE, ABSORBING], ids=["clamped", "free", "absorbing"])
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
@ORDERS
def test_ends_of_a_solid(order, kind, side, gruneisen):
    n, layer = 2 * side - 1, solid_record(40, gruneisen)
    value = 0.7 if kind == CLAMPED else -9e4
    layer["end_kind"][side], layer["end_data"][side, 0] = kind, value
    rows = max(2, OPERATORS[order].rows)
    trace = solid_state(40)[:rows].copy()
    trace[:, 3] *= -n
    before = trace.copy()
    close_solid(layer, packed(order), side, trace)
    d = -n / H * np.array([float(w) for w in OPERATORS[order].closure[0][:rows]])
    x_X = d @ trace[:, 3]
    traction, old = (v[0, 1] - gruneisen * ROD.m0 * ROD.alpha * trace[0, 2] / x_X for v in (trace, before))
    Z = np.sqrt(ROD.K * ROD.m0 / x_X)
    assert abs(d @ trace[:, 2]) < 1e-9, "no heat through the end"
    if kind == CLAMPED:
        assert trace[0, 0] == value
    elif kind == FREE:
        np.testing.assert_allclose(traction, value, rtol=1e-14)
    else:
        np.testing.assert_allclose(traction - value + n * Z * trace[0, 0], 0, atol=1e-9)
        np.testing.assert_allclose(traction - n * Z * trace[0, 0], old - n * Z * before[0, 0], rtol=1e-13)
    assert np.array_equal(trace[1:], before[1:])
    assert trace[0, 3] == before[0, 3]
