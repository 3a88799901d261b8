"""One of the ranks that kept_ranks.py keeps for the runs of tests: does what it is told over a
socket, until that is closed.

Started under mpiexec: SOCKET. A job: the ranks that do it, from 0 on, the folder they do it in, and
either the words of a command line, or runs, name -> (case, options), of which each leaves NAME.h5,
or NAME.txt with its error, in the folder. With a command line there may be petsc_options, for the
environment, and stand_in, a source that defines what takes the place of stepping.run.run_given. The
answer: exit status, and what was said.
"""

from __future__ import annotations

import json
import os
import select
import socket
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from fsipetsc import cli
from fsipetsc.process.launch import start_mpi, start_petsc

#: seconds that an orderly end may take
_FAREWELL = 60.0


@cache
def first(n: int) -> Any:
    """The communicator of so many ranks. Collective on them alone."""
    world = start_mpi()
    return world.Create_group(world.group.Incl(range(n)))


@contextmanager
def said(answer: dict[str, Any]) -> Iterator[None]:
    """What is written within to the two streams, by C code too."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        files = {1: out, 2: err}
        kept = {number: os.dup(number) for number in files}
        for number, file in files.items():
            os.dup2(file.fileno(), number)
        try:
            yield
        finally:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            for number, name in ((1, "stdout"), (2, "stderr")):
                os.dup2(kept[number], number)
                os.close(kept[number])
                files[number].seek(0)
                answer[name] = files[number].read().decode(errors="replace")


def run_all(runs: dict[str, list[str]], comm: Any) -> None:
    """Each as the command line would."""
    from fsipetsc.cases import load_case
    from fsipetsc.errors import FsiError
    from fsipetsc.options import given_options
    from fsipetsc.process.launch import left_as_found
    from fsipetsc.stepping.run import run_given

    for name, (case_name, text) in runs.items():
        given = given_options([*text.split(), "-fsi_quiet", "-fsi_output", f"{name}.h5"])
        try:
            with left_as_found():
                run_given(load_case(case_name), given, comm)
        except FsiError as error:
            if comm.rank == 0:
                Path(f"{name}.txt").write_text(f"{type(error).__name__}: {error}")


def run_line(job: dict[str, Any]) -> int:
    """A command line; its status."""
    from fsipetsc.stepping import run

    usual, environment = run.run_given, dict(os.environ)
    if "stand_in" in job:
        names: dict[str, Any] = {}
        exec(job["stand_in"], names)
        run.run_given = names["run_given"]
    if "petsc_options" in job:
        os.environ["PETSC_OPTIONS"] = job["petsc_options"]
    try:
        return cli.main(job["words"])
    finally:
        run.run_given = usual
        os.environ.clear()
        os.environ.update(environment)


def do(job: dict[str, Any]) -> dict[str, Any]:
    comm, answer = first(job["ranks"]), {}
    cli.start_mpi = lambda: comm
    os.chdir(job["folder"])
    status = 0
    with said(answer):
        try:
            if "runs" in job:
                run_all(job["runs"], comm)
            else:
                status = run_line(job)
        except BaseException:
            status = 1
            traceback.print_exc()
    os.chdir("/")
    return {"status": status, **answer}


def leave_after(line: socket.socket) -> None:
    """End this process soon after the other end of the line has gone, even if a job hangs."""
    gone = select.poll()
    gone.register(line, select.POLLHUP | select.POLLRDHUP)
    gone.poll()
    time.sleep(_FAREWELL)
    os._exit(1)


def main(place: str) -> None:
    world = start_mpi()
    start_petsc([], world)  # for which PETSc wants all ranks
    sys.argv = ["-m"]
    # in each run, as if it were the process's first
    warnings.filterwarnings("always", category=RuntimeWarning)
    with socket.socket(socket.AF_UNIX) as line:
        line.connect(place)
        threading.Thread(target=leave_after, args=(line,), daemon=True).start()
        with line.makefile("rw") as file:
            print(world.rank, file=file, flush=True)
            for job in file:
                print(json.dumps(do(json.loads(job))), file=file, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
