"""Blocks of flat layers that lie one above the other, in one, two or three dimensions.

Layers are stacked along the last axis and share the others, which go *along* them. A layer that
does not reach over all of these, as a panel that is set into a wall, has a span. Where one ends,
every layer is cut, so that faces conform: a gas over a panel becomes three blocks side by side,
joined.
"""

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
    if cells is None and along and h is None:
        raise InputError("layers: neither cells nor h is given: expected one of them")
    if cells is None:
        step = number(1.0 if h is None else h, "layers: h", POSITIVE)
        cells = [max(1, round((b - a) / step)) for a, b in along]
    if len(cells) != len(along):
        raise InputError(f"layers: cells is {described(cells)}: expected one for each of along")
    least = 1 if order is None else operator(order).min_points - 1
    made = _Stack(_meeting(stack), along, cells, sides, (lower, upper))
    pieces = []
    for layer in made.layers:
        rows, (low, high) = layer.cells, layer.across
        if rows is None and h is None:
            raise InputError(f"layer '{layer.name}': neither its cells nor h is given")
        rows = max(round((high - low) / h), least, 1) if rows is None else rows
        pieces.append(made.pieces(layer, rows))
    blocks = tuple(block for of_layer in pieces for block in of_layer.values())
    return BlockProblem(blocks, made.faces(pieces), jumps, notes=tuple(notes), units=units)


def _meeting(stack: Sequence[Layer]) -> list[Layer]:
    """Layers whose ends are the same number where they meet. InputError where they do not."""
    found = [stack[0]]
    for below, above in zip(stack, stack[1:]):
        low, high = below.across
        if abs(high - above.across[0]) > 1e-9 * (high - low):
            ends = f"ends at {high:g}, '{above.name}' begins at {above.across[0]:g}"
            raise InputError(f"layers: '{below.name}' {ends}: expected the same")
        found.append(replace(above, across=(high, above.across[1])))
    return found


class _Stack:
    """Where layers are cut along each axis, and what stands at faces that meet no other."""

    def __init__(
        self,
        stack: list[Layer],
        along: Sequence[Extent],
        cells: Sequence[int],
        sides: Sides | None,
        ends: tuple[Condition, Condition],
    ) -> None:
        self.layers, self._along, self._cells = stack, along, cells
        self._sides, self._ends = sides, ends
        found = [{0, n} for n in cells]
        for layer in stack:
            if layer.span is not None and len(layer.span) != len(along):
                expected = "expected (low, high) for each of along"
                raise InputError(f"layer '{layer.name}': span: {expected}")
            for axis, numbers in enumerate(found):
                numbers |= set(self._span(layer, axis))
        #: of each axis along the layers, numbers of the columns where they are cut
        self._cuts = [sorted(numbers) for numbers in found]
        #: whether one block closes in itself
        self._closed = [
            len(cuts) == 2 and all(self._side(layer, axis, 0) is None for layer in stack)
            for axis, cuts in enumerate(self._cuts)
        ]

    def _span(self, layer: Layer, axis: int) -> tuple[int, ...]:
        """Numbers of the columns at which a layer begins and ends. InputError where none is."""
        (low, high), n = self._along[axis], self._cells[axis]
        ends = None if layer.span is None else layer.span[axis]
        columns = (0, n) if ends is None else [(x - low) / (high - low) * n for x in ends]
        for place, column in zip(ends or (), columns):
            if abs(column - round(column)) > _SAME * n or not 0 <= round(column) <= n:
                apart = f"{(high - low) / n:.6g} apart from {low:g} to {high:g}"
                expected = f"expected one of the columns, which are {apart}"
                raise InputError(f"layer '{layer.name}' has an end at {place:g}: {expected}")
        return tuple(map(round, columns))

    def pieces(self, layer: Layer, rows: int) -> dict[tuple[int, ...], Block]:
        """The blocks of a layer by their numbers between cuts, axis 0 fastest."""
        (low, high), ranges, found = layer.across, [], {}
        for axis, cuts in enumerate(self._cuts):
            first, end = map(cuts.index, self._span(layer, axis))
            ranges.append(range(first, end))
        numbers = [where[::-1] for where in product(*ranges[::-1])]
        for count, where in enumerate(numbers, 1):
            at = [(cuts[k], cuts[k + 1]) for cuts, k in zip(self._cuts, where)]
            a, b = ([self._place(axis, ends[s]) for axis, ends in enumerate(at)] for s in (0, 1))
            found[where] = Block(
                layer.name if len(numbers) == 1 else f"{layer.name} {count}",
                layer.material,
                rectangle((*a, low), (*b, high)),
                (*(end - begin for begin, end in at), rows),
                layer.initial,
                layer.forcing,
                layer.exact,
                periodic=(*self._closed, False),
            )
        return found

    def _place(self, axis: int, column: int) -> float:
        (low, high), n = self._along[axis], self._cells[axis]
        return high if column == n else low + (high - low) * column / n

    def faces(self, pieces: list[dict[tuple[int, ...], Block]]) -> dict[FaceName, Condition]:
        """The conditions of all faces that do not meet another one. InputError."""
        found: dict[FaceName, Condition] = {}
        across = len(self._along)
        for n, of_layer in enumerate(pieces):
            for where, block in of_layer.items():
                for axis, side in product(range(across + 1), (0, 1)):
                    step = 2 * side - 1
                    if axis == across:
                        met = 0 <= n + step < len(pieces) and where in pieces[n + step]
                    else:
                        beyond = (*where[:axis], where[axis] + step, *where[axis + 1 :])
                        met = beyond in of_layer or block.periodic[axis]
                    if not met:
                        found[block.name, axis, side] = self._condition(n, axis, side)
        return found

    def _condition(self, n: int, axis: int, side: int) -> Condition:
        """Of a face of layer n. A wall without a name gets one: over several blocks it is one."""
        layer, other = self.layers[n], n + 2 * side - 1
        if axis < len(self._along):
            said, name = self._side(layer, axis, side), f"{layer.name} {axis} {side}"
            if said is None and layer.span is not None and layer.span[axis] is not None:
                nothing = f"nothing is said of axis {axis}, side {side}"
                raise InputError(f"layer '{layer.name}' has a span: sides: {nothing}")
        elif 0 <= other < len(self.layers):
            said, name = layer.beside, f"{layer.name} {('lower', 'upper')[side]} beside"
            if said is None:
                ended = f"'{self.layers[other].name}' does not reach over all of it"
                raise InputError(f"layer '{layer.name}': {ended}: expected beside=…")
        else:
            said, name = self._ends[side], f"{layer.name} {('lower', 'upper')[side]}"
        if said is None:
            shift = [0.0] * (len(self._along) + 1)
            shift[axis] = (self._along[axis][1] - self._along[axis][0]) * (1 - 2 * side)
            return Periodic(tuple(shift))
        return replace(said, name=name) if isinstance(said, Slip) and not said.name else said

    def _side(self, layer: Layer, axis: int, side: int) -> Condition | None:
        """What is said of a side of a layer."""
        chosen = layer.sides if layer.sides is not None else self._sides
        return chosen.get((axis, side)) if isinstance(chosen, Mapping) else chosen
