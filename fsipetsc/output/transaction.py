"""Changes to an HDF5 file that become visible all at once, so that a killed program leaves no half-changed file behind.

HDF5 updates a file in many small writes; between the first and the last of them it cannot be read. Here what overwrites
something is collected in memory; what is new goes to the end of the file at once, where nobody looks yet. To apply the
changes, the bytes that they overwrite are first saved beside the file (FILE.undo), which is removed when all is written.
Whoever finds an .undo file reads the file as it was before.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

_ENTRY = struct.Struct("<qq")  # offset and length, before the bytes themselves


@contextmanager
def changes(path: str | os.PathLike[str]) -> Iterator[h5py.File]:
    """Open a file to change it. At the end all changes are applied; none of them if there was an exception."""
    raw = _Overlay(path, os.O_RDWR, [])
    try:
        # chunks are written whole or not read again: HDF5's cache for them would only be one more copy
        with h5py.File(raw, "r+", rdcc_nbytes=0) as file:
            yield file
        raw.apply(undo_path(path))
    except BaseException:
        raw.forget()
        raise
    finally:
        raw.close()


def open_unchanged(path: str | os.PathLike[str]) -> h5py.File | None:
    """The file as it was before changes that were interrupted; None if there are no such changes."""
    try:
        saved = undo_path(path).read_bytes()
    except OSError:
        return None
    writes, position = [], 0
    while position < len(saved):
        offset, length = _ENTRY.unpack_from(saved, position)
        position += _ENTRY.size + length
        writes.append((offset, saved[position - length : position]))
    return h5py.File(_Overlay(path, os.O_RDONLY, writes), "r")


def undo_path(path: str | os.PathLike[str]) -> Path:
    return Path(f"{os.fspath(path)}.undo")


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

    def __init__(self, path: str | os.PathLike[str], flags: int, writes: list[tuple[int, bytes]]) -> None:
        self._descriptor = os.open(path, flags)
        self._size = self._size_before = os.fstat(self._descriptor).st_size
        self._writes = writes  # in their order: later ones cover earlier ones
        self._position = 0
        self._error: BaseException | None = None
        self._safe = False  # the file can be read as it was or as it will be, whatever comes

    def apply(self, undo: Path) -> None:
        """Write the pieces into the file. Raises what was raised when something was written to the end of it."""
        if self._error is not None:
            raise self._error
        saved = bytearray()
        for offset, data in self._writes:
            before = os.pread(self._descriptor, len(data), offset)  # nothing, if after the end
            saved += _ENTRY.pack(offset, len(before)) + before
        temporary = undo.with_suffix(".tmp")
        try:
            temporary.write_bytes(saved)
        except OSError:
            temporary.unlink()
            raise
        self._safe = True
        temporary.rename(undo)
        for offset, data in self._writes:
            self._put(data, offset)
        if self._size > os.fstat(self._descriptor).st_size:
            os.ftruncate(self._descriptor, self._size)
        undo.unlink()
        os.ftruncate(self._descriptor, self._size)  # only now may the file become smaller
        leave_to_disk(self._descriptor, self._size_before)

    def forget(self) -> None:
        """Take back what was written to the end of the file, as long as nothing refers to it."""
        with suppress(OSError):
            if not self._safe and os.fstat(self._descriptor).st_size > self._size_before:
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
