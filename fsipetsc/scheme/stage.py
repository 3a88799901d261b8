"""What sweeps store of the rates k of nodes: k itself, or what follows in a stage of a step.

A stage of the classical Runge-Kutta method, from the solution y and the sum ``total`` of it, is

    FIRST    next = y + a k,       total = y + b k
    MIDDLE   next = y + a k,       total = total + b k
    LAST     next = total + b k    the new solution

Where nothing else adds to the rates of nodes, their sweep makes the stage at once: k needs no
memory. ``advance`` of fsipetsc.scheme.runge_kutta, which has a and b, does the same with the other
nodes, after all is added.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import along, scale
from fsipetsc.kernels.kernel import OWNED, SHARED, Kernel

Spans = Sequence[tuple[int, int]]
#: what is stored: see the head of this file
RATES, FIRST, MIDDLE, LAST = range(4)
KINDS = "rates", "first", "middle", "last"


class Stage(ctypes.Structure):
    """The struct stage of fsipetsc/scheme/stage.c."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("numbers", "y", "total")]


#: rates are what is stored
_ALWAYS_RATES = np.zeros(3)


def no_stage() -> Stage:
    """The stage of sweeps that store rates."""
    return Stage(_ALWAYS_RATES.ctypes.data, None, None)


class Owned(ctypes.Structure):
    """The struct owned of fsipetsc/scheme/stage.c."""

    _fields_ = [(name, ctypes.c_long) for name in ("begin", "end", "free_begin", "free_end")]


def store(kernel: Kernel, kind: int, k: Sequence[Any]) -> None:
    """Let a kernel store what becomes of the rates k of its nodes; all kinds of a kernel take the
    same arguments.
    """
    kernel.takes(OWNED, "y", "total")
    kernel.takes(SHARED, "numbers")
    if kind == RATES:
        kernel.store("next", OWNED, k)
        return
    a, b = kernel.read("numbers", SHARED, 2, 1)
    if kind == LAST:
        kernel.store("next", OWNED, along(kernel.read("total", OWNED, len(k)), b, k))
        return
    y = kernel.read("y", OWNED, len(k))
    kernel.store("next", OWNED, along(y, a, k))
    if kind == FIRST:
        kernel.store("total", OWNED, along(y, b, k))
    else:
        kernel.add("total", OWNED, scale(b, k))
