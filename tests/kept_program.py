"""One of the ranks that kept_ranks.py keeps for the runs of tests, started under mpiexec:
FOLDER.

Does the jobs that come through its pipe in the folder, a line each, until the process that gives
them ends or closes it: the command lines of the first so many ranks, in the folder that the job
names. There may be petsc_options, for the environment, and stand_in, a source that defines what
takes the place of stepping.run.run_given. The answer: of each line exit status, and what was said.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import traceback
import warnings
from functools import cache
from pathlib import Path
from typing import Any

from fsipetsc import cli
from fsipetsc.process.launch import start_mpi, start_petsc


@cache
def first(n: int) -> Any:
    """The communicator of so many ranks. Collective on them alone."""
    world = start_mpi()
    return world.Create_group(world.group.Incl(range(n)))


def answered(words: list[str]) -> tuple[int, str, str]:
    """(status, standard output, standard error) of a command line, with what C code says."""
    kept, said = [os.dup(number) for number in (1, 2)], []
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        for number, file in ((1, out), (2, err)):
            os.dup2(file.fileno(), number)
        try:
            status = cli.main(words)
        except BaseException:
            status = 1
            traceback.print_exc()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for number, file in ((1, out), (2, err)):
            os.dup2(kept[number - 1], number)
            os.close(kept[number - 1])
            file.seek(0)
            said.append(file.read().decode(errors="replace"))
    return status, *said


def do(job: dict[str, Any]) -> list[tuple[int, str, str]]:
    """A job of this rank's."""
    from fsipetsc.stepping import run

    comm = first(job["ranks"])
    cli.start_mpi = lambda: comm
    usual, environment = run.run_given, dict(os.environ)
    if "stand_in" in job:
        names: dict[str, Any] = {}
        exec(job["stand_in"], names)
        run.run_given = names["run_given"]
    if "petsc_options" in job:
        os.environ["PETSC_OPTIONS"] = job["petsc_options"]
    os.chdir(job["folder"])
    try:
        return [answered(words) for words in job["lines"]]
    finally:
        os.chdir("/")
        run.run_given = usual
        os.environ.clear()
        os.environ.update(environment)


def main(folder: str) -> None:
    world = start_mpi()
    start_petsc([], world)  # for which PETSc wants all ranks
    sys.argv = ["-m"]
    # in each run, as if it were the process's first
    warnings.filterwarnings("always", category=RuntimeWarning)
    # not to wait for a giver that has ended
    pipe = os.open(Path(folder, f"jobs.{world.rank}"), os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(pipe, True)
    with open(pipe) as jobs:
        for line in jobs:
            job = json.loads(Path(folder, f"job.{int(line)}").read_text())
            draft = Path(folder, f"draft.{world.rank}")
            draft.write_text(json.dumps(do(job)))
            os.replace(draft, Path(folder, f"{job['number']}.{world.rank}"))


if __name__ == "__main__":
    main(*sys.argv[1:])
