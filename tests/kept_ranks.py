"""Ranks that are kept from test to test: a run among them costs the run, and not the start of as
many processes.

What they do is what the command line does in a process that makes many runs (see cli.main); tests
of what becomes of processes, of signals and of starts make their own. Jobs come through a pipe for
each rank, so that a rank without a job takes no time of a processor; answers are files.
"""

from __future__ import annotations

import atexit
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

#: as many ranks as there can be
MOST = 4


class KeptRanks:
    """MOST ranks, started when the first job comes, and again when one was left unfinished."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._jobs, self._folder, self._pipes = 0, Path(), list[int]()

    def do(
        self,
        ranks: int,
        folder: Path,
        timeout: float,
        environment: Mapping[str, str],
        lines: Sequence[Sequence[str]],
        **more: str,
    ) -> list[tuple[int, str, str]]:
        """(status, standard output, standard error) of command lines on the first so many ranks,
        one after the other, see kept_program.py.

        subprocess.TimeoutExpired, with nothing left running, where there is no answer in time;
        AssertionError where a rank has ended, or the ranks do not agree in the status.
        """
        try:
            if self._process is None:
                self._start(environment)
            self._jobs += 1
            job = {"number": self._jobs, "ranks": ranks, "folder": str(folder), "lines": lines}
            (self._folder / f"job.{self._jobs}").write_text(json.dumps({**job, **more}))
            for pipe in self._pipes[:ranks]:
                os.write(pipe, f"{self._jobs}\n".encode())
            end = time.monotonic() + timeout
            answers = [self._answer(rank, end, timeout) for rank in range(ranks)]
        except BaseException:
            self.close(kill=True)
            raise
        found = []
        for said in zip(*answers, strict=True):  # of each line, by all ranks
            statuses, out, err = zip(*said, strict=True)
            assert len(set(statuses)) == 1, said
            found.append((statuses[0], "".join(out), "".join(err)))
        return found

    def _start(self, environment: Mapping[str, str]) -> None:
        self._folder, self._jobs = Path(tempfile.mkdtemp(prefix="fsi-")), 0
        program = str(Path(__file__).with_name("kept_program.py"))
        for path in (self._folder / f"jobs.{rank}" for rank in range(MOST)):
            os.mkfifo(path)
            self._pipes.append(os.open(path, os.O_RDWR))  # does not wait for the rank
        command = ["mpiexec", "-n", str(MOST), sys.executable, program, str(self._folder)]
        with open(self._folder / "said", "wb") as said:
            self._process = subprocess.Popen(
                command,
                cwd="/",
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=said,
            )

    def _answer(self, rank: int, end: float, timeout: float) -> list[tuple[int, str, str]]:
        path = self._folder / f"{self._jobs}.{rank}"
        while not path.exists():
            if self._process.poll() is not None:
                said = (self._folder / "said").read_text(errors="replace")
                raise AssertionError(f"a rank has ended: {said}")
            if time.monotonic() > end:
                raise subprocess.TimeoutExpired("a job of the kept ranks", timeout)
            time.sleep(0.005)
        return json.loads(path.read_text())

    def close(self, kill: bool = False) -> None:
        """Let the ranks end, which they do when their pipes are closed."""
        process, self._process = self._process, None
        while self._pipes:
            os.close(self._pipes.pop())
        if process is not None:
            if kill:
                process.terminate()  # mpiexec ends its ranks on that
            try:
                process.wait(60.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            shutil.rmtree(self._folder, ignore_errors=True)


#: of this process
KEPT = KeptRanks()
atexit.register(KEPT.close)
