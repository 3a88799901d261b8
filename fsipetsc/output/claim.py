"""Who may write the result of a name, or its checkpoints: one run at a time, and no result is ever overwritten.

A run holds a lock on .NAME.lock beside the file, which the system takes back when the program ends in whatever way; the
file that a killed run leaves is of no account. A second run of the same name is refused while the first goes on. The
result is not locked itself: on network file systems that would keep the other ranks from writing it. Something else of the
lock's name is left as it is, and the run refused.
Where the file system knows no locks, two runs of one name still get two files, but the later one renames the earlier
one's while it is being written.
"""

from __future__ import annotations

import fcntl
import glob
import itertools
import os
import re
import socket
import stat
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from fsipetsc.errors import FileError

#: bytes of what a lock says
LONGEST = 300


def is_still(descriptor: int, path: Path) -> bool:
    """Whether an open file is still the one of this name: what is locked may have been removed meanwhile."""
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(descriptor), os.lstat(path))
    return False


_held: dict[Path, Claim] = {}  # of this process


class Claim:
    """The right to write the file `target`, until `release`.

    Raises FileError if another process has it, which says what ("rod.h5: another run is writing it") and the option that gives
    another name. In this process the later one takes it over: the earlier run has failed, or it finds its file under the new
    name.
    """

    def __init__(self, target: Path, what: str = "", option: str = "-fsi_output") -> None:
        self.target = target
        self._what, self._option = what or f"{target}: another run is writing it", option
        self._path = target.with_name(f".{target.name}.lock")
        if target in _held:
            _held[target].release()
        self._descriptor = self._lock()
        _held[target] = self
        if self._descriptor is not None:
            self._tidy()

    def _lock(self) -> int | None:
        while True:
            descriptor, own = self._open()
            if not _is_lock(descriptor):
                os.close(descriptor)
                raise FileError(f"{self._path}: stands where the lock of {self.target.name} belongs, and is none; move it away")
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if not is_still(descriptor, self._path):  # removed meanwhile: it stands for nothing
                    os.close(descriptor)
                    continue
                who = os.pread(descriptor, LONGEST, 0).decode(errors="replace").split(", session ")[0].strip()
                os.close(descriptor)
                raise FileError(
                    f"{self._what}{f' ({who})' if who else ''}; give this one a name of its own with {self._option}"
                ) from None
            except OSError:  # no locks here
                os.close(descriptor)
                if not own:  # there may be some, for who can write the file
                    raise
                self._path.unlink(missing_ok=True)
                return None
            if is_still(descriptor, self._path) and (own or not self._make_way()):
                if own:
                    os.ftruncate(descriptor, 0)
                    os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
                return descriptor
            os.close(descriptor)  # it was removed meanwhile

    def _open(self) -> tuple[int, bool]:
        """(descriptor of the lock's file, whether it can be written). OSError where none can be made.

        That of another user's run often cannot be, and on some systems not be opened as one that may be new: to be locked it
        need only be read. FileError if it cannot be.
        """
        common = os.O_NOFOLLOW | os.O_NONBLOCK
        while True:
            try:
                return os.open(self._path, os.O_RDWR | os.O_CREAT | common, 0o666), True
            except PermissionError:
                if not os.path.lexists(self._path):
                    raise
            with suppress(FileNotFoundError):  # removed meanwhile
                try:
                    return os.open(self._path, os.O_RDONLY | common), False
                except PermissionError:
                    raise FileError(f"{self._path}: the lock of another user's run, which cannot be read") from None

    def _make_way(self) -> bool:
        """Remove another user's file, which is locked and would tell of a run that is no more; whether that may be done."""
        with suppress(PermissionError):
            self._path.unlink()
            return True
        return False

    def _tidy(self) -> None:
        """Remove files that runs killed in the midst have left: nobody else makes such as long as we have the right."""
        for left in self.target.parent.glob(f".{glob.escape(self.target.name)}.*.new"):
            with suppress(OSError):
                left.unlink()

    def release(self) -> None:
        """Let others write the result. May be called again."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with suppress(OSError):
                if is_still(descriptor, self._path):
                    self._path.unlink()
            os.close(descriptor)
        if _held.get(self.target) is self:
            del _held[self.target]


def _is_lock(descriptor: int) -> bool:
    """Whether an open file is what a run makes: empty, or with one line about who it is, and of this name only."""
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1 or status.st_size > LONGEST:
        return False
    return re.fullmatch(rb"(process \d+ on [^\n]*)?", os.pread(descriptor, LONGEST, 0)) is not None


def is_there(target: Path) -> bool:
    """Whether there is a result. FileError for what stands in its place and is no regular file."""
    try:
        mode = os.lstat(target).st_mode
    except FileNotFoundError:
        return False
    if not stat.S_ISREG(mode):
        raise FileError(f"{target}: exists and is not a regular file")
    return True


def keep_earlier(target: Path) -> Path | None:
    """Give an existing result the first free name NAME.1.h5, NAME.2.h5 …; that name, None if there is no result."""
    return set_aside([target], target.stem).get(target) if is_there(target) else None


def set_aside(files: Sequence[Path], stem: str, beside: Sequence[Path] = ()) -> dict[Path, Path]:
    """Give files, whose names begin with a stem, the first free number behind it: NAME.1.h5, NAME.1.checkpoint.h5.

    beside: files that stay, or are not there, and whose names with that number are to be free, too. Returns old -> new names.
    OSError if one cannot be renamed; then all have their old names.
    """
    for k in itertools.count(1):
        names = {file: file.with_name(f"{stem}.{k}{file.name.removeprefix(stem)}") for file in (*files, *beside)}
        if any(map(os.path.lexists, names.values())):
            continue
        taken, renamed = [], {}
        try:
            for file in files:
                os.close(os.open(names[file], os.O_WRONLY | os.O_CREAT | os.O_EXCL))
                taken.append(names[file])
            for file in files:
                with suppress(FileNotFoundError):  # another run was faster
                    os.rename(file, names[file])
                    renamed[file] = names[file]
        except FileExistsError:
            continue
        except OSError:  # one is another user's, in a folder where only owners may rename: what belongs together stays so
            for file, name in renamed.items():
                if not os.path.lexists(file):
                    os.rename(name, file)
            raise
        finally:
            for name in set(taken) - set(renamed.values()):
                name.unlink()
        return renamed
    raise AssertionError  # there is always a free number


def publish(target: Path, content: bytes) -> tuple[int, int] | None:
    """Make the file `target` of this content, visible only when it is whole; None if there is one by now.

    Returns device and number of the file, which stay when another run renames it.
    """
    fresh = target.with_name(f".{target.name}.{os.getpid()}.new")
    fresh.unlink(missing_ok=True)  # of a program killed in the midst that had our number
    descriptor = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            status = os.fstat(descriptor)
        try:
            os.link(fresh, target)
        except FileExistsError:
            return None
        except OSError:  # no hard links here: the name is taken first, and empty for a moment
            try:
                os.close(os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            except FileExistsError:
                return None
            os.rename(fresh, target)
        return status.st_dev, status.st_ino
    finally:
        fresh.unlink(missing_ok=True)
