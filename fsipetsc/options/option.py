"""One entry of the table of options: its type, what it allows, how a text becomes its value."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

from fsipetsc.blame import call
from fsipetsc.errors import InputError

REQUIRED = ...
"""Default of an option that the case or the user must give."""
INT_MAX = 2**31 - 1
_BOOLS = dict.fromkeys(("", "true", "yes", "1", "on"), True)
_BOOLS |= dict.fromkeys(("false", "no", "0", "off"), False)
#: kind -> what is expected, in a message
_NOUNS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false, or no value for true",
    "ints": "whole numbers with commas and no spaces between them",
    "floats": "numbers with commas and no spaces between them",
}
#: check -> what is expected of a number
_BOUNDS = {"positive": " above 0", "nonnegative": " not below 0"}


def above_one(value: float) -> str | None:
    """A check, of ratios of specific heats and of Mach numbers."""
    return None if value > 1 else "a number above 1"


@dataclass(frozen=True)
class Option:
    """One option of a case or of the program.

    Args:
        name: name without the dash, as in "solid_kappa".
        kind: int, float, str, bool, "ints" or "floats"; the last two are lists with commas.
        default: a value, None (not set) or `REQUIRED`.
        unit: as in "kg/m3"; "" or "-" if there is none.
        help: one line that `-help` prints.
        choices: the only values that are allowed.
        check: "positive", "nonnegative", or a function of the value. It returns None or True if the
            value is fine; else it returns what is expected, as in "a number below 1", or False.

    Raises:
        TypeError: one of these is not as described.
    """

    name: str
    kind: type | str
    default: Any
    unit: str
    help: str
    choices: tuple[Any, ...] | None = None
    check: str | Callable[[Any], str | bool | None] | None = None

    def __post_init__(self) -> None:
        kind = self.kind.__name__ if isinstance(self.kind, type) else self.kind
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "unit", "" if self.unit == "-" else self.unit)
        checks = self.check in (None, *_BOUNDS) or callable(self.check)
        for good, expected in (
            (re.fullmatch(r"[A-Za-z]\w*", self.name), "a name has letters, digits and _"),
            (kind in _NOUNS, f"kind must be one of {', '.join(_NOUNS)}"),
            (isinstance(self.choices or (), (tuple, list)), "choices must be a tuple"),
            (checks, "check must be 'positive', 'nonnegative' or a function"),
        ):
            if not good:
                raise TypeError(f"option {self.name!r}: {expected}")

    def parse(self, text: str) -> Any:
        """The value that a text from the options database stands for; InputError if it is none."""
        if text == "" and self.kind != "bool":
            raise InputError(f"-{self.name} needs a value: {self.expected()}")
        return self.checked(text.strip(), f"bad value {text[:80]!r} for -{self.name}")

    def checked(self, value: Any, said: str) -> Any:
        """A text or a Python value as this option's type. InputError that begins with ``said``."""
        try:
            found = _as_kind(str(self.kind), value)
        except (ValueError, TypeError, OverflowError):
            raise InputError(f"{said}: expected {self.expected()}") from None
        if objection := self._objection(found):
            raise InputError(f"{said}: expected {objection}")
        return found

    def expected(self) -> str:
        """What is valid, as the end of a sentence."""
        if self.choices is not None:
            return "one of " + ", ".join(map(str, self.choices))
        unit = f" [{self.unit}]" if self.unit else ""
        return _NOUNS[str(self.kind)] + _BOUNDS.get(str(self.check), "") + unit

    def _objection(self, value: Any) -> str | None:
        """What would be valid if the value is not allowed, else None."""
        if self.choices is not None and value not in self.choices:
            return self.expected()
        if callable(self.check):
            verdict = call(self.check, (value,), f"check of -{self.name}")
            if isinstance(verdict, str):
                return verdict
            return None if verdict is None or verdict else "a value within its range"
        least = min(value, default=1) if isinstance(value, tuple) else value
        fine = self.check is None or least > 0 or (self.check == "nonnegative" and least == 0)
        return None if fine else self.expected()


def floats(text: str, name: str, unit: str) -> tuple[float, ...]:
    """The numbers of a list such as 0.1,0.25. InputError, naming the option, for other texts."""
    try:
        found: tuple[float, ...] = _as_kind("floats", text)
    except ValueError:
        said = f"bad value {text[:80]!r} for -{name}: expected {_NOUNS['floats']} [{unit}]"
        raise InputError(said) from None
    return found


def _as_kind(kind: str, value: Any) -> Any:
    """A text or a Python value as one of a kind; ValueError, TypeError, OverflowError."""
    if kind in ("ints", "floats"):
        items = value.split(",") if isinstance(value, str) else value
        return tuple(_as_kind(kind[:-1], item) for item in items)
    if kind == "str" and value is not None:
        return str(value)
    if isinstance(value, str):
        if "_" in value:  # Python would skip it in a number
            raise ValueError
        text = value.strip().lower()
        value = _BOOLS.get(text) if kind == "bool" else int(text) if kind == "int" else float(text)
    if (kind == "bool") != isinstance(value, bool) or not isfinite(value):
        raise ValueError
    if kind == "int" and (int(value) != value or abs(value) > INT_MAX):
        raise ValueError
    return {"bool": bool, "int": int, "float": float}[kind](value)
