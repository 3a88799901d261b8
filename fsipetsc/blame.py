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
_EXTRAS = {"solver": ("petsc4py", "mpi4py", "numba", "llvmlite", "scipy", "yaml"), "plot": ("matplotlib",)}
_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)
#: lines of numba's messages that only say where in numba it was
_NUMBAS = "Failed in", "During:", "---", 'File "', "Return of:"
#: letters of somebody else's message that are repeated
_LONGEST = 300


def explain(error: BaseException, path: str | os.PathLike[str]) -> str:
    """One line about an error that came out of a case file: file, line, reason; of a module that it imports, these too."""
    lines = [frame.lineno for frame in frames_in(error, path)]
    line = f", line {lines[-1]}" if lines else ""
    if isinstance(error, SyntaxError):
        place = f", line {error.lineno}" if error.lineno else ""  # none where the file cannot even be decoded
        own = error.filename is None or os.path.realpath(error.filename) == os.path.realpath(path)
        elsewhere = "" if own else f"{line}: {short(error.filename or '')}"
        return f"case file {path}{elsewhere}{place}: {error.msg}"
    last = _last_frame(error)
    deeper = ""
    if last is not None and lines and os.path.realpath(last.filename) != os.path.realpath(path):
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
        return f"fsipetsc has no module {error.name}" if package == "fsipetsc" else missing(package)
    if isinstance(error, SystemExit):
        return "SystemExit: sys.exit() is called; a case file describes a problem and must not end the program"
    if _is_compilers(error):
        return f"numba cannot compile it: {compilers_words(error)}"
    return type(error).__name__ + (f": {text}" if text else "")


def missing(package: str) -> str:
    """How to get a Python package that is not there, if it is one of those that come with this one."""
    extra = next((extra for extra, packages in _EXTRAS.items() if package in packages), None)
    how = f": scripts/setup installs it, as does pip install '.[{extra}]' in the folder of the sources" if extra else ""
    return f"this needs the Python package {package}, which is not installed here{how}"


def frames_in(error: BaseException, path: str | os.PathLike[str]) -> list[traceback.FrameSummary]:
    """The frames of an error's traceback that lie in a file."""
    path = os.path.realpath(path)
    return [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]


def call(function: Callable[..., Any], arguments: tuple[Any, ...], where: str) -> Any:
    """function(*arguments), a user's; InputError with file and line for whatever it raises, perhaps on this rank alone.

    where: what the function is, in a message.
    """
    try:
        return function(*arguments)
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:  # SystemExit of one rank would leave the others waiting
        if isinstance(error, FsiError) and getattr(function, "__module__", "").startswith("fsipetsc."):
            raise  # it is about an option, or explained already
        raise _explained(error, function, where) from error


def _explained(error: BaseException, function: Callable[..., Any], where: str) -> InputError:
    """What a user's function has raised, for `call`: whose frame must not hold it, as it holds the frame, and all beyond."""
    fault = InputError(f"{place_of_error(error, function)}: {where}: {reason(error)}", collective=False)
    fault.users = users_lines(error)
    return fault


def users_lines(error: BaseException) -> str:
    """The traceback of an error of a user's function, from the first line of the user's on.

    "" if there is none: for what this package explains in one message, for numba's words, and for cases of this package. Of
    errors that it came from, -fsi_debug tells.
    """
    files = _users_files(error)
    first = next((k for k, name in enumerate(files) if name), None)
    if first is None or files[first].startswith(_CASES) or isinstance(error, FsiError) or _is_compilers(error):
        return ""
    told = traceback.TracebackException(type(error), error, error.__traceback__)
    del told.stack[:first]
    return "".join(told.format(chain=False)).rstrip()


def _users_files(error: BaseException) -> list[str]:
    """Of each frame of an error's traceback the file if it is the user's, else ""."""
    names = (os.path.abspath(frame.f_code.co_filename) for frame, _ in traceback.walk_tb(error.__traceback__))
    return [name if _is_users(name) else "" for name in names]


def place_of_error(error: BaseException, function: Callable[..., Any]) -> str:
    """"file, line N" where an error left the user's code; where the function is defined if it never was in it."""
    last = _last_frame(error)
    place = _place_of_frame(last) if last else place_of(function)
    if _is_compilers(error):  # which names the line, of this function or of one that it calls
        found = re.findall(r'File "([^"]+)", line (\d+)', str(error))
        named = [(os.path.abspath(name), line) for name, line in found if _is_users(os.path.abspath(name))]
        place = f"{short(named[0][0])}, line {named[0][1]}" if named else place
    return place


def _last_frame(error: BaseException) -> traceback.FrameSummary | None:
    """The innermost frame of an error in the user's code, if it ever was in it."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if _is_users(os.path.abspath(frame.filename)):
            return frame
    return None


def _is_users(name: str) -> bool:
    """Whether a file is the user's, and not of Python, of a library or of this package but for its cases."""
    known = name.startswith(_LIBRARIES) and not name.startswith(_CASES)
    return not known and not {"site-packages", "dist-packages"} & set(name.split(os.sep)) and os.path.isfile(name)


def _place_of_frame(frame: traceback.FrameSummary) -> str:
    return f"{short(os.path.abspath(frame.filename))}, line {frame.lineno}"


def _is_compilers(error: BaseException) -> bool:
    """Whether numba has raised it about a function of the user's."""
    return type(error).__module__.startswith("numba.")


def compilers_words(error: BaseException) -> str:
    """What numba says about a function that it cannot compile, without its list of what it has tried."""
    said: list[str] = []
    for line in str(error).splitlines():
        if said and line.startswith('File "'):  # the source itself follows
            break
        if line.strip() and not line.startswith(_NUMBAS):
            said.append(line.strip())
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
    """"file, line N" where a function is defined; its description if that is not known."""
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
