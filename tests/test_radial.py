"""The engine around an axis or a centre: its rates are the oracle's (oracle_radial.py), whose sums
are known (test_radial_formulas.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from oracle_engine import Engine
from oracle_formulas import Block, Clamped, Problem, Slip
from oracle_radial import Radial
from test_block_oracle import NODES, SLIPPING, STICKING
from test_blocks_against_oracle import ELASTIC, with_sums
from test_radial_formulas import mirrored, radial, shell

KAPPA = pytest.mark.parametrize("kappa", [1, 2])


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
    """The unknowns, or rates, of r > 0, as the engine has them: J is per other coordinates."""
    found = {name: value for name, value in q.items() if "mirrored" not in name}
    if centre:
        n = q["gas inside"].shape[1] // 2
        found["gas inside"] = q["gas inside"][:, n:] * ((n - 1) / (2 * n - 1))
    return found


@pytest.mark.parametrize("centre", [False, True], ids=["shell", "centre"])
@KAPPA
@pytest.mark.parametrize(
    ("order", "both", "options"),
    [
        (4, SLIPPING, {"dissipation": 0.3}),
        (4, STICKING, {}),
        pytest.param(2, STICKING, {}, marks=pytest.mark.long),
        (6, STICKING, {}),
        (8, STICKING, {}),
        pytest.param(4, ELASTIC, {"form": "divergence"}, marks=pytest.mark.long),
    ],
)
def test_rates_are_the_oracles(order, both, options, kappa, centre):
    """At random states of all blocks: the sums of its rates vanish where those of the oracle do."""
    oracle = radial(shell(NODES[order], centre), *both, order, kappa, **options)
    q = oracle.random_state(np.random.default_rng(order))
    q = oracle.complete(mirrored(oracle, q) if centre else q)
    expected = half_of(with_sums(oracle, oracle.rates(q)), centre)
    engine = engine_of(oracle, kappa, centre)
    found = engine.rates(half_of(q, centre))
    if centre:  # sums of both at the interface want the oracle's coordinates
        n = q["gas inside"].shape[1] // 2
        whole = {**oracle.rates(q), **found}
        inside = oracle.rates(q)["gas inside"].copy()
        inside[:, n:] = found["gas inside"] * ((2 * n - 1) / (n - 1))
        found = half_of(with_sums(oracle, {**whole, "gas inside": inside}), True)
    else:
        found = with_sums(oracle, found)
    size = max(np.abs(r).max() for r in expected.values())
    for name in expected:
        assert np.abs(found[name] - expected[name]).max() < 1e-11 * size, name
