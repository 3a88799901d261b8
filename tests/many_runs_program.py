"""Makes run after run in one process, as a notebook would, and says what each of them leaves
behind: RUNS.json.

RUNS.json: list of [exit status expected or a list of those allowed, arguments]. Prints one line of
JSON: "wrong", what is not as expected or has changed in the process since the first run, of all
ranks; "said", what rank 0 said on stderr, run by run.
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


def answer(words: list[str]) -> tuple[int, str]:
    """(status, what was said on stderr) of one run."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        status = main(words)
    return status, said.getvalue()


if __name__ == "__main__":
    comm = start_mpi()
    count_copies()
    rank, wrong, every, before = comm.rank, [], [], None
    for expected, text in json.loads(Path(sys.argv[1]).read_text()):
        status, said = answer(text.split())
        every.append(said)
        allowed = expected if isinstance(expected, list) else [expected]
        if status not in allowed or said.count("\n") != (status != 0 and rank == 0):
            wrong.append([text, f"status {status}, not {expected}", said])
        now = footprint()
        # PETSc, once started, is there for good, and the first run starts it
        wrong += [
            [text, name, before[name], now[name]]
            for name in now
            if before and now[name] != before[name]
        ]
        before = before or now
    gathered = comm.gather(wrong)
    if gathered is not None:
        print(json.dumps({"wrong": [entry for part in gathered for entry in part], "said": every}))
