"""How a run ends that cannot go on: one message, an exit status, and no rank left waiting."""

import traceback

from fsipetsc.blame import missing, reason
from fsipetsc.errors import FsiError, Interrupted, petsc_words
from fsipetsc.process.streams import abandon, say_error
from fsipetsc.process.together import Comm, done_asleep

#: PETSc's error codes that stand for something other than a fault of the program
_PETSC_STATUS = {55: 3, 65: 4, 66: 4, 67: 4, 72: 3, 82: 3, 91: 3}


def describe(error: BaseException) -> tuple[int, str, bool]:
    """(exit status, one-line message, whether all ranks surely meet it) of any exception."""
    if isinstance(error, (FsiError, Interrupted)):
        return error.status, str(error), error.collective
    if isinstance(error, KeyboardInterrupt):  # the others get it, too, and may need time to end
        return 130, "stopped by SIGINT", True
    if isinstance(error, MemoryError):
        known = f" ({error})" if str(error) else ""
        return 3, f"out of memory{known}; a coarser grid or more ranks need less", False
    if isinstance(error, OSError) and error.errno is not None:
        name = f"{error.filename}: " if error.filename is not None else ""
        return 4, f"{name}{error.strerror}", False
    if missing(error):
        return 2, reason(error), False
    if hasattr(error, "ierr"):  # PETSc has raised it
        return _PETSC_STATUS.get(error.ierr, 1), petsc_words(error), False
    return 1, f"unexpected {reason(error)}", False


def end_together(error: BaseException, notes: Comm | None) -> int:
    """Report an error, with a traceback where the program itself is at fault (status 1). Returns
    the exit status, or stops all ranks if not all of them failed.

    notes: a communicator of all ranks that is used for nothing else; None without MPI. Called by
    every rank that failed. Rank 0 speaks; another rank speaks where rank 0 goes on.
    """
    status, message, collective = describe(error)
    if notes is None or notes.rank == 0:
        _print(message, error, status)
    if notes is None or notes.size == 1:
        return status
    others = range(1, notes.size) if notes.rank == 0 else ()
    told = [notes.isend(status, other) for other in others]  # that rank 0 has spoken
    patience = 10.0 if collective else 1.0  # seconds for the others to fail as well
    if done_asleep(notes.Ibarrier(), patience + min(notes.rank, 1)):
        for request in told:
            request.wait()
        return status if notes.rank == 0 else notes.recv(source=0)
    if notes.rank > 0 and not notes.iprobe(source=0):
        _print(message, error, status)
    notes.Abort(status)
    return status


def _print(message: str, error: BaseException, status: int) -> None:
    try:
        print(end="", flush=True)
    except (OSError, ValueError):
        abandon(1)
    if status == 1:
        say_error("".join(traceback.format_exception(error)).rstrip())
    say_error(f"fsipetsc: error: {message}")
