"""Makes run after run in one process, as a notebook would, and says what each of them leaves
behind: RUNS.json.

RUNS.json: list of [exit status expected, arguments]. Prints one line of
JSON: what is not as expected or has changed in the process since the first run.
"""

from __future__ import annotations

import contextlib
import gc
import io
import json
import os
import signal
import sys
from pathlib import Path

from fsipetsc.cli import main
from fsipetsc.process.launch import start_mpi

copies = [0]  # of the communicator of all ranks that have not been freed


def count_copies() -> None:
    """Have MPI count: a copy takes the attributes of a communicator with it, and gives them back
    when it is freed.
    """
    from mpi4py import MPI

    def copied(comm: object, key: int, value: object) -> object:
        copies[0] += 1
        return value

    def freed(comm: object, key: int, value: object) -> None:
        copies[0] -= 1

    MPI.COMM_WORLD.allreduce(0)  # for which mpi4py makes a copy of its own, once
    MPI.COMM_WORLD.Set_attr(MPI.Comm.Create_keyval(copied, freed), 0)


def footprint() -> dict[str, object]:
    """All that a run could leave behind."""
    from petsc4py import PETSc

    gc.collect()
    objects = [
        o
        for o in gc.get_objects()
        if issubclass(type(o), PETSc.Object) and o and not o.klass.startswith("Viewer")
    ]
    return {
        "options": PETSc.Options().getAll(),
        "signals": [
            str(signal.getsignal(n))
            for n in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGPIPE)
        ],
        "objects": sorted(o.klass for o in objects),
        "communicators": copies[0],
        "environment": dict(os.environ),
        "path": list(sys.path),
        "modules": sorted(
            name for name in sys.modules if "case_" in name or name == "helper_of_a_case"
        ),
        "files": sorted(
            os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd") if _is_file(n)
        ),
        "threshold": gc.get_threshold(),
    }


def _is_file(number: str) -> bool:
    """PETSc leaves an options file open in which it finds a fault."""
    with contextlib.suppress(OSError):
        path = os.readlink(f"/proc/self/fd/{number}")
        return path.startswith(os.getcwd()) and not path.endswith(".opts")
    return False


if __name__ == "__main__":
    start_mpi()
    count_copies()
    wrong, before = [], None
    for expected, text in json.loads(Path(sys.argv[1]).read_text()):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            status = main(text.split())
        if status != expected or said.getvalue().count("\n") != (status != 0):
            wrong.append([text, f"status {status}, not {expected}", said.getvalue()])
        now = footprint()
        # PETSc, once started, is there for good, and the first run starts it
        before = before or now
        wrong += [
            [text, name, before[name], now[name]] for name in now if now[name] != before[name]
        ]
    print(json.dumps(wrong))
