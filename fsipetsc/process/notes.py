"""Notes that ranks which fail send to all others, who may be computing or waiting for them: nothing here waits for good."""

from __future__ import annotations

import math
import os
import time
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from mpi4py import MPI

Word = TypeVar("Word")

#: where a machine is so busy that ranks come late by seconds: the one number that PATIENCE is then
VARIABLE = "FSIPETSC_PATIENCE"


def _patience(text: str) -> dict[bool, float]:
    """PATIENCE with the variable's text: that of seconds, or whatever else, which changes nothing."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    return {True: seconds, False: seconds} if seconds >= 0.0 else {True: 10.0, False: 1.0}


#: seconds for the other ranks to fail as well, before they are stopped: after an error that all ranks meet together,
#: and after one that a rank may be alone with
PATIENCE = _patience(os.environ.get(VARIABLE, ""))
_NOTE = 1


def exchange(notes: MPI.Comm, word: Word, patience: float) -> dict[int, Word]:
    """Rank -> word of the ranks that report within `patience` seconds, this one included.

    notes: a communicator of all ranks on which nothing else is sent.
    """
    from mpi4py import MPI

    heard = {notes.rank: word}
    sent = [notes.isend(word, dest=rank, tag=_NOTE) for rank in range(notes.size) if rank != notes.rank]
    end, info = time.monotonic() + patience, MPI.Status()
    while len(heard) < notes.size and time.monotonic() < end:
        if notes.iprobe(tag=_NOTE, status=info):
            heard[info.source] = notes.recv(source=info.source, tag=_NOTE)
        else:
            time.sleep(0.005)
    if len(heard) == notes.size:
        for request in sent:
            request.wait()
    return heard
