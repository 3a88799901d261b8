"""Another program to measure against, if there is one: a serial one for the same problem, given by its folder.

The folder holds an executable ``rod``, or a Makefile that makes one (it is built in a temporary copy). Called as

    rod ORDER H T_END -q -n STEPS

it makes so many steps of the falling rod from rest, and prints one line: order, points on the average, steps, seconds,
µs per step, ns per point and evaluation of the right-hand side. In two dimensions it is ``plane``, of another folder:

    plane ORDER N N STEPS -q [-form div] [-visc 1]

for a gas and a solid of N by N points each, whose line has behind the word ``median`` µs per step.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from fsipetsc.errors import InputError

ENVIRONMENT = "FSIPETSC_YARDSTICK"


class _Program:
    """The other program. InputError if the folder has none that runs; ``close`` removes what was built."""

    name, option = "rod", "bench_yardstick"

    def __init__(self, folder: str) -> None:
        self._built: tempfile.TemporaryDirectory[str] | None = None
        self._program = Path(folder) / self.name
        if not os.access(self._program, os.X_OK):
            self._program = self._build(Path(folder))

    def _build(self, folder: Path) -> Path:
        if not (folder / "Makefile").is_file():
            raise InputError(f"-{self.option} {folder}: there is neither an executable {self.name} nor a Makefile")
        self._built = tempfile.TemporaryDirectory()
        copy = Path(shutil.copytree(folder, Path(self._built.name) / "yardstick"))
        copy.chmod(0o755)  # the original may be write-protected
        made = subprocess.run(["make", "-s", self.name], cwd=copy, capture_output=True, text=True)
        if made.returncode:
            reason = (made.stderr.strip() or "make failed").splitlines()[-1]
            raise InputError(f"-{self.option} {folder}: it cannot be built here: {reason}")
        return copy / self.name

    def _said(self, words: tuple[str, ...], pick: Callable[[list[str]], str]) -> float:
        """The number that ``pick`` takes of the words that the program prints."""
        command = [str(self._program.resolve()), *words]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            return float(pick(done.stdout.split()))
        except (OSError, subprocess.CalledProcessError, IndexError, ValueError) as error:
            raise InputError(f"the yardstick does not answer as it should: {' '.join(command)}: {error}") from None

    def close(self) -> None:
        """Remove what was built."""
        if self._built is not None:
            self._built.cleanup()


class Yardstick(_Program):
    """Of one dimension."""

    def __init__(self, folder: str) -> None:
        super().__init__(folder)
        self.step(4, 0.05, 10)

    def step(self, order: int, h: float, steps: int) -> float:
        """Time of a step [µs] over the first ``steps`` steps from rest."""
        return self._said((str(order), repr(h), "3", "-q", "-n", str(steps)), lambda words: words[4])


class PlaneYardstick(_Program):
    """Of two dimensions."""

    name, option = "plane", "bench_plane_yardstick"

    def __init__(self, folder: str) -> None:
        super().__init__(folder)
        self.step(4, 32, 2)

    def step(self, order: int, n: int, steps: int, more: tuple[str, ...] = ()) -> float:
        """Median time of a step [µs] of so many."""
        words = (str(order), str(n), str(n), str(steps), "-q", *more)
        return self._said(words, lambda words: words[words.index("median") + 1])
