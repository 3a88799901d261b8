"""How the ranks share the nodes of blocks: plain integers, no communication.

The nodes of a block are cut along its axes; a *part* is what lies between cuts, and belongs to
one rank. A rank that has an end of an axis has all rows of the closure there and what they reach;
parts in the middle have at least the nodes of a halo.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise, product
from math import prod

import numpy as np

from fsipetsc.errors import RanksError

#: work of a node of gas in entropy form by dimension, relative to a solid's: measured
COST = {1: 1.6, 2: 1.3, 3: 1.45}
#: work [nodes of a solid] that sending and receiving one message costs
MESSAGE = 100.0
#: "auto" cuts blocks across materials only if that makes the slowest rank faster by this factor
WORTH_IT = 1.1


@dataclass(frozen=True)
class Extent:
    """A block as its partition sees it.

    kind: "fluid" or "solid". shape: nodes per axis. periodic: per axis. end, inner: nodes, at
    least, that a rank has along an axis, if it has an end of the axis, and if not. halo: width of
    the halo.
    """

    kind: str
    shape: tuple[int, ...]
    periodic: tuple[bool, ...]
    end: int
    inner: int
    halo: int

    @property
    def work(self) -> float:
        """That of all nodes, of which one of a solid is 1."""
        return prod(self.shape) * (COST[len(self.shape)] if self.kind == "fluid" else 1.0)

    def least(self, axis: int) -> int:
        """Nodes, at least, of the first and the last one of several parts along an axis."""
        return self.inner if self.periodic[axis] else self.end

    def most(self, axis: int) -> int:
        """Parts that there can be along an axis."""
        between = self.shape[axis] - 2 * self.least(axis)
        return 1 if between < 0 else 2 + between // self.inner

    @property
    def cap(self) -> int:
        return prod(map(self.most, range(len(self.shape))))

    def allows(self, axis: int, cuts: Sequence[int]) -> bool:
        """Whether parts between these cuts are large enough."""
        sizes = [b - a for a, b in pairwise(cuts)]
        ends = min(sizes[0], sizes[-1]) >= self.least(axis)
        return len(sizes) == 1 or (ends and min(sizes) >= self.inner)

    def even(self, axis: int, parts: int) -> tuple[int, ...]:
        """Cuts into so many parts, not more than ``most``, as even as they can be."""
        n, end = self.shape[axis], self.end
        cuts = tuple(n * k // parts for k in range(parts + 1))
        if self.allows(axis, cuts):
            return cuts
        inner = (end + (n - 2 * end) * k // (parts - 2) for k in range(parts - 1))
        return 0, *inner, n


@dataclass(frozen=True)
class Share:
    """The ranks of a block, those along axis 0 side by side, and the cuts of each axis."""

    ranks: tuple[int, ...]
    cuts: tuple[tuple[int, ...], ...]

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(cuts[-1] for cuts in self.cuts)

    @property
    def grid(self) -> tuple[int, ...]:
        return tuple(len(cuts) - 1 for cuts in self.cuts)

    def part(self, rank: int) -> tuple[tuple[int, int], ...]:
        """(first node, first node beyond) of a rank, per axis."""
        place = np.unravel_index(self.ranks.index(rank), self.grid, order="F")
        return tuple((cuts[i], cuts[i + 1]) for cuts, i in zip(self.cuts, place, strict=True))

    def nodes(self, rank: int) -> np.ndarray:
        """Numbers of the nodes of a rank, ascending; they are counted with axis 0 first."""
        if rank not in self.ranks:
            return np.empty(0, np.int64)
        index = np.ix_(*(np.arange(a, b) for a, b in self.part(rank)))
        return np.ravel_multi_index(index, self.shape, order="F").ravel(order="F")

    def owners(self, nodes: np.ndarray) -> np.ndarray:
        """The ranks that own nodes, by their numbers."""
        places = np.unravel_index(nodes, self.shape, order="F")
        at = [np.searchsorted(c, i, "right") - 1 for c, i in zip(self.cuts, places, strict=True)]
        return np.array(self.ranks)[np.ravel_multi_index(at, self.grid, order="F")]


def share_out(extents: Sequence[Extent], size: int, mode: str = "auto") -> list[Share]:
    """The share of each block, for ``size`` ranks.

    physics: each rank has one block, or a part of one; with fewer ranks than blocks whole blocks,
    and gas and solid on different ranks. balanced: equal work for all ranks, in the order of the
    blocks, gas first; blocks are cut along their longest axes only. Where that is impossible it is
    physics. auto: the one with which the slowest rank has less to do.
    RanksError, which names the largest number of ranks that works, if these are too many.
    """
    if size == 1:
        return [Share((0,), _uncut(extent)) for extent in extents]
    most = sum(extent.cap for extent in extents)
    if size > most:
        raise RanksError(
            f"{size} ranks are more than these blocks can feed: with at least "
            f"{min(extent.end for extent in extents)} nodes along each cut axis on a rank, {most} "
            "is the largest number that works"
        )
    apart, chained = _physics(extents, size), _balanced(extents, size)
    if chained is None or mode == "physics":
        return apart
    gain = slowest(extents, apart, size) / slowest(extents, chained, size)
    return chained if mode == "balanced" or gain > WORTH_IT else apart


def _uncut(extent: Extent) -> tuple[tuple[int, ...], ...]:
    return tuple((0, n) for n in extent.shape)


def slowest(extents: Sequence[Extent], shares: Sequence[Share], size: int) -> float:
    """Work of the rank that has most to do: nodes, half of the halos, messages."""
    work = np.zeros(size)
    for extent, share in zip(extents, shares, strict=True):
        for rank in share.ranks:
            part, neighbours = extent.work, 0
            for axis, (begin, end) in enumerate(share.part(rank)):
                whole = end - begin == extent.shape[axis]
                outer = (begin == 0) + (end == extent.shape[axis])
                sides = 0 if whole else 2 if extent.periodic[axis] else 2 - outer
                part *= (end - begin + 0.5 * sides * extent.halo) / extent.shape[axis]
                neighbours += sides
            work[rank] += part + MESSAGE * neighbours
    return float(work.max())


def _physics(extents: Sequence[Extent], size: int) -> list[Share]:
    """Each rank has one block, or a part of one, or whole blocks of one kind."""
    if size >= len(extents):
        counts = _apportion([e.work for e in extents], [e.cap for e in extents], size)
        begins = [0, *accumulate(counts)]
        return [_cut(extent, range(*ends)) for extent, ends in zip(extents, pairwise(begins))]
    kinds = sorted({extent.kind for extent in extents})  # gas on the lower ranks
    of_kinds = [[k for k, e in enumerate(extents) if e.kind == kind] for kind in kinds]
    work = [sum(extents[k].work for k in blocks) for blocks in of_kinds]
    loads, ranks, first = [0.0] * size, [0] * len(extents), 0
    for blocks, count in zip(of_kinds, _apportion(work, list(map(len, of_kinds)), size)):
        for k in sorted(blocks, key=lambda k: (-extents[k].work, k)):  # the largest first
            ranks[k] = min(range(first, first + count), key=loads.__getitem__)
            loads[ranks[k]] += extents[k].work
        first += count
    return [Share((r,), _uncut(extent)) for extent, r in zip(extents, ranks, strict=True)]


def _apportion(work: Sequence[float], caps: Sequence[int], size: int) -> list[int]:
    """Ranks for each, one at least; each further one goes where a rank has most work."""
    counts = [1] * len(work)
    for _ in range(size - len(work)):
        open_ones = [k for k in range(len(work)) if counts[k] < caps[k]]
        counts[max(open_ones, key=lambda k: work[k] / counts[k])] += 1
    return counts


def _cut(extent: Extent, ranks: range) -> Share:
    """A block on these ranks, or on some of them if it cannot be cut into so many parts; with the
    fewest nodes along cuts.
    """
    shape, grids, count = extent.shape, list[tuple[int, ...]](), len(ranks) + 1
    while not grids:
        count -= 1
        divisors = [n for n in range(1, count + 1) if count % n == 0]
        parts = [[n for n in divisors if n <= extent.most(axis)] for axis in range(len(shape))]
        grids = [grid for grid in product(*parts) if prod(grid) == count]

    def nodes_along_cuts(grid: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
        return sum((k - 1) * (prod(shape) // n) for k, n in zip(grid, shape, strict=True)), grid

    grid = min(grids, key=nodes_along_cuts)
    cuts = tuple(extent.even(axis, parts) for axis, parts in enumerate(grid))
    return Share(tuple(ranks[:count]), cuts)


def _balanced(extents: Sequence[Extent], size: int) -> list[Share] | None:
    """Blocks one after the other on a line of work, cut into equal pieces; None if impossible."""
    order = sorted(range(len(extents)), key=lambda k: (extents[k].kind != "fluid", k))
    total, begun = sum(extent.work for extent in extents), 0.0
    shares: dict[int, Share] = {}
    for k in order:
        ended = begun + extents[k].work
        share = _slabs(extents[k], begun * size / total, ended * size / total, size)
        if share is None:
            return None
        shares[k], begun = share, ended
    used = {rank for share in shares.values() for rank in share.ranks}
    return [shares[k] for k in range(len(extents))] if len(used) == size else None


def _slabs(extent: Extent, begin: float, end: float, size: int) -> Share | None:
    """A block between the places ``begin`` and ``end`` on a line on which rank r has r … r + 1."""
    n, axis = max((n, axis) for axis, n in enumerate(extent.shape))  # rows stay whole
    first, last = min(int(begin + 1e-9), size - 1), min(int(end - 1e-9), size - 1)
    inner = [round(n * (rank - begin) / (end - begin)) for rank in range(first + 1, last + 1)]
    # a part that would be too small goes to the next rank
    least = extent.least(axis)
    cuts = [0, *(0 if cut < least else n if cut > n - least else cut for cut in inner), n]
    kept = [(rank, a, b) for rank, (a, b) in zip(range(first, last + 1), pairwise(cuts)) if b > a]
    along = (0, *(b for _, _, b in kept))
    if not extent.allows(axis, along):
        return None
    whole = list(_uncut(extent))
    whole[axis] = along
    return Share(tuple(rank for rank, _, _ in kept), tuple(whole))
