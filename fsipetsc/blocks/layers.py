"""Blocks of flat layers that lie one above the other, in one, two or three dimensions.

Layers are stacked along the last axis and share the others, which go *along* them. A layer that
does not reach over all of these, as a panel that is set into a wall, has a span. Where one ends,
every layer is cut, so that faces conform: a gas over a panel becomes three blocks side by side,
joined.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Condition, Periodic, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem, FaceName
from fsipetsc.checks import POSITIVE, described, extent, number
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import operator

#: (low, high) [m]
Extent = tuple[float, float]
#: what stands at (axis, side), axis one of those along the layers
Sides = Condition | Mapping[tuple[int, int], Condition]
#: of a length: places that are no further apart are the same
_SAME = 1e-6


@dataclass(frozen=True)
class Layer:
    """A flat layer; InputError as of Block.

    across: (low, high) of it along the last axis [m]. cells: across it; None: by the spacing h of
    ``layers``. span: (low, high) for each axis along the layers, None for one that it reaches over
    all of; None: over all of all. sides: what stands at its sides, one condition or one for each
    (axis, side); None: those of ``layers``. beside: what its lower or upper face is where the layer
    there has ended. initial, forcing, exact: as of Block.
    """

    name: str
    material: Any
    across: Extent
    initial: Callable[..., Any]
    cells: int | None = None
    span: Sequence[Extent | None] | None = None
    sides: Sides | None = None
    beside: Condition | None = None
    forcing: Callable[..., Any] | None = None
    exact: Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        what = f"layer {described(self.name)}"
        object.__setattr__(self, "across", extent(self.across, what))
        if self.span is not None:
            span = tuple(None if ends is None else extent(ends, what) for ends in self.span)
            object.__setattr__(self, "span", span)
        whole = isinstance(self.cells, int) and not isinstance(self.cells, bool) and self.cells > 0
        if self.cells is not None and not whole:
            raise InputError(f"{what}: cells is {described(self.cells)}: expected a number above 0")


@dataclass(frozen=True)
class Piece:
    """A part of a layer between two cuts along each axis; where: its number along each."""

    layer: Layer
    where: tuple[int, ...]
    block: Block


def layers(
    *stack: Layer,
    lower: Condition,
    upper: Condition,
    along: Sequence[Extent] = (),
    cells: Sequence[int] | None = None,
    h: float | None = None,
    order: int | None = None,
    sides: Sides | None = None,
    jumps: Callable[..., Any] | None = None,
    notes: Sequence[str] = (),
    units: str = "SI",
) -> BlockProblem:
    """The blocks of layers from below; two neighbours of different kinds, or of the same, meet.

    along: (low, high) of each axis along the layers [m], none in one dimension. cells: along each;
    or h: spacing [m] that gives these and those across the layers; order: of the operators, whose
    least number of cells layers across which none is said then have. lower, upper: what stands at
    the lowest and the topmost layer. sides: at the sides of layers that have none of their own;
    None: they go on periodically. jumps, notes, units: as of BlockProblem. InputError where these
    do not fit together.
    """
    if not stack or not all(isinstance(layer, Layer) for layer in stack):
        raise InputError("layers: expected one or more of Layer")
    along = tuple(extent(ends, "layers: along") for ends in along)
    for below, above in zip(stack, stack[1:]):
        if abs(below.across[1] - above.across[0]) > 1e-9 * (below.across[1] - below.across[0]):
            ends = f"ends at {below.across[1]:g}, '{above.name}' begins at {above.across[0]:g}"
            raise InputError(f"layers: '{below.name}' {ends}: expected the same")
    stack = tuple(_meeting(stack))
    grid = _Grid(stack, along, _cells_along(along, cells, h), h, order, sides)
    pieces = [grid.pieces(layer) for layer in stack]
    faces = _faces(pieces, along, lower, upper, sides)
    blocks = tuple(piece.block for of_layer in pieces for piece in of_layer.values())
    return BlockProblem(blocks, faces, jumps, notes=tuple(notes), units=units)


def _meeting(stack: Sequence[Layer]) -> Sequence[Layer]:
    """Layers whose ends are the same number where they meet."""
    low = [stack[0].across[0], *(below.across[1] for below in stack[:-1])]
    return [replace(layer, across=(a, layer.across[1])) for layer, a in zip(stack, low)]


def _cells_along(
    along: Sequence[Extent], cells: Sequence[int] | None, h: float | None
) -> tuple[int, ...]:
    if cells is not None:
        if len(cells) != len(along):
            raise InputError(f"layers: cells is {described(cells)}: expected one for each of along")
        return tuple(cells)
    if along and h is None:
        raise InputError("layers: neither cells nor h is given: expected one of them")
    return tuple(max(1, round((b - a) / number(h, "layers: h", POSITIVE))) for a, b in along)


class _Grid:
    """Where layers are cut, and how many cells there are between the cuts."""

    def __init__(
        self,
        stack: Sequence[Layer],
        along: Sequence[Extent],
        cells: Sequence[int],
        h: float | None,
        order: int | None,
        sides: Sides | None,
    ) -> None:
        self.along, self.cells, self.h = along, cells, h
        self.least = 1 if order is None else operator(order).min_points - 1
        spans = [layer for layer in stack if layer.span is not None]
        for layer in spans:
            if len(layer.span) != len(along):
                expected = "expected (low, high) for each of along"
                raise InputError(f"layer '{layer.name}': span: {expected}")
        found = [{0, n} for n in cells]
        for layer in spans:
            for axis, ends in enumerate(layer.span):
                found[axis] |= {self._number(layer, axis, place) for place in ends or ()}
        #: of each axis along the layers, numbers of the columns where they are cut
        self.cuts = [sorted(numbers) for numbers in found]
        #: whether one block closes in itself
        self.closed = [
            len(cuts) == 2 and all(_sides_of(layer, sides, axis, 0) is None for layer in stack)
            for axis, cuts in enumerate(self.cuts)
        ]

    def _number(self, layer: Layer, axis: int, place: float) -> int:
        """Of the column at a place; InputError where there is none."""
        (low, high), n = self.along[axis], self.cells[axis]
        column = (place - low) / (high - low) * n
        if abs(column - round(column)) > _SAME * n or not 0 <= round(column) <= n:
            raise InputError(
                f"layer '{layer.name}' has an end at {place:g}: expected one of the columns, which "
                f"are {(high - low) / n:.6g} apart from {low:g} to {high:g}"
            )
        return round(column)

    def place(self, axis: int, column: int) -> float:
        """Of a column [m]."""
        (low, high), n = self.along[axis], self.cells[axis]
        return high if column == n else low + (high - low) * column / n

    def pieces(self, layer: Layer) -> dict[tuple[int, ...], Piece]:
        """By their numbers along the axes, axis 0 fastest."""
        low, high = layer.across
        rows = layer.cells
        if rows is None:
            if self.h is None:
                raise InputError(f"layer '{layer.name}': neither its cells nor h is given")
            rows = max(round((high - low) / self.h), self.least, 1)
        ranges = [range(len(cuts) - 1) for cuts in self.cuts]
        for axis, ends in enumerate(layer.span or ()):
            if ends is not None:
                first, end = (self.cuts[axis].index(self._number(layer, axis, x)) for x in ends)
                ranges[axis] = range(first, end)
        numbers = [where[::-1] for where in product(*ranges[::-1])]
        found = {}
        for count, where in enumerate(numbers, 1):
            at = [(cuts[k], cuts[k + 1]) for cuts, k in zip(self.cuts, where)]
            corners = [[self.place(axis, ends[s]) for axis, ends in enumerate(at)] for s in (0, 1)]
            name = layer.name if len(numbers) == 1 else f"{layer.name} {count}"
            block = Block(
                name,
                layer.material,
                rectangle((*corners[0], low), (*corners[1], high)),
                (*(b - a for a, b in at), rows),
                layer.initial,
                layer.forcing,
                layer.exact,
                periodic=(*self.closed, False),
            )
            found[where] = Piece(layer, where, block)
        return found


def _faces(
    pieces: Sequence[Mapping[tuple[int, ...], Piece]],
    along: Sequence[Extent],
    lower: Condition,
    upper: Condition,
    sides: Sides | None,
) -> dict[FaceName, Condition]:
    """The conditions of all faces that do not meet another one."""
    found: dict[FaceName, Condition] = {}
    for n, of_layer in enumerate(pieces):
        below = pieces[n - 1] if n > 0 else None
        above = pieces[n + 1] if n + 1 < len(pieces) else None
        for where, piece in of_layer.items():
            name, layer = piece.block.name, piece.layer
            for axis, side in product(range(len(along)), (0, 1)):
                beyond = list(where)
                beyond[axis] += 2 * side - 1
                if tuple(beyond) not in of_layer and not piece.block.periodic[axis]:
                    found[name, axis, side] = _side(layer, sides, along, axis, side)
            for side, other, end in ((0, below, lower), (1, above, upper)):
                if other is None or where not in other:
                    found[name, len(along), side] = _end(layer, side, other, end)
    return found


def _end(layer: Layer, side: int, other: Mapping[Any, Piece] | None, end: Condition) -> Condition:
    """What a piece has below (0) or above (1) where it meets none. InputError."""
    edge = f"{layer.name} {('lower', 'upper')[side]}"
    if other is None:
        return _wall(end, edge)
    if layer.beside is None:
        ended = next(iter(other.values())).layer.name
        raise InputError(
            f"layer '{layer.name}': '{ended}' does not reach over all of it: expected beside=…"
        )
    return _wall(layer.beside, f"{edge} beside")


def _side(
    layer: Layer, sides: Sides | None, along: Sequence[Extent], axis: int, side: int
) -> Condition:
    """What stands at a side of a layer. InputError where nothing is said."""
    chosen = _sides_of(layer, sides, axis, side)
    if chosen is not None:
        return _wall(chosen, f"{layer.name} {axis} {side}")
    if layer.span is not None and layer.span[axis] is not None:
        nothing = f"nothing is said of axis {axis}, side {side}"
        raise InputError(f"layer '{layer.name}' has a span: sides: {nothing}")
    shift = [0.0] * (len(along) + 1)
    shift[axis] = (along[axis][1] - along[axis][0]) * (1 - 2 * side)
    return Periodic(tuple(shift))


def _sides_of(layer: Layer, sides: Sides | None, axis: int, side: int) -> Condition | None:
    """What is said of a side of a layer."""
    chosen = layer.sides if layer.sides is not None else sides
    return chosen.get((axis, side)) if isinstance(chosen, Mapping) else chosen


def _wall(condition: Condition, name: str) -> Condition:
    """The condition; a wall without a name gets this one: over several blocks it is one wall."""
    if isinstance(condition, Slip) and not condition.name:
        return replace(condition, name=name)
    return condition
