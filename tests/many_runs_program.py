"""Runs in one process, RUNS: JSON of [status, arguments]; prints what is not as expected."""

import contextlib
import gc
import io
import json
import os
import signal
import sys
from pathlib import Path

import petsc4py

# PETSc 3.22 would list options that the program leaves unused
petsc4py.init(["host", "-host_option", "7", "-fsi_order", "8", "-options_left", "false"])
from petsc4py import PETSc

from fsipetsc.cli import main
from fsipetsc.process.launch import start_mpi


def left() -> dict[str, object]:
    """All that a run could leave behind."""
    gc.collect()
    objects = [o for o in gc.get_objects() if issubclass(type(o), PETSc.Object) and o]
    opened = sorted(map(os.path.realpath, Path("/proc/self/fd").iterdir()))
    return {
        "options": PETSc.Options().getAll(),
        "signals": [str(signal.getsignal(n)) for n in (signal.SIGTERM, signal.SIGINT)],
        "objects": sorted(o.klass for o in objects if not o.klass.startswith("Viewer")),
        "environment": dict(os.environ),
        "path": list(sys.path),
        "modules": sorted(name for name in sys.modules if "_case" in name),
        # PETSc leaves an options file open in which it finds a fault
        "files": [name for name in opened if name.startswith(os.getcwd()) and ".opts" not in name],
    }


if __name__ == "__main__":
    start_mpi()  # which sets what Open MPI is to know
    wrong, before = [], left()
    given = {"host_option": "7", "fsi_order": "8", "options_left": "false"}
    assert before["options"] == given
    for expected, text in json.loads(sys.argv[1]):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            status = main(text.split())
        if status != expected or said.getvalue().count("\n") != (status != 0):
            wrong.append([text, f"status {status}, not {expected}", said.getvalue()])
        now = left()
        wrong += [[text, k, before[k], now[k]] for k in now if now[k] != before[k]]
    print(json.dumps(wrong))
