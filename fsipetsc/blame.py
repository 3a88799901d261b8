"""Whose code is at fault: file, line and reason of errors that come out of users' functions."""

from __future__ import annotations

import os
import re
import sys
import traceback
from collections.abc import Callable
from functools import partial
from types import FrameType
from typing import Any

from fsipetsc.errors import FsiError, InputError

#: extra of the installation -> what is imported of it, as pyproject.toml has it
_EXTRAS = {
    "solver": ("petsc4py", "mpi4py", "numba", "llvmlite", "scipy", "yaml"),
    "plot": ("matplotlib",),
}
_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)
#: letters of somebody else's message that are repeated
_LONGEST = 300


def explain(error: BaseException, path: str | os.PathLike[str]) -> str:
    """One line about an error that came out of a case file: file, line, reason.

    Where it was in a module that the file imports, this module's place follows.
    """
    lines = [frame.lineno for frame in frames_in(error, path)]
    line = f", line {lines[-1]}" if lines else ""
    if isinstance(error, SyntaxError):
        own = error.filename is None or os.path.realpath(error.filename) == os.path.realpath(path)
        elsewhere = "" if own else f"{line}: {short(error.filename or '')}"
        place = f", line {error.lineno}" if error.lineno else ""
        return f"case file {path}{elsewhere}{place}: {error.msg}"
    last, deeper = _last_frame(error), ""
    if last and lines and os.path.realpath(last.filename) != os.path.realpath(path):
        deeper = f"{_place_of_frame(last)}: "
    return f"case file {path}{line}: {deeper}{reason(error)}"


def reason(error: BaseException) -> str:
    """What an exception says, on one line."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # a user's exception may fail to say anything
        text = ""
    if isinstance(error, FsiError):
        return text
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.split(".")[0]
        own = package == "fsipetsc"
        return f"fsipetsc has no module {error.name}" if own else missing(package)
    if isinstance(error, SystemExit):
        return "SystemExit: sys.exit() is called; a case file must not end the program"
    if _is_compilers(error):
        return f"numba cannot compile it: {_compilers_words(error)}"
    return type(error).__name__ + (f": {text}" if text else "")


def missing(package: str) -> str:
    """How to get a Python package that is not there, if it is one that comes with this one."""
    extra = next((extra for extra, names in _EXTRAS.items() if package in names), None)
    how = f": scripts/setup installs it, as does pip install '.[{extra}]' in the sources' folder"
    what = f"this needs the Python package {package}, which is not installed here"
    return what + (how if extra else "")


def frames_in(error: BaseException, path: str | os.PathLike[str]) -> list[traceback.FrameSummary]:
    """The frames of an error's traceback that lie in a file."""
    path = os.path.realpath(path)
    return [f for f in traceback.extract_tb(error.__traceback__) if f.filename == path]


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
        what = f"{_place_of_error(error, function)}: {where}: {reason(error)}"
        raise InputError(what, collective=False) from error


def _place_of_error(error: BaseException, function: Callable[..., Any]) -> str:
    """"file, line N" where an error left the user's code, or else where the function is."""
    if _is_compilers(error):  # which names the line, of this function or of one that it calls
        for name, line in re.findall(r'File "([^"]+)", line (\d+)', str(error)):
            if _is_users(os.path.abspath(name)):
                return f"{short(os.path.abspath(name))}, line {line}"
    last = _last_frame(error)
    return _place_of_frame(last) if last else place_of(function)


def _last_frame(error: BaseException) -> traceback.FrameSummary | None:
    """The innermost frame of an error in the user's code, if it ever was in it."""
    frames = reversed(traceback.extract_tb(error.__traceback__))
    return next((frame for frame in frames if _is_users(os.path.abspath(frame.filename))), None)


def _is_users(name: str) -> bool:
    """Whether a file is the user's: not of Python, of a library or of this package
    but its cases.
    """
    known = name.startswith(_LIBRARIES) and not name.startswith(_CASES)
    library = {"site-packages", "dist-packages"} & set(name.split(os.sep))
    return not known and not library and os.path.isfile(name)


def _place_of_frame(frame: traceback.FrameSummary) -> str:
    return f"{short(os.path.abspath(frame.filename))}, line {frame.lineno}"


def _is_compilers(error: BaseException) -> bool:
    """Whether numba has raised it about a function of the user's."""
    return type(error).__module__.startswith("numba.")


def _compilers_words(error: BaseException) -> str:
    """What numba says about a function, without where in numba it was and what it has tried."""
    before = str(error).split('\nFile "')[0].splitlines()
    where = "Failed in", "During:", "---", "Return of:"
    said = [line.strip() for line in before if line.strip() and not line.startswith(where)]
    return " ".join(said[:2])[:_LONGEST]


def place_of_caller() -> str:
    """"file, line N: " of the case file that called what calls this; "" if it is called by none."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        name = os.path.abspath(frame.f_code.co_filename)
        if _is_users(name):
            return "" if name.startswith(_CASES) else f"{short(name)}, line {frame.f_lineno}: "
        frame = frame.f_back
    return ""


def place_of(function: Callable[..., Any]) -> str:
    """"file, line N" where a function is defined; its name if that is not known."""
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
    return os.fspath(name) if inside.startswith(os.pardir) else inside
