"""Whose code is at fault: file, line and reason of errors that come out of users' functions."""

import os
import re
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from fsipetsc.errors import FsiError, InputError

#: packages that this one needs
NEEDED = ("h5py", "matplotlib", "mpi4py", "numba", "numpy", "petsc4py", "scipy")
_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)


def explain(error: BaseException, path: str | os.PathLike[str]) -> str:
    """One line about an error that came out of a case file: file, line, reason."""
    if isinstance(error, SyntaxError):
        file, line, why = error.filename or path, error.lineno or 0, str(error.msg)
    else:
        frame, why = _last_frame(error), reason(error)
        file, line = (frame.filename, frame.lineno or 0) if frame else (path, 0)
    own = os.path.realpath(file) == os.path.realpath(path)
    place = f", line {line}" if own else f": {short(file)}, line {line}"
    return f"case file {path}{place if line else ''}: {why}"


def reason(error: BaseException) -> str:
    """What an exception says, on one line."""
    text = " ".join(str(error).split())
    if isinstance(error, FsiError):
        return text
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.split(".")[0]
        own = package == "fsipetsc"
        return f"fsipetsc has no module {error.name}" if own else missing(package)
    if isinstance(error, SystemExit):
        return "SystemExit: sys.exit() is called; a case file must not end the program"
    if _is_compilers(error):
        said = [line for line in str(error).split('\nFile "')[0].splitlines() if line.strip()]
        where = "Failed in", "During:", "---", "Return of:"
        text = " ".join([line.strip() for line in said if not line.startswith(where)][:2])
        return f"numba cannot compile it: {text[:300]}"
    return type(error).__name__ + (f": {text[:300]}" if text else "")


def missing(package: str) -> str:
    """How to get a Python package that is not there."""
    said = f"this needs the Python package {package}, which is not installed here"
    how = "scripts/setup, or pip install '.[solver,plot]', installs what fsipetsc needs"
    return f"{said}: {how}" if package in NEEDED else said


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
        frame = _last_frame(error)
        place = f"{short(frame.filename)}, line {frame.lineno}" if frame else place_of(function)
        if _is_compilers(error):  # numba names the line, of this function or of one that it calls
            for name, line in re.findall(r'File "([^"]+)", line (\d+)', str(error))[:1]:
                place = f"{short(name)}, line {line}"
        raise InputError(f"{place}: {where}: {reason(error)}", collective=False) from error


def _last_frame(error: BaseException) -> traceback.FrameSummary | None:
    """The innermost frame of an error in the user's code, if it ever was in it."""
    frames = reversed(traceback.extract_tb(error.__traceback__))
    return next((frame for frame in frames if _is_users(frame.filename)), None)


def _is_users(name: str) -> bool:
    """Whether a file is a user's, as cases are: not Python's, a library's or this package's."""
    name = os.path.abspath(name)
    known = name.startswith(_LIBRARIES) and not name.startswith(_CASES)
    library = {"site-packages", "dist-packages"} & set(name.split(os.sep))
    return not known and not library and os.path.isfile(name)


def _is_compilers(error: BaseException) -> bool:
    """Whether numba has raised it about a function of the user's."""
    return type(error).__module__.startswith("numba.")


def place_of_caller() -> str:
    """What stands before a message about a case file that called this: "file, line N: ", or ""."""
    stack = reversed(traceback.extract_stack())
    frame = next((frame for frame in stack if _is_users(frame.filename)), None)
    if frame is None or frame.filename.startswith(_CASES):
        return ""
    return f"{short(frame.filename)}, line {frame.lineno}: "


def place_of(function: Callable[..., Any]) -> str:
    """Where a function is defined, as "file, line N"; its name if that is not known."""
    while isinstance(function, partial) or hasattr(function, "__wrapped__"):
        function = function.func if isinstance(function, partial) else function.__wrapped__
    for found in (function, type(function).__call__):
        code = getattr(found, "__code__", None)
        if code is not None:
            return f"{short(code.co_filename)}, line {code.co_firstlineno}"
    return getattr(function, "__name__", type(function).__name__)


def short(name: str | os.PathLike[str]) -> str:
    """A path as a user would write it."""
    inside = os.path.relpath(name)
    return os.path.abspath(name) if inside.startswith(os.pardir) else inside


def brief(text: str) -> str:
    """A text for a message: in one line, and not all of it if it is long."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= 80 else f"{line[:60]}… ({len(line)} characters)"
