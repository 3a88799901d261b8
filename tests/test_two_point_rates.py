"""Convection in two-point form in the compiled right-hand side: against sums over pairs, what it conserves, on any cut."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from helpers import from_python
from test_kernels import GAS, ORDERS, H, fluid_record, fluid_state, right_hand_side

from fsipetsc.boundaries import WALL
from fsipetsc.operators import OPERATORS
from fsipetsc.operators.kernels import BLOCK
from fsipetsc.physics.constant_transport import constant_transport
from fsipetsc.materials.fluid import navier_stokes
from fsipetsc.physics.layer import UNLOADED
from fsipetsc.physics.perfect_gas import perfect_gas
from fsipetsc.physics.two_point import entropy_conserving
from fsipetsc.scheme.laws import LAWS, law
from fsipetsc.scheme.sweep import sweep

kernel = from_python(sweep, law(entropy_conserving(navier_stokes(perfect_gas, constant_transport))))
divergence = from_python(sweep, LAWS[0])
#: points: few, and enough for three blocks with ends in the middle of a vector
SIZES = pytest.mark.parametrize("n", [23, 2 * BLOCK + 37])


def log_mean(a, b):
    """(a - b) / (ln a - ln b) in more digits than a double has."""
    a, b = np.longdouble(a), np.longdouble(b)
    same = abs(a - b) < 1e-12 * a
    return np.where(same, (a + b) / 2, (a - b) / np.where(same, 1, np.log(a / np.where(same, 2 * a, b))))


def pairs(rho, u, T, w):
    """(n, n, 3) F of all pairs; w: velocities of the grid."""

    def mean(a):
        return (a[:, None] + a[None, :]) / 2

    p = rho * GAS.R * T
    flow = log_mean(rho[:, None], rho[None, :]) * (mean(u) - mean(w))
    energy = u[:, None] * u[None, :] / 2 + GAS.cv / log_mean(1 / T[:, None], 1 / T[None, :])
    work = (p[:, None] * u[None, :] + p[None, :] * u[:, None]) / 2
    return np.stack([flow, flow * mean(u) + mean(p), flow * energy + work], axis=-1).astype(float)


def moving(n: int, lo: int, hi: int):
    """A stretched layer, which changes its length, of gas without friction and conduction, and a rough state."""
    layer, q = fluid_record(n, lo, hi), fluid_state(n)
    layer["stretched"], layer["J"], layer["spread"], layer["s"] = 1, 1.3, 0.02, -3.0
    layer["mu"] = layer["kappa"] = 0.0
    i = np.arange(n)
    q[:, [0, 2]] *= (1 + 0.7 * (i > n // 3) + 0.1 * (-1.0) ** i * (i > n // 2))[:, None]
    return layer, q


def state(layer, q):
    """rho, u, T per volume in space, and the velocities of the grid."""
    rho, u, T, _ = GAS.primitive(q / float(layer["J"]))
    return rho, u, T, float(layer["s"]) + float(layer["spread"]) * np.arange(len(q))


def variables(rho, u, T):
    """(n, 3) derivatives of -rho S."""
    cp = GAS.cv + GAS.R
    return np.stack([(cp * T - u * u / 2) / T - GAS.cv * np.log(T) + GAS.R * np.log(rho), u / T, -1 / T], axis=-1)


@ORDERS
@SIZES
def test_rates(order, n):
    """Those of the sum over all pairs; nothing changes beyond the ends."""
    layer, q = moving(n, 2, n - 2)
    found, active = right_hand_side(kernel, layer, order, q, 0, n), slice(2, n - 1)
    rho, u, T, w = (a[active] for a in state(layer, q))
    D = OPERATORS[order].matrix(len(rho), H)
    expected = -2 * np.einsum("il,ilk->ik", D, pairs(rho, u, T, w))
    scale = np.abs(D) @ np.abs(pairs(rho, u, T, w)).max(axis=1)
    assert np.all(np.abs(found[active] - expected) <= 1e-13 * scale.max(axis=0))
    assert not found[:2].any() and not found[n - 1 :].any()


@ORDERS
def test_uniform_flow(order):
    """A uniform flow stays one on a grid that is stretched: J U changes as J does."""
    n = 61
    layer, q = moving(n, 0, n - 1)
    q[:] = float(layer["J"]) * GAS.conserved(np.full(n, 1.2), np.full(n, 7.0), np.full(n, 300.0))
    found = right_hand_side(kernel, layer, order, q, 0, n)
    change = float(layer["spread"]) / H / float(layer["J"])
    np.testing.assert_allclose(found, change * q, atol=1e-10 * np.abs(q).max() / H)


def closed(n: int, V: tuple[float, float]):
    """Between two walls that move with V: the grid's ends, and the gas there, have these velocities."""
    layer, q = moving(n, 0, n - 1)
    layer["s"], layer["spread"] = V[0], (V[1] - V[0]) / (n - 1)
    layer["end_kind"], layer["unloaded"], layer["end_v"] = WALL, UNLOADED, V
    for i, v in ((0, V[0]), (-1, V[1])):
        q[i, 2] += (q[i, 0] * v) ** 2 / 2 / q[i, 0] - q[i, 1] ** 2 / 2 / q[i, 0]
        q[i, 1] = q[i, 0] * v
    return layer, q


