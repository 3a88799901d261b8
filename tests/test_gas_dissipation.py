"""Dissipation of gas blocks, with the terms of shocks. The oracle of blocks has no shocks of gases:
here they are sums over all pairs and links of a line.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import oracle_formulas as formulas
import pytest

from fsipetsc.equations.gas import Gas
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.operators.bands import NO_AXIS, Patch, band
from fsipetsc.operators.undivided import differences
from fsipetsc.scheme.gas_dissipation import gas_damping, gas_dissipation
from fsipetsc.scheme.gas_memory import Work, scratch
from fsipetsc.scheme.gas_rates import gas_rates
from fsipetsc.scheme.gas_rows import EntropyForm, Viscous

LAW = formulas.Gas()
GAS = Gas(PerfectGas(LAW.gamma, LAW.R), ConstantTransport(), 0.0, 0.0, (0.0,))
#: numba compiles it anew for each order
ORDERS = pytest.mark.parametrize("order", [2, 4, pytest.param(6, marks=pytest.mark.long)])


class OnePart(NamedTuple):
    """What rates take of a part, see fsipetsc.scheme.gas_record."""

    laws: Gas
    like: tuple
    form: EntropyForm
    viscous: Viscous
    metrics: np.ndarray
    S: tuple
    weight: tuple
    patch: Patch
    work: Work


def part_of(gas, metrics, axes, patch):
    """Of the bands of the axes."""
    like, work = gas.force, scratch(gas.force, Viscous(), axes, patch)
    S, weight = zip(*axes, strict=True)
    return OnePart(gas, like, EntropyForm(), Viscous(), metrics, S, weight, patch, work)


class Line(NamedTuple):
    """Nodes of [0, 1] with unknowns q (n, 4), on a grid of the velocity metrics[1]; the axes."""

    q: np.ndarray
    metrics: np.ndarray
    axes: list
    order: int

    @property
    def weights(self):
        return self.axes[0].weight[:, None]

    def dissipation(self, sigma, shock):
        """(n, 4) rates."""
        n = len(self.q)
        found, rates = differences(1, self.order, self.axes, [n - 1]), np.zeros((n, 4))
        part = part_of(GAS, self.metrics, self.axes, Patch((n, 1, 1), (n, 1, 1), (0, 0, 0)))
        gas_dissipation(part, gas_damping(1, found, sigma, shock), self.q, rates)
        return rates


def line(order, spread=1.0):
    """A random state, or with rho, u and T one."""
    n, rng = (26 if order > 4 else 19), np.random.default_rng(7)
    v, J = 0.1 * rng.standard_normal(n), 0.9 + 0.2 * rng.random(n)
    rho, T = 1.0 + spread * rng.random((2, n))
    u = (rng.random(n) - 0.5) * (spread > 0.0) + 0.4
    q = np.array(GAS.conserved(J, rho, (u,), T)).T.copy()
    metrics = np.array([np.ones(n), v, np.zeros(n)])
    return Line(q, metrics, [band(order, n - 1), NO_AXIS, NO_AXIS], order)


@ORDERS
@pytest.mark.parametrize("shock", [0.0, 1.0])
def test_dissipation_conserves_and_makes_entropy_grow(order, shock):
    """And a uniform flow stays, on a moving grid."""
    s = line(order, 0.3)
    found, w = s.weights * s.dissipation(0.3, shock), GAS.primitive(tuple(s.q.T))
    z = np.array([GAS.first_entropy_variable(w), *GAS.entropy_variables(w)]).T
    assert np.abs(found.sum(axis=0)).max() < 1e-14 * np.abs(found).sum()
    assert -(found[:, 1:] * z).sum() > 1e-3 * np.abs(found[:, 1:] * z).sum()
    assert np.abs(line(order, 0.0).dissipation(0.3, shock)[:, 1:]).max() < 1e-13


def steepness(a):
    """(n,) s of a line of values, 0 at the ends."""
    rise, fall = a[2:] - a[1:-1], a[1:-1] - a[:-2]
    size = np.abs(rise) + np.abs(fall) + 0.05 * (a[2:] + 2.0 * a[1:-1] + a[:-2])
    return np.pad(np.abs(rise - fall) / size, 1)


@ORDERS
def test_shock_terms_of_a_line(order):
    """Against sums over all pairs and links, one by one."""
    s = line(order, 0.03)
    v, S, n = s.metrics[1], s.axes[0].S, len(s.q)
    state = formulas.gas_state(LAW, s.q.T)
    s_most = np.maximum(steepness(state.rho), steepness(state.p))
    alpha = np.clip(2.5 * (s_most - 0.03), 0.0, 1.0)
    assert 0 < (alpha < 0.2).sum() < n

    def at(i):
        return formulas.State(*(f[..., i] for f in state))

    exact, A, G = np.zeros((3, n)), np.zeros(n), np.zeros(n)
    for i in range(n):
        for l in range(i + 1, min(i + len(S), n)):
            weight, g = alpha[i : l + 1].max() * S[l - i, i], 0.5 * (v[i] + v[l])
            F = weight * formulas.pair_flux(LAW, at(i), at(l), np.ones(1), g)
            exact[:, i] += F
            exact[:, l] -= F
            A[i:l] += weight
            G[i:l] += weight * g
    for m in range(n - 1):
        sides = at(m), at(m + 1)
        speed = max(
            abs(A[m] * w.u[0] - G[m]) + np.sqrt(LAW.gamma * LAW.R * w.T) * abs(A[m]) for w in sides
        )
        l, r = (formulas.conserved(LAW, w.rho, w.u, w.T) for w in sides)
        F = formulas.pair_flux(LAW, *sides, A[m : m + 1], G[m]) - 0.5 * 0.9 * speed * (r - l)
        exact[:, m] -= F
        exact[:, m + 1] += F
    found = s.weights * s.dissipation(0.0, 0.9)
    np.testing.assert_allclose(found[:, 1:].T, exact, rtol=0.0, atol=1e-14 * n)


def test_where_all_is_a_shock_there_is_no_other_dissipation():
    """Density goes up and down from node to node."""
    s = line(4, 0.0)
    s.q[::2, 1:] *= 2.0
    assert np.abs(s.dissipation(0.3, 0.0)).max() > 1e-2
    assert np.array_equal(s.dissipation(0.3, 0.9), s.dissipation(0.0, 0.9))


def test_rows_of_a_plane_are_lines():
    """A state that varies along rows; the end of one is not beside the beginning of the next."""
    s, m = line(4, 0.03), 13
    s.q[0, 1:] *= 2.0
    n, zero, (J, mass, momentum, energy) = len(s.q), np.zeros(len(s.q) * m), np.tile(s.q.T, m)
    gas, q = GAS._replace(force=(0.0, 0.0)), np.array([J, mass, momentum, zero, energy]).T.copy()
    one, v = np.ones(n * m), np.tile(s.metrics[1], m)
    metrics = np.array([one, zero, zero, one, v, zero, zero])
    axes, patch = [s.axes[0], band(4, m - 1), NO_AXIS], Patch((n, m, 1), (n, m, 1), (0, 0, 0))
    found, rates = differences(2, 4, axes, [n - 1, m - 1]), np.zeros((n * m, 5))
    part = part_of(gas, metrics, axes, patch)
    gas_dissipation(part, gas_damping(2, found, 0.3, 0.9), q, rates)
    expected = np.tile(s.dissipation(0.3, 0.9).T, m).T
    np.testing.assert_allclose(rates[:, [0, 1, 2, 4]], expected, rtol=0.0, atol=1e-14)
    assert np.abs(rates[:, 3]).max() == 0.0


@ORDERS
def test_strong_shock_lives(order):
    """A pressure ratio of 1000 onto a wall, fifty nodes: positive, mass and energy to round-off."""
    n, p = 51, np.where(np.arange(51) < 3 * 51 // 4, 1000.0, 1.0)
    axes, metrics = [band(order, n - 1), NO_AXIS, NO_AXIS], np.outer([1.0, 0.0, 0.0], np.ones(n))
    part = part_of(GAS, metrics, axes, Patch((n, 1, 1), (n, 1, 1), (0, 0, 0)))
    w = part.weight
    q = np.array(GAS.conserved(np.ones(n), np.ones(n), (np.zeros(n),), p)).T.copy()
    start, dt = w[0] @ q, 0.4 / (n - 1) / 60.0

    def slope(q):
        rates = np.zeros_like(q)
        gas_rates(part, q, rates)
        rates += Line(q, metrics, axes, order).dissipation(0.3, 1.0)
        rates[[0, -1], 2] = 0.0
        return rates

    for _ in range(120):
        a = slope(q)
        b = slope(q + 0.5 * dt * a)
        c = slope(q + 0.5 * dt * b)
        q = q + dt / 6.0 * (a + 2.0 * b + 2.0 * c + slope(q + dt * c))
    state = GAS.primitive(tuple(q.T))
    assert state[0].min() > 0.3 and state[1].min() > 0.9 and state[1][-1] > 500.0
    np.testing.assert_allclose((w[0] @ q)[[0, 1, 3]], start[[0, 1, 3]], rtol=1e-13)
