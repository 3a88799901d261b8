"""The dissipation of the compiled right-hand side: against matrices, on any cut, and what it does to energy and entropy."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from helpers import from_python
from test_kernels import GAS, ORDERS, ROD, H, fluid_record, fluid_state, right_hand_side, solid_record, solid_state

from fsipetsc.boundaries import WALL
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.kernels import BLOCK
from fsipetsc.operators.narrow import difference
from fsipetsc.operators.sensor import SMALL
from fsipetsc.physics import dissipation
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.physics.fluid import navier_stokes
from fsipetsc.physics.gruneisen import gruneisen
from fsipetsc.physics.layer import UNLOADED
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.solid import elastic_solid
from fsipetsc.scheme.laws import law
from fsipetsc.scheme.sweep import sweep

GAS_TERMS = dissipation.GAS_SHOCKS, dissipation.GAS_DISSIPATION[1]
SOLID_TERMS = dissipation.SOLID_SHOCKS, dissipation.SOLID_DISSIPATION[1]
gas_kernel = from_python(sweep, law(navier_stokes(perfect_gas, constant_transport, GAS_TERMS)))
solid_kernel = from_python(sweep, law(elastic_solid(gruneisen, SOLID_TERMS)))
#: points: few, and enough for three blocks with ends in the middle of a vector
SIZES = pytest.mark.parametrize("n", [23, 2 * BLOCK + 37])
SIGMA, SHOCKS = 0.7, 1.3
MEANS = {1: (1 / 2, 1 / 2), 2: (1 / 4, 1 / 2, 1 / 4), 3: (1 / 8, 3 / 8, 3 / 8, 1 / 8), 4: (1 / 4, 1 / 2, 1 / 4)}


def differences(n: int, q: int) -> np.ndarray:
    """(n - q, n)."""
    return sum(np.eye(n - q, n, k) * weight for k, weight in enumerate(difference(q)))


def middles(n: int, q: int, weights) -> np.ndarray:
    """(n - q, n)"""
    first = (q + 1 - len(weights)) // 2
    return sum(np.eye(n - q, n, first + k) * weight for k, weight in enumerate(weights))


def alpha_of(p: int, *rows) -> np.ndarray:
    """(n - 1,) the sensor of rows (values, least)."""
    s = np.zeros(len(rows[0][0]))
    for a, least in rows:
        rise, fall = a[2:] - a[1:-1], a[1:-1] - a[:-2]
        total = abs(rise) + abs(fall) + SMALL * (abs(a[2:]) + 2 * abs(a[1:-1]) + abs(a[:-2])) + least
        s[1:-1] = np.maximum(s[1:-1], abs(rise - fall) / total)
    seen = np.pad(s, p)
    return np.minimum(1, 2 * np.array([seen[i + 1 : i + 2 * p + 1].max() for i in range(len(s) - 1)]))


def limit_of(p: int, alpha: np.ndarray) -> np.ndarray:
    """(n - p,) 1 - alpha of the differences of order p."""
    return 1 - np.array([alpha[i : i + p].max() for i in range(len(alpha) + 1 - p)])


def near_ends(order: int, n: int, q: int, of_two: bool) -> np.ndarray:
    """(n - q,) at most 1: least weight of the norm at the points of a difference, of two neighbours their geometric mean."""
    H_ = OPERATORS[order].norm_weights(n)
    return np.array([min(1, np.sqrt(H_[i] * H_[i + 1]) if of_two else H_[i : i + q + 1].min()) for i in range(n - q)])


def variables(rho, u, T) -> np.ndarray:
    """(3, n) derivatives of -rho S."""
    cp = GAS.cv + GAS.R
    return np.array([(cp * T - u * u / 2) / T - GAS.cv * np.log(T) + GAS.R * np.log(rho), u / T, -1 / T])


def derivative_of_state(rho, u, T) -> np.ndarray:
    """dU/dw (3, 3) in the form with the pressure and the enthalpy."""
    p = rho * GAS.R * T
    e = rho * (GAS.cv * T + u * u / 2)
    H_t, c2 = (e + p) / rho, GAS.gamma * GAS.R * T
    flux, last = rho * H_t * u, rho * H_t**2 - c2 * p / (GAS.gamma - 1)
    return np.array([[rho, rho * u, e], [rho * u, rho * u * u + p, flux], [e, flux, last]]) / GAS.R


def gas_terms(order: int, q: np.ndarray, w: np.ndarray, sigma: float, shocks: float) -> np.ndarray:
    """(n, 3) what is added to the rates; w: velocity of the grid."""
    p, n = order // 2, len(q)
    rho, u, T, pressure = GAS.primitive(q)
    speed = abs(u - w) + GAS.sound_speed(T)
    alpha = alpha_of(p, (rho, 0.0), (pressure, 0.0))
    factor = shocks / 2 * alpha * np.maximum(speed[1:], speed[:-1]) * near_ends(order, n, 1, True)
    total = differences(n, 1).T @ (factor[:, None] * (differences(n, 1) @ q))
    mean, D, v = middles(n, p, MEANS[p]), differences(n, p), variables(rho, u, T)
    means = mean @ rho, (mean @ v[1]) / -(mean @ v[2]), 1 / -(mean @ v[2])
    factor = sigma / 4**p * limit_of(p, alpha) * (mean @ speed) * near_ends(order, n, p, False)
    inner = [a * derivative_of_state(*state) @ d for a, state, d in zip(factor, np.transpose(means), (D @ v.T), strict=True)]
    total += D.T @ np.array(inner)
    return -total / OPERATORS[order].norm_weights(n)[:, None] / H


def solid_terms(order: int, q: np.ndarray, sigma: float, shocks: float) -> np.ndarray:
    """(n, 2) what is added to the rates of u and T."""
    p, n = order // 2, len(q)
    alpha, Z = alpha_of(p, (q[:, 1], 1e-10 * ROD.K)), np.sqrt(ROD.K * ROD.m0 / (OPERATORS[order].matrix(n, H) @ q[:, 3]))
    du, dT = np.zeros(n), np.zeros(n)
    at_shocks, everywhere = 0.7 * shocks * alpha * np.maximum(Z[1:], Z[:-1]), sigma / 4**p * (middles(n, p, MEANS[p]) @ Z)
    for k, factor, of_two in ((1, at_shocks, True), (p, everywhere * limit_of(p, alpha), False)):
        D, factor = differences(n, k), factor * near_ends(order, n, k, of_two)
        du -= D.T @ (factor * (D @ q[:, 0])) / ROD.m0
        dT += middles(n, k, (1,) if k % 2 == 0 else (0.5, 0.5)).T @ (factor * (D @ q[:, 0]) ** 2) / (ROD.m0 * ROD.alpha)
    return np.stack([du, dT], axis=-1) / OPERATORS[order].norm_weights(n)[:, None] / H


def rough(q: np.ndarray, columns: tuple[int, ...]) -> np.ndarray:
    """With steps, large and small, and what no grid resolves."""
    q, i = q.copy(), np.arange(len(q))
    for c in columns:
        q[:, c] *= 1 + 0.6 * (i > len(q) // 3) + 1e-3 * (i > len(q) // 2) + 0.02 * (-1.0) ** i * (i > 2 * len(q) // 3)
    return q


def gas_at(n: int, lo: int, hi: int, sigma: float = SIGMA, shocks: float = SHOCKS):
    layer = fluid_record(n, lo, hi)
    layer["dissipation"], layer["shocks"] = sigma, shocks
    return layer, rough(fluid_state(n), (0, 2))


def solid_at(n: int, sigma: float = SIGMA, shocks: float = SHOCKS):
    layer = solid_record(n, 0.3)
    layer["dissipation"], layer["shocks"] = sigma, shocks
    return layer, rough(solid_state(n), (0, 1))


def added(kernel, made, order: int, n: int) -> np.ndarray:
    """What the terms add to the rates."""
    layer, q = made
    found = right_hand_side(kernel, layer, order, q, 0, n)
    layer["dissipation"] = layer["shocks"] = 0.0
    return found - right_hand_side(kernel, layer, order, q, 0, n)


@ORDERS
@SIZES
@pytest.mark.parametrize("strength", [(SIGMA, 0.0), (0.0, SHOCKS)], ids=["dissipation", "shocks"])
def test_gas(order, n, strength):
    """What is added is what the matrices say, to the round-off of the rates; nothing changes beyond the ends."""
    made = gas_at(n, 2, n - 2, *strength)
    found, active = added(gas_kernel, made, order, n), slice(2, n - 1)
    assert not found[:2].any() and not found[n - 1 :].any()
    expected = gas_terms(order, made[1][active], float(made[0]["s"]), *strength)
    rounding = 1e-11 * np.abs(right_hand_side(gas_kernel, made[0], order, made[1], 0, n)).max(axis=0)
    assert np.all(np.abs(expected).max(axis=0) > 1e3 * rounding)
    assert np.all(np.abs(found[active] - expected) <= rounding + 1e-10 * np.abs(expected))


@ORDERS
@SIZES
@pytest.mark.parametrize("strength", [(SIGMA, 0.0), (0.0, SHOCKS)], ids=["dissipation", "shocks"])
def test_solid(order, n, strength):
    made = solid_at(n, *strength)
    found = added(solid_kernel, made, order, n)
    assert not found[:, [1, 3]].any()
    expected = solid_terms(order, made[1], *strength)
    rounding = 1e-11 * np.abs(right_hand_side(solid_kernel, made[0], order, made[1], 0, n)).max(axis=0)[[0, 2]]
    assert np.all(np.abs(found[:, [0, 2]] - expected) <= rounding + 1e-10 * np.abs(expected))
    assert np.abs(expected).max() > 1e-6


@ORDERS
def test_any_cut_gives_the_same_bits(order):
    n = 2 * BLOCK + 37
    for kernel, (layer, q) in ((gas_kernel, gas_at(n, 2, n - 2)), (solid_kernel, solid_at(n))):
        whole = right_hand_side(kernel, layer, order, q, 0, n)
        assert np.isfinite(whole).all()
        for begin, end, cuts in ((0, n, (5, 17, BLOCK + 3)), (0, 61, (9, 30)), (61, 700, (333,)), (700, n, (n - 7,))):
            assert np.array_equal(whole[begin:end], right_hand_side(kernel, layer, order, q, begin, end, cuts))


@ORDERS
def test_conserved_and_entropy(order):
    """Mass, momentum and energy stay; the entropy of the gas grows, that of the solid at each point, and by both terms."""
    n = 61
    norm = OPERATORS[order].norm_weights(n)
    for strength in ((SIGMA, 0.0), (0.0, SHOCKS)):
        made = gas_at(n, 0, n - 1, *strength)
        found, (rho, u, T, _) = added(gas_kernel, made, order, n), GAS.primitive(made[1])
        assert np.all(np.abs(norm @ found) <= 1e-13 * (norm @ np.abs(found)) + 1e-12 * np.abs(made[1]).sum(axis=0) / H)
        w = variables(rho, u, T)
        assert -np.sum(norm * (w * found.T).sum(axis=0)) > 0
        made = solid_at(n, *strength)
        du, dT = added(solid_kernel, made, order, n)[:, [0, 2]].T
        assert np.all(dT > -1e-9 * np.abs(dT).max())
        lost = -norm @ (ROD.m0 * made[1][:, 0] * du)
        assert lost > 0
        np.testing.assert_allclose(norm @ (ROD.m0 * ROD.alpha * dT), lost, rtol=1e-9)


def test_moving_wall():
    """The wall gives its point the momentum: what dissipation would change of it is work of the wall's."""
    n, order, V = 41, 4, 2.5
    made = gas_at(n, 0, n - 1)
    free = added(gas_kernel, made, order, n)
    made = gas_at(n, 0, n - 1)
    layer = made[0]
    layer["end_kind"][0], layer["unloaded"][0], layer["end_v"][0] = WALL, UNLOADED, V
    at_wall = added(gas_kernel, made, order, n)
    rho, m, _ = free[0]
    scale = np.abs(free[0]).max()
    np.testing.assert_allclose(at_wall[0] - free[0], [0, 0, V * (V * rho - m)], atol=1e-9 * scale)
    np.testing.assert_array_equal(at_wall[1:], free[1:])
