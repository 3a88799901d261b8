"""How a run ends that cannot go on: one message, the same exit status on all ranks, and no rank left waiting."""

from __future__ import annotations

import os
import sys
import traceback
from typing import TYPE_CHECKING

from fsipetsc.blame import explain, frames_in, reason
from fsipetsc.errors import FsiError, is_petsc, lines_of, petsc_words
from fsipetsc.process.notes import PATIENCE, exchange
from fsipetsc.process.streams import abandon_stdout, say_error

if TYPE_CHECKING:
    from mpi4py import MPI

    from fsipetsc.process.interrupts import Launcher

#: PETSc's error codes that stand for something other than a fault of the program
_PETSC_STATUS = {55: 3, 65: 4, 66: 4, 67: 4, 72: 3, 82: 3, 91: 3}


def describe(error: BaseException, case_file: str | None = None) -> tuple[int, str, bool]:
    """(exit status, one-line message, whether all ranks surely meet it) of any exception.

    case_file: path of a user's case file, whose errors are the user's and not the program's.
    """
    if isinstance(error, FsiError):
        return error.status, str(error), error.collective
    if isinstance(error, KeyboardInterrupt):
        return 130, "stopped by SIGINT", False
    if isinstance(error, MemoryError):
        return 3, f"out of memory{_detail(error)}; a coarser grid (-fsi_h) or more ranks need less", False
    if case_file is not None and frames_in(error, case_file):
        return 2, explain(error, case_file), False
    if isinstance(error, OSError) and error.errno is not None:
        name = f"{os.fspath(error.filename)}: " if error.filename is not None else ""
        return 4, f"{name}{error.strerror}", False
    if isinstance(error, ModuleNotFoundError) and not (error.name or "").startswith("fsipetsc"):
        return 1, reason(error), False
    if is_petsc(error):
        return _PETSC_STATUS.get(error.ierr, 1), petsc_words(error), False
    where = traceback.extract_tb(error.__traceback__)[-1:]
    place = "".join(f" in {os.path.basename(f.filename)}, line {f.lineno}" for f in where)
    return 1, f"unexpected {type(error).__name__}{place}{_detail(error)}; -fsi_debug shows the traceback", False


def _detail(error: BaseException) -> str:
    lines = str(error).splitlines()
    return f": {lines[0]}" if lines else ""


def end_together(
    error: BaseException,
    notes: MPI.Comm | None,
    *,
    debug: bool = False,
    case_file: str | None = None,
    launcher: Launcher | None = None,
) -> int:
    """Report an error, once over all ranks; returns the exit status, or stops all ranks if not all of them failed.

    notes: a communicator of all ranks that is used for nothing else; None without MPI. Called by every rank that
    failed. Each tells all others; the lowest that failed speaks, and if some rank is not heard of in time, it is
    computing or waiting for us, and MPI_Abort ends it. Without the launcher, if there was one, each is on its own.
    """
    status, message, collective = describe(error, case_file)
    if notes is None or notes.size == 1:
        _print(message, error, debug)
        return status
    if notes.rank == 0:
        _print(message, error, debug)
    if launcher is not None:
        launcher.leave_if_gone(status)
    failed = exchange(notes, status, PATIENCE[collective])
    if notes.rank == min(failed) != 0:
        _print(message, error, debug)
    status = failed[min(failed)]
    if len(failed) < notes.size:
        notes.Abort(status)
    return status


def _print(message: str, error: BaseException, debug: bool) -> None:
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        abandon_stdout()
    told = getattr(error, "told", "") or lines_of(error) if debug else getattr(error, "users", "")
    if told:
        say_error(told)
    say_error(f"fsipetsc: error: {message}")
