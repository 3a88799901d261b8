"""What each rank does for itself, and all go on from together: nobody waits for one that has failed, nor takes its time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from fsipetsc.errors import FsiError, clear_frames, lines_of

if TYPE_CHECKING:
    from mpi4py import MPI

Result = TypeVar("Result")


def together(comm: MPI.Comm, action: Callable[[], Result]) -> Result:
    """What action() returns on this rank. Collective, though the action must not be.

    If it raises an FsiError on any rank, all ranks raise the error of the lowest one.
    """
    fault, result = None, None
    try:
        result = action()
    except FsiError as error:
        fault = error
    agree(comm, fault)
    return result


def wait_asleep(comm: MPI.Comm) -> None:
    """Wait for all ranks, asleep: where one compiles or draws, others that look out for it all the time may have its core."""
    request = comm.Ibarrier()
    while not request.Test():
        time.sleep(0.002)


def agree(comm: MPI.Comm, fault: FsiError | None) -> None:
    """Raise the fault of the lowest rank that has one, on all ranks; none may have. Collective."""
    clear_frames(fault)
    known = comm.allgather(None if fault is None else (type(fault), fault.args, fault.told or lines_of(fault), fault.users))
    first = next((entry for entry in known if entry is not None), None)
    if first is not None:
        kind, words, told, users = first
        error = kind(*words)
        error.told, error.users = told, users
        raise error from fault
