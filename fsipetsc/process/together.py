"""What each rank does for itself, and all go on from together: nobody waits for one that failed."""

import math
import signal
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from fsipetsc.errors import FsiError, Interrupted, clear_frames

if TYPE_CHECKING:  # importing MPI starts it
    from mpi4py.MPI import Comm as Comm
else:
    Comm = Any
Result = TypeVar("Result")
#: requests and buffers of ``_arrive`` that this rank has not waited for: MPI may still use them
_pending: list[Any] = []


def together(comm: Comm, action: Callable[[], Result], asleep: bool = False) -> Result:
    """What action() returns on this rank. Collective, though the action must not be.

    If it raises an FsiError on any rank, all ranks raise the error of the lowest one. asleep: ranks
    that are done sleep until all are; if a signal has stopped the others, they raise Interrupted.
    """
    fault, result = None, None
    try:
        result = action()
    except FsiError as error:
        fault = error
    except KeyboardInterrupt as error:
        if asleep:
            _arrive(comm, getattr(error, "status", 128 + signal.SIGINT))
        raise
    if asleep:
        wait_asleep(comm)
    agree(comm, fault)
    return result


def wait_asleep(comm: Comm) -> None:
    """Wait for all ranks, asleep: one that compiles or draws may have this rank's core.

    Raises Interrupted if a signal has stopped ranks that were at work in ``together``; one that
    comes to this rank while it waits is a KeyboardInterrupt, as everywhere.
    """
    request, statuses = _arrive(comm)
    done_asleep(request)
    _pending.pop()
    number = max(statuses) - 128
    if number > 0:
        raise Interrupted(number, f"stopped by {signal.Signals(number).name}")


def done_asleep(request: Any, patience: float = math.inf) -> bool:
    """Whether a request is done within so many seconds, for which this rank sleeps."""
    end = time.monotonic() + patience
    while not request.Test():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
    return True


def _arrive(comm: Comm, status: int = 0) -> tuple[Any, bytearray]:
    """Tell all ranks that this one is here. status: of the signal that has stopped it; else 0.

    Returns the request, and the statuses of all ranks, which are known when the request is done.
    """
    statuses = bytearray(comm.size)
    request = comm.Iallgather(bytes([status]), statuses)
    _pending.append((request, statuses))
    return request, statuses


def agree(comm: Comm, fault: FsiError | None) -> None:
    """Raise the fault of the lowest rank that has one, on all ranks; none may have. Collective."""
    clear_frames(fault)
    mine = None if fault is None else (type(fault), fault.args)
    first = next((known for known in comm.allgather(mine) if known is not None), None)
    if first is not None:
        kind, words = first
        raise kind(*words) from fault