def entropy_rate(layer, q, rates, order):
    """(rate of the entropy of a closed gas, sum of the absolute values of its parts); walls give their points the velocity."""
    rho, u, T, _ = state(layer, q)
    rates = rates.copy()
    rates[[0, -1], 1] = u[[0, -1]] * rates[[0, -1], 0]
    norm = OPERATORS[order].norm_weights(len(q))[:, None]
    parts = -norm * variables(rho, u, T) * rates
    # rho S J: its rate is that of J U times the derivatives and R rho J_t
    grown = GAS.R * np.sum(norm[:, 0] * rho) * float(layer["spread"]) / H
    return parts.sum() + grown, np.abs(parts).sum()


@ORDERS
def test_entropy_is_conserved(order):
    """In a closed gas without friction and conduction at a rough state, between walls at rest and such that move."""
    for V in ((0.0, 0.0), (3.0, -2.0)):
        layer, q = closed(61, V)
        found = right_hand_side(kernel, layer, order, q, 0, 61)
        plain = right_hand_side(divergence, layer, order, q, 0, 61)
        rate, parts = entropy_rate(layer, q, found, order)
        assert abs(rate) < 1e-12 * parts
        assert abs(entropy_rate(layer, q, plain, order)[0]) > 1e-7 * parts


@ORDERS
def test_friction_and_conduction_produce_entropy(order):
    for mu, kappa in ((GAS.mu, 0.0), (0.0, GAS.kappa), (GAS.mu, GAS.kappa)):
        layer, q = closed(61, (3.0, -2.0))
        layer["mu"], layer["kappa"] = 4 / 3 * mu, kappa
        found = right_hand_side(kernel, layer, order, q, 0, 61)
        rate, parts = entropy_rate(layer, q, found, order)
        _, u, T, _ = state(layer, q)
        D, J = OPERATORS[order].matrix(61, H), float(layer["J"])
        w2, w3 = D @ (u / T) / J, D @ (-1 / T) / J
        u_x, T_x = T * (w2 + u * w3), T * T * w3
        norm = OPERATORS[order].norm_weights(61)
        produced = J * np.sum(norm * (4 / 3 * mu * u_x**2 / T + kappa * T_x**2 / T**2))
        assert produced > 0 and abs(rate - produced) < 1e-11 * parts


@ORDERS
def test_conserved(order):
    """Between walls at rest mass and energy stay to round-off."""
    layer, q = closed(61, (0.0, 0.0))
    layer["mu"], layer["kappa"] = GAS.mu, GAS.kappa
    found = right_hand_side(kernel, layer, order, q, 0, 61)
    norm = OPERATORS[order].norm_weights(61)
    for c in (0, 2):
        assert abs(norm @ found[:, c]) < 1e-13 * (norm @ np.abs(found[:, c]))
