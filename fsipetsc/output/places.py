"""Where files are to be written: directories that are there, or are made."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fsipetsc.errors import FileError


def check_folder(path: str | os.PathLike[str], folder: Path, writable: bool = False) -> None:
    """FileError, which names the file that is to be written, unless this directory is there.

    writable: and files can be written there.
    """
    fault = ""
    if not os.path.lexists(folder):
        fault = f"the directory {folder} does not exist"
    elif not os.path.isdir(folder):
        fault = f"{folder} is not a directory"
    elif writable and not os.access(folder, os.W_OK | os.X_OK):
        fault = f"the directory {folder} is not writable"
    if fault:
        raise FileError(f"{os.fspath(path)}: {fault}")


@contextmanager
def writing(target: Path, what: str = "the picture") -> Iterator[None]:
    """Make the directory of a file that is written within; what: it is. FileError."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        there = next(filter(os.path.exists, target.parents), target.parent)
        is_file = os.path.exists(there) and not os.path.isdir(there)
        reason = f"{there} is not a directory" if is_file else error.strerror or error
        raise FileError(f"{target}: cannot write {what}: {reason}") from error
