"""Functions in C for loops that numba compiles: called by address."""

import ctypes
from typing import Any

import numba.experimental.function_type  # noqa: F401  (lets numba know such objects)
from numba import types


class CompiledFunction(types.WrapperAddressProtocol):
    """A function of a library, which takes the address of a struct and those of some arrays."""

    def __init__(self, library: ctypes.CDLL, name: str, arrays: int) -> None:
        self.function = getattr(library, name)
        self._address = ctypes.cast(self.function, ctypes.c_void_p).value
        self._signature = types.void(types.int64, *[types.uint64] * arrays)

    def __call__(self, *addresses: int) -> None:
        self.function(*map(ctypes.c_void_p, addresses))

    def __wrapper_address__(self) -> int:
        return self._address

    def signature(self) -> Any:
        return self._signature
