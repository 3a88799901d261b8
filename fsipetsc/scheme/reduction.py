"""What ranks tell each other after a step: extremes of the layers, an unphysical state, the wish to stop. Compiled.

The extremes themselves go round, not the speeds that follow from them: a speed depends on several extremes, and what one rank
made of those of its own points would depend on how the points are dealt out. The exchange is a maximum of 64-bit words, so
numbers are sent as words whose order is theirs, or the opposite one for smallest values. What is not a number comes first.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.parallel.pointers import words_at
from fsipetsc.parallel.shared_memory import largest
from fsipetsc.physics.layer import FLUID
from fsipetsc.scheme.extremes_and_sums import GREATEST_T, SIZE, SPEED, SUMS

_SIGN, _ALL = np.uint64(1 << 63), np.uint64(2**64 - 1)


def reduced_words(layers: int) -> int:
    """Number of the words: the extremes of each layer, BAD, STOP."""
    return SUMS * layers + 2


@njit(**OPTIONS)
def ordered(word):
    """Words in the order of the numbers whose bits are ``word``."""
    return ~word if word >= _SIGN else word | _SIGN


@njit(**OPTIONS)
def bits(word):
    """The bits of the number that ``ordered`` has made the word of."""
    return word ^ _SIGN if word >= _SIGN else ~word


@njit(**OPTIONS)
def is_largest(layer, extreme):
    """Whether an extreme of a layer is a largest value, not a smallest one."""
    return extreme == GREATEST_T or (extreme == SPEED and layer.kind == FLUID)


@njit(**OPTIONS)
def reduce_extremes(head, layers, memory, bad, stop):
    """(bad, stop), the largest of all ranks, and in memory[head.everywhere:] the extremes of all points. Collective."""
    count, base = head.reduced, memory.ctypes.data
    said, heard = words_at(base + 8 * head.said, count), words_at(base + 8 * head.heard, count)
    own = words_at(base + 8 * head.extremes, SIZE * layers.size)
    everywhere = words_at(base + 8 * head.everywhere, SIZE * layers.size)
    for k in range(layers.size):
        for extreme in range(SUMS):
            value, word = memory[U64(head.extremes + SIZE * k + extreme)], ordered(own[SIZE * k + extreme])
            if not is_largest(layers[k], extreme):
                word = ~word
            if layers[k].present == 0:
                word = U64(0)
            said[SUMS * k + extreme] = _ALL if value != value else word
    memory[U64(head.said + count - 2)], memory[U64(head.said + count - 1)] = bad, stop
    largest(head.world, base + 8 * head.said, base + 8 * head.heard, count)
    for k in range(layers.size):
        for extreme in range(SUMS):
            word = heard[SUMS * k + extreme]
            number = bits(word if is_largest(layers[k], extreme) else ~word)
            everywhere[SIZE * k + extreme] = _ALL if word == _ALL else number
            # the sums of other ranks are not known, and have no say in speeds
            memory[U64(head.everywhere + SIZE * k + SUMS + extreme)] = 0.0
    return memory[U64(head.heard + count - 2)], memory[U64(head.heard + count - 1)]
