"""Which ranks own which points: plain integers, no communication.

A *share* is one rank's piece of a layer, ``(rank, begin, end)``. Pieces are at least ``smallest`` points long, so
that every halo and every closure row at an interface lies with one neighbour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fsipetsc.errors import InputError

MODES = ("auto", "physics", "balanced")
#: active points from which an even share of the points weighs more than messages within layers
BALANCED_FROM = 1000


@dataclass(frozen=True)
class Extent:
    """A layer as the partition sees it: n stored points of which ``active`` ones have work, spare ones at one end."""

    kind: str
    n: int
    active: int
    spare_left: bool


Share = tuple[int, int, int]


def partition(extents: Sequence[Extent], size: int, mode: str, smallest: int) -> list[list[Share]]:
    """Shares of each layer for ``size`` ranks.

    auto: one rank owns all; on grids of BALANCED_FROM points and more as balanced, where that is possible; fewer ranks
    than layers: as physics; else ranks in proportion to work, one layer each.
    physics: fluids on the lower half of the ranks, solids on the upper, as long as there are fewer ranks than layers.
    balanced: points dealt out evenly in the order of X, a rank may own parts of neighbouring layers.
    Raises InputError, naming the largest number of ranks that would work.
    """
    points = sum(e.active for e in extents)
    if mode == "auto" and size > 1 and points >= BALANCED_FROM and size <= _most_balanced(extents, smallest):
        mode = "balanced"
    if mode == "balanced":
        total = sum(e.active for e in extents)
        if size > _most_balanced(extents, smallest):
            raise InputError(_too_many(size, _most_balanced(extents, smallest), total, smallest))
        return _balanced(extents, size, smallest)
    caps = [max(1, e.active // smallest) for e in extents]
    if size > sum(caps):
        raise InputError(_too_many(size, sum(caps), sum(e.active for e in extents), smallest))
    if size == 1:
        return [[(0, 0, e.n)] for e in extents]
    if size < len(extents):
        ranks = by_physics([e.kind for e in extents], size)
        return [[(rank, 0, e.n)] for rank, e in zip(ranks, extents, strict=True)]
    ranks = apportion([e.active for e in extents], caps, size)
    shares, first = [], 0
    for extent, count in zip(extents, ranks, strict=True):
        cuts = [round(k * extent.active / count) for k in range(count + 1)]
        shares.append(_with_spare(extent, [(first + k, cuts[k], cuts[k + 1]) for k in range(count)]))
        first += count
    return shares


def _too_many(size: int, most: int, points: int, smallest: int) -> str:
    return (
        f"{size} ranks are more than this grid can feed: with {points} active points and at least {smallest} of a "
        f"layer on a rank, {most} is the largest number that works"
    )


def _with_spare(extent: Extent, shares: list[Share]) -> list[Share]:
    """Shares of the active points, moved to where these are stored; the outermost rank gets the spare ones."""
    spare = extent.n - extent.active
    if extent.spare_left:
        shares = [(rank, begin + spare, end + spare) for rank, begin, end in shares]
        rank, _, end = shares[0]
        return [(rank, 0, end), *shares[1:]]
    rank, begin, _ = shares[-1]
    return [*shares[:-1], (rank, begin, extent.n)]


def stretched(extent: Extent, shares: Sequence[Share]) -> list[Share]:
    """The shares of a layer that had fewer stored points, or as many: what is new belongs to the outermost rank."""
    if extent.spare_left:
        added = extent.n - shares[-1][2]
        return [(rank, begin + added if begin else 0, end + added) for rank, begin, end in shares]
    rank, begin, _ = shares[-1]
    return [*shares[:-1], (rank, begin, extent.n)]


def by_physics(kinds: Sequence[str], size: int) -> list[int]:
    """A rank for each layer: fluids dealt over the lower half of the ranks, solids over the upper."""
    lower = max(1, size // 2)
    seen = {"fluid": 0, "solid": 0}
    ranks = []
    for kind in kinds:
        k = seen[kind]
        seen[kind] += 1
        ranks.append(k % lower if kind == "fluid" else lower + k % (size - lower))
    return ranks


def apportion(work: Sequence[int], caps: Sequence[int], size: int) -> list[int]:
    """Ranks per layer, one at least, each further one to the layer with most work per rank."""
    ranks = [1] * len(work)
    for _ in range(size - len(work)):
        open_layers = [k for k in range(len(work)) if ranks[k] < caps[k]]
        ranks[max(open_layers, key=lambda k: work[k] / ranks[k])] += 1
    return ranks


def _most_balanced(extents: Sequence[Extent], smallest: int) -> int:
    """Largest number of ranks with an even share of at least twice the smallest piece."""
    return max(1, min(sum(e.active for e in extents) // (2 * smallest), sum(e.active // smallest for e in extents)))


def _balanced(extents: Sequence[Extent], size: int, smallest: int) -> list[list[Share]]:
    """Even cuts of the chain of active points; a cut closer to an end of a layer than ``smallest`` moves there."""
    total = sum(e.active for e in extents)
    starts = [sum(e.active for e in extents[:k]) for k in range(len(extents) + 1)]
    cuts = [0]
    for r in range(1, size):
        cut = round(r * total / size)
        for start in starts:
            if abs(cut - start) < smallest:
                cut = start
        cuts.append(max(cut, cuts[-1]))
    cuts.append(total)
    shares = []
    for k, extent in enumerate(extents):
        pieces = []
        for rank in range(size):
            begin, end = max(cuts[rank], starts[k]), min(cuts[rank + 1], starts[k + 1])
            if end > begin:
                pieces.append((rank, begin - starts[k], end - starts[k]))
        shares.append(_with_spare(extent, pieces))
    return shares
