"""Ranks that stay from test to test: a run among them costs no start of processes.

Rank 0 reads jobs from its standard input. The ranks do a job as a process that makes many runs
(fsipetsc.cli.main). Tests of processes, signals and starts use their own processes."""

import atexit
import json
import os
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

MOST = 4
Answer = tuple[int, str, str]  # exit status, standard output, standard error


class KeptRanks:
    """MOST ranks, started when the first job comes, and again when one was left unfinished."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def do(
        self, ranks: int, folder: Path, environment: Mapping[str, str], lines: Sequence[list[str]]
    ) -> list[Answer]:
        """What comes of command lines on the first ranks. AssertionError if a rank ended."""
        try:
            if self._process is None:
                command = ["mpiexec", "-n", str(MOST), sys.executable, __file__]
                given = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
                self._process = subprocess.Popen(command, env=dict(environment), **given)
            job = json.dumps([ranks, str(folder), os.environ.get("CFLAGS", ""), lines])
            print(job, file=self._process.stdin, flush=True)
            answer = self._process.stdout.readline()
            assert answer, "a rank has ended"
        except BaseException:
            self.close()
            raise
        found = []
        for said in zip(*json.loads(answer), strict=True):  # of each line, by all ranks
            statuses, out, err = zip(*said, strict=True)
            assert len(set(statuses)) == 1, said
            found.append((statuses[0], "".join(out), "".join(err)))
        return found

    def close(self) -> None:
        """End the ranks: mpiexec does so on SIGTERM."""
        process, self._process = self._process, None
        if process is not None:
            process.terminate()
            process.communicate()


#: of this process
KEPT = KeptRanks()


def answered(words: list[str]) -> Answer:
    """What comes of a command line, with what C code says."""
    from fsipetsc import cli

    kept, said = [os.dup(number) for number in (1, 2)], []
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        for number, file in ((1, out), (2, err)):
            os.dup2(file.fileno(), number)
        try:
            status = cli.main(words)
        except BaseException:
            status = 1
            traceback.print_exc()
        for number, file, stream in ((1, out, sys.stdout), (2, err, sys.stderr)):
            stream.flush()
            os.dup2(kept[number - 1], number)
            os.close(kept[number - 1])
            file.seek(0)
            said.append(file.read().decode(errors="replace"))
    return status, *said


def work() -> None:
    """Do jobs until there are no more."""
    from fsipetsc import cli
    from fsipetsc.process.launch import start_mpi, start_petsc
    from fsipetsc.process.together import done_asleep

    world = start_mpi()
    start_petsc([], world)  # for which PETSc wants all ranks
    first = cache(lambda n: world.Create_group(world.group.Incl(range(n))))
    jobs = os.fdopen(os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)  # for the runs, and what they start
    sys.argv = ["-m"]
    warnings.filterwarnings("always", category=RuntimeWarning)  # in each run
    while True:
        line = jobs.readline() if world.rank == 0 else ""
        done_asleep(world.Ibarrier())  # takes no time of a processor
        line = world.bcast(line)
        if not line:
            return
        ranks, folder, os.environ["CFLAGS"], lines = json.loads(line)
        if world.rank < ranks:
            comm = first(ranks)
            cli.start_mpi = lambda alone, comm=comm: comm
            os.chdir(folder)
            answers = comm.gather([answered(words) for words in lines])
            if world.rank == 0:
                print(json.dumps(answers), flush=True)


if __name__ == "__main__":
    work()
else:
    atexit.register(KEPT.close)
