"""The engine around an axis or a centre: its rates are the oracle's (oracle_radial.py), and
keep the sums.
"""

from __future__ import annotations

from typing import NamedTuple

import block_shapes as shapes
import numpy as np
import pytest

pytest.importorskip("petsc4py")

from oracle_engine import Engine
from oracle_formulas import Block, Clamped, Problem, Slip
from oracle_radial import Radial
from test_block_oracle import ELASTIC, NODES, SLIPPING, STICKING, derivatives, with_sums

KAPPA = pytest.mark.parametrize("kappa", [1, 2])


def shell(n, centre):
    """A shell in gas, with gas inside to the centre, or from 0.4."""
    inside = shapes.box((-1.0,), (1.0,), 2 * n) if centre else shapes.box((0.4,), (1.0,), n)
    outer = {"solid": shapes.box((1.0,), (1.3,), n), "gas around": shapes.box((1.3,), (2.0,), n)}
    if not centre:
        return {"gas inside": inside, **outer}
    mirrored = {
        "solid mirrored": shapes.box((-1.3,), (-1.0,), n),
        "gas mirrored": shapes.box((-2.0,), (-1.3,), n),
    }
    return {"gas inside": inside, **outer, **mirrored}


def radial(shape, gas, solid, order, kappa, **options):
    """The oracle of a shape, closed."""
    blocks = [
        Block(name, gas if name.startswith("gas") else solid, X, periods)
        for name, (X, periods) in shape.items()
    ]
    closed = lambda owner: Clamped() if owner[0].startswith("solid") else Slip()  # noqa: E731
    return Radial(Problem(tuple(blocks), closed, order, **options), kappa)


def mirrored(oracle, q):
    """q with the states of r > 0 at -r: densities and energies are even, velocities are odd."""
    places = {
        "gas inside": "gas inside",
        "gas mirrored": "gas around",
        "solid mirrored": "solid",
    }
    found = dict(q)
    for name, of in places.items():
        odd = np.array([-1.0, -1.0, 1.0] if of == "solid" else [1.0, 1.0, -1.0, 1.0])
        image = odd[:, None] * q[of][:, ::-1]
        half = q[of].shape[1] // 2
        found[name] = (
            np.concatenate([image[:, :half], q[of][:, half:]], axis=1) if name == of else image
        )
    return found


class Centre(NamedTuple):
    """The oracle does not know it: there a block goes on to -r."""


def engine_of(oracle, kappa, centre):
    """The engine with the blocks of r > 0 of an oracle."""
    blocks = [b for b in oracle.blocks if "mirrored" not in b.name]
    if centre:
        half = oracle.blocks[0].X.shape[1] // 2
        blocks[0] = Block(blocks[0].name, blocks[0].material, blocks[0].X[:, half:])

    def closed(owner):
        if owner == ("gas inside", 0, 0) and centre:
            return Centre()
        return Clamped() if owner[0].startswith("solid") else Slip()

    p = oracle.problem
    return Engine(Radial(Problem(tuple(blocks), closed, *p[2:]), kappa), symmetry=kappa)


def half_of(q, centre):
    """The unknowns of r > 0, as the engine has them: J is per other coordinates."""
    found = {name: value for name, value in q.items() if "mirrored" not in name}
    if centre:
        n = q["gas inside"].shape[1] // 2
        found["gas inside"] = q["gas inside"][:, n:] * ((n - 1) / (2 * n - 1))
    return found


def whole_of(oracle, found, centre):
    """Rates of the engine as the oracle has them, with images."""
    if not centre:
        return found
    n = found["gas inside"].shape[1]
    right = found["gas inside"] * ((2 * n - 1) / (n - 1))
    return mirrored(oracle, {**found, "gas inside": np.concatenate([right, right], axis=1)})


@pytest.mark.parametrize("centre", [False, True], ids=["shell", "centre"])
@KAPPA
@pytest.mark.parametrize(
    ("order", "both", "options"),
    [
        (2, SLIPPING, {}),
        (4, SLIPPING, {}),
        (4, SLIPPING, {"dissipation": 0.3}),
        (6, SLIPPING, {}),
        (8, SLIPPING, {}),
        (4, STICKING, {}),
        (6, STICKING, {}),
        pytest.param(4, ELASTIC, {"form": "divergence"}, marks=pytest.mark.long),
    ],
)
def test_rates_are_the_oracles(order, both, options, kappa, centre):
    """At random states of gas and shell, on grids that move. Sums of mass and energy stay; the
    entropy of the gas stays, too, or grows by viscosity and dissipation.
    """
    oracle = radial(shell(NODES[order], centre), *both, order, kappa, **options)
    q = oracle.random_state(np.random.default_rng(order))
    q = oracle.complete(mirrored(oracle, q) if centre else q)
    expected = with_sums(oracle, oracle.rates(q))
    rates = engine_of(oracle, kappa, centre).rates(half_of(q, centre))
    rates = whole_of(oracle, rates, centre)
    found, size = with_sums(oracle, rates), max(np.abs(r).max() for r in expected.values())
    for name in expected:
        assert np.abs(found[name] - expected[name]).max() < 1e-11 * size, name
    sums, size = derivatives(oracle, q, rates)
    assert abs(sums["mass"]) < 1e-13 * size and abs(sums["energy"]) < 1e-13 * size
    if both is SLIPPING and not options:
        assert abs(sums["entropy"]) < 1e-13 * size
    elif "form" not in options:
        assert sums["entropy"] > 1e-3 * size
