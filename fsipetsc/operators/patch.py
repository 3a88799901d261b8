"""A rank's part of a block, as compiled loops get it."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from fsipetsc.operators.loops import CALL

Triple = tuple[int, int, int]


class Patch(NamedTuple):
    """Sizes along the three axes, axis 0 contiguous; of an axis that is not there 1, 1 and 0.

    own: nodes that the rank owns. ghosted: nodes of the array with halos; at an end of the block
    there is no halo. first: where those that it owns begin in that array.
    """

    own: Triple
    ghosted: Triple
    first: Triple


@njit(**CALL)
def mirror(values, first, signs):
    """Let the `first` nodes of an array (N, …) be the images of those behind them, with signs."""
    for i in range(first):
        for c in range(signs.size):
            values[first - 1 - i, c] = signs[c] * values[first + i, c]
