"""Compiled loops for the command ``bench``: pieces of a time step, and the machine's own limits, many times over."""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import ENTRY, U64
from fsipetsc.parallel.exchange import exchange
from fsipetsc.parallel.shared_memory import largest
from fsipetsc.scheme.conditions import apply_conditions
from fsipetsc.scheme.plan import WORK


@njit(**ENTRY)
def apply_conditions_often(heads, layers, faces, memory, count):
    """Apply the conditions to the first work area ``count`` times. Collective on all ranks."""
    head = heads[0]
    for _ in range(count):
        apply_conditions(head, layers, faces, memory, WORK)


@njit(**ENTRY)
def exchange_often(heads, layers, faces, memory, count):
    """Fill the halos of the first work area and learn the traces, ``count`` times. Collective on all ranks."""
    head = heads[0]
    for _ in range(count):
        exchange(head, layers, faces, memory, WORK)


@njit(**ENTRY)
def reduce_often(heads, memory, words, count):
    """The reduction that bounds a time step, of so many words, ``count`` times. Collective on all ranks."""
    head = heads[0]
    world, base = head.world, memory.ctypes.data
    if world.size > 1:
        for _ in range(count):
            largest(world, base + 8 * head.sent, base + 8 * head.traces, words)


@njit(**ENTRY)
def triad(memory, length, count):
    """STREAM's triad a = b + 3 c on three arrays of a length that stand one after the other, ``count`` times."""
    a, b, c, n = U64(0), U64(length), U64(2 * length), U64(length)
    for _ in range(count):
        for i in range(n):
            memory[a + i] = memory[b + i] + 3.0 * memory[c + i]
