"""Patterns that the content of a file must fit, and one check against them.

A pattern is

    a Kind                    NUMBER, COUNT, TEXT …, or one_of(…)
    [pattern]                 a list, of any length
    (pattern, pattern, …)     a list of as many entries
    {name: pattern, …}        a table with these names, and perhaps others; where a name ends with ?
                              it may be missing
    {str: pattern}            a table of any names

Of an array, `check_array` takes the shape and the kind of its numbers.
"""

from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import described


class Kind(NamedTuple):
    """What a value must be, in words, and whether one is."""

    words: str
    fits: Callable[[Any], bool]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def one_of(*values: Any) -> Kind:
    """A value that is one of these."""
    words = f"one of {', '.join(map(str, values))}"
    return Kind(words, lambda value: any(type(v) is type(value) and v == value for v in values))


ANYTHING = Kind("anything", lambda value: True)
TEXT = Kind("a text", lambda value: isinstance(value, str))
FLAG = Kind("true or false", lambda value: isinstance(value, bool))
COUNT = Kind("a whole number from 0 on", lambda value: type(value) is int and 0 <= value < 1 << 62)
NUMBER = Kind("a finite number", lambda value: _is_number(value) and abs(value) < inf)
TIME = Kind("a time from 0 on", lambda value: NUMBER.fits(value) and value >= 0)
#: what is measured may be no number, where that is what was found
MEASURE = Kind("a number, perhaps nan", _is_number)


def check(value: Any, pattern: Any, name: str) -> None:
    """ValueError, which says what is wrong, if a value with this name does not fit a pattern."""
    if isinstance(pattern, Kind):
        if not pattern.fits(value):
            raise ValueError(f"{name} is {described(value)}: expected {pattern.words}")
    elif isinstance(pattern, dict):
        if not isinstance(value, dict):
            raise ValueError(f"{name} is {described(value)}: expected a table of names and values")
        _check_table(value, pattern, name)
    else:
        several = isinstance(pattern, tuple)
        if not isinstance(value, list) or (several and len(value) != len(pattern)):
            words = f"a list of {len(pattern)}" if several else "a list"
            raise ValueError(f"{name} is {described(value)}: expected {words}")
        for k, entry in enumerate(value):
            check(entry, pattern[k if several else 0], f"entry {k} of {name}")


def _check_table(table: dict[str, Any], pattern: dict[Any, Any], name: str) -> None:
    for key, wanted in pattern.items():
        if key is str:
            for known, value in table.items():
                check(value, wanted, f"'{known}' of {name}")
        elif key.rstrip("?") in table:
            check(table[key.rstrip("?")], wanted, f"'{key.rstrip('?')}' of {name}")
        elif not key.endswith("?"):
            raise ValueError(f"{name} has no '{key}'")


def check_array(array: Any, shape: tuple[int, ...], name: str, kind: str = "finite") -> None:
    """ValueError if it is no array of this shape, of a kind of numbers: "finite" doubles, "any"
    doubles, or "whole" numbers.
    """
    known = "whole numbers" if kind == "whole" else "numbers of double precision"
    if array.dtype != (np.int64 if kind == "whole" else np.float64):
        raise ValueError(f"{name} is of the type {array.dtype}: expected {known}")
    if array.shape != shape:
        raise ValueError(f"{name} has the shape {array.shape}: expected {shape}")
    if kind == "finite" and not np.isfinite(array).all():
        raise ValueError(f"{name} has numbers that are not finite")
