"""-fsi_view for problems of blocks: blocks, their ranks, materials and faces."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod
from typing import TYPE_CHECKING, Any

from fsipetsc.blockrun.run_problem import PLACES
from fsipetsc.blocks.problem import Meeting

if TYPE_CHECKING:
    from fsipetsc.blockrun.block_state import BlockState

#: parts of a block that are listed
_LISTED = 4


def block_lines(state: BlockState, described: Any) -> Iterator[str]:
    """Lines about the blocks. Not collective. described: says what a material or a condition is."""
    problem, layout = state.problem, state.layout
    for k, block in enumerate(problem.layers):
        nodes = " x ".join(map(str, layout.shapes[k]))
        closed = [f"axis {a}" for a, p in enumerate(block.periodic) if p]
        ring = f", periodic along {' and '.join(closed)}" if closed else ""
        yield f"  Block {k}: ({block.name}) {block.kind}, {nodes} nodes{ring}"
        yield f"    map: {type(block.map).__name__}, {_extent(state, k)}"
        yield f"    ranks: {_ranks(state, k)}"
        yield f"    material: {described(block.material)}"
        for (axis, side), stands in sorted(problem.faces_of(k).items()):
            yield f"    face {axis}, {side}: {_face(problem, k, axis, side, stands, described)}"


def _extent(state: BlockState, k: int) -> str:
    """Where the corners of a block's box are."""
    problem, m = state.problem, state.problem.unit("m")
    places = problem.positions(k, [(0, n) for n in state.layout.shapes[k]])
    spans = zip(PLACES.upper(), places.min(axis=1), places.max(axis=1), strict=False)
    return ", ".join(f"{name} = {low:g} … {high:g}{m}" for name, low, high in spans)


def _ranks(state: BlockState, k: int) -> str:
    """Which ranks own how many nodes."""
    share = state.layout.shares[k]
    parts = [
        f"{rank} ({' x '.join(str(b - a) for a, b in share.part(rank))})" for rank in share.ranks
    ]
    more = f", … {parts[-1]}" if len(parts) > _LISTED else ""
    cut = f" in {' x '.join(map(str, share.grid))} parts" if prod(share.grid) > 1 else ""
    return ", ".join(parts[:_LISTED]) + more + cut


def _face(problem: Any, k: int, axis: int, side: int, stands: Any, described: Any) -> str:
    if not isinstance(stands, Meeting):
        return str(described(stands))
    what = "interface with" if problem.is_interface(k, axis, side) else "joined to"
    return f"{what} {problem.layers[stands.block].name}, face {stands.axis}, {stands.side}"
