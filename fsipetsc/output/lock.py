"""Who may write the result of a name: one run at a time. And new names for what earlier runs left.

A run holds a lock on NAME.parts/lock, which the system takes back when the program ends in whatever
way. Where the file system knows no locks, nothing keeps a second run off.
"""

import fcntl
import itertools
import os
from contextlib import suppress
from pathlib import Path

from fsipetsc.errors import FileError


class Lock:
    """The right to write in a folder, which is made if need be, until `release`.

    FileError if another run has it; OSError where no folder can be made.
    """

    def __init__(self, folder: Path, what: str) -> None:
        self.path, self._descriptor = folder / "lock", -1
        while not self._is_there():  # else the run that had it has just removed the folder
            self.release()
            folder.mkdir(exist_ok=True)
            with suppress(FileNotFoundError):
                self._descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
                self._take(what)

    def _take(self, what: str) -> None:
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            said = "another run is writing it; give this one a name of its own with -fsi_output"
            raise FileError(f"{what}: {said}") from None
        except OSError:  # no locks here
            pass

    def _is_there(self) -> bool:
        """Whether it is taken, and the file still has its name."""
        with suppress(OSError):
            return os.path.samestat(os.fstat(self._descriptor), os.stat(self.path))
        return False

    def release(self, remove: bool = False) -> None:
        """Let other runs have the name. remove: the folder, if nothing else is in it."""
        if remove and self._is_there():
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    __del__ = release  # whatever becomes of the run


def set_aside(file: Path) -> Path:
    """Give NAME.h5 or NAME.parts the first number that no result has, as NAME.1.h5 or NAME.1.parts,
    which it returns. OSError.
    """
    ending = file.suffix if file.suffix in (".h5", ".parts") else ""
    stem = file.name.removesuffix(ending)
    for k in itertools.count(1):
        names = [file.with_name(f"{stem}.{k}{last}") for last in ("", ".h5", ".parts")]
        if not any(map(os.path.lexists, names)):
            break
    return file.rename(file.with_name(f"{stem}.{k}{ending}"))
