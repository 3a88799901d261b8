"""What stands for numba where it is not installed: enough to load a case for its options. Nothing can be computed with it."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import FunctionType, ModuleType
from typing import Any

_NAMES = "numba", "llvmlite"


class _Anything(ModuleType):
    """A module, type, decorator or value: has all attributes, can be called and inherited from; leaves functions alone."""

    def __init__(self, name: object, *_: object) -> None:
        super().__init__(str(name))

    def __getattr__(self, name: str) -> _Anything:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Anything(name)

    def __call__(self, *values: Any, **_: Any) -> Any:
        decorates = len(values) == 1 and isinstance(values[0], FunctionType) and not self.__name__.startswith("overload")
        return values[0] if decorates else self


class _Finder(MetaPathFinder, Loader):
    def find_spec(self, name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        return ModuleSpec(name, self, is_package=True) if name.split(".")[0] in _NAMES else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _Anything(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        return


def numba_is_missing() -> bool:
    """Whether numba is not installed here."""
    try:
        return find_spec("numba") is None
    except ModuleNotFoundError:
        return True


@contextmanager
def numba_stood_in() -> Iterator[bool]:
    """Whether numba is missing; within, what imports it can be imported nevertheless, and is forgotten afterwards."""
    missing = numba_is_missing()
    if not missing:
        yield False
        return
    finder, before = _Finder(), set(sys.modules)
    sys.meta_path.insert(0, finder)
    try:
        yield True
    finally:
        sys.meta_path.remove(finder)
        for name in set(sys.modules) - before:
            if name.split(".")[0] in (*_NAMES, "fsipetsc"):
                del sys.modules[name]
