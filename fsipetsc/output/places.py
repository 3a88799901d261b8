"""Where files are to be written: directories that are there, or are made; and what is said where that cannot be."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fsipetsc.errors import FileError


def check_folder(path: str | os.PathLike[str], folder: Path) -> None:
    """FileError, which names the file that is to be written, unless there is this directory for it."""
    try:
        is_there = folder.is_dir()
    except OSError as error:  # a name that is too long; a directory that may not be looked into
        raise FileError(f"{os.fspath(path)}: {folder}: {error.strerror}") from None
    if not is_there:
        what = f"{folder} is not a directory" if os.path.lexists(folder) else f"the directory {folder} does not exist"
        raise FileError(f"{os.fspath(path)}: {what}")


@contextmanager
def writing(target: Path, what: str = "the picture") -> Iterator[None]:
    """Make the directory of a file that is written within. FileError where either cannot be. what: the file is."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        there = next(filter(os.path.exists, target.parents), target.parent)  # Path.exists raises where it may not look
        elsewhere = os.path.exists(there) and not os.path.isdir(there)
        reason = f"{there} is not a directory" if elsewhere else error.strerror or error
        raise FileError(f"{target}: cannot write {what}: {reason}") from error
