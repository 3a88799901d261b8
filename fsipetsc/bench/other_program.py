"""Another program to measure beside, given by a folder with its executable or a Makefile.

In one dimension it is ``rod ORDER H T -q -n STEPS``: steps of the falling rod from rest; the fifth
word that it prints is µs a step. In two dimensions it is ``plane ORDER N N STEPS -q [-form div]
[-visc 1]`` for a gas and a solid of N by N points; µs a step follow the word ``median``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from fsipetsc.errors import InputError


class OtherProgram:
    """The executable ``name`` of a folder, built in a temporary copy if need be.

    ``close`` removes what was built. InputError where there is none that runs.
    """

    def __init__(self, name: str, folder: str) -> None:
        self._copy: tempfile.TemporaryDirectory[str] | None = None
        self.path = Path(folder).resolve() / name
        if not os.access(self.path, os.X_OK):
            self.path = self._built(name, Path(folder))

    def _built(self, name: str, folder: Path) -> Path:
        if not (folder / "Makefile").is_file():
            raise InputError(f"{folder}: there is neither an executable {name} nor a Makefile")
        self._copy = tempfile.TemporaryDirectory()
        copy = Path(shutil.copytree(folder, Path(self._copy.name) / "copy"))
        copy.chmod(0o755)  # the original may be write-protected
        made = subprocess.run(["make", "-s", name], cwd=copy, capture_output=True, text=True)
        if made.returncode:
            reason = (made.stderr.strip() or "make failed").splitlines()[-1]
            raise InputError(f"{folder}: {name} cannot be built here: {reason}")
        return copy / name

    def step(self, *words: object) -> float:
        """Time of a step [µs] with these arguments."""
        command = [str(self.path), *map(str, words)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            said = done.stdout.split()
            return float(said[said.index("median") + 1] if "median" in said else said[4])
        except (OSError, subprocess.CalledProcessError, IndexError, ValueError) as error:
            raise InputError(f"{' '.join(command)} does not answer as it should: {error}") from None

    def close(self) -> None:
        """Remove what was built."""
        if self._copy is not None:
            self._copy.cleanup()
