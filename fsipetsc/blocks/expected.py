"""What a problem of blocks expects of its blocks, of the names of faces and of an axis or a centre:
checks, which raise InputError.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Centre, Condition, Hinge
from fsipetsc.blocks.maps import place_text
from fsipetsc.checks import described
from fsipetsc.errors import InputError

#: (block name, axis, side)
FaceName = tuple[str, int, int]


def check_blocks(blocks: Sequence[Any]) -> None:
    """Blocks have names of their own and one number of dimensions."""
    if not blocks or not all(isinstance(block, Block) for block in blocks):
        raise InputError("BlockProblem: blocks: expected one or more Blocks")
    for k, block in enumerate(blocks):
        if block.name in [other.name for other in blocks[:k]]:
            raise InputError(f"BlockProblem: two blocks are named '{block.name}'")
        if block.dimension != blocks[0].dimension:
            numbers = f"{block.dimension} dimensions, {blocks[0]} {blocks[0].dimension}"
            raise InputError(f"{block} has {numbers}: expected the same")


def number_of(blocks: Sequence[Block], name: str) -> int:
    """The number of the block of this name."""
    names = [block.name for block in blocks]
    if name not in names:
        known = ", ".join(map(repr, names))
        raise InputError(f"there is no block {described(name)}: expected one of {known}")
    return names.index(name)


def named_faces(
    blocks: Sequence[Block],
    faces: Mapping[FaceName, Condition] | Iterable[tuple[FaceName, Condition]],
) -> dict[FaceName, Condition]:
    """The faces as a dict. InputError for wrong names and conditions, and for those named
    twice.
    """
    given = faces.items() if isinstance(faces, Mapping) else list(faces)
    found: dict[FaceName, Condition] = {}
    for name, condition in given:
        if not isinstance(name, tuple) or len(name) != 3:
            wanted = "expected (block name, axis, side)"
            raise InputError(f"BlockProblem: faces: {described(name)}: {wanted}")
        block = blocks[number_of(blocks, name[0])]
        where = f"{block}, face (axis {name[1]}, side {name[2]})"
        if name[1] not in range(block.dimension) or name[2] not in (0, 1):
            last = block.dimension - 1
            raise InputError(f"{where}: expected an axis from 0 to {last} and side 0 or 1")
        if block.periodic[name[1]]:
            raise InputError(f"{where} is named, but a periodic axis has no faces")
        if name in found:
            raise InputError(f"{where} is named twice: expected one condition")
        _check_condition(block, where, condition)
        found[name] = condition
    return found


def check_symmetry(
    blocks: Sequence[Block], faces: Mapping[FaceName, Condition], symmetry: int
) -> None:
    """InputError for what a problem with an axis or a centre cannot have."""
    d = blocks[0].dimension
    if symmetry not in (0, 1, 2)[: max(4 - d, 1)]:
        found = f"symmetry is {described(symmetry)} in {d} dimensions"
        wanted = "expected 0, 1 in one or two dimensions, or 2 in one"
        raise InputError(f"{blocks[0]}: {found}: {wanted}")
    centres = [name for name, met in faces.items() if isinstance(met, Centre)]
    for name in centres:
        if not symmetry or name[1:] != (d - 1, 0):
            wanted = f"expected axis {d - 1}, side 0 of a problem with an axis or a centre"
            raise InputError(f"block '{name[0]}', face {name[1:]}: Centre(): {wanted}")
        if symmetry == 1 and blocks[number_of(blocks, name[0])].kind == "solid":
            raise InputError(
                f"block '{name[0]}': a solid cannot reach an axis, where its stresses would be "
                "wrong on any grid: expected r > 0, or a centre (symmetry=2)"
            )
    for block in blocks if symmetry else ():
        _check_radial(block, (block.name, d - 1, 0) in centres)


def _check_radial(block: Block, centred: bool) -> None:
    """InputError where a block does not fit around an axis or a centre."""
    X = block.positions([(0, n) for n in block.shape])
    r, lines = X[-1], X.reshape(block.dimension, block.shape[-1], -1)
    slanted = any(period[-1] for period, p in zip(block.periods, block.periodic) if p)
    if slanted or block.prestress is not None:
        raise InputError(f"{block}: r grows by a period, or it has a prestress: expected neither")
    lowest = int(np.argmin(r))
    if not r[lowest] > 1e-9 * r.max():
        wanted = "expected r > 0 at all nodes; with Centre() a map as ball or off_axis make it"
        raise InputError(f"{block}: a node is at {place_text(X[:, lowest])}: {wanted}")
    first, second = lines[:, 0], lines[:, 1]
    spacing = second[-1] - first[-1]
    wrong = np.abs(3.0 * first[-1] - second[-1]) > 0.1 * spacing
    wrong |= np.abs(second - first)[:-1].sum(axis=0) > 0.1 * spacing
    if centred and wrong.any():
        i = int(np.argmax(wrong))
        found = f"its first nodes are at {place_text(first[:, i])} and {place_text(second[:, i])}"
        wanted = "expected half a spacing and one and a half from r = 0, as off_axis has them"
        raise InputError(f"{block}: Centre(): {found}: {wanted}")


def _check_condition(block: Block, where: str, condition: Any) -> None:
    """InputError for what is no condition of this kind of block, or has another dimension."""
    if not isinstance(condition, Condition) or isinstance(condition, Hinge):
        wanted = "expected a condition, as NoSlip() or Clamped()"
        raise InputError(f"{where}: {described(condition)}: {wanted}")
    name = type(condition).__name__
    if block.kind not in condition.of:
        raise InputError(f"{where}: {name} is no condition of a {block.kind}")
    vector = {"Open": "u", "Periodic": "shift"}.get(name, "")
    numbers = getattr(condition, vector, ())
    if vector and not callable(numbers) and len(numbers) != block.dimension:
        found = f"{vector} has {len(numbers)} numbers"
        raise InputError(f"{where}: {name}: {found}: expected {block.dimension}")
