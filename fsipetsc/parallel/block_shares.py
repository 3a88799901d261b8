"""How the ranks share the nodes of blocks: plain integers, no communication.

The nodes of a block are cut along its axes; a *part* is what lies between cuts, and belongs to one
rank. Parts have so many nodes that no rank needs more than its neighbours and its own closures.
"""

from collections.abc import Sequence
from itertools import accumulate, pairwise, product
from math import prod
from typing import NamedTuple

import numpy as np

from fsipetsc.errors import InputError

#: work of a node of gas in entropy form by dimension, relative to a solid's: measured
COST = {1: 1.6, 2: 1.35, 3: 1.45}
#: work [nodes of a solid] that sending and receiving one message costs
MESSAGE = 100.0
#: "auto" cuts blocks across materials only if that makes the slowest rank faster by this factor
WORTH_IT = 1.1


class Extent(NamedTuple):
    """A block as its partition sees it. kind: "fluid" or "solid". shape: nodes per axis. least: of
    the nodes of a part along an axis that is cut. halo: width of the halo.
    """

    kind: str
    shape: tuple[int, ...]
    least: tuple[int, ...]
    halo: int

    @property
    def cost(self) -> float:
        """Work of a node, of which one of a solid is 1."""
        return COST[len(self.shape)] if self.kind == "fluid" else 1.0

    @property
    def work(self) -> float:
        return self.cost * prod(self.shape)

    @property
    def most(self) -> tuple[int, ...]:
        """Parts that there can be along each axis."""
        return tuple(max(1, n // least) for n, least in zip(self.shape, self.least, strict=True))


class Share(NamedTuple):
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

    physics: each rank has one block, or a part of one; with fewer ranks than blocks whole blocks.
    balanced: equal work for all ranks, in the order of the blocks, gas first; blocks are cut along
    their longest axes only. Where that is impossible it is physics. auto: the one with which the
    slowest rank has less to do.
    InputError, which names the largest number of ranks that works, if these are too many.
    """
    caps = [prod(extent.most) for extent in extents]
    if size > sum(caps):
        least = min(min(extent.least) for extent in extents)
        raise InputError(
            f"{size} ranks are more than these blocks can feed: with at least {least} nodes along "
            f"each cut axis on a rank, {sum(caps)} is the largest number that works"
        )
    apart, chained = _physics(extents, caps, size), _balanced(extents, size)
    if chained is None or mode == "physics":
        return apart
    gain = slowest(extents, apart, size) / slowest(extents, chained, size)
    return chained if mode == "balanced" or gain > WORTH_IT else apart


def slowest(extents: Sequence[Extent], shares: Sequence[Share], size: int) -> float:
    """Work of the rank that has most to do, roughly: nodes, half of the halos, messages."""
    work = np.zeros(size)
    for extent, share in zip(extents, shares, strict=True):
        sides = [min(parts - 1, 2) for parts in share.grid]  # with a neighbour
        for rank in share.ranks:
            ends = zip(share.part(rank), sides, strict=True)
            nodes = prod(b - a + 0.5 * n * extent.halo for (a, b), n in ends)
            work[rank] += extent.cost * nodes + MESSAGE * sum(sides)
    return float(work.max())


def _physics(extents: Sequence[Extent], caps: Sequence[int], size: int) -> list[Share]:
    """Each rank has one block, or a part of one, or whole blocks."""
    works = [extent.work for extent in extents]
    if size >= len(extents):
        counts = [1] * len(extents)
        for _ in range(size - len(extents)):  # where a rank has most work
            free = [k for k, cap in enumerate(caps) if counts[k] < cap]
            counts[max(free, key=lambda k: works[k] / counts[k])] += 1
        begins = accumulate([0, *counts])
        return [_cut(extent, range(*ends)) for extent, ends in zip(extents, pairwise(begins))]
    loads, found = [0.0] * size, dict[int, Share]()
    for k in sorted(range(len(extents)), key=lambda k: -works[k]):  # the largest first
        rank = loads.index(min(loads))
        found[k] = _cut(extents[k], range(rank, rank + 1))
        loads[rank] += works[k]
    return [found[k] for k in range(len(extents))]


def _cut(extent: Extent, ranks: range) -> Share:
    """A block on as many of these ranks as it can have, with the fewest nodes along cuts."""
    shape, grids, count = extent.shape, list[tuple[int, ...]](), len(ranks) + 1
    while not grids:
        count -= 1
        divisors = [n for n in range(1, count + 1) if count % n == 0]
        parts = [[n for n in divisors if n <= most] for most in extent.most]
        grids = [grid for grid in product(*parts) if prod(grid) == count]

    def nodes_along_cuts(grid: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
        return sum((k - 1) * (prod(shape) // n) for k, n in zip(grid, shape, strict=True)), grid

    grid = min(grids, key=nodes_along_cuts)
    cuts = (tuple(n * k // parts for k in range(parts + 1)) for n, parts in zip(shape, grid))
    return Share(tuple(ranks[:count]), tuple(cuts))


def _balanced(extents: Sequence[Extent], size: int) -> list[Share] | None:
    """Blocks one after the other on a line of work, cut into equal pieces; None if impossible."""
    order = sorted(range(len(extents)), key=lambda k: (extents[k].kind != "fluid", k))
    ends = [0.0, *accumulate(extents[k].work for k in order)]
    scaled = pairwise(end * size / ends[-1] for end in ends)
    shares = {k: _slabs(extents[k], *pair, size) for k, pair in zip(order, scaled)}
    used = {rank for share in shares.values() if share for rank in share.ranks}
    found = [share for k in range(len(extents)) if (share := shares[k])]
    return found if len(used) == size and len(found) == len(extents) else None


def _slabs(extent: Extent, begin: float, end: float, size: int) -> Share | None:
    """A block between the places ``begin`` and ``end`` on a line on which rank r has r … r + 1."""
    n, axis = max((n, axis) for axis, n in enumerate(extent.shape))  # rows stay whole
    first, last = min(int(begin + 1e-9), size - 1), min(int(end - 1e-9), size - 1)
    inner = [round(n * (rank - begin) / (end - begin)) for rank in range(first + 1, last + 1)]
    # a part that would be too small goes to the next rank
    least = extent.least[axis]
    cuts = [0, *(0 if cut < least else n if cut > n - least else cut for cut in inner), n]
    kept = [(rank, a, b) for rank, (a, b) in zip(range(first, last + 1), pairwise(cuts)) if b > a]
    if any(b - a < min(least, n) for _, a, b in kept):
        return None
    every: list[tuple[int, ...]] = [(0, n) for n in extent.shape]
    every[axis] = (0, *(b for _, _, b in kept))
    return Share(tuple(rank for rank, _, _ in kept), tuple(every))
