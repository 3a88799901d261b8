"""Dissipation of gas blocks and the terms of shocks: against the numpy oracle, what they keep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import oracle_formulas as formulas
import pytest
from oracle_volume import Volume

from fsipetsc.equations.gas import Gas
from fsipetsc.materials.constant_transport import ConstantTransport
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.operators.bands import NO_AXIS, band
from fsipetsc.operators.patch import Patch
from fsipetsc.operators.undivided import differences
from fsipetsc.scheme.gas_dissipation import gas_dissipation, room
from fsipetsc.scheme.gas_rates import (
    DivergenceForm,
    EntropyForm,
    Viscous,
    gas_rates,
    scratch,
)

FORMS = {"entropy": EntropyForm(), "divergence": DivergenceForm()}
NODES = {1: (19,), 2: (14, 13), 3: (8, 9, 8)}


class Setting(NamedTuple):
    """A block of the oracle at a random state q (d + 3, ...), its grid, the same for the engine."""

    oracle: Volume
    equations: Gas
    like: tuple
    q: np.ndarray
    grid: object
    metrics: np.ndarray


def flat(array, components):
    """(components, N), axis 0 contiguous."""
    return np.asarray(array).reshape(components, -1, order="F")


def setting(d, form="entropy", viscous=False, order=4, periodic=False, spread=1.0, sigma=0.0):
    """periodic: along axis 1."""
    rng, nodes = np.random.default_rng(7), NODES[d]
    if order > 4:
        nodes = (26, 24, 24)[:d]
    mu, kappa = (0.07, 0.11) if viscous else (0.0, 0.0)
    gas = formulas.Gas(mu=mu, kappa=kappa, force=(0.0,) * d)
    xi = np.meshgrid(
        *(np.arange(n) / (n - (not (periodic and k == 1))) for k, n in enumerate(nodes)),
        indexing="ij",
    )
    periods = tuple(np.eye(d)[k] if periodic and k == 1 else None for k in range(d))
    X = np.array(xi) + 0.02 * np.sin(6.28 * np.array(xi[::-1]))
    block = formulas.Block("gas", gas, X, periods)
    oracle = Volume(formulas.Problem((block,), {}, order, form=form, dissipation=sigma))
    moved, v = 0.01 * rng.random((2, d, *nodes))
    rho, T = (1.0 + spread * rng.random(nodes) for _ in range(2))
    densities = formulas.conserved(gas, rho, rng.random((d, *nodes)) - 0.5, T)
    J = 0.9 + 0.2 * rng.random(nodes)
    q = np.array([J, *(J * densities)])
    grid = oracle.grids({"gas": q}, 0.0, {"gas": (moved, v)})[0]
    metrics = np.concatenate([*grid.a, grid.v, [oracle.volume_rate(0, grid)]])
    law, transport = PerfectGas(gas.gamma, gas.R), ConstantTransport()
    equations = Gas(law, transport, mu, kappa, (0.0,) * d)
    return Setting(oracle, equations, (0.0,) * d, q, grid, metrics)


def dissipation_of(s, sigma, shock):
    """(nodes, d + 3) of the engine."""
    d, order = len(s.like), s.oracle.problem.order
    shape, ones = s.q.shape[1:], (1,) * (3 - d)
    turns = [s.oracle.periodic(0, k) for k in range(d)]
    cells = [n - (not turn) for n, turn in zip(shape, turns, strict=True)]
    bands = [band(order, n, turn) for n, turn in zip(cells, turns, strict=True)]
    axes, cells = [*bands, *[NO_AXIS] * (3 - d)], [*cells, *ones]
    halo, periodic = [4 * turn for turn in turns] + [0] * (3 - d), [*turns, *[False] * (3 - d)]
    sizes = [*shape, *ones]
    axes = [
        b.part(-h, n + h) if turn else b
        for b, h, n, turn in zip(axes, halo, sizes, periodic, strict=True)
    ]
    ghosted = tuple(n + 2 * h for n, h in zip(sizes, halo, strict=True))
    pad = [(0, 0), *((h, h) for h in halo[:d])]
    q, metrics = (np.pad(f, pad, mode="wrap") for f in (s.q, s.metrics))
    q, metrics = np.ascontiguousarray(flat(q, len(q)).T), flat(metrics, len(metrics)).copy()
    found, S = differences(d, order, axes, cells), [b.S for b in axes]
    rates, memory = np.zeros((s.q[0].size, len(s.q))), room(d, found)
    of_block = Patch(tuple(sizes), ghosted, tuple(halo)), rates, memory
    form = FORMS[s.oracle.problem.form]
    gas_dissipation(s.equations, s.like, form, sigma, shock, q, metrics, *S, found, *of_block)
    return rates


def weights(s):
    return flat(s.oracle.W[0][None], 1)[0][:, None]


def uniform(s):
    """The same with one density, velocity and temperature."""
    gas, d = s.oracle.blocks[0].material, len(s.like)
    u = np.reshape([0.4, -0.3, 0.6][:d], (d, *[1] * d)) + 0.0 * s.q[2 : 2 + d]
    densities = formulas.conserved(gas, 1.3 + 0.0 * s.q[0], u, 0.8 + 0.0 * s.q[0])
    return s._replace(q=np.array([s.q[0], *(s.q[0] * densities)]))


def variables(s):
    """(nodes, d + 2) entropy variables."""
    w = s.equations.primitive(tuple(flat(s.q, len(s.q))))
    return np.array([s.equations.first_entropy_variable(w), *s.equations.entropy_variables(w)]).T


# dissipation and shocks


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("d", [1, 2])
def test_dissipation_is_that_of_the_oracle(d, order):
    for periodic in (False, True)[:d]:
        s = setting(d, order=order, periodic=periodic, sigma=0.3)
        state = formulas.gas_state(s.oracle.blocks[0].material, s.q)
        exact = flat(s.oracle._gas_dissipation(0, state, s.grid), d + 2).T / weights(s)
        found = dissipation_of(s, 0.3, 0.0)
        np.testing.assert_allclose(found[:, 1:], exact, rtol=0.0, atol=1e-13 * np.abs(exact).max())
        assert np.abs(found[:, 0]).max() == 0.0


@pytest.mark.parametrize("order", [4, 6])
@pytest.mark.parametrize(("sigma", "shock"), [(0.3, 0.0), (0.3, 1.0)])
@pytest.mark.parametrize("d", [1, 2])
def test_dissipation_conserves_and_makes_entropy_grow(d, order, sigma, shock):
    s = setting(d, order=order, spread=0.3)
    found = weights(s) * dissipation_of(s, sigma, shock)
    assert np.abs(found.sum(axis=0)).max() < 1e-14 * np.abs(found).sum()
    produced = -(found[:, 1:] * variables(s)).sum()
    assert produced > 1e-3 * np.abs(found[:, 1:] * variables(s)).sum()
    flow = uniform(s)
    left = dissipation_of(flow, sigma, shock)[:, 1:]
    assert np.abs(left).max() < 1e-13


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("d", [1, 2])
def test_chains_of_neighbours_give_the_entropy_of_their_pair(d, order):
    """Without the flux of Lax and Friedrichs the blend changes rates, but no sum and no entropy.

    alpha is between 0 and 1 and varies from node to node.
    """
    s = setting(d, order=order, spread=0.03)
    found = weights(s) * dissipation_of(s, 0.0, 1e-300)
    parts = np.abs(found[:, 1:] * variables(s)).sum()
    if order > 2:  # the pairs of order 2 are neighbours, but for none
        assert np.abs(found).max() > 1e-5
    assert np.abs(found.sum(axis=0)).max() < 1e-14
    assert abs((found[:, 1:] * variables(s)).sum()) < 1e-14 * max(parts, 1.0)


def steepness(a):
    """(n,) s of a line of values, 0 at the ends."""
    rise, fall = a[2:] - a[1:-1], a[1:-1] - a[:-2]
    size = np.abs(rise) + np.abs(fall) + 0.05 * (a[2:] + 2.0 * a[1:-1] + a[:-2])
    return np.pad(np.abs(rise - fall) / size, 1)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_shock_terms_of_a_line(order):
    """Against sums over all pairs and links, one by one."""
    s = setting(1, order=order, spread=0.03)
    gas, v = s.oracle.blocks[0].material, s.grid.v
    state, n, S = formulas.gas_state(gas, s.q), s.q.shape[1], s.oracle.axes[0][0][1]
    s_most = np.maximum(steepness(state.rho), steepness(state.p))
    alpha = np.clip(2.5 * (s_most - 0.03), 0.0, 1.0)
    assert 0 < (alpha < 0.2).sum() < n and (order == 6 or min(alpha[1], alpha[-2]) > 0.0)

    def at(i):
        return formulas.State(*(f[..., i] for f in state))

    exact, A, G = np.zeros((3, n)), np.zeros(n), np.zeros(n)
    for i in range(n):
        for l in range(i + 1, n):
            weight, g = alpha[i : l + 1].max() * S[i, l], 0.5 * (v[0, i] + v[0, l])
            F = weight * formulas.pair_flux(gas, at(i), at(l), np.ones(1), g)
            exact[:, i] += F
            exact[:, l] -= F
            A[i:l] += weight
            G[i:l] += weight * g
    for m in range(n - 1):
        l, r = at(m), at(m + 1)
        c = [np.sqrt(gas.gamma * gas.R * side.T) for side in (l, r)]
        speed = max(
            abs(A[m] * side.u[0] - G[m]) + of_sound * abs(A[m])
            for side, of_sound in zip((l, r), c, strict=True)
        )
        jump = formulas.conserved(gas, r.rho, r.u, r.T) - formulas.conserved(gas, l.rho, l.u, l.T)
        F = formulas.pair_flux(gas, l, r, A[m : m + 1], G[m]) - 0.5 * 0.9 * speed * jump
        exact[:, m] -= F
        exact[:, m + 1] += F
    found = weights(s) * dissipation_of(s, 0.0, 0.9)
    np.testing.assert_allclose(found[:, 1:].T, exact, rtol=0.0, atol=1e-14 * n)


def test_smooth_flow_has_no_shocks():
    s = setting(1)
    wave = 0.03 * np.sin(2.0 * np.pi * np.linspace(0.0, 1.0, NODES[1][0]))
    s.q[0], s.q[1], s.q[2], s.q[3] = 1.0, 1.0 + wave, 0.3, 2.5 + wave
    assert np.abs(dissipation_of(s, 0.0, 1.0)).max() == 0.0


@pytest.mark.parametrize("order", [2, 4, 6])
def test_strong_shock_lives(order):
    """A pressure ratio of 1000 onto a wall, fifty nodes: positive, mass and energy to round-off."""
    n, gas = 51, Gas(PerfectGas(1.4, 1.0), ConstantTransport(), 0.0, 0.0, (0.0,))
    axes = [band(order, n - 1), NO_AXIS, NO_AXIS]
    S, w = [b.S for b in axes], [b.weight for b in axes]
    patch, found = Patch((n, 1, 1), (n, 1, 1), (0, 0, 0)), differences(1, order, axes, [n - 1])
    like, form, kind, memory = (0.0,), EntropyForm(), Viscous(), room(1, found)
    metrics, work = np.outer([1.0, 0.0, 0.0], np.ones(n)), scratch(like, form, kind, axes, patch)
    p = np.where(np.arange(n) < 3 * n // 4, 1000.0, 1.0)
    q = np.array(gas.conserved(np.ones(n), np.ones(n), (np.zeros(n),), p)).T.copy()
    start, dt = w[0] @ q, 0.4 / (n - 1) / 60.0

    def slope(q):
        rates = np.zeros_like(q)
        gas_rates(gas, like, form, kind, q, metrics, *S, *w, patch, rates, work)
        gas_dissipation(gas, like, form, 0.3, 1.0, q, metrics, *S, found, patch, rates, memory)
        rates[[0, -1], 2] = 0.0
        return rates

    for _ in range(120):
        a = slope(q)
        b = slope(q + 0.5 * dt * a)
        c = slope(q + 0.5 * dt * b)
        q = q + dt / 6.0 * (a + 2.0 * b + 2.0 * c + slope(q + dt * c))
    state = gas.primitive(tuple(q.T))
    assert state[0].min() > 0.3 and state[1].min() > 0.9 and state[1][-1] > 500.0
    np.testing.assert_allclose((w[0] @ q)[[0, 1, 3]], start[[0, 1, 3]], rtol=1e-13)
