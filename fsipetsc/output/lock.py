"""Who may write the result of a name: one run at a time. And new names for what earlier runs have left.

A run holds a lock on NAME.parts/lock, which the system takes back when the program ends in whatever way. Where the file
system knows no locks, nothing keeps a second run off.
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
        self.path, self._what = folder / "lock", what
        self._descriptor: int | None = None
        while not self._take():
            pass

    def _take(self) -> bool:
        self.path.parent.mkdir(exist_ok=True)
        try:
            descriptor = os.open(
                self.path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666
            )
        except FileNotFoundError:  # its run has ended meanwhile
            return False
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            who = os.pread(descriptor, 300, 0).decode(errors="replace")
            os.close(descriptor)
            raise FileError(
                f"{self._what}: another run is writing it ({who}); give this one a name of its own with -fsi_output"
            ) from None
        except OSError:  # no locks here
            self._descriptor = descriptor
            return True
        if not self.is_still(descriptor):  # removed or renamed meanwhile
            os.close(descriptor)
            return False
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
        self._descriptor = descriptor
        return True

    def is_still(self, descriptor: int) -> bool:
        """Whether an open file is still the one of this name."""
        with suppress(FileNotFoundError):
            return os.path.samestat(os.fstat(descriptor), os.lstat(self.path))
        return False

    def release(self, remove: bool = False) -> None:
        """Let other runs have the name. remove: the folder, if nothing else is in it."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is None:
            return
        if remove and self.is_still(descriptor):
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()
        os.close(descriptor)


def set_aside(files: Iterable[Path], stem: str, beside: Iterable[Path] = ()) -> dict[Path, Path]:
    """Give files, whose names begin with a stem, the first free number behind it: NAME.1.h5, NAME.1.checkpoint.h5.

    beside: names that are to be free with that number, too. Returns old -> new names. OSError, and FileError for what is
    neither a regular file nor a folder of pieces.
    """
    files, beside = list(files), list(beside)
    if not files:
        return {}
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
