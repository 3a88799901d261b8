"""Another program to measure beside, of a folder with its executable or a Makefile.

In one dimension it is ``rod ORDER H T -q -n STEPS``: steps of the falling rod from rest; the fifth
word that it prints is µs a step. In two dimensions it is ``plane ORDER N N STEPS -q [-form div]
[-visc 1]`` for a gas and a solid of N by N points; µs a step follow the word ``median``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from fsipetsc.errors import InputError


def executable(name: str, folder: str, copies: str) -> Path:
    """That of a folder, or one built in a copy below ``copies``. InputError."""
    path = Path(folder).resolve() / name
    if os.access(path, os.X_OK):
        return path
    copy = Path(copies) / name
    try:
        shutil.copytree(folder, copy).chmod(0o755)  # the original may be write-protected
        subprocess.run(["make", "-s", name], cwd=copy, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        reason = str(getattr(error, "stderr", "") or error).strip().splitlines()[-1]
        raise InputError(f"{folder}: no executable {name}, and it cannot be built: {reason}") from None
    return copy / name


def time_of(*command: object) -> float:
    """Time of a step [µs] by a program with these arguments. InputError."""
    words = [str(word) for word in command]
    try:
        said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
        return float(said[said.index("median") + 1] if "median" in said else said[4])
    except (OSError, subprocess.CalledProcessError, IndexError, ValueError) as error:
        raise InputError(f"{' '.join(words)} does not answer as it should: {error}") from None
