"""The scheme of blocks, as the oracle has it: what holds at any state, order and shape.

The numbers of SCHEME-BLOCKS.md section 10 that are cheap, and the rates of the older code's
kernels.
"""

from __future__ import annotations

import block_shapes as shapes
import numpy as np
import pytest
from block_oracle import build
from oracle_formulas import (
    Block,
    Clamped,
    Free,
    Gas,
    Motion,
    Open,
    Problem,
    Slip,
    Solid,
    cofactor,
    conserved,
    det,
    dot,
    energy_and_stress,
    spread,
)

TINY = 1e-30
#: inviscid gas that slips along solids with an energy of their own; viscous, conducting gas and
#: solid
SLIPPING = Gas(), Solid("neo-hookean", heat="elastic")
STICKING = Gas(mu=0.02, kappa=0.03), Solid("svk", kappa=0.05)
LINE = {
    "gas left": shapes.box((0.0,), (1.0,), 17),
    "solid": shapes.box((1.0,), (1.5,), 17),
    "gas right": shapes.box((1.5,), (2.0,), 17),
    "gas beyond": shapes.box((2.0,), (4.0,), 17),
}


def closed(owner):
    """Walls and clamps."""
    return Clamped() if owner[0].startswith("solid") else Slip()


def made(shape, gas, solid, order, faces=closed, **options):
    """The oracle of a shape."""
    blocks = [
        Block(name, gas if name.startswith("gas") else solid, X, periods)
        for name, (X, periods) in shape.items()
    ]
    return build(Problem(tuple(blocks), faces, order, **options))


def derivatives(oracle, q, rates, t=0.0):
    """Of the integrals, by a step into the complex plane; size: of the parts of the energy's."""
    stepped = {name: q[name] + 1j * TINY * rates[name] for name in q}
    found = {key: np.imag(value) / TINY for key, value in oracle.integrals(stepped, t).items()}
    weights = dict(zip(oracle.names, oracle.W))
    size = sum(np.abs(weights[name] * r[-1]).sum() for name, r in rates.items())
    return found, size


def check_sums(shape, both, order, **options):
    """Mass, momentum, energy; returns the rate of entropy over the size of the energy's parts."""
    oracle = made(shape, *both, order, **options)
    q = oracle.random_state(np.random.default_rng(order))
    rates = oracle.rates(q)
    found, size = derivatives(oracle, q, rates)
    through = sum(oracle.ledger.values())
    assert size > 0.1  # or it would be no test
    assert oracle.jacobian_error(q) > 0.1
    assert abs(found["mass"] - through[0]) < 1e-14 * size
    assert np.abs(found["momentum"] - through[1:-1]).max() < 1e-14 * size
    assert abs(found["energy"] - through[-1]) < 1e-14 * size
    assert through[0] == 0.0 and abs(through[-1]) < 1e-14 * size
    return found["entropy"] / size


SHAPES = {
    "line": lambda n: LINE,
    "periodic": lambda n: shapes.layers(n, True),
    "walls": lambda n: shapes.layers(n, False),
    "ring": shapes.ring,
    "square": shapes.square,
    "disk": shapes.disk,
    "panel": shapes.panel,
    "three": shapes.three,
    "tube": shapes.tube,
}
NODES = {2: 7, 4: 9, 6: 12, 8: 16}
LONG = [pytest.param(order, marks=pytest.mark.long) for order in (6, 8)]


def in_orders(shapes):
    """(shape, order): the orders 2 and 4, and in one and two dimensions, taking longer, 6 and 8."""
    cases = [(name, order) for name in shapes for order in (2, 4)]
    higher = [(name, order) for name in shapes if name not in ("three", "tube") for order in (6, 8)]
    return [*cases, *(pytest.param(*case, marks=pytest.mark.long) for case in higher)]


@pytest.mark.parametrize(("name", "order"), in_orders(SHAPES))
def test_sums_of_rates_at_random_states(name, order):
    """Mass, momentum, energy, and the entropy of the inviscid gas; of the viscous one it grows."""
    shape = SHAPES[name](NODES[order])
    assert abs(check_sums(shape, SLIPPING, order)) < 1e-14
    assert check_sums(shape, STICKING, order) > 1e-2


