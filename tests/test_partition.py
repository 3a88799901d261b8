"""Which ranks own which points: every point once, pieces long enough, and a clear end where ranks run out."""

from __future__ import annotations

import pytest

pytest.importorskip("petsc4py")

from fsipetsc.errors import InputError
from fsipetsc.parallel.partition import MODES, Extent, partition

ROD = (Extent("fluid", 62, 41, True), Extent("solid", 41, 41, False), Extent("fluid", 197, 161, False))
PULSE = (Extent("solid", 61, 61, False), Extent("fluid", 77, 61, False))
FIVE = (
    Extent("fluid", 30, 20, True),
    Extent("solid", 9, 9, False),
    Extent("fluid", 50, 50, False),
    Extent("solid", 100, 100, False),
    Extent("fluid", 400, 333, False),
)
CHAINS = {"rod": ROD, "pulse": PULSE, "five layers": FIVE}
SMALLEST = 6

ALL = pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
EVERY_MODE = pytest.mark.parametrize("mode", MODES)


def largest(chain, mode, smallest=SMALLEST) -> int:
    """The largest number of ranks that the partition accepts."""
    with pytest.raises(InputError) as caught:
        partition(chain, 10**6, mode, smallest)
    message = str(caught.value)
    assert message.startswith("1000000 ranks")
    return int(message.split(", ")[-1].split()[0])


def active_part(extent: Extent) -> tuple[int, int]:
    return (extent.n - extent.active, extent.n) if extent.spare_left else (0, extent.active)


@ALL
@EVERY_MODE
def test_every_point_has_one_owner_and_every_rank_something(chain, mode):
    for size in range(1, largest(chain, mode) + 1):
        shares = partition(chain, size, mode, SMALLEST)
        for extent, pieces in zip(chain, shares, strict=True):
            cuts = [pieces[0][1], *(end for _, _, end in pieces)]
            assert (cuts[0], cuts[-1]) == (0, extent.n)
            assert all(a[2] == b[1] for a, b in zip(pieces, pieces[1:], strict=False))
            ranks = [rank for rank, _, _ in pieces]
            assert ranks == sorted(set(ranks)), "DMDA numbers its ranks in ascending order"
        owners = {rank for pieces in shares for rank, _, _ in pieces}
        assert owners == set(range(min(size, len(chain)) if mode != "balanced" and size < len(chain) else size))


@ALL
@EVERY_MODE
def test_pieces_are_long_enough_for_halos_and_closures(chain, mode):
    for size in range(1, largest(chain, mode) + 1):
        for extent, pieces in zip(chain, partition(chain, size, mode, SMALLEST), strict=True):
            begin, end = active_part(extent)
            lengths = [min(b, end) - max(a, begin) for _, a, b in pieces]
            assert min(lengths) >= min(SMALLEST, extent.active)


@ALL
@EVERY_MODE
def test_one_rank_too_many_is_refused_with_the_number_that_works(chain, mode):
    most = largest(chain, mode)
    partition(chain, most, mode, SMALLEST)
    with pytest.raises(InputError, match=f"{most + 1} ranks .* {most} is the largest"):
        partition(chain, most + 1, mode, SMALLEST)


def test_one_rank_owns_all():
    for mode in MODES:
        assert partition(ROD, 1, mode, SMALLEST) == [[(0, 0, e.n)] for e in ROD]


def test_two_ranks_are_one_for_the_fluids_and_one_for_the_solids():
    owners = [[rank for rank, _, _ in pieces] for pieces in partition(ROD, 2, "auto", SMALLEST)]
    assert owners == [[0], [1], [0]]


def test_ranks_in_proportion_to_work():
    counts = [len(pieces) for pieces in partition(ROD, 6, "auto", SMALLEST)]
    assert counts == [1, 1, 4]


@pytest.mark.parametrize("size", [2, 3, 4, 6])
def test_balanced_is_balanced(size):
    """No rank has more than an even share and what moving a cut to the end of a layer adds."""
    work = [0] * size
    for extent, pieces in zip(ROD, partition(ROD, size, "balanced", SMALLEST), strict=True):
        begin, end = active_part(extent)
        for rank, a, b in pieces:
            work[rank] += min(b, end) - max(a, begin)
    assert max(work) <= sum(work) / size + 2 * SMALLEST


def test_spare_points_belong_to_the_outermost_rank():
    left, _, right = partition(ROD, 8, "auto", SMALLEST)
    assert left[0][1] == 0
    assert right[-1][2] == ROD[2].n
