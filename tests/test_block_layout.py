"""Blocks on ranks: shares of their nodes, layouts, halos, what goes between faces and particles."""

from __future__ import annotations

from math import prod

import numpy as np
import pytest

from fsipetsc.errors import InputError
from fsipetsc.parallel.block_shares import COST, MODES, Extent, share_line, share_out, slowest


def extent(kind: str, shape: tuple[int, ...], ring: int | None = None, p: int = 2) -> Extent:
    """A block for the operators 2/1 (p = 1) or 4/2; ring: a periodic axis."""
    rows = {1: 1, 2: 4}[p]
    periodic = tuple(axis == ring for axis in range(len(shape)))
    return Extent(kind, shape, periodic, rows + p, 2 * p, 2 * p)


PROBLEMS = {
    "line": [extent("fluid", (81,)), extent("solid", (41,)), extent("fluid", (161,))],
    "flat": [extent("fluid", (128, 64)), extent("solid", (128, 33))],
    "annulus": [
        extent("fluid", (96, 17), 0),
        extent("solid", (96, 9), 0),
        extent("fluid", (96, 21), 0),
    ],
    "nine": [extent("fluid" if k % 3 else "solid", (13 + k, 25)) for k in range(9)],
    "box": [extent("fluid", (33, 30, 27), p=1), extent("solid", (33, 30, 12), p=1)],
}
ALL = pytest.mark.parametrize("blocks", PROBLEMS.values(), ids=PROBLEMS)
EVERY_MODE = pytest.mark.parametrize("mode", MODES)


def most(blocks: list[Extent], mode: str) -> int:
    """The largest number of ranks that works, as the message says."""
    with pytest.raises(InputError) as caught:
        share_out(blocks, 10**6, mode)
    assert str(caught.value).startswith("1000000 ranks")
    return int(str(caught.value).split(", ")[-1].split()[0])


@ALL
@EVERY_MODE
def test_every_node_has_one_owner_and_parts_are_large_enough(blocks, mode):
    largest = most(blocks, mode)
    assert largest >= 6
    with pytest.raises(InputError, match=f"{largest + 1} ranks are more"):
        share_out(blocks, largest + 1, mode)
    for size in {*range(1, 12), largest // 2, largest} & set(range(1, largest + 1)):
        for block, share in zip(blocks, share_out(blocks, size, mode), strict=True):
            assert len(set(share.ranks)) == len(share.ranks) == prod(share.grid)
            assert set(share.ranks) <= set(range(size))
            assert share.ranks == tuple(sorted(share.ranks))
            owners = np.full(block.shape, -1)
            for rank in share.ranks:
                part = share.part(rank)
                place = tuple(slice(a, b) for a, b in part)
                assert (owners[place] == -1).all()
                owners[place] = rank
                for axis, (a, b) in enumerate(part):
                    n = block.shape[axis]
                    ends = not block.periodic[axis] and (a == 0 or b == n)
                    assert b - a >= (block.end if ends else block.inner) or b - a == n
            assert np.array_equal(
                share.owners(np.arange(block.size)), owners.reshape(-1, order="F")
            )


@ALL
def test_gas_and_solid_are_apart_where_there_are_ranks(blocks):
    for size in range(2, 12):
        shares = share_out(blocks, size, "physics")
        ranks = {
            kind: {
                r for b, s in zip(blocks, shares, strict=True) if b.kind == kind for r in s.ranks
            }
            for kind in COST
        }
        assert not ranks["fluid"] & ranks["solid"]


def test_work_is_shared_by_cost_and_not_by_nodes():
    blocks = [extent("fluid", (128, 128)), extent("solid", (128, 128))]
    total = sum(block.work for block in blocks)
    shares = share_out(blocks, 2, "auto")
    assert slowest(blocks, shares, 2) < 1.03 * total / 2, "balanced: gas is cut"
    assert shares[0].ranks == (0, 1) and shares[1].ranks == (1,)
    by_physics = share_out(blocks, 2, "physics")
    assert slowest(blocks, by_physics, 2) == pytest.approx(total * 1.9 / 2.9, rel=1e-3)
    assert share_out(blocks, 3, "physics")[0].ranks == (0, 1), "gas has more work"


def test_pieces_of_a_line():
    """Spare points, here of both gases of the rod, go with the outermost ranks."""
    rod = ("fluid", 62, 41, True), ("solid", 41, 41, False), ("fluid", 197, 161, False)
    for mode in MODES:
        for size in range(1, 20):
            for (_, n, active, left), pieces in zip(rod, share_line(rod, size, mode, 6)):
                cuts = [0, *(end for _, _, end in pieces)]
                assert cuts[-1] == n and [begin for _, begin, _ in pieces] == cuts[:-1]
                begin = n - active if left else 0
                for _, a, b in pieces:
                    assert min(b, begin + active) - max(a, begin) >= 6
    assert [[r for r, _, _ in pieces] for pieces in share_line(rod, 2, "auto", 6)][1] == [1]
    with pytest.raises(InputError, match="38 is the largest number that works"):
        share_line(rod, 100, "auto", 6)
