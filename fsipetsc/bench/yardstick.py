"""Another program to measure against, if there is one: a serial one for the same problem, given by its folder.

The folder holds an executable ``rod``, or a Makefile that makes one (it is built in a temporary copy). Called as

    rod ORDER H T_END -q -n STEPS

it makes so many steps of the falling rod from rest, and prints one line: order, points on the average, steps, seconds,
µs per step, ns per point and evaluation of the right-hand side.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from fsipetsc.errors import InputError

ENVIRONMENT = "FSIPETSC_YARDSTICK"


class Yardstick:
    """The other program. InputError if the folder has none that runs; ``close`` removes what was built."""

    def __init__(self, folder: str) -> None:
        self._built: tempfile.TemporaryDirectory[str] | None = None
        self._program = Path(folder) / "rod"
        if not os.access(self._program, os.X_OK):
            self._program = self._build(Path(folder))
        self.step(4, 0.05, 10)

    def _build(self, folder: Path) -> Path:
        if not (folder / "Makefile").is_file():
            raise InputError(f"-bench_yardstick {folder}: there is neither an executable rod nor a Makefile")
        self._built = tempfile.TemporaryDirectory()
        copy = Path(shutil.copytree(folder, Path(self._built.name) / "yardstick"))
        copy.chmod(0o755)  # the original may be write-protected
        made = subprocess.run(["make", "-s", "rod"], cwd=copy, capture_output=True, text=True)
        if made.returncode:
            reason = (made.stderr.strip() or "make failed").splitlines()[-1]
            raise InputError(f"-bench_yardstick {folder}: it cannot be built here: {reason}")
        return copy / "rod"

    def step(self, order: int, h: float, steps: int) -> float:
        """Time of a step [µs] over the first ``steps`` steps from rest."""
        command = [str(self._program.resolve()), str(order), repr(h), "3", "-q", "-n", str(steps)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            return float(done.stdout.split()[4])
        except (OSError, subprocess.CalledProcessError, IndexError, ValueError) as error:
            raise InputError(f"the yardstick does not answer as it should: {' '.join(command)}: {error}") from None

    def close(self) -> None:
        """Remove what was built."""
        if self._built is not None:
            self._built.cleanup()