@pytest.mark.parametrize("law", ["log", "linear"])
@pytest.mark.parametrize(("m0", "heat"), [(0.01, "coupled"), (50.0, "elastic")])
def test_light_and_heavy_solids(law, m0, heat):
    """Also with dissipation, a stiffened gas, body forces, and solids that share their heat."""
    gas = Gas(1.8, 0.7, p_inf=0.4, kappa=0.03, force=(0.3, -0.2))
    solid = Solid(law, 1.0, 2.0, m0, 1.5, 0.05, 0.7, heat, (0.3, -0.2))
    oracle = made(shapes.disk(9), gas, solid, 4, dissipation=0.3)
    q = oracle.random_state(np.random.default_rng(3))
    rates = oracle.rates(q)
    found, size = derivatives(oracle, q, rates)
    force = np.zeros(3)
    for k, name in enumerate(oracle.names):
        M = oracle.solids[k][1] * m0 if k in oracle.solids else q[name][1]
        v = q[name][2:4] if k in oracle.solids else q[name][2:4] / q[name][1]
        f = oracle.W[k] * M * spread((0.3, -0.2), 2)
        force += np.array([*f.sum(axis=(1, 2)), dot(f, v).sum()])
    through = sum(oracle.ledger.values())
    assert abs(found["mass"]) < 1e-14 * size
    assert np.abs(found["momentum"] - through[1:-1] - force[:2]).max() < 1e-13 * size
    assert abs(found["energy"] - force[2]) < 1e-14 * size
    assert found["entropy"] / size > 1e-4


@pytest.mark.parametrize(("shape", "order"), in_orders(["disk", "three", "tube"]))
def test_free_stream(shape, order):
    """Uniform flow on a random moving grid, random J, turned joins, open edges; all terms on."""
    blocks = SHAPES[shape](NODES[order])
    blocks = {name.replace("solid", "gas"): value for name, value in blocks.items()}
    d, rng = len(next(iter(blocks.values()))[0]), np.random.default_rng(order)
    u, gas = (0.7, -0.4, 0.3)[:d], Gas(mu=0.02, kappa=0.03)
    for form in ("entropy", "divergence"):
        oracle = made(
            blocks, gas, None, order, lambda owner: Open(1.3, u, 0.9), form=form, dissipation=0.3
        )
        uniform = conserved(gas, 1.3, np.array(u), 0.9)
        q, grid = {}, {}
        for b in oracle.blocks:
            J = 1.0 + 0.3 * rng.uniform(-1, 1, b.X.shape[1:])
            q[b.name] = J * np.reshape([1.0, *uniform], (-1, *[1] * d))
            grid[b.name] = 0.02 * rng.uniform(-1, 1, b.X.shape), rng.uniform(-1, 1, b.X.shape)
        for p in oracle.particles:
            first = [
                part[(slice(None), *p.gas[0][1])].copy() for part in grid[oracle.names[p.gas[0][0]]]
            ]
            for k, node in p.gas:
                for part, value in zip(grid[oracle.names[k]], first):
                    part[(slice(None), *node)] = value
        rates = oracle.rates(q, grid=grid)
        size = max(np.abs(r).max() for r in rates.values())
        assert size > 1.0
        for r in rates.values():
            assert np.abs(r[1:] - r[0] * spread(uniform, d)).max() < 1e-13 * size


def turned(x, angle=0.7):
    """Places in a plane (or space, about its third axis) turned."""
    y = x.copy()
    y[0], y[1] = (
        np.cos(angle) * x[0] - np.sin(angle) * x[1],
        np.sin(angle) * x[0] + np.cos(angle) * x[1],
    )
    return y


