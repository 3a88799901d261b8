"""What a case says is checked where it says it; a message names the user's file and line.

Errors that come out of a user's functions are told with file, line and reason.
"""

import os
import traceback
from collections.abc import Callable, Mapping, Sequence
from datetime import timedelta
from functools import partial
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.errors import FsiError, InputError

#: what functions of a case take, and what they return for several unknowns
Array = NDArray[Any]
Fields = Sequence[Array | float]

#: cells of a layer: the unknowns of a few such layers can still be counted in 32 bits
MOST_CELLS = 50_000_000
POSITIVE, NONNEGATIVE, ANY = "above 0", "not below 0", ""
#: name of a number -> what it must be: "" for any, "above …" or "not below …"
Ranges = Mapping[str, str]
#: packages that this one needs
NEEDED = ("h5py", "matplotlib", "mpi4py", "numpy", "petsc4py", "scipy")
_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)


def described(value: Any) -> str:
    """A value in a message: short, and on one line."""
    if callable(value):
        return f"a function ({getattr(value, '__name__', type(value).__name__)})"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def counted(count: int, word: str) -> str:
    """ "1 step", "2 steps"."""
    return f"{count} {word}{'s' * (count != 1)}"


def duration(seconds: float) -> str:
    """Seconds, as "4.2 s" or "1:02:33"."""
    return f"{seconds:.3g} s" if seconds < 60 else str(timedelta(seconds=int(seconds)))


# what a case gives


def number(value: Any, what: str, bound: str = ANY, unit: str = "") -> float:
    """The value as a float; InputError if it is no finite real number or out of bound."""
    expected = f"expected a number{' ' * bool(bound)}{bound}{f' [{unit}]' if unit else ''}"
    found = np.nan
    if np.ndim(value) == 0 and not isinstance(value, (str, bytes, bool, np.bool_, complex)):
        try:
            found = float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    if not isfinite(found):
        raise InputError(f"{what} is {described(value)}: {expected}")
    least = float(bound.split()[-1]) if bound else -np.inf
    if found < least or (found == least and bound.startswith("above")):
        raise InputError(f"{what} is {found:g}: {expected}")
    return found


def numbers(record: Any, owner: str, ranges: Ranges) -> None:
    """Make attributes of a frozen dataclass floats within their ranges. InputError."""
    for name, bound in ranges.items():
        object.__setattr__(record, name, number(getattr(record, name), f"{owner}: {name}", bound))


def check_name(value: Any, what: str) -> None:
    """InputError if a value is no name of a layer or a block."""
    if not isinstance(value, str) or not value.isprintable() or not value.strip() or "|" in value:
        raise InputError(f"{what}: name is {described(value)}: expected a line of text without |")


def extent(X: Any, what: str) -> tuple[float, float]:
    """(left, right), left < right; InputError."""
    if not isinstance(X, (tuple, list, np.ndarray)) or len(X) != 2:
        raise InputError(f"{what}: X is {described(X)}: expected (left, right), two numbers [m]")
    left, right = (number(end, f"{what}: X") for end in X)
    if not left < right:
        expected = "expected (left, right) with left below right"
        raise InputError(f"{what}: X = ({left:g}, {right:g}): {expected}")
    return left, right


def whole(value: Any) -> bool:
    """Whether it is a whole number above 0."""
    return isinstance(value, (int, np.integer)) and value is not True and int(value) > 0


def own_cells(cells: Any, h: Any, ends: tuple[float, float], what: str) -> int | None:
    """Cells of a layer that says their number or size h [m], or neither: None. InputError."""
    if cells is not None and h is not None:
        raise InputError(f"{what}: cells and h are given: expected one of them")
    if h is not None:
        return cells_of(ends, number(h, f"{what}: h", POSITIVE, "m"), what)
    if cells is not None and not whole(cells):
        raise InputError(f"{what}: cells is {described(cells)}: expected a whole number above 0")
    return None if cells is None else int(cells)


def cells_of(ends: tuple[float, float], h: float, what: str) -> int:
    """Cells of about h [m] between the ends of a layer. InputError for more than MOST_CELLS."""
    width = (ends[1] - ends[0]) / h
    if not width < MOST_CELLS:
        found = f"{what} of length {ends[1] - ends[0]:g} would have {width:.3g} cells"
        raise InputError(f"{found}; {MOST_CELLS} are too many")
    return max(1, round(width))


def function(value: Any, what: str, form: str, *, optional: bool = False) -> None:
    """InputError if a value is no function; form: as in "initial(X) -> (rho, u, T)"."""
    if not (callable(value) or (optional and value is None)):
        expected = f"a function {form}{' or None' if optional else ''}"
        raise InputError(f"{what} is {described(value)}: expected {expected}")


# what its functions do


def call(function: Callable[..., Any], arguments: tuple[Any, ...], where: str) -> Any:
    """function(*arguments), a user's; where: what it is, in a message.

    InputError with file and line for whatever it raises, perhaps on this rank alone.
    """
    try:
        return function(*arguments)
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:  # SystemExit of one rank would leave the others waiting
        of_package = getattr(function, "__module__", "").startswith("fsipetsc.")
        if isinstance(error, FsiError) and of_package:
            raise  # it is about an option, or explained already
        place = place_in(error) or place_of(function)
        raise InputError(f"{place}: {where}: {reason(error)}", collective=False) from error


def reason(error: BaseException) -> str:
    """What an exception says, on one line."""
    text = " ".join(str(getattr(error, "msg", None) or error).split())
    if isinstance(error, FsiError):
        return text
    if package := missing(error):
        said = f"this needs the Python package {package}, which is not installed here"
        how = "scripts/setup, or pip install '.[solver,plot]', installs what fsipetsc needs"
        return f"{said}: {how}" if package in NEEDED else said
    return type(error).__name__ + (f": {text[:300]}" if text else "")


def missing(error: BaseException) -> str:
    """The Python package that an import did not find; "" if it is this one, or no such error."""
    name = (error.name or "") if isinstance(error, ModuleNotFoundError) else ""
    package = name.split(".")[0]
    return package if package != "fsipetsc" else ""


def place_in(error: BaseException) -> str:
    """Where in the user's code an error arose, as "file, line N"; "" if it never was in it."""
    if isinstance(error, SyntaxError) and error.lineno and _is_users(error.filename or ""):
        return f"{short(error.filename or '')}, line {error.lineno}"
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if _is_users(frame.filename):
            return f"{short(frame.filename)}, line {frame.lineno}"
    return ""


def _is_users(name: str) -> bool:
    """Whether a file is a user's, as cases are: not Python's, a library's or this package's."""
    name = os.path.abspath(name)
    known = name.startswith(_LIBRARIES) and not name.startswith(_CASES)
    library = {"site-packages", "dist-packages"} & set(name.split(os.sep))
    return not known and not library and os.path.isfile(name)


def place_of(function: Callable[..., Any]) -> str:
    """Where a function is defined, as "file, line N"; its name if that is not known."""
    while isinstance(function, partial) or hasattr(function, "__wrapped__"):
        function = function.func if isinstance(function, partial) else function.__wrapped__
    if code := getattr(function, "__code__", getattr(type(function).__call__, "__code__", None)):
        return f"{short(code.co_filename)}, line {code.co_firstlineno}"
    return getattr(function, "__name__", type(function).__name__)


def short(name: str | os.PathLike[str]) -> str:
    """A path as a user would write it."""
    inside = os.path.relpath(name)
    return os.path.abspath(name) if inside.startswith(os.pardir) else inside
