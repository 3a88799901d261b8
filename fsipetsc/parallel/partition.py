"""Which ranks own which points: plain integers, no communication.

A *share* is one rank's piece of a layer, ``(rank, begin, end)``. Pieces are at least ``smallest``
points long, so that every halo and every closure row at an interface lies with one neighbour.
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
    """A layer as the partition sees it: n stored points of which ``active`` ones have work, spare
    ones at one end."""

    kind: str
    n: int
    active: int
    spare_left: bool


Share = tuple[int, int, int]


def partition(extents: Sequence[Extent], size: int, mode: str, smallest: int) -> list[list[Share]]:
    """Shares of each layer for ``size`` ranks.

    physics: fluids on the lower half of the ranks, solids on the upper, as long as there are fewer
    ranks than layers; else ranks in proportion to work, one layer each. balanced: points dealt out
    evenly in the order of X, a rank may own parts of neighbouring layers. auto: balanced on grids
    of BALANCED_FROM points and more, where that is possible, else physics. Raises InputError,
    naming the largest number of ranks that would work.
    """
    if size == 1:
        return [[(0, 0, e.n)] for e in extents]
    points = sum(e.active for e in extents)
    even = min(points // (2 * smallest), sum(e.active // smallest for e in extents))
    caps = [max(1, e.active // smallest) for e in extents]
    if mode == "auto":
        mode = "balanced" if points >= BALANCED_FROM and size <= even else "physics"
    most = max(1, even) if mode == "balanced" else sum(caps)
    if size > most:
        raise InputError(
            f"{size} ranks are more than this grid can feed: with {points} active points and at "
            f"least {smallest} of a layer on a rank, {most} is the largest number that works"
        )
    if mode == "balanced":
        return _balanced(extents, size, smallest)
    if size < len(extents):
        ranks = _by_physics([e.kind for e in extents], size)
        return [[(rank, 0, e.n)] for rank, e in zip(ranks, extents, strict=True)]
    shares, first = [], 0
    for extent, count in zip(extents, _in_proportion(extents, caps, size), strict=True):
        cuts = [round(k * extent.active / count) for k in range(count + 1)]
        pieces = [(first + k, cuts[k], cuts[k + 1]) for k in range(count)]
        shares.append(_with_spare(extent, pieces))
        first += count
    return shares


def _with_spare(extent: Extent, shares: list[Share]) -> list[Share]:
    """Shares of the active points, moved to where these are stored; the outermost rank gets the
    spare ones."""
    spare = extent.n - extent.active
    if extent.spare_left:
        shares = [(rank, begin + spare, end + spare) for rank, begin, end in shares]
        rank, _, end = shares[0]
        return [(rank, 0, end), *shares[1:]]
    rank, begin, _ = shares[-1]
    return [*shares[:-1], (rank, begin, extent.n)]


def _by_physics(kinds: Sequence[str], size: int) -> list[int]:
    """A rank for each layer: fluids dealt over the lower half of the ranks, solids over the
    upper."""
    lower, ranks = size // 2, []
    for k, kind in enumerate(kinds):
        alike = kinds[:k].count(kind)
        ranks.append(alike % lower if kind == "fluid" else lower + alike % (size - lower))
    return ranks


def _in_proportion(extents: Sequence[Extent], caps: Sequence[int], size: int) -> list[int]:
    """Ranks per layer, one at least, each further one to the layer with most work per rank."""
    ranks = [1] * len(extents)
    for _ in range(size - len(extents)):
        free = [k for k in range(len(extents)) if ranks[k] < caps[k]]
        ranks[max(free, key=lambda k: extents[k].active / ranks[k])] += 1
    return ranks


def _balanced(extents: Sequence[Extent], size: int, smallest: int) -> list[list[Share]]:
    """Even cuts of the chain of active points; a cut closer to an end of a layer than ``smallest``
    moves there."""
    starts = [sum(e.active for e in extents[:k]) for k in range(len(extents) + 1)]
    total, cuts = starts[-1], [0]
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
