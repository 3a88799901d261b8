"""Blocks of flat layers that lie one above the other, in one, two or three dimensions.

A layer that does not reach over all of the axes along it, as a panel that is set into a wall, has a
span: a gas over it becomes three blocks side by side, joined.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import InitVar, dataclass, replace
from itertools import product
from typing import Any

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Condition, Periodic
from fsipetsc.blocks.maps import rectangle
from fsipetsc.checks import POSITIVE, cells_of, described, extent, number, own_cells
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
    """A flat layer, for `layers`.

    Args:
        name: name of its block, or the beginning of the names of its blocks.
        material: a `Fluid` or an `ElasticSolid`.
        across: (low, high) along the last axis [m].
        initial: as of `Block`.
        cells: number of cells across it; None: by h.
        h: size of the cells across it [m], to which the nearest that fits is taken; None: the h of
            `layers`.
        span: (low, high) [m] for each axis along the layers, None for one that it reaches over all
            of; None: it reaches over all of them.
        sides: what stands at its sides: a condition, or (axis, side) -> condition; None: those of
            `layers`.
        beside: condition of its lower or upper face where the layer there has ended.
        forcing: as of `Block`.
        exact: as of `Block`.
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
    h: InitVar[float | None] = None

    def __post_init__(self, h: float | None) -> None:
        what = f"layer {described(self.name)}"
        object.__setattr__(self, "across", extent(self.across, what))
        object.__setattr__(self, "cells", own_cells(self.cells, h, self.across, what))
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
    **more: Any,
) -> BlockProblem:
    """The blocks of flat layers that lie one above the other, along the last axis.

    Where a layer ends, all layers are cut into blocks, so that faces conform. Neighbours meet, be
    they of gas or of a solid.

    Args:
        stack: the layers, from below.
        lower: condition at the lower face of the lowest layer.
        upper: condition at the upper face of the topmost layer.
        along: (low, high) of each axis along the layers [m]; () in one dimension.
        cells: number of cells along each of these axes; None: by h.
        h: spacing [m] for cells that are not given.
        order: order of the operators, whose least number of cells layers then have.
        sides: what stands at the sides of layers that have none of their own; None: they go on
            periodically.
        more: `jumps`, `notes`, `units`, as of `BlockProblem`.
    """
    along = tuple(extent(ends, "layers: along") for ends in along)
    cells = [_cells(ends, h, "layers") for ends in along] if cells is None else cells
    if len(cells) != len(along):
        raise InputError(f"layers: cells is {described(cells)}: expected one for each of along")
    least, found = 1 if order is None else operator(order).min_points - 1, []
    for layer in stack:
        rows = layer.cells or max(_cells(layer.across, h, f"layer '{layer.name}'"), least)
        (low, high), span = layer.across, layer.span or (None,) * len(along)
        if found:  # it begins where the one below it ends, to the bit
            bottom, top = found[-1].across
            if abs(top - low) > 1e-9 * (top - bottom):
                ends = f"ends at {top:g}, '{layer.name}' begins at {low:g}"
                raise InputError(f"layers: '{found[-1].name}' {ends}: expected the same")
            low = top
        if len(span) != len(along):
            raise InputError(f"layer '{layer.name}': span: expected (low, high) for each of along")
        own = sides if layer.sides is None else layer.sides
        if not isinstance(own, Mapping):
            own = dict.fromkeys(product(range(len(along)), (0, 1)), own)
        found.append(replace(layer, across=(low, high), cells=rows, span=span, sides=own))
    blocks, faces = _pieces(found, along, cells), {}
    for (where, block), axis, side in product(blocks.items(), range(len(along) + 1), (0, 1)):
        layer, beyond = found[where[-1]], list(where)
        beyond[axis] += 2 * side - 1
        if tuple(beyond) in blocks or block.periodic[axis]:
            continue
        if axis < len(along):
            condition, missing = layer.sides.get((axis, side)), f"sides, of ({axis}, {side})"
            if condition is None and layer.span[axis] is None:
                shift = [0.0] * len(beyond)
                shift[axis] = (along[axis][1] - along[axis][0]) * (1 - 2 * side)
                condition = Periodic(tuple(shift))
        else:
            condition, missing = layer.beside, "beside=…, as another layer has ended there"
            if not 0 <= beyond[axis] < len(stack):
                condition = (lower, upper)[side]
        if condition is None:
            raise InputError(f"layer '{layer.name}': a face has no condition: expected {missing}")
        faces[block.name, axis, side] = condition
    return BlockProblem(tuple(blocks.values()), faces, **more)


def _cells(ends: Extent, h: float | None, what: str) -> int:
    """Cells of the spacing h [m]. InputError where it is none."""
    if h is None:
        raise InputError(f"{what}: neither cells nor h is given: expected one of them")
    return cells_of(ends, number(h, "layers: h", POSITIVE), what)


def _pieces(
    stack: Sequence[Layer], along: Sequence[Extent], cells: Sequence[int]
) -> dict[tuple[int, ...], Block]:
    """The blocks of all layers by their numbers between cuts along each axis, and that of the
    layer; axis 0 fastest.
    """
    spans = [list(map(_columns, [layer] * len(along), layer.span, along, cells)) for layer in stack]
    cuts = [sorted({0, n}.union(*(span[k] for span in spans))) for k, n in enumerate(cells)]
    closed = [
        len(cut) == 2 and all(layer.sides.get((axis, 0)) is None for layer in stack)
        for axis, cut in enumerate(cuts)
    ]
    found = {}
    for n, (layer, span) in enumerate(zip(stack, spans)):
        ranges = [range(*map(cut.index, ends)) for cut, ends in zip(cuts, span)]
        numbers = [where[::-1] for where in product(*ranges[::-1])]
        for count, where in enumerate(numbers, 1):
            columns = [cut[i : i + 2] for cut, i in zip(cuts, where)]
            ends = [
                [b if column == n else a + (b - a) * column / n for column in pair]
                for pair, (a, b), n in zip(columns, along, cells)
            ]
            found[(*where, n)] = Block(
                layer.name if len(numbers) == 1 else f"{layer.name} {count}",
                layer.material,
                rectangle(*zip(*ends, layer.across)),
                (*(end - begin for begin, end in columns), layer.cells),
                layer.initial,
                layer.forcing,
                layer.exact,
                periodic=(*closed, False),
            )
    return found


def _columns(layer: Layer, span: Extent | None, along: Extent, n: int) -> list[int]:
    """Numbers of the columns at which a layer begins and ends. InputError where none is."""
    low, high = along
    columns = [(x - low) / (high - low) * n for x in span or along]
    if any(abs(x - round(x)) > _SAME * n or not 0 <= round(x) <= n for x in columns):
        apart = f"the columns, {(high - low) / n:.6g} apart from {low:g} to {high:g}"
        raise InputError(f"layer '{layer.name}': span: {span}: expected ends at {apart}")
    return list(map(round, columns))
