"""Calls of compiled functions with arguments that stay the same.

At each call numba looks at the types of all arguments to find the machine code for them, which takes longer than a row of
points. Where the same arrays are handed over again and again it is found once.
"""

from __future__ import annotations

from typing import Any

import numba


class Prepared:
    """``entry(*arguments, *others)``; only ``others``, if there are any, differ from call to call, but not their types.

    entry: an entry, compiled for these types at the first call, if it has not been before.
    """

    __slots__ = "_arguments", "_entry", "_function"

    def __init__(self, entry: Any, *arguments: Any) -> None:
        self._entry, self._arguments = entry, arguments
        self._function = self._find

    def __call__(self, *others: Any) -> Any:
        return self._function(*self._arguments, *others)

    def _find(self, *arguments: Any) -> Any:
        """The first call."""
        types = tuple(numba.typeof(argument) for argument in arguments)
        self._entry.compile(types)
        self._function = self._entry.get_overload(types)
        return self._function(*arguments)
