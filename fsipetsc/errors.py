"""What can go wrong, with exit statuses; errors of a user's functions, with file and line."""

import os
import traceback
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

_PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "")
_CASES = os.path.join(_PACKAGE, "cases", "")
_LIBRARIES = (os.path.join(os.path.dirname(os.path.abspath(os.__file__)), ""), _PACKAGE)


class FsiError(Exception):
    """An error that is explained to the user in one message, without a traceback.

    Args:
        message: what is wrong, and what would be valid.
        collective: whether every rank raises it at the same place; else the others are stopped.
    """

    status = 1

    def __init__(self, message: str, *, collective: bool = True) -> None:
        super().__init__(message)
        self.collective = collective


class InputError(FsiError):
    """Bad input: an option, a case file, the number of ranks. Exit status 2."""

    status = 2


class ComputationError(FsiError):
    """The computation failed; the message names field, layer, x, t and step. Exit status 3."""

    status = 3


class FileError(FsiError):
    """A file could not be read or written. Exit status 4."""

    status = 4


class Interrupted(KeyboardInterrupt):
    """A signal has ended a run, after its checkpoint, on all ranks. It is no FsiError: what a
    program does about a run that fails must not go on after a SIGTERM.
    """

    collective = True

    def __init__(self, number: int, message: str) -> None:
        super().__init__(message)
        self.status = 128 + number


def petsc_words(error: BaseException) -> str:
    """Return PETSc's words without its list of routines, "[0] TSSolve() at file:line" and so on."""
    lines = [line.split("] ", 1)[-1] for line in str(error).splitlines()[1:]]
    reason = "; ".join(line for line in lines if "() at " not in line)
    return f"PETSc error {getattr(error, 'ierr', '')}" + (f": {reason}" if reason else "")


def clear_frames(error: BaseException | None) -> None:
    """Empty the frames of an error, of its cause and of their callers. They hold PETSc's objects,
    which must not outlive the run: PETSc waits at its end for all ranks to have the same ones.
    """
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        frame = error.__traceback__.tb_frame if error.__traceback__ else None
        while frame is not None:
            with suppress(RuntimeError):  # it is still at work
                frame.clear()
            frame = frame.f_back
        error = error.__cause__ or error.__context__


def call(function: Callable[..., Any], arguments: tuple[Any, ...], where: str) -> Any:
    """function(*arguments) of a user; whatever it raises becomes an InputError with its place."""
    try:
        return function(*arguments)
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:  # SystemExit of one rank would leave the others waiting
        of_package = (getattr(function, "__module__", None) or "").startswith("fsipetsc.")
        if isinstance(error, FsiError) and of_package:
            raise  # it is about an option, or explained already
        place = place_in(error) or place_of(function)
        raise InputError(f"{place}: {where}: {reason(error)}", collective=False) from error


def reason(error: BaseException) -> str:
    """What an exception says, on one line."""
    text = " ".join(str(getattr(error, "msg", None) or error).split())
    if isinstance(error, FsiError):
        return text
    if misses_package(error):
        return f"{text}: pip install '.[solver,plot]' installs what fsipetsc needs"
    return type(error).__name__ + (f": {text[:300]}" if text else "")


def misses_package(error: BaseException) -> bool:
    """Whether an import did not find another package than this one."""
    name = (error.name or "") if isinstance(error, ModuleNotFoundError) else ""
    return name.partition(".")[0] not in ("", "fsipetsc")


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
    """Where a user's function is defined, as "file, line N"; else its name."""
    while isinstance(function, partial) or hasattr(function, "__wrapped__"):
        function = function.func if isinstance(function, partial) else function.__wrapped__
    code = getattr(function, "__code__", getattr(type(function).__call__, "__code__", None))
    if code and _is_users(code.co_filename):
        return f"{short(code.co_filename)}, line {code.co_firstlineno}"
    return getattr(function, "__name__", type(function).__name__)


def short(name: str | os.PathLike[str]) -> str:
    """A path as a user would write it."""
    inside = os.path.relpath(name)
    return os.path.abspath(name) if inside.startswith(os.pardir) else inside
