"""Around an axis or a centre, too, rates are the oracle's (block_oracle.py), and keep the sums."""

from collections import namedtuple

import block_shapes as shapes
import numpy as np
import pytest
import test_block_oracle as flat
from block_oracle import Oracle
from oracle_engine import Engine
from oracle_formulas import Problem

#: dimension, number of coordinates around: a sphere, and (z, r)
SPHERE, PLANE = (1, 2), (2, 1)
#: a condition that the oracle does not know: there a block goes on to -r
Centre = namedtuple("Centre", "")


def shell(d, n, centre):
    """A shell in gas, with gas inside or a ball of solid; in 2-D a bent tube, or a rod."""

    def block(low, high, nodes):
        if d == 1:
            return shapes.box((low,), (high,), nodes)
        (z, r), periods = shapes.box((0.0, low), (1.0, high), n, nodes)
        bent = z + 0.05 * np.cos(1.3 * r) * np.sin(2.0 * z), r * (1.0 + 0.1 * np.sin(2.0 * z + 0.4))
        return np.array(bent), periods

    inside = block(-1.0, 1.0, 2 * n) if centre else block(0.4, 1.0, n)
    if centre == "solid":
        around = {"gas around": block(1.0, 2.0, n), "gas mirrored": block(-2.0, -1.0, n)}
        return {"solid inside": inside, **around}
    outer = {"solid": block(1.0, 1.3, n), "gas around": block(1.3, 2.0, n)}
    if not centre:
        return {"gas inside": inside, **outer}
    mirrored = {"solid mirrored": block(-1.3, -1.0, n), "gas mirrored": block(-2.0, -1.3, n)}
    return {"gas inside": inside, **outer, **mirrored}


def mirrored(oracle, q):
    """q with the states of r > 0 at -r: densities and energies are even, velocities are odd."""
    inside = oracle.names[0]
    places = {inside: inside, "gas mirrored": "gas around", "solid mirrored": "solid"}
    found, d = dict(q), oracle.d
    for name, of in ((name, places[name]) for name in q if name in places):
        odd = np.ones(len(q[of]))
        odd[[d - 1, 2 * d - 1] if of.startswith("solid") else [d + 1]] = -1.0
        image = odd.reshape(-1, *[1] * d) * q[of][..., ::-1]
        half = q[of].shape[-1] // 2
        found[name] = (
            np.concatenate([image[..., :half], q[of][..., half:]], axis=-1) if name == of else image
        )
    return found


def engine_of(oracle, kappa, centre):
    """The engine with the blocks of r > 0 of an oracle."""
    blocks = [b for b in oracle.blocks if "mirrored" not in b.name]
    if centre:
        half = oracle.blocks[0].X.shape[-1] // 2
        blocks[0] = blocks[0]._replace(X=blocks[0].X[..., half:])

    def condition(owner):
        to_axis = owner == (blocks[0].name, oracle.d - 1, 0) and centre
        return Centre() if to_axis else flat.closed(owner)

    p = oracle.problem
    return Engine(Oracle(Problem(tuple(blocks), condition, *p[2:]), kappa), symmetry=kappa)


def half_of(q, centre):
    """The unknowns of r > 0, as the engine has them: J is per other coordinates."""
    found = {name: value for name, value in q.items() if "mirrored" not in name}
    if centre:
        name, n = f"{centre} inside", q[f"{centre} inside"].shape[-1] // 2
        found[name] = q[name][..., n:] * ((n - 1) / (2 * n - 1) if centre == "gas" else 1.0)
    return found


def whole_of(oracle, found, centre):
    """Rates of the engine as the oracle has them, with images."""
    if not centre:
        return found
    name, n = f"{centre} inside", found[f"{centre} inside"].shape[-1]
    right = found[name] * ((2 * n - 1) / (n - 1) if centre == "gas" else 1.0)
    whole = {"solid mirrored": found["solid"]} if "solid" in found else {}
    whole |= {name: np.concatenate([right, right], axis=-1), "gas mirrored": found["gas around"]}
    return mirrored(oracle, {**found, **whole})


RADIAL = [
    *((1, 1, order, flat.SLIPPING, {}) for order in (2, 4, 6, 8)),
    *((*of, 8, flat.SLIPPING, {}) for of in (SPHERE, PLANE)),
    *((*of, 4, flat.SLIPPING, {"dissipation": 0.3}) for of in (SPHERE, PLANE)),
    *((*of, 6, flat.STICKING, {}) for of in (SPHERE, PLANE)),
]


@pytest.mark.parametrize(
    ("centre", "d", "kappa", "order", "both", "options"),
    [
        *(("gas", *of) for of in RADIAL),
        *(("", *of) for of in RADIAL if of[:2] == PLANE),
        *(("solid", *of) for of in RADIAL if of[:2] == SPHERE),
    ],
)
def test_rates_are_the_oracles(centre, d, kappa, order, both, options):
    """At random states on grids that move; sums stay. Solids go to a centre."""
    gas, solid = both[0], both[1]._replace(law="neo-hookean")  # as in the cases of shells
    shape = shell(d, flat.NODES[order], centre)
    oracle = flat.made(shape, gas, solid, order, kappa=kappa, **options)
    q = oracle.random_state(np.random.default_rng(order))
    q = oracle.complete(mirrored(oracle, q) if centre else q)
    expected = flat.with_sums(oracle, oracle.rates(q))
    rates = engine_of(oracle, kappa, centre).rates(half_of(q, centre))
    rates = whole_of(oracle, rates, centre)
    found, size = flat.with_sums(oracle, rates), max(np.abs(r).max() for r in expected.values())
    for name in expected:
        assert np.abs(found[name] - expected[name]).max() < 1e-11 * size, name
    flat.check_sums(oracle, q, rates, both)
