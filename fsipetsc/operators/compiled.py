"""Functions in C that Python calls with addresses."""

import ctypes


class CompiledFunction:
    """A function of a library, which takes the address of a struct and those of some arrays."""

    def __init__(self, library: ctypes.CDLL, name: str, arrays: int) -> None:
        self.function = getattr(library, name)

    def __call__(self, *addresses: int) -> None:
        self.function(*map(ctypes.c_void_p, addresses))