@pytest.mark.parametrize("order", [2, 4, *LONG])
@pytest.mark.parametrize("law", ["log", "neo-hookean", "svk"])
def test_rigid_rotation_of_a_disk(law, order):
    """F is Q to the bit of round-off on five turned blocks: nothing moves."""
    oracle = made(shapes.disk(NODES[order], False), None, Solid(law), order, lambda owner: Free())
    q = {}
    for b in oracle.blocks:
        x = turned(b.X) + 0.3
        q[b.name] = np.array([*(x - b.X), *(0.0 * x), np.full(x.shape[1:], 1.5)])
    rates = oracle.rates(q)
    assert max(np.abs(r).max() for r in rates.values()) < 2e-11
    moved = oracle.complete(q)
    assert max(np.abs(moved[name] - q[name]).max() for name in q) < 1e-13


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_momenta_of_a_free_solid(heat):
    """Also the angular momentum, which P F^T = F P^T keeps; in two and three dimensions."""
    for shape in (shapes.disk(9, False), {"solid": shapes.three(8)["solid"]}):
        oracle = made(shape, None, Solid("svk", kappa=0.05, heat=heat), 4, lambda owner: Free())
        q = oracle.random_state(np.random.default_rng(5))
        rates = oracle.rates(q)
        found, size = derivatives(oracle, q, rates)
        for key in ("momentum", "angular", "energy"):
            assert np.abs(found[key]).max() < 1e-14 * size
        assert abs(found["kinetic"]) > 1e-3 * size and abs(found["stored"]) > 1e-3 * size
        if heat == "elastic":
            assert abs(found["kinetic"] + found["stored"]) < 1e-14 * size
            assert abs(found["heat"]) < 1e-14 * size




# walls that move, rest


def wobbling(size, phase):
    """A wall that goes to and fro in its plane and across it, with the period 1."""

    def value(derivative):
        def place(X, t):
            w = 2 * np.pi
            turns = [w**derivative * f(w * t + phase + 3 * X[0]) for f in WAVES[derivative]]
            return size * np.array(turns) + (X if derivative == 0 else 0.0)

        return place

    return Motion(value(0), value(1), value(2))


WAVES = (
    (np.sin, np.cos),
    (np.cos, lambda z: -np.sin(z)),
    (lambda z: -np.sin(z), lambda z: -np.cos(z)),
)


@pytest.mark.parametrize("name", ["ring", "disk", "panel", "three", "tube"])
def test_a_state_of_rest_stays(name):
    """Solids are free of stress under p_ref: with gas of this pressure around them nothing moves.
    """
    solid, gas = Solid("log", 1.0, 2.0, p_ref=0.8), Gas()
    for order in (2, 4):
        oracle = made(SHAPES[name](NODES[order]), gas, solid, order)
        q = {}
        for k, b in enumerate(oracle.blocks):
            J, zero = det(oracle.slopes(k, b.X)), 0.0 * b.X
            if k in oracle.solids:
                q[b.name] = np.array([*zero, *zero, 1.5 + 0 * J])
            else:
                q[b.name] = J * np.array([1 + 0 * J, *conserved(gas, 0.8 + 0 * J, zero, 1 + 0 * J)])
        rates = oracle.rates(oracle.complete(q))
        assert max(np.abs(r).max() for r in rates.values()) < 1e-11


# smooth fields: rates are those of the equations


class Waves:
    """Smooth functions of places with their gradients: A sin(k.x + b)."""

    def __init__(self, d, count, seed):
        rng = np.random.default_rng(seed)
        self.A, self.b = rng.uniform(0.1, 0.2, count), rng.uniform(0.0, 6.0, count)
        self.k = rng.uniform(-1.2, 1.2, (count, d))

    def __call__(self, x):
        return spread(self.A, x.ndim - 1) * np.sin(self._phase(x))

    def gradient(self, x):
        """[function, direction]."""
        slopes = spread(self.A, x.ndim - 1) * np.cos(self._phase(x))
        return slopes[:, None] * self.k.reshape(*self.k.shape, *[1] * (x.ndim - 1))

    def _phase(self, x):
        return np.einsum("ij,j...->i...", self.k, x) + spread(self.b, x.ndim - 1)


def divergence(flux, x):
    """Of flux(x), [component, direction], by steps into the complex plane."""
    total = 0.0
    for j in range(len(x)):
        step = x.astype(complex)
        step[j] += 1j * TINY
        total = total + flux(step)[:, j].imag / TINY
    return total


def gas_flux(m, waves):
    """x -> fluxes of (rho, rho u, E), and x -> the unknowns."""

    def unknowns(x):
        rho, T, *u = waves(x)
        return conserved(m, 1.0 + rho, np.array(u), 1.0 + T)

    def flux(x):
        U, slopes, d = unknowns(x), waves.gradient(x), len(x)
        u, T = U[1:-1] / U[0], 1.0 + waves(x)[1]
        gu, one = slopes[2:], np.eye(d).reshape(d, d, *[1] * d)
        tau = m.mu * (gu + np.swapaxes(gu, 0, 1) - 2.0 / 3.0 * np.trace(gu) * one)
        p = U[0] * m.R * T - m.p_inf
        momentum = U[1:-1][:, None] * u + p * one - tau
        energy = (U[-1] + p) * u - np.einsum("ij...,j...->i...", tau, u) - m.kappa * slopes[1]
        return np.array([U[1:-1], *momentum, energy])

    return flux, unknowns


