"""What each rank does for itself, and all go on from together; how the ranks get libraries of
kernels; how a run ends that cannot go on: one message, an exit status, and no rank left waiting.
"""

import ctypes
import math
import os
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar

from fsipetsc.errors import FsiError, Interrupted, clear_frames, misses_package, petsc_words, reason

#: mpi4py.MPI.Comm, without an import, which would start MPI
Comm = Any
Result = TypeVar("Result")
#: where launchers tell a process its rank
_RANKS = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID")
#: PETSc's error codes that stand for something other than a fault of the program
_PETSC_STATUS = {55: 3, 65: 4, 66: 4, 67: 4, 72: 3, 82: 3, 91: 3}


def launcher_rank() -> int | None:
    """Return this process's rank as mpiexec tells it, for what needs no MPI; None without it."""
    found = (os.environ.get(name, "") for name in _RANKS)
    return next((int(text) for text in found if text.isdigit()), None)


def say(text: str) -> None:
    """Print a line of a run; where nothing can be printed any more, the run goes on in silence."""
    try:
        print(text, flush=True)
    except OSError:
        abandon_output()


def abandon_output() -> None:
    """Let everything still to be printed on stdout, by C code too, go nowhere."""
    with suppress(OSError, ValueError), open(os.devnull, "w") as null:
        os.dup2(null.fileno(), 1)


def together(comm: Comm, action: Callable[[], Result], asleep: bool = False) -> Result:
    """Return what action() returns on this rank. Collective, though the action must not be.

    If it raises an FsiError on any rank, all raise that of the lowest. asleep: who is done sleeps.
    """
    fault, result = None, None
    try:
        result = action()
    except FsiError as error:
        fault = error
    if asleep:
        done_asleep(comm.Ibarrier())
    agree(comm, fault)
    return result


def done_asleep(request: Any, patience: float = math.inf) -> bool:
    """Tell whether a request is done within so many seconds; this rank sleeps, its core is free."""
    end = time.monotonic() + patience
    while not request.Test():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
    return True


def agree(comm: Comm, fault: FsiError | None) -> None:
    """Raise the fault of the lowest rank that has one, on all ranks; none may have. Collective."""
    clear_frames(fault)
    mine = None if fault is None else (type(fault), fault.args)
    for kind, words in filter(None, comm.allgather(mine)):
        raise kind(*words) from fault


def libraries(comm: Comm, texts: Sequence[str], announce: Any) -> list[ctypes.CDLL]:
    """Return the libraries of this rank's texts in C. Collective, though ranks may have other
    texts: what ranks lack is compiled once, for its processor by a rank that has it, and sent as
    bytes, so that no file system has to show a new file in time.

    announce: called on rank 0 before and after somebody compiles. InputError where there is no
    compiler, or it fails; FileError.
    """
    from fsipetsc.kernels import build

    says = announce if comm.rank == 0 else lambda text: None
    names, made = [*map(build.name_of, texts)], dict[str, bytes]()
    text_of = dict(zip(names, texts, strict=True))
    lacks = together(comm, lambda: [name for name in text_of if build.found(name) is None])
    # name -> the rank that compiles it: the lowest one that lacks it
    makers = {name: k for k, some in reversed([*enumerate(comm.allgather(lacks))]) for name in some}
    lost = ""
    if build.keeps_text and comm.rank == 0:
        in_C = {name.replace(".so", ".c"): text.encode() for name, text in text_of.items()}
        lost = build.keep(in_C)
        for name in () if lost else in_C:
            says(f"C text of kernels: {build.folder() / name}")
    if makers:
        begin = time.monotonic()
        says(f"compiling the kernels of this case (libraries: {len(makers)})")
        mine = {name: text_of[name] for name, k in makers.items() if k == comm.rank}
        # asleep: the compilers may have this rank's core
        for of_rank in comm.allgather(together(comm, lambda: build.made(mine), asleep=True)):
            made |= of_rank
        says(f"compiled in {time.monotonic() - begin:.1f} s")
    lost = build.keep({name: made[name] for name in lacks}) or lost
    if lost and comm.rank == 0:
        print(f"fsipetsc: warning: {lost}", file=sys.stderr)
    return together(comm, lambda: [build.loaded(name, made) for name in names])


def describe(error: BaseException) -> tuple[int, str, bool]:
    """Return (exit status, one-line message, whether all ranks surely meet it) of any exception."""
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
    if misses_package(error):
        return 2, reason(error), False
    if hasattr(error, "ierr"):  # PETSc has raised it
        return _PETSC_STATUS.get(error.ierr, 1), petsc_words(error), False
    return 1, f"unexpected {reason(error)}", False


def end_together(error: BaseException, notes: Comm | None) -> int:
    """Report an error, with a traceback where the program itself is at fault (status 1). Returns
    the exit status, or stops all ranks if not all of them failed. Every rank that failed calls it.

    notes: a communicator of all ranks that is used for nothing else; None without MPI. Rank 0
    speaks for all that failed; of an error that not all ranks meet each speaks that has it.
    """
    status, message, collective = describe(error)
    first = notes is None or notes.rank == 0
    told = first and (collective or notes is None or notes.size == 1)
    if told:
        _print(message, error, status)
    if notes is None:
        return status
    met = done_asleep(notes.Ibarrier(), 10.0 if collective else 1.0)  # so long others may take
    if not (told or collective) and (first or not met):
        _print(message, error, status)
    if not met:
        notes.Abort(status)
    return notes.bcast(status)


def _print(message: str, error: BaseException, status: int) -> None:
    try:
        print(end="", flush=True)
    except (OSError, ValueError):
        abandon_output()
    with suppress(OSError, ValueError):
        if status == 1:
            traceback.print_exception(error)
        print(f"fsipetsc: error: {message}", file=sys.stderr, flush=True)
