"""Blocks of flat layers that lie one above the other, in one, two or three dimensions.

A layer that does not reach over all of the axes along it, as a panel that is set into a wall, has a
span: a gas over it becomes three blocks side by side, joined.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Condition, Periodic
from fsipetsc.blocks.maps import rectangle
from fsipetsc.checks import POSITIVE, cells_of, check, described, extent, number
from fsipetsc.errors import InputError
from fsipetsc.operators.sbp import OPERATORS

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
        cells: number of cells across it; None: by the h of `layers`.
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

    Where a layer ends, all layers are cut into blocks, so that faces conform. Neighbours meet.

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
    spans = [_columns(layer, along, cells) for layer in stack]
    cuts = [sorted({0, n}.union(*(span[k] for span in spans))) for k, n in enumerate(cells)]
    places = [
        [b if column == n else a + (b - a) * column / n for column in cut]
        for cut, (a, b), n in zip(cuts, along, cells)
    ]
    at_sides = [_at_sides(layer, sides, along) for layer in stack]
    sided = {face for of in at_sides for face in of}
    closed = [len(cut) == 2 and (k, 0) not in sided for k, cut in enumerate(cuts)]
    least, top = 1 if order is None else OPERATORS[order].min_points - 1, stack[0].across[0]
    blocks = {}
    for n, (layer, span) in enumerate(zip(stack, spans)):
        what, of = f"layer '{layer.name}'", (layer.initial, layer.forcing, layer.exact)
        check("cells", layer.cells, f"{what}: cells")
        low, high = extent(layer.across, what)
        if abs(top - low) > 1e-9 * (high - low):
            wrong = f"ends at {top:g}, '{layer.name}' begins at {low:g}: expected the same"
            raise InputError(f"layers: '{stack[n - 1].name}' {wrong}")
        rows = layer.cells or max(_cells((low, high), h, what), least)
        ranges = [range(*map(cut.index, ends)) for cut, ends in zip(cuts, span)]
        columns = [where[::-1] for where in product(*ranges[::-1])]  # axis 0 fastest
        for count, where in enumerate(columns, 1):
            name = layer.name if len(columns) == 1 else f"{layer.name} {count}"
            ends = [x[i : i + 2] for x, i in zip(places, where)]
            box = rectangle(*zip(*ends, (top, high)))  # from where the one below ends, to the bit
            size = *(cut[i + 1] - cut[i] for cut, i in zip(cuts, where)), rows
            block = Block(name, layer.material, box, size, *of, periodic=(*closed, False))
            blocks[(*where, n)] = block
        top = high
    faces, ends = {}, {(len(along), 0): lower, (len(along), 1): upper}
    for where, block in blocks.items():
        layer, given = stack[where[-1]], {**at_sides[where[-1]], **ends}
        for axis, side in block.faces:
            beyond = (*where[:axis], where[axis] + 2 * side - 1, *where[axis + 1 :])
            if beyond not in blocks:
                ended = axis == len(along) and 0 <= beyond[axis] < len(stack)
                found = layer.beside if ended else given.get((axis, side))
                faces[block.name, axis, side] = found or _goes_on(layer, along, axis, side, ended)
    return BlockProblem(tuple(blocks.values()), faces, **more)


def _goes_on(layer: Layer, along: Sequence[Extent], axis: int, side: int, ended: bool) -> Periodic:
    """What stands at a face that has no condition. InputError if it must have one."""
    if axis == len(along) or (layer.span is not None and layer.span[axis] is not None):
        wanted = f"sides, of ({axis}, {side})" if axis < len(along) else ("lower", "upper")[side]
        wanted = "beside=…, as another layer has ended there" if ended else wanted
        raise InputError(f"layer '{layer.name}': a face has no condition: expected {wanted}")
    shift = [0.0] * (len(along) + 1)
    shift[axis] = (along[axis][1] - along[axis][0]) * (1 - 2 * side)
    return Periodic(tuple(shift))


def _at_sides(layer: Layer, sides: Sides | None, along: Sequence[Extent]) -> dict[Any, Condition]:
    """(axis, side) -> what stands there, of the sides of a layer."""
    of = sides if layer.sides is None else layer.sides
    if not isinstance(of, Mapping):
        of = dict.fromkeys(product(range(len(along)), (0, 1)), of)
    return {face: condition for face, condition in of.items() if condition is not None}


def _cells(ends: Extent, h: float | None, what: str) -> int:
    """Cells of the spacing h [m]. InputError where it is none."""
    if h is None:
        raise InputError(f"{what}: neither cells nor h is given: expected one of them")
    return cells_of(ends, number(h, "layers: h", POSITIVE), what)


def _columns(layer: Layer, along: Sequence[Extent], cells: Sequence[int]) -> list[list[int]]:
    """The columns at which a layer begins and ends, of each axis along it. InputError."""
    what, found = f"layer '{layer.name}': span", []
    if len(layer.span or along) != len(along):
        raise InputError(f"{what}: expected (low, high) for each of along")
    for span, (low, high), n in zip(layer.span or along, along, cells):
        columns = [(x - low) / (high - low) * n for x in extent(span or (low, high), what)]
        if any(abs(x - round(x)) > _SAME * n or not 0 <= round(x) <= n for x in columns):
            apart = f"the columns, {(high - low) / n:.6g} apart from {low:g} to {high:g}"
            raise InputError(f"{what}: {span}: expected ends at {apart}")
        found.append(list(map(round, columns)))
    return found
