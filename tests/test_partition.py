"""Which ranks own which points: every point once, pieces long enough, and a clear end where ranks
run out."""

from __future__ import annotations

import pytest

from fsipetsc.errors import InputError
from fsipetsc.parallel.partition import MODES, Extent, partition

ROD = (
    Extent("fluid", 62, 41, True),
    Extent("solid", 41, 41, False),
    Extent("fluid", 197, 161, False),
)
PULSE = (Extent("solid", 61, 61, False), Extent("fluid", 77, 61, False))
FINE = tuple(Extent(e.kind, 9 * e.n, 9 * e.active, e.spare_left) for e in ROD)
CHAINS = {"rod": ROD, "pulse": PULSE, "fine": FINE}
SMALLEST = 6


def largest(chain, mode):
    """The largest number of ranks that the partition accepts."""
    with pytest.raises(InputError, match="1000000 ranks") as caught:
        partition(chain, 10**6, mode, SMALLEST)
    return int(str(caught.value).split(", ")[-1].split()[0])


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
@pytest.mark.parametrize("mode", MODES)
def test_every_point_has_one_owner_and_pieces_are_long_enough(chain, mode):
    most = largest(chain, mode)
    for size in range(1, most + 1):
        shares = partition(chain, size, mode, SMALLEST)
        work = [0] * size
        for extent, pieces in zip(chain, shares, strict=True):
            cuts = [pieces[0][1], *(end for _, _, end in pieces)]
            assert (cuts[0], cuts[-1]) == (0, extent.n)
            assert all(a[2] == b[1] for a, b in zip(pieces, pieces[1:], strict=False))
            ranks = [rank for rank, _, _ in pieces]
            assert ranks == sorted(set(ranks)), "DMDA numbers its ranks in ascending order"
            begin = extent.n - extent.active if extent.spare_left else 0
            for rank, a, b in pieces:
                active = min(b, begin + extent.active) - max(a, begin)
                assert active >= SMALLEST
                work[rank] += active
        if mode == "balanced":
            assert max(work) <= sum(work) / size + 2 * SMALLEST
        assert min(work) > 0 or size < len(chain)
    with pytest.raises(InputError, match=f"{most + 1} ranks .* {most} is the largest"):
        partition(chain, most + 1, mode, SMALLEST)


def test_physics():
    two, six = (partition(ROD, size, "auto", SMALLEST) for size in (2, 6))
    assert [[rank for rank, _, _ in pieces] for pieces in two] == [[0], [1], [0]]
    assert [len(pieces) for pieces in six] == [1, 1, 4], "in proportion to work"
