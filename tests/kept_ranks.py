"""Ranks that are kept from test to test: a run among them costs the run, and not the start of as
many processes.

What they do is what the command line does in a process that makes many runs (see cli.main); tests
of what becomes of processes, of signals and of starts make their own.
"""

from __future__ import annotations

import atexit
import json
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: as many ranks as there can be
MOST = 4
#: seconds that they may take to start and to end
_START, _END = 1800.0, 60.0


class KeptRanks:
    """MOST ranks, started when the first job comes, and again when one was left unfinished."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lines: list[Any] = []
        self._lock = threading.Lock()
        self._folder = ""

    def do(
        self, ranks: int, folder: Path, timeout: float, environment: Mapping[str, str], **job: Any
    ) -> tuple[int, str, str]:
        """(status, standard output, standard error) of a job, see kept_program.py, on the first so
        many ranks.

        subprocess.TimeoutExpired, with nothing left running, where there is no answer in time;
        AssertionError where a rank has ended, or the ranks do not agree in the status.
        """
        with self._lock:
            try:
                if self._process is None:
                    self._start(environment)
                text = json.dumps({"ranks": ranks, "folder": str(folder), **job}) + "\n"
                for line in self._lines[:ranks]:
                    line.sendall(text.encode())
                end = time.monotonic() + timeout
                answers = [self._answer(line, end, timeout) for line in self._lines[:ranks]]
            except BaseException:
                self.close(kill=True)
                raise
        statuses = {answer["status"] for answer in answers}
        said = ["".join(answer[name] for answer in answers) for name in ("stdout", "stderr")]
        assert len(statuses) == 1, (statuses, *said)
        return statuses.pop(), said[0], said[1]

    def _start(self, environment: Mapping[str, str]) -> None:
        self._folder = tempfile.mkdtemp(prefix="fsi-", dir="/tmp")  # a socket's name must be short
        place = f"{self._folder}/socket"
        with socket.socket(socket.AF_UNIX) as door:
            door.bind(place)
            door.listen(MOST)
            door.settimeout(_START)
            program = str(Path(__file__).with_name("kept_program.py"))
            command = ["mpiexec", "-n", str(MOST), sys.executable, program, place]
            with open(f"{self._folder}/said", "wb") as said:
                self._process = subprocess.Popen(
                    command, cwd="/", env=dict(environment),
                    stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                )
            lines = {}
            for _ in range(MOST):
                line = door.accept()[0]
                lines[int(self._line(line, time.monotonic() + _START, _START))] = line
        self._lines = [lines[rank] for rank in sorted(lines)]

    def _answer(self, line: socket.socket, end: float, timeout: float) -> dict[str, Any]:
        return json.loads(self._line(line, end, timeout))

    def _line(self, line: socket.socket, end: float, timeout: float) -> bytes:
        text = b""
        while not text.endswith(b"\n"):
            if not select.select([line], [], [], max(0.0, end - time.monotonic()))[0]:
                raise subprocess.TimeoutExpired("a job of the kept ranks", timeout)
            more = line.recv(1 << 16)
            said = Path(self._folder, "said")
            assert more, f"a rank has ended: {said.read_text(errors='replace')}"
            text += more
        return text

    def close(self, kill: bool = False) -> None:
        """Let the ranks end."""
        process, self._process = self._process, None
        for line in self._lines:
            line.close()
        self._lines = []
        if process is not None:
            if kill:
                process.terminate()  # mpiexec ends its ranks on that
            try:
                process.wait(_END)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)


#: of this process
KEPT = KeptRanks()
atexit.register(KEPT.close)
