"""The compiled right-hand sides against plain matrices; extremes and sums."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from helpers import from_python

pytest.importorskip("numba")

from fsipetsc.operators import OPERATORS, packed
from fsipetsc.operators.kernels import BLOCK, scratch_size
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.layer import LAYER
from fsipetsc.physics.solid import Solid
from fsipetsc.scheme.extremes_and_sums import LEAST_RHO, LEAST_T, SIZE, SPEED, SUMS, begin_extremes_and_sums
from fsipetsc.scheme.laws import LAWS
from fsipetsc.scheme.stage_update import Target
from fsipetsc.scheme.sweep import sweep

fluid_rhs, solid_rhs = (from_python(sweep, law) for law in LAWS)
fluid_extremes, solid_extremes = (from_python(law.look, law) for law in LAWS)
solid_speeds = from_python(LAWS[1].speeds, LAWS[1])
begin_extremes_and_sums = from_python(begin_extremes_and_sums)

GAS = Fluid(mu=0.5, kappa=0.7, gamma=1.4, R=287.0)
ROD = Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, force=-10.0)
H = 0.01
HALO = 14  # points; enough for two derivatives of any order
ROWS = 20  # of scratch

ORDERS = pytest.mark.parametrize("order", OPERATORS)


def fluid_record(n: int, lo: int, hi: int) -> np.void:
    """A fluid layer of n stored points, lo..hi of them active, all on this rank."""
    layer = np.zeros(1, LAYER)[0]
    layer["n"], layer["lo"], layer["hi"], layer["own_hi"], layer["h"] = n, lo, hi, n, H
    layer["J"] = 1.0
    layer["gamma"], layer["R"], layer["cv"] = GAS.gamma, GAS.R, GAS.cv
    layer["mu"], layer["kappa"], layer["s"] = 4 / 3 * GAS.mu, GAS.kappa, -3.0
    return layer


def solid_record(n: int, gruneisen: float) -> np.void:
    """A solid layer of n points, all on this rank."""
    layer = np.zeros(1, LAYER)[0]
    layer["kind"], layer["n"], layer["hi"], layer["own_hi"], layer["h"], layer["J"] = 1, n, n - 1, n, H, 1.0
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
    target = Target(first, first + area, first + 2 * area, first + 2 * area, -1, stride, 0.0, 1.0, 1.0)
    for part in ranges:
        kernel(layer, packed(order), memory, first, 16 + 3 * area, target, *part)
    after = memory[16 : 16 + 3 * area].reshape(areas.shape)
    assert np.array_equal(after[0], areas[0], equal_nan=True), "the state is only read"
    outside = np.ones(stride, bool)
    outside[layer["halo_lo"] : layer["halo_lo"] + end - begin] = False
    assert np.array_equal(after[:, :, outside], areas[:, :, outside], equal_nan=True), "nothing else changes"
    return after[2][:, ~outside].T


def looked_at(kernel, layer: np.void, q: np.ndarray, cuts: tuple[int, ...] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Extremes and sums of a rank that owns all points, cut into parts, and the memory they stand in."""
    stride = layer["stride"] = len(q) + 5
    layer["own_lo"], layer["own_hi"] = 0, len(q)
    memory = np.full(16 + q.shape[1] * stride + SIZE, np.nan)
    memory[16:-SIZE].reshape(-1, stride)[:, : len(q)] = q.T
    at = memory.size - SIZE
    begin_extremes_and_sums(layer, memory, at)
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
@pytest.mark.parametrize("spread", [0.0, 0.1, -0.1])
def test_extremes_and_sums_of_the_fluid(cuts, spread):
    n = 3 * BLOCK // 2 + 1
    layer, q = fluid_record(n, 2, n - 3), fluid_state(n)
    layer["spread"] = spread  # the grid is fastest at the last point, which is not the last of four
    seen, _ = looked_at(fluid_extremes, layer, q, cuts)
    rho, u, T, _ = GAS.primitive(q[2:-2])
    relative = u - layer["s"] - spread * np.arange(2, n - 2)
    np.testing.assert_allclose(seen[SPEED], np.max(np.abs(relative) + GAS.sound_speed(T)), rtol=1e-13)
    np.testing.assert_allclose([seen[LEAST_RHO], seen[LEAST_T]], [rho.min(), T.min()], rtol=1e-13)
    np.testing.assert_allclose(seen[SUMS : SUMS + 3], q[2:-2].sum(axis=0), rtol=1e-12)
    for at, column, value in ((2, 0, -1.0), (n // 2, 2, 0.0), (n - 3, 1, np.nan)):
        broken = q.copy()
        broken[at, column] = value
        found, _ = looked_at(fluid_extremes, layer, broken, cuts)
        assert not (found[LEAST_RHO] > 0 and found[LEAST_T] > 0 and found[SPEED] < np.inf)
    for at in (0, 1, n - 2, n - 1):  # outside the active part
        broken = q.copy()
        broken[at] = np.nan
        assert np.array_equal(looked_at(fluid_extremes, layer, broken, cuts)[0], seen, equal_nan=True)


def squared_wave_speed(gruneisen: float, x_X: float, T: float, sigma: float) -> float:
    """Of the equations (3.1) without conduction, linearised: an eigenvalue."""
    heat = ROD.alpha * ROD.m0
    p = gruneisen * heat * T / x_X
    A = np.zeros((4, 4))  # u, sigma, T, x_X
    A[0, 1:] = np.array([1.0, -gruneisen * heat / x_X, p / x_X]) / ROD.m0
    A[1:, 0] = ROD.K / x_X, (sigma - p) / heat, 1.0
    return float(np.max(np.linalg.eigvals(A).real) ** 2)


@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
def test_wave_speed(gruneisen):
    for x_X in (0.25, 1.0, 1.7):
        c = dataclasses.replace(ROD, gruneisen=gruneisen).sound_speed(x_X, 310.0, -4e4)
        np.testing.assert_allclose(c**2, squared_wave_speed(gruneisen, x_X, 310.0, -4e4), rtol=1e-12)


@CUTS
@pytest.mark.parametrize("gruneisen", [0.0, 0.3])
def test_extremes_and_sums_of_the_solid(cuts, gruneisen):
    n = 50
    layer, q = solid_record(n, gruneisen), solid_state(n)
    q[:, 3] *= 0.4
    x_X = np.diff(q[:, 3]).min() / H
    c2 = squared_wave_speed(gruneisen, x_X, q[:, 2].max(), q[:, 1].min())
    expected = [1.0, np.sqrt(c2), ROD.kappa_e / (ROD.alpha * ROD.m0 * x_X)]
    seen, memory = looked_at(solid_extremes, layer, q, cuts)
    np.testing.assert_allclose(solid_speeds(layer, memory, memory.size - SIZE), expected, rtol=1e-12)
    sums = q[:, 0].sum(), np.sum(q[:, 0] ** 2), q[:, 2].sum()
    np.testing.assert_allclose(seen[SUMS : SUMS + 3], sums, rtol=1e-12)
    for at, column, value in ((0, 2, -1.0), (n - 1, 2, 0.0), (7, 0, np.nan), (n - 1, 0, np.nan), (4, 1, np.nan), (9, 3, 1e9)):
        broken = q.copy()
        broken[at, column] = value
        _, memory = looked_at(solid_extremes, layer, broken, cuts)
        assert not solid_speeds(layer, memory, memory.size - SIZE)[0]
