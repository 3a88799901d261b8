"""The scheme of blocks, as the oracle has it: what holds at any state, order and shape
(SCHEME-BLOCKS.md, section 10).
"""

from __future__ import annotations

import block_shapes as shapes
import numpy as np
import pytest
from block_oracle import Oracle
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
    conserved,
    det,
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


def closed(owner):
    """Walls and clamps."""
    return Clamped() if owner[0].startswith("solid") else Slip()


def made(shape, gas, solid, order, faces=closed, **options):
    """The oracle of a shape."""
    blocks = [
        Block(name, gas if name.startswith("gas") else solid, X, periods)
        for name, (X, periods) in shape.items()
    ]
    return Oracle(Problem(tuple(blocks), faces, order, **options))


def derivatives(oracle, q, rates, t=0.0):
    """Of the integrals, by a step into the complex plane; size: of the parts of the energy's."""
    stepped = {name: q[name] + 1j * TINY * rates[name] for name in q}
    found = {key: np.imag(value) / TINY for key, value in oracle.integrals(stepped, t).items()}
    weights = dict(zip(oracle.names, oracle.W))
    size = sum(np.abs(weights[name] * r[-1]).sum() for name, r in rates.items())
    return found, size


@pytest.mark.parametrize("order", [2, 4, pytest.param(8, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", [name for name in SHAPES if name != "square"])
def test_sums_of_rates_at_random_states(name, order):
    """Mass, energy, and the entropy of the inviscid gas; of the viscous one it grows."""
    if order > 4 and name in ("three", "tube"):
        pytest.skip("as many nodes as that take too long")
    for both in (SLIPPING, STICKING):
        oracle = made(SHAPES[name](NODES[order]), *both, order)
        q = oracle.random_state(np.random.default_rng(order))
        found, size = derivatives(oracle, q, oracle.rates(q))
        assert size > 0.1  # or it would be no test
        assert abs(found["mass"]) < 1e-14 * size
        assert abs(found["energy"]) < 1e-14 * size
        if both is SLIPPING:
            assert abs(found["entropy"]) < 1e-14 * size
        else:
            assert found["entropy"] > 1e-2 * size


@pytest.mark.parametrize("form", ["entropy", "divergence"])
@pytest.mark.parametrize("shape", ["disk", "three", "tube"])
def test_free_stream(shape, form):
    """Uniform flow on a random moving grid, random J, turned joins, open edges; all terms on."""
    blocks = {name.replace("solid", "gas"): X for name, X in SHAPES[shape](9).items()}
    d, rng = len(next(iter(blocks.values()))[0]), np.random.default_rng(4)
    u, gas = (0.7, -0.4, 0.3)[:d], Gas(mu=0.02, kappa=0.03)
    outside = lambda owner: Open(1.3, u, 0.9)  # noqa: E731
    oracle = made(blocks, gas, None, 4, outside, form=form, dissipation=0.3)
    uniform, q, grid = conserved(gas, 1.3, np.array(u), 0.9), {}, {}
    for b in oracle.blocks:
        J = 1.0 + 0.3 * rng.uniform(-1, 1, b.X.shape[1:])
        q[b.name] = J * np.reshape([1.0, *uniform], (-1, *[1] * d))
        grid[b.name] = 0.02 * rng.uniform(-1, 1, b.X.shape), rng.uniform(-1, 1, b.X.shape)
    for p in oracle.particles:  # members of one place move together
        k, node = p.gas[0]
        first = [part[(slice(None), *node)].copy() for part in grid[oracle.names[k]]]
        for k, node in p.gas:
            for part, value in zip(grid[oracle.names[k]], first):
                part[(slice(None), *node)] = value
    rates = oracle.rates(q, grid=grid)
    size = max(np.abs(r).max() for r in rates.values())
    assert size > 1.0
    for r in rates.values():
        assert np.abs(r[1:] - r[0] * spread(uniform, d)).max() < 1e-13 * size


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_momenta_of_a_free_solid(heat):
    """Also the angular momentum, which P F^T = F P^T keeps; in two and three dimensions."""
    for shape in (shapes.disk(9, False), {"solid": shapes.three(8)["solid"]}):
        oracle = made(shape, None, Solid("svk", kappa=0.05, heat=heat), 4, lambda owner: Free())
        q = oracle.random_state(np.random.default_rng(5))
        found, size = derivatives(oracle, q, oracle.rates(q))
        for key in ("momentum", "angular", "energy"):
            assert np.abs(found[key]).max() < 1e-14 * size


@pytest.mark.parametrize("name", ["ring", "disk", "panel", "three"])
def test_a_state_of_rest_stays(name):
    """Solids are free of stress under p_ref: with gas of this pressure around nothing moves."""
    solid, gas = Solid("log", 1.0, 2.0, p_ref=0.8), Gas()
    oracle, q = made(SHAPES[name](9), gas, solid, 4), {}
    for k, b in enumerate(oracle.blocks):
        J, zero = det(oracle.slopes(k, b.X)), 0.0 * b.X
        if k in oracle.solids:
            q[b.name] = np.array([*zero, *zero, 1.5 + 0 * J])
        else:
            q[b.name] = J * np.array([1 + 0 * J, *conserved(gas, 0.8 + 0 * J, zero, 1 + 0 * J)])
    rates = oracle.rates(oracle.complete(q))
    assert max(np.abs(r).max() for r in rates.values()) < 1e-11


# walls that move, for comparisons with the engine


def wobbling(size, phase):
    """A wall that goes to and fro in its plane and across it, with the period 1."""
    w = 2 * np.pi

    def derived(order):
        def place(X, t):
            angle = w * t + phase + 3 * X[0] + 0.5 * np.pi * order  # a derivative turns the phase
            return size * w**order * np.array([np.sin(angle), np.cos(angle)]) + X * (order == 0)

        return place

    return Motion(derived(0), derived(1), derived(2))
