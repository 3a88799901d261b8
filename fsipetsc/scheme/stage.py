"""What sweeps store of the rates k of nodes: k itself, or what follows in a stage of a step.

Where nothing else adds to the rates of nodes, their sweep makes the stage at once, and k needs no
memory. The classical Runge-Kutta method from the solution y has the stages

    y1 = y + dt/2 k(y),   y2 = y + dt/2 k(y1),   y3 = y + dt k(y2)

and, as y_1 - y is dt/2 k(y) and so on, without a sum that is kept from stage to stage, the solution

    y + 1/3 ((y1 - y) + 2 (y2 - y) + (y3 - y)) + dt/6 k(y3)

With the other nodes, whose stages conditions may change, ``advance`` of
fsipetsc.scheme.runge_kutta does the same after all is added, with such a sum.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import add, along, sub
from fsipetsc.kernels.kernel import OWNED, SHARED, Kernel

Spans = Sequence[tuple[int, int]]
#: what is stored: k, the next stage, the solution
RATES, NEXT, LAST = range(3)
KINDS = "rates", "next", "last"


class Stage(ctypes.Structure):
    """The struct stage of fsipetsc/scheme/stage.c."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("numbers", "y", "y1", "y2", "y3")]


#: rates are what is stored
_ALWAYS_RATES = np.zeros(2)


def no_stage() -> Stage:
    """The stage of sweeps that store rates."""
    return Stage(_ALWAYS_RATES.ctypes.data)


class Owned(ctypes.Structure):
    """The struct owned of fsipetsc/scheme/stage.c."""

    _fields_ = [(name, ctypes.c_long) for name in ("begin", "end", "free_begin", "free_end")]


def store(kernel: Kernel, kind: int, k: Sequence[Any]) -> None:
    """Let a kernel store what becomes of the rates k of its nodes; all kinds of a kernel take the
    same arguments.
    """
    kernel.takes(OWNED, "y", "y1", "y2", "y3")
    kernel.takes(SHARED, "numbers")
    if kind == RATES:
        kernel.store("next", OWNED, k)
        return
    (a,) = kernel.read("numbers", SHARED, 1, 1)
    if kind == NEXT:
        kernel.store("next", OWNED, along(kernel.read("y", OWNED, len(k)), a, k))
        return
    y = kernel.read("next", OWNED, len(k))  # the solution, which becomes the next one
    one, two, three = (sub(kernel.read(n, OWNED, len(k)), y) for n in ("y1", "y2", "y3"))
    change = along(add(one, three), 2.0, two)
    kernel.store("next", OWNED, along(along(y, 1.0 / 3.0, change), a, k))
