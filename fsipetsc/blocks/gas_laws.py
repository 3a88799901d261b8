"""The laws of the gases of a problem. Gas at one place has one state, and so one law."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block


class GasLaws:
    """laws: those that differ in their formulas or numbers, in the order of blocks. numbers: block
    of a gas -> the number of its law among these.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        laws: list[Any] = []
        self.numbers: dict[int, int] = {}
        for k, block in enumerate(blocks):
            if block.kind == "fluid":
                law = block.material.gas_law
                known = [n for n, other in enumerate(laws) if _same(law, other)]
                self.numbers[k] = known[0] if known else len(laws)
                laws += [] if known else [law]
        self.laws = tuple(laws)

    def number_at(self, members: Sequence[tuple[int, int]]) -> int:
        """The number of the law of the gas among (block, node) at one place; 0 if there is none."""
        return next((self.numbers[k] for k, _ in members if k in self.numbers), 0)


def _same(law: Any, other: Any) -> bool:
    """Whether two laws have the same formulas and the same numbers."""
    return type(law) is type(other) and all(map(np.array_equal, law, other))
