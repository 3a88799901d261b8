"""Changes to an HDF5 file that are made all at once at their end, or not at all if something fails before.

HDF5 updates a file in many small writes. Here what overwrites something is collected in memory and written when HDF5 is
done; what is new goes to the end of the file at once, where nobody looks yet. Other programs that read the file meanwhile
may meet it for a fraction of a millisecond between two of those writes; fsipetsc does not (see `commits`).
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import h5py


@contextmanager
def changes(path: str | os.PathLike[str]) -> Iterator[h5py.File]:
    """Open a file to change it. At the end all changes are applied; none of them if there was an exception."""
    raw = _Overlay(path)
    try:
        # chunks are written whole or not read again: HDF5's cache for them would only be one more copy
        with h5py.File(raw, "r+", rdcc_nbytes=0) as file:
            yield file
        raw.apply()
    except BaseException:
        raw.forget()
        raise
    finally:
        raw.close()


def ensure_space(path: str | os.PathLike[str], nbytes: int) -> None:
    """Allocate nbytes after the end of the file; HDF5 uses what it needs of them and gives the rest back.

    If the space ran out under HDF5, it could not even close the file, and the program would end in a crash.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(descriptor, os.fstat(descriptor).st_size, nbytes)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):  # others: this file system cannot allocate
            raise
    finally:
        os.close(descriptor)


def leave_to_disk(file: int | str | os.PathLike[str], first: int) -> None:
    """Let the disk begin with what is new in a file from byte ``first`` on; what it has already need not stay in memory.

    Who flushes the file later waits the less, and what is written next finds memory that is in use: a result is written
    once, and fresh memory costs more than the writing.
    """
    if not hasattr(os, "posix_fadvise"):
        return
    with suppress(OSError):  # it is no more than advice
        descriptor = file if isinstance(file, int) else os.open(file, os.O_RDONLY)
        try:
            os.posix_fadvise(descriptor, first, 0, os.POSIX_FADV_DONTNEED)
        finally:
            if descriptor is not file:
                os.close(descriptor)


class _Overlay(io.RawIOBase):
    """A file of which some pieces are replaced by others in memory; h5py's driver for Python file objects uses it."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._descriptor = os.open(path, os.O_RDWR)
        self._size = self._size_before = os.fstat(self._descriptor).st_size
        self._writes: list[tuple[int, bytes]] = []  # in their order: later ones cover earlier ones
        self._position = 0
        self._error: BaseException | None = None
        self._applied = False  # or begun

    def apply(self) -> None:
        """Write the pieces into the file. Raises what was raised when something was written to the end of it."""
        if self._error is not None:
            raise self._error
        self._applied = True
        for offset, data in self._writes:
            self._put(data, offset)
        os.ftruncate(self._descriptor, self._size)
        leave_to_disk(self._descriptor, self._size_before)

    def forget(self) -> None:
        """Take back what was written to the end of the file, as long as nothing refers to it."""
        with suppress(OSError):
            if not self._applied and os.fstat(self._descriptor).st_size > self._size_before:
                os.ftruncate(self._descriptor, self._size_before)

    def _put(self, data: bytes | memoryview, offset: int) -> None:
        if os.pwrite(self._descriptor, data, offset) != len(data):
            raise OSError(f"{len(data)} bytes could not be written")

    # what HDF5 asks of a file

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self._position = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}[whence]
        return self._position

    def tell(self) -> int:
        return self._position

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        target, start = memoryview(buffer).cast("B"), self._position
        done = os.preadv(self._descriptor, [target], start)
        target[done:] = bytes(len(target) - done)
        for offset, data in self._writes:
            first, last = max(offset, start), min(offset + len(data), start + len(target))
            if first < last:
                target[first - start : last - start] = data[first - offset : last - offset]
        self._position += len(target)
        return len(target)

    def write(self, data: memoryview) -> int:  # type: ignore[override]
        whole = memoryview(data).cast("B")
        old = max(0, min(len(whole), self._size_before - self._position))
        if old:
            self._writes.append((self._position, bytes(whole[:old])))
        if old < len(whole) and self._error is None:
            try:
                self._put(whole[old:], self._position + old)
            except BaseException as error:  # HDF5 cannot go on from it, not even close the file: it is raised later
                self._error = error
        self._position += len(whole)
        self._size = max(self._size, self._position)
        return len(whole)

    def truncate(self, size: int | None = None) -> int:
        self._size = self._position if size is None else size
        return self._size

    def flush(self) -> None:
        """Nothing to do before `apply`."""

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def close(self) -> None:
        if not self.closed:
            super().close()
            with suppress(OSError):
                os.close(self._descriptor)
