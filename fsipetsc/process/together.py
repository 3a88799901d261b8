"""What each rank does for itself, and all go on from together: nobody waits for one that failed."""

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from fsipetsc.errors import FsiError, clear_frames

if TYPE_CHECKING:  # importing MPI starts it
    from mpi4py.MPI import Comm as Comm
else:
    Comm = Any
Result = TypeVar("Result")


def together(comm: Comm, action: Callable[[], Result], asleep: bool = False) -> Result:
    """What action() returns on this rank. Collective, though the action must not be.

    If it raises an FsiError on any rank, all ranks raise the error of the lowest one. asleep: ranks
    that are done sleep until all are.
    """
    fault, result = None, None
    try:
        result = action()
    except FsiError as error:
        fault = error
    if asleep:
        wait_asleep(comm)
    agree(comm, fault)
    return result


def wait_asleep(comm: Comm) -> None:
    """Wait for all ranks, asleep: one that compiles or draws may have this rank's core."""
    done_asleep(comm.Ibarrier())


def done_asleep(request: Any, patience: float = math.inf) -> bool:
    """Whether a request is done within so many seconds, for which this rank sleeps."""
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
    first = next((known for known in comm.allgather(mine) if known is not None), None)
    if first is not None:
        kind, words = first
        raise kind(*words) from fault