def solid_rates(m, waves, X):
    """(force, heating) per m0 and m0 alpha, of x = X + waves[:d], v = waves[d : 2d], T = 1 +
    waves[2d].
    """
    d = len(X)

    def deformation(X):
        return waves.gradient(X)[:d] + np.eye(d).reshape(d, d, *[1] * d)

    def stress(X):
        return energy_and_stress(m, deformation(X), m.p_ref)[1]

    def heat(X):
        F = deformation(X)
        cof, slope = cofactor(F), waves.gradient(X)[2 * d]
        return m.kappa / det(F) * np.einsum("ki...,kj...,j...->i...", cof, cof, slope)[None]

    work = (
        (stress(X) * waves.gradient(X)[d : 2 * d]).sum(axis=(0, 1)) if m.heat == "coupled" else 0.0
    )
    return divergence(stress, X) / m.m0, (divergence(heat, X)[0] + work) / (m.m0 * m.alpha)


def errors(name, n, order, both):
    """Weighted L2 norms of the errors of rates of gas and solid, but for nodes of faces with a
    condition.
    """
    shape, (gas, solid) = SHAPES[name](n), both
    oracle = made(shape, gas, solid, order)
    d, q = oracle.d, {}
    waves, moves = Waves(d, d + 2, 1), Waves(d, 2 * d + 1, 2)
    flux, unknowns = gas_flux(gas, waves)
    total, expected = {"gas": 0.0, "solid": 0.0}, {}
    zero = {b.name: (0.0 * b.X, 0.0 * b.X) for b in oracle.blocks if b.material.kind == "gas"}
    for k, b in enumerate(oracle.blocks):
        if k in oracle.solids:
            D, v, T = np.split(moves(b.X), [d, 2 * d])
            W = oracle.elastic(k, b.X + D)[0] / solid.m0 if solid.heat == "elastic" else 0.0
            q[b.name] = np.array([*D, *v, 0.5 * dot(v, v) + W + solid.alpha * (1.0 + T[0])])
            expected[b.name] = solid_rates(solid, moves, b.X)
        else:
            J = det(oracle.slopes(k, b.X))
            q[b.name] = J * np.array([1.0 + 0 * J, *unknowns(b.X)])
            expected[b.name] = -J * divergence(flux, b.X)
    # of solids first, which do not know of the gas yet; then of both as they are
    rates = oracle.rates(q, grid=zero)
    for k, b in enumerate(oracle.blocks):
        inner = np.ones(b.X.shape[1:])
        for p in oracle.particles:
            for j, node in p.gas + p.solid:
                if j == k and (p.outer or (p.gas and p.solid)):
                    inner[node] = 0.0
        W = oracle.W[k] * inner
        if k in oracle.solids:
            T_t = np.imag(oracle.temperature(k, q[b.name] + 1j * TINY * rates[b.name])) / TINY
            force, heating = expected[b.name]
            gap = np.array([*(rates[b.name][d:-1] - force), T_t - heating])
        else:
            gap = rates[b.name][1:] - expected[b.name]
        total[b.material.kind] += (W * dot(gap, gap)).sum()
    return np.sqrt([total["gas"], total["solid"]])


@pytest.mark.parametrize(
    ("name", "both", "rates"),
    [
        ("disk", (Gas(p_inf=0.3), Solid("log", p_ref=0.5)), (1.6, 1.6)),
        ("disk", (Gas(mu=0.3, kappa=0.4), Solid("svk", kappa=0.4, heat="elastic")), (1.4, 1.4)),
        ("ring", (Gas(mu=0.3, kappa=0.4), Solid("neo-hookean", kappa=0.4)), (1.4, 1.4)),
    ],
)
def test_rates_of_smooth_fields(name, both, rates):
    """On curved, joined blocks: errors in L2 fall as closures of order 2 let them, once or twice
    applied.
    """
    coarse, fine = errors(name, 9, 4, both), errors(name, 17, 4, both)
    found = np.log2(coarse / fine)
    assert (fine < 0.1).all() and (found > rates).all(), (coarse, fine, found)


