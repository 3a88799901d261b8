"""Who may write the result of a name: one run at a time. And new names for what earlier runs left.

A run holds a lock on NAME.parts/lock, which the system takes back when the program ends in whatever
way. Where the file system knows no locks, nothing keeps a second run off.
"""

from __future__ import annotations

import fcntl
import itertools
import os
import socket
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from fsipetsc.errors import FileError


class Lock:
    """The right to write in a folder, which is made if need be, until `release`.

    FileError if another run has it, which is named; OSError where no folder can be made.
    """

    def __init__(self, folder: Path, what: str) -> None:
        self.path, self._descriptor = folder / "lock", -1
        while self._descriptor < 0:
            folder.mkdir(exist_ok=True)
            with suppress(FileNotFoundError):  # the run that had it has just removed the folder
                self._take(what)

    def _take(self, what: str) -> None:
        descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            with suppress(OSError):  # no locks here
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    who = os.pread(descriptor, 300, 0).decode(errors="replace")
                    raise FileError(
                        f"{what}: another run is writing it ({who}); "
                        "give this one a name of its own with -fsi_output"
                    ) from None
            if os.path.samestat(os.fstat(descriptor), os.lstat(self.path)):  # not renamed meanwhile
                os.ftruncate(descriptor, 0)
                who = f"process {os.getpid()} on {socket.gethostname()}"
                os.pwrite(descriptor, who.encode(), 0)
                self._descriptor, descriptor = descriptor, -1
        finally:
            if descriptor >= 0:
                os.close(descriptor)

    def release(self, remove: bool = False) -> None:
        """Let other runs have the name. remove: the folder, if nothing else is in it."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor < 0:
            return
        with suppress(OSError):
            if remove and os.path.samestat(os.fstat(descriptor), os.lstat(self.path)):
                self.path.unlink()
                self.path.parent.rmdir()
        os.close(descriptor)

    __del__ = release  # whatever becomes of the run


def set_aside(files: Iterable[Path], stem: str, beside: Iterable[Path] = ()) -> dict[Path, Path]:
    """Give files, whose names begin with a stem, the first free number: NAME.1.h5, NAME.1.parts.

    beside: names that are to be free with that number, too. Returns old -> new names. OSError, and
    FileError for what is neither a regular file nor a folder of pieces.
    """
    files, beside = list(files), list(beside)
    for file in files:
        if not (file.is_file() or (file.is_dir() and file.suffix == ".parts")):
            raise FileError(f"{file}: exists and is not a regular file")
    for k in itertools.count(1):
        names = {
            file: file.with_name(f"{stem}.{k}{file.name.removeprefix(stem)}")
            for file in (*files, *beside)
        }
        if not any(map(os.path.lexists, names.values())):
            break
    for file in files:
        os.rename(file, names[file])
    return {file: names[file] for file in files}
