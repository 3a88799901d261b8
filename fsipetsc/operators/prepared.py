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

    __slots__ = "_function", "arguments", "entry"

    def __init__(self, entry: Any, *arguments: Any) -> None:
        self.entry, self.arguments = entry, arguments
        self._function = self._find

    def __call__(self, *others: Any) -> Any:
        return self._function(*self.arguments, *others)

    def found(self, types: tuple[Any, ...]) -> Any:
        """numba's result of having compiled the entry for arguments of these types."""
        self.entry.compile(types)
        return self.entry.overloads[types]

    def _find(self, *arguments: Any) -> Any:
        """The first call."""
        self._function = self.found(tuple(numba.typeof(argument) for argument in arguments)).entry_point
        return self._function(*arguments)
