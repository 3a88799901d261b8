"""Which ranks have which nodes of blocks, and which points of a line."""

from math import prod

import numpy as np
import pytest

from fsipetsc.errors import InputError
from fsipetsc.parallel.block_shares import Extent, share_out


def extent(kind, *shape, least=6, ring=None):
    """A block for the operators 4/2, or others; ring: a periodic axis."""
    return Extent(kind, shape, tuple(4 if k == ring else least for k in range(len(shape))), 4)


PROBLEMS = {
    "line": [extent("fluid", 81), extent("solid", 41), extent("fluid", 161)],
    "annulus": [extent("fluid", 96, 17, ring=0), extent("solid", 96, 9, ring=0)],
    "nine": [extent("fluid" if k % 3 else "solid", 13 + k, 25) for k in range(9)],
    "box": [extent("fluid", 33, 30, 27, least=2), extent("solid", 33, 30, 12, least=2)],
}


@pytest.mark.parametrize("blocks", PROBLEMS.values(), ids=PROBLEMS)
@pytest.mark.parametrize("mode", ["auto", "physics", "balanced"])
def test_every_node_has_one_owner_and_parts_are_large_enough(blocks, mode):
    with pytest.raises(InputError, match=r"^1000000 ranks") as caught:
        share_out(blocks, 10**6, mode)
    largest = int(str(caught.value).split(", ")[-1].split()[0])
    with pytest.raises(InputError, match=f"{largest + 1} ranks are more"):
        share_out(blocks, largest + 1, mode)
    for size in (*range(1, 7), largest // 2, largest):
        shares, ranks = share_out(blocks, size, mode), {"fluid": set(), "solid": set()}
        for block, share in zip(blocks, shares, strict=True):
            assert len(set(share.ranks)) == prod(share.grid) and set(share.ranks) <= {*range(size)}
            assert share.ranks == tuple(sorted(share.ranks))
            ranks[block.kind] |= set(share.ranks)
            owners = np.full(block.shape, -1)
            for rank in share.ranks:
                part = share.part(rank)
                place = tuple(slice(a, b) for a, b in part)
                assert (owners[place] == -1).all()
                owners[place] = rank
                for axis, (a, b) in enumerate(part):
                    assert b - a >= block.least[axis] or b - a == block.shape[axis]
            found = share.owners(np.arange(prod(block.shape)))
            assert np.array_equal(found, owners.reshape(-1, order="F"))
        assert mode != "physics" or size < len(blocks) or not ranks["fluid"] & ranks["solid"]
