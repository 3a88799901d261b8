"""The command line in a process that signals itself, or its mpiexec, at named places:
PLACES WORDS...

PLACES: JSON, a list of [place, count, rank, number of the signal], of which a number below 0 goes
to mpiexec. The places:
    frame        as a frame is to be saved
    piece        a piece is full, and has not got its name
    checkpoint   half of a checkpoint is written
    join, clear  before the pieces become one file, and before they are removed
all but the first on rank 0."""

import json
import os
import signal
import sys
from collections import Counter
from pathlib import Path

from fsipetsc import cli
from fsipetsc.process.launch import start_mpi, start_petsc
from fsipetsc.process.together import launcher_rank

# as the program does; to import PETSc would start it with signals of its own
start_petsc([], start_mpi())

from fsipetsc.output import file_layout, writer

places, seen = json.loads(sys.argv.pop(1)), Counter()


def reached(place: str) -> None:
    """Send the signals that are to come here, this time."""
    seen[place] += 1
    for *where, number in places:
        if where == [place, seen[place], launcher_rank() or 0]:
            if number < 0:
                os.kill(os.getppid(), -number)
            else:
                signal.raise_signal(number)


def signalled(owner: object, name: str, place: str) -> None:
    """Let a place be reached before a function is called."""
    usual = getattr(owner, name)

    def called(*arguments: object, **more: object) -> object:
        reached(place)
        return usual(*arguments, **more)

    setattr(owner, name, called)


def put_signalled(path: Path, content: bytes) -> None:
    path.with_name(f".{path.name}.new").write_bytes(content[: len(content) // 2])
    reached("checkpoint")
    put(path, content)


put, file_layout.put = file_layout.put, put_signalled
signalled(writer.RunWriter, "write_frame", "frame")
signalled(writer, "publish", "piece")
signalled(writer.RunWriter, "_join", "join")
signalled(writer, "clear", "clear")
if __name__ == "__main__":
    sys.exit(cli.main())
