"""Lists of calls of procedures that C makes one after the other: fsipetsc/kernels/calls.c."""

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsipetsc.kernels.kernel import c_source, unit
from fsipetsc.kernels.procedure import Code, Procedure

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class _Call(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("procedure", "of", "y")),
        *(("y_size", _NUMBER), ("f", _POINTER), ("f_size", _NUMBER)),
    ]


def calling_code(*texts: str) -> Code:
    """Code with the functions of calls.c, whose library `Calls` needs; procedures can be added."""
    return Code(unit({}, [], c_source("fsipetsc.kernels", "calls.c"), *texts))


class Calls:
    """Calls of procedures that are loaded, each with up to two world vectors; library: that of
    ``calling_code``.
    """

    def __init__(self, library: Any, calls: Sequence[tuple[Procedure, Any]]) -> None:
        self._library, self._calls, self._count = library, (_Call * len(calls))(), len(calls)
        self._kept = calls
        for one, (procedure, vectors) in zip(self._calls, calls, strict=True):
            one.procedure, one.of = procedure.address, procedure.structure
            for name, vector in zip(("y", "f"), vectors):
                setattr(one, name, vector.ctypes.data)
                setattr(one, f"{name}_size", vector.size)

    def __call__(self) -> None:
        """Make all calls."""
        if self._count:
            self._library.run_calls(self._calls, _NUMBER(self._count))

    def batch(self, bad: np.ndarray, allowed: np.ndarray) -> None:
        """Make all calls, once, and again while the number ``bad`` is 0 and ``allowed`` is not."""
        numbers = (_POINTER(number.ctypes.data) for number in (bad, allowed))
        self._library.run_batch(self._calls, _NUMBER(self._count), *numbers)
