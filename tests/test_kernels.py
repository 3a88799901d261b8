"""The compiled right-hand sides against plain matrices."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from helpers import from_python

pytest.importorskip("numba")

from fsipetsc.operators import OPERATORS, packed
from fsipetsc.operators.kernels import BLOCK, scratch_size
from fsipetsc.materials.fluid import Fluid
from fsipetsc.physics.layer import LAYER
from fsipetsc.materials.line_solid import Solid
from fsipetsc.scheme.laws import LAWS
from fsipetsc.scheme.stage_update import Target
from fsipetsc.scheme.sweep import sweep

fluid_rhs, solid_rhs = (from_python(sweep, law) for law in LAWS)

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


def assert_close(got: np.ndarray, wanted: np.ndarray) -> None:
    """Equal up to round-off of the largest number in a column."""
    assert np.all(np.abs(got - wanted) <= 1e-10 * np.abs(wanted).max(axis=0)), np.abs(got - wanted).max(axis=0)


def sizes(order: int) -> list[int]:
    """Numbers of active points: the smallest, where the closures meet, and over the seams of blocks."""
    least = OPERATORS[order].min_points
    return [*range(least, least + 6), 60, BLOCK, BLOCK + 1, 2 * BLOCK + 5]


@ORDERS
@pytest.mark.parametrize("spare", [(9, 0)], ids=["spare left"])
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
@pytest.mark.parametrize("gruneisen", [0.3])
def test_solid_against_matrices(order, gruneisen):
    for n in sizes(order):
        layer, q = solid_record(n, gruneisen), solid_state(n)
        assert_close(right_hand_side(solid_rhs, layer, order, q, 0, n), solid_reference(order, layer, q))


def squared_wave_speed(gruneisen: float, x_X: float, T: float, sigma: float) -> float:
    """Of the equations (3.1) without conduction, linearised: an eigenvalue."""
    heat = ROD.alpha * ROD.m0
    p = gruneisen * heat * T / x_X
    A = np.zeros((4, 4))  # u, sigma, T, x_X
    A[0, 1:] = np.array([1.0, -gruneisen * heat / x_X, p / x_X]) / ROD.m0
    A[1:, 0] = ROD.K / x_X, (sigma - p) / heat, 1.0
    return float(np.max(np.linalg.eigvals(A).real) ** 2)
