"""Whose code is at fault: file, line and reason of errors that come out of users' functions."""

import os
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from fsipetsc.errors import FsiError, InputError

#: packages that this one needs
NEEDED = ("h5py", "matplotlib", "mpi4py", "numpy", "petsc4py", "scipy")
_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)


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


def place_in(error: BaseException) -> str:
    """Where in the user's code an error arose, as "file, line N"; "" if it never was in it."""
    if isinstance(error, SyntaxError) and error.lineno and _is_users(error.filename or ""):
        return f"{short(error.filename or '')}, line {error.lineno}"
    frame = _users_frame(traceback.extract_tb(error.__traceback__))
    return f"{short(frame.filename)}, line {frame.lineno}" if frame else ""


def place_of_caller() -> str:
    """What stands before a message about a case file that called this: "file, line N: ", or ""."""
    frame = _users_frame(traceback.extract_stack())
    own = frame if frame and not frame.filename.startswith(_CASES) else None
    return f"{short(own.filename)}, line {own.lineno}: " if own else ""


def _users_frame(frames: list[traceback.FrameSummary]) -> traceback.FrameSummary | None:
    """The innermost frame in the user's code."""
    return next((frame for frame in reversed(frames) if _is_users(frame.filename)), None)


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
