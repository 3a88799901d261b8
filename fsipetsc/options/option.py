"""One entry of the table of options: its type, what it allows, how a text becomes its value."""

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
_NAMES: dict[type | str, str] = {int: "int", float: "float", str: "str", bool: "bool"}
_TRUE = ("", "true", "yes", "1", "on")
_FALSE = ("false", "no", "0", "off")
#: kind -> what is expected, in a message
_NOUNS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false, or no value for true",
    "ints": "whole numbers with commas and no spaces between them",
    "floats": "numbers with commas and no spaces between them",
    "optional": "a text or nothing",
}
#: check -> what is expected of a number
_BOUNDS = {"positive": " above 0", "nonnegative": " not below 0"}
_INT = r"[+-]?\d+"


def above_one(value: float) -> str | None:
    """A check, of ratios of specific heats and of Mach numbers."""
    return None if value > 1 else "a number above 1"


@dataclass(frozen=True)
class Option:
    """One option.

    name: without the dash, as in "solid_kappa". kind: int, float, str, bool, "ints" or "floats"
    (comma-separated), or "optional", a text that may be left out and is "" then. default: a value,
    None (not set) or REQUIRED. unit: "" or "-" if there is none. choices: the only values allowed.
    check: "positive", "nonnegative" or a function of the value that returns None or True if it is
    fine and otherwise says what is expected, as in "a number below 1", or False.
    TypeError, ValueError where this is not so.
    """

    name: str
    kind: type | str
    default: Any
    unit: str
    help: str
    choices: tuple[Any, ...] | None = None
    check: str | Callable[[Any], str | bool | None] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", _NAMES.get(self.kind, str(self.kind)))
        object.__setattr__(self, "unit", "" if self.unit == "-" else self.unit)
        texts = all(isinstance(text, str) for text in (self.name, self.unit, self.help))
        known = self.check in (None, "positive", "nonnegative")
        for good, expected in (
            (texts, "name, unit and help must be texts"),
            (texts and re.fullmatch(r"[A-Za-z]\w*", self.name), "a name has letters, digits and _"),
            (self.kind in _NOUNS, "kind must be int, float, str, bool, 'ints' or 'floats'"),
            (isinstance(self.choices or (), (tuple, list)), "choices must be a tuple"),
            (known or callable(self.check), "check must be 'positive', 'nonnegative', a function"),
        ):
            if not good:
                raise TypeError(f"option {self.name!r}: {expected}")

    @property
    def needs_value(self) -> bool:
        """False if the name alone is enough."""
        return self.kind not in ("bool", "optional")

    def parse(self, text: str) -> Any:
        """The value that a text from the options database stands for; InputError if it is none."""
        if text == "" and self.needs_value:
            raise InputError(f"-{self.name} needs a value: {self.expected()}")
        try:
            return self.convert(_from_text(str(self.kind), text.strip()))
        except (ValueError, OverflowError):
            what = f"bad value '{brief(text)}' for -{self.name}"
            raise InputError(f"{what}: expected {self.expected(text)}") from None

    def convert(self, value: Any) -> Any:
        """A Python value as this option's type, checked; ValueError if it is not allowed."""
        if value is None or value is REQUIRED:
            return value
        value = _as_kind(str(self.kind), value)
        if self.choices is not None and value not in self.choices:
            raise ValueError
        if self._objection(value):
            raise ValueError
        return value

    def expected(self, text: str | None = None) -> str:
        """What is valid, as the end of a sentence; text: what was given instead."""
        if self.choices is not None:
            return "one of " + ", ".join(map(str, self.choices))
        kind = str(self.kind)
        if callable(self.check) and text is not None:
            try:
                return self._objection(_as_kind(kind, _from_text(kind, text))) or _NOUNS[kind]
            except (ValueError, OverflowError):
                pass
        bound = _BOUNDS.get(str(self.check), "")
        return _NOUNS[kind] + bound + (f" [{self.unit}]" if self.unit else "")

    def _objection(self, value: Any) -> str | None:
        """What would be valid if the value is out of range, else None."""
        if not callable(self.check):
            least = min(value, default=1) if isinstance(value, tuple) else value
            fine = self.check is None or least > 0 or (self.check == "nonnegative" and least == 0)
            return None if fine else f"a number{_BOUNDS[str(self.check)]}"
        verdict = call(self.check, (value,), f"check of -{self.name}")
        if verdict is False:
            return "a value within its range"
        if verdict is not None and verdict is not True and not isinstance(verdict, str):
            what = "expected None or True, else a text or False"
            raise InputError(f"check of -{self.name} returns {verdict!r}: {what}")
        return verdict if isinstance(verdict, str) and verdict else None


def brief(text: str) -> str:
    """A text for a message: in one line, and not all of it if it is long."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= 80 else f"{line[:60]}… ({len(line)} characters)"


def _from_text(kind: str, text: str) -> Any:
    """What a text says, as Python has it; ValueError."""
    if kind in ("ints", "floats"):
        return tuple(_from_text(kind[:-1], word.strip()) for word in text.split(","))
    if kind == "bool":
        if text.lower() not in _TRUE + _FALSE:
            raise ValueError
        return text.lower() in _TRUE
    if kind in ("int", "float") and not re.fullmatch(r"[^_]+" if kind == "float" else _INT, text):
        raise ValueError
    return {"int": int, "float": float}.get(kind, str)(text)


def _as_kind(kind: str, value: Any) -> Any:
    """A Python value as one of a kind; ValueError."""
    if kind in ("ints", "floats"):
        return tuple(_as_kind(kind[:-1], item) for item in value)
    if kind == "str" or kind == "optional":
        return str(value)
    number = isinstance(value, (int, float)) or hasattr(value, "__float__")
    if (kind == "bool") != isinstance(value, bool) or not number or not isfinite(value):
        raise ValueError
    if kind == "int" and (int(value) != value or abs(value) > INT_MAX):
        raise ValueError
    return {"bool": bool, "int": int, "float": float}[kind](value)
