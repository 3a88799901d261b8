"""One entry of the table of options: its type, what it allows, and how a text becomes its value."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

from fsipetsc.blame import call
from fsipetsc.errors import InputError

#: default of an option that the case or the user must give
REQUIRED = ...
INT_MAX = 2**31 - 1
_KINDS: dict[type | str, str] = {int: "int", float: "float", str: "str", bool: "bool"}
_CHECKS = ("positive", "nonnegative")
_TRUE = ("", "true", "yes", "1", "on")
_FALSE = ("false", "no", "0", "off")


def above_one(value: float) -> str | None:
    """A check, of ratios of specific heats and of Mach numbers."""
    return None if value > 1 else "a number above 1"


@dataclass(frozen=True)
class Option:
    """One option.

    name: without the dash, as in "solid_kappa". kind: int, float, str, bool, "ints" or "floats" (comma-separated), or
    "optional", a text that may be left out and is "" then.
    default: a value, None (not set) or REQUIRED. unit: "" or "-" if there is none. choices: the only values allowed.
    check: "positive", "nonnegative" or a function of the value that returns None or True if it is fine and otherwise
    says what is expected, as in "a number below 1", or False.
    """

    name: str
    kind: type | str
    default: Any
    unit: str
    help: str
    choices: tuple[Any, ...] | None = None
    check: str | Callable[[Any], str | bool | None] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", _KINDS.get(self.kind, str(self.kind)))
        object.__setattr__(self, "unit", "" if self.unit == "-" else self.unit)
        if not isinstance(self.name, str) or not isinstance(self.unit, str) or not isinstance(self.help, str):
            raise TypeError(f"option {self.name!r}: name, unit and help must be texts")
        if not (self.check is None or callable(self.check) or self.check in _CHECKS):
            raise ValueError(f"option '{self.name}': check is {self.check!r}: expected {', '.join(_CHECKS)} or a function")
        if not (self.choices is None or isinstance(self.choices, (tuple, list))):
            raise TypeError(f"option '{self.name}': choices is {self.choices!r}: expected a tuple")
        if self.kind not in _READERS:
            raise TypeError(f"option '{self.name}': kind must be int, float, str, bool, 'ints', 'floats' or 'optional'")
        if not re.fullmatch(r"[A-Za-z]\w*", self.name):
            raise ValueError(f"option '{self.name}': a name is made of letters, digits and _, without the dash")

    @property
    def needs_value(self) -> bool:
        """False if the name alone is enough."""
        return self.kind not in ("bool", "optional")

    def parse(self, text: str) -> Any:
        """The value that a text from the options database stands for; InputError if it is none."""
        if text == "" and self.needs_value:
            raise InputError(f"-{self.name} needs a value: {self.expected()}")
        try:
            return self.convert(_READERS[str(self.kind)](text.strip()))
        except (ValueError, OverflowError):
            raise InputError(f"bad value '{brief(text)}' for -{self.name}: expected {self.expected(text)}") from None

    def convert(self, value: Any) -> Any:
        """A Python value as this option's type, checked; ValueError if it is not allowed."""
        if value is None or value is REQUIRED:
            return value
        value = _CONVERTERS[str(self.kind)](value)
        if self.choices is not None and value not in self.choices:
            raise ValueError
        if self._objection(value):
            raise ValueError
        return value

    def expected(self, text: str | None = None) -> str:
        """What is valid, as the end of a sentence; text: what was given instead."""
        if self.choices is not None:
            return "one of " + ", ".join(map(str, self.choices))
        if callable(self.check) and text is not None:
            try:
                return self._objection(_CONVERTERS[str(self.kind)](_READERS[str(self.kind)](text))) or _NOUNS[str(self.kind)]
            except (ValueError, OverflowError):
                pass
        bound = {"positive": " above 0", "nonnegative": " not below 0"}.get(str(self.check), "")
        return _NOUNS[str(self.kind)] + bound + (f" [{self.unit}]" if self.unit else "")

    def _objection(self, value: Any) -> str | None:
        """What would be valid if the value is out of range, else None."""
        values = value if isinstance(value, tuple) else (value,)
        if self.check == "positive":
            return "a number above 0" if any(v <= 0 for v in values) else None
        if self.check == "nonnegative":
            return "a number not below 0" if any(v < 0 for v in values) else None
        verdict = call(self.check, (value,), f"check of -{self.name}") if callable(self.check) else None
        if not (verdict is None or isinstance(verdict, (str, bool))):
            raise InputError(f"check of -{self.name} returns {verdict!r}: expected None or True, else a text or False")
        return "a value within its range" if verdict is False else None if verdict is True else verdict or None


def brief(text: str) -> str:
    """A text for a message: in one line, and not all of it if it is long."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= 80 else f"{line[:60]}… ({len(line)} characters)"


def _read_int(text: str) -> int:
    if not re.fullmatch(r"[+-]?\d+", text):
        raise ValueError
    return int(text)


def _read_float(text: str) -> float:
    if "_" in text:
        raise ValueError
    return float(text)


def _read_bool(text: str) -> bool:
    if text.lower() not in _TRUE + _FALSE:
        raise ValueError
    return text.lower() in _TRUE


def _list_of(item: Callable[[str], Any]) -> Callable[[str], tuple[Any, ...]]:
    return lambda text: tuple(item(word.strip()) for word in text.split(","))


def _to_int(value: Any) -> int:
    if isinstance(value, bool) or int(value) != value or abs(value) > INT_MAX:
        raise ValueError
    return int(value)


def _to_float(value: Any) -> float:
    if isinstance(value, (bool, str)) or not isfinite(value):
        raise ValueError
    return float(value)


def _to_bool(value: Any) -> bool:
    if value is not True and value is not False:
        raise ValueError
    return value


_READERS: dict[str, Callable[[str], Any]] = {
    "int": _read_int,
    "float": _read_float,
    "str": str,
    "bool": _read_bool,
    "ints": _list_of(_read_int),
    "floats": _list_of(_read_float),
    "optional": str,
}
_CONVERTERS: dict[str, Callable[[Any], Any]] = {
    "int": _to_int,
    "float": _to_float,
    "str": str,
    "bool": _to_bool,
    "ints": lambda values: tuple(map(_to_int, values)),
    "floats": lambda values: tuple(map(_to_float, values)),
    "optional": str,
}
_NOUNS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false, or no value for true",
    "ints": "whole numbers with commas and no spaces between them",
    "floats": "numbers with commas and no spaces between them",
    "optional": "a text or nothing",
}
