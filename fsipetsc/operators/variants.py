"""Compiled functions once more, with other laws in the place of the built-in ones.

The functions of the scheme name the laws of a problem as constants of their modules, so that calls of formulas are calls of
known functions. For other laws the same source is compiled once more, with other constants; of what is called, only what
names one of them, directly or not. On disk such code lies in a folder of its own, named after all that the laws consist of.
"""

from __future__ import annotations

import hashlib
import types
from collections.abc import Iterator, Sequence
from typing import Any

import numba
import numpy as np
from numba import njit
from numba.core.dispatcher import Dispatcher

from fsipetsc.operators.cache import cache_folder, make_folder
from fsipetsc.operators.formulas import Formulas

#: packages whose functions are named, not read: the sources of this one name the folder of the kernels already
_KNOWN = ("fsipetsc", "numpy", "numba", "math", "builtins")


class Variants:
    """The variants of compiled functions for some changes: pairs (constant of a module, what takes its place)."""

    def __init__(self, changes: Sequence[tuple[Any, Any]], name: str) -> None:
        """name: of the folder for what is kept on disk, within that of the kernels."""
        self._name = name
        self._made: dict[int, tuple[Any, Any]] = {id(old): (old, new) for old, new in changes}

    @staticmethod
    def on_disk(name: str) -> bool:
        """Whether something has been kept under this name."""
        return any((cache_folder() / name).glob("*/*.nbi"))

    def of(self, function: Any) -> Any:
        """The variant of a compiled function or of formulas; anything itself if it names no constant that changes."""
        if id(function) not in self._made:
            self._made[id(function)] = function, function  # what calls itself
            self._made[id(function)] = function, self._variant(function)
        return self._made[id(function)][1]

    def _variant(self, function: Any) -> Any:
        if isinstance(function, Formulas):
            members = {name: self.of(member) for name, member in vars(function).items()}
            return Formulas(**members) if any(members[n] is not m for n, m in vars(function).items()) else function
        if not isinstance(function, Dispatcher):
            return function
        plain = function.py_func
        named = {name: plain.__globals__[name] for name in _names(plain.__code__) if name in plain.__globals__}
        changed = {name: self.of(value) for name, value in named.items()}
        if all(changed[name] is value for name, value in named.items()):
            return function
        other = types.FunctionType(
            plain.__code__, {**plain.__globals__, **changed}, plain.__name__, plain.__defaults__, plain.__closure__
        )
        other.__module__, other.__doc__ = plain.__module__, plain.__doc__
        # The linker knows code by this name, and a number that another process, which has compiled another variant, may have
        # given as well: where both are loaded from disk, one would be called for the other.
        other.__qualname__ = f"{plain.__qualname__}.{self._name}"
        options = {key: value for key, value in function.targetoptions.items() if key != "nopython"}
        options["pipeline_class"] = function._compiler.pipeline_class
        if function.stats.cache_path is None:
            return njit(**options)(other)
        return self._kept(other, options)

    def _kept(self, function: Any, options: dict[str, Any]) -> Any:
        """Compiled for Python, and kept on disk if there is a place."""
        folder = make_folder(self._name)
        if folder is None:
            return njit(**options)(function)
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder)
        try:
            return njit(cache=True, **options)(function)
        finally:
            numba.config.CACHE_DIR = before


def _names(code: types.CodeType) -> Iterator[str]:
    """Names of globals and attributes in a code and in those within it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _names(constant)


def digest(thing: Any) -> str:
    """Digest of formulas, functions and constants, with all that they refer to."""
    result = hashlib.sha256()
    for part in _parts(thing, {}):
        result.update(part.encode() + b"\0")
    return result.hexdigest()[:16]


def _parts(thing: Any, seen: dict[int, Any]) -> Iterator[str]:
    """What a digest is made of. Of what is met again: when it was met first."""
    thing = getattr(thing, "py_func", thing)
    if isinstance(thing, (Formulas, types.FunctionType)):
        if id(thing) in seen:
            yield f"met as {list(seen).index(id(thing))}"
            return
        seen[id(thing)] = thing
    if isinstance(thing, Formulas):
        for name in sorted(vars(thing)):
            yield name
            yield from _parts(getattr(thing, name), seen)
    elif isinstance(thing, types.FunctionType):
        yield from _parts_of_function(thing, seen)
    elif isinstance(thing, types.CodeType):
        yield thing.co_code.hex()
        yield from (repr(thing.co_names), repr(thing.co_varnames), repr(thing.co_freevars))
        for constant in thing.co_consts:
            yield from _parts(constant, seen)
    elif isinstance(thing, (tuple, list)):
        yield f"{type(thing).__name__} {len(thing)}"
        for item in thing:
            yield from _parts(item, seen)
    elif isinstance(thing, np.ndarray):
        yield f"array {thing.dtype} {thing.shape} {thing.tobytes().hex()}"
    elif isinstance(thing, (int, float, complex, str, bytes, type(None), np.generic)):
        yield f"{type(thing).__name__} {thing!r}"
    else:
        yield f"{type(thing).__name__} {getattr(thing, '__module__', '')} {getattr(thing, '__name__', '')}"


def _parts_of_function(function: types.FunctionType, seen: dict[int, Any]) -> Iterator[str]:
    yield f"{function.__module__}.{function.__qualname__}"
    for cell in function.__closure__ or ():
        yield from _parts(cell.cell_contents, seen)
    yield from _parts(function.__defaults__, seen)
    if function.__module__.split(".")[0] in _KNOWN:
        return
    yield from _parts(function.__code__, seen)
    names = list(dict.fromkeys(_names(function.__code__)))
    for name in names:
        if name in function.__globals__:
            value = function.__globals__[name]
            yield name
            yield from _parts(value, seen)
            if isinstance(value, types.ModuleType) and value.__name__.split(".")[0] not in _KNOWN:
                for attribute in names:
                    if hasattr(value, attribute):
                        yield attribute
                        yield from _parts(getattr(value, attribute), seen)
