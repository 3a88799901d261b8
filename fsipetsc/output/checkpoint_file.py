"""The file of a checkpoint: numbers and a text, never code; what was written whole is read, and nothing else.

    the first 512 bytes   the words "fsipetsc checkpoint 1", the SHA-256 and the length of all that follows, in letters
    from there on         an HDF5 file: /header, JSON text, and a dataset for each array

HDF5 passes over the first block, so h5dump and h5py open the file as it is. Before HDF5 sees a byte of it the checksum is
compared: each byte of the file, those of the first block among them, is held by it.

A checkpoint is written beside the one that is there, synchronised, and then takes its name; the one before stays as
NAME.previous.h5. The name always leads to a whole one, whenever the program is killed or the disk is full. Where the system has
files without a name (Linux, most of its file systems) one that is not finished leaves nothing behind. What stands at these
names and is no checkpoint is never touched.
"""

from __future__ import annotations

import errno
import glob
import hashlib
import io
import json
import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.places import check_folder

Array = np.ndarray[Any, Any]
_MAGIC = b"fsipetsc checkpoint "
VERSION = 1
_HEAD = 512  # bytes: HDF5 looks for its own beginning at this place, too


class CheckpointError(FileError):
    """A checkpoint could not be written; the result may well be."""


class Checkpoint(NamedTuple):
    """What a checkpoint says: header, as JSON has it, and arrays by name."""

    header: dict[str, Any]
    arrays: dict[str, Array]


def pack(checkpoint: Checkpoint) -> bytes:
    """The content of the file."""
    with h5py.File("checkpoint", "w", driver="core", backing_store=False) as file:
        file["header"] = json.dumps(checkpoint.header)
        for name, array in checkpoint.arrays.items():
            file.create_dataset(f"arrays/{name}", data=array)
        file.flush()
        body = file.id.get_file_image()
    return _head(body) + body


def unpack(content: bytes, name: str) -> Checkpoint:
    """The checkpoint of a file's content. FileError, which says name, if a byte is not as it was written."""
    if not content.startswith(_MAGIC):
        raise FileError(f"{name}: is not a checkpoint of fsipetsc")
    head, body = content[:_HEAD], content[_HEAD:]
    fields = head.rstrip(b"\0").split()
    if len(fields) == 5 and fields[2].isdigit() and fields[2] != b"%d" % VERSION and int(fields[2]) > VERSION:
        version = int(fields[2])
        raise FileError(f"{name}: is a checkpoint of format {version}, which this fsipetsc does not know, or damaged")
    if head != _head(body):
        length = fields[4] if len(fields) == 5 else b""
        cut = length.isdigit() and int(length) > len(body)
        what = f"it ends after {len(content)} of {int(length) + _HEAD} bytes" if cut else "its checksum is another one"
        raise FileError(f"{name}: the checkpoint is damaged: {what}")
    try:
        with h5py.File(io.BytesIO(body), "r") as file:
            group = _own(file, "arrays", h5py.Group) if "arrays" in set(file) else {}
            arrays = {key: _numbers(group, key) for key in group}
            return Checkpoint(json.loads(_own(file, "header", h5py.Dataset).asstr()[()]), arrays)
    except (KeyError, OSError, RuntimeError, TypeError, ValueError) as error:  # its checksum is right: somebody has made it so
        raise FileError(f"{name}: is not a checkpoint of fsipetsc: {' '.join(str(error).split())}") from None


def _numbers(group: h5py.Group, key: str) -> Array:
    """A dataset of this file that holds numbers, not texts or references. ValueError."""
    found = _own(group, key, h5py.Dataset)
    if found.dtype.kind not in "fiu":
        raise ValueError(f"{key} holds no numbers")
    return found[...]


def _own(group: h5py.Group, key: str, kind: type) -> Any:
    """What a group has by this name, if it lies in this file, and is of this kind: no link leads out of it. ValueError."""
    found = group[key] if isinstance(group.get(key, getlink=True), h5py.HardLink) else None
    if not isinstance(found, kind) or (isinstance(found, h5py.Dataset) and (found.external or found.is_virtual)):
        raise ValueError(f"{key} is not what a checkpoint has, in this file")
    return found


def _head(body: bytes) -> bytes:
    return b"\n".join([b"%s%d" % (_MAGIC, VERSION), hashlib.sha256(body).hexdigest().encode(), b"%d" % len(body)]).ljust(
        _HEAD, b"\0"
    )


def previous(path: str | os.PathLike[str]) -> Path:
    """Where the checkpoint before the last one is: NAME.previous.h5 for NAME.h5."""
    path = Path(path)
    return path.with_name(f"{path.stem}.previous{path.suffix}")


def read(path: str | os.PathLike[str]) -> Checkpoint:
    """The checkpoint in a file. FileError."""
    name = os.fspath(path)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would wait for somebody who writes
        with os.fdopen(descriptor, "rb") as file:
            start = file.read(len(_MAGIC))
            content = start + (file.read() if start == _MAGIC else b"")  # of what is ours
    except FileNotFoundError:
        there = previous(path).is_file()
        hint = f"; the one before it is there: {previous(path)}" if there else ""
        raise FileError(f"{name}: there is no such file{hint}") from None
    except OSError as error:
        raise FileError(f"{name}: cannot be read: {error.strerror}") from None
    return unpack(content, name)


def is_one(path: Path) -> bool:
    """Whether a file begins as a checkpoint does, whole or damaged; not if it cannot be read."""
    with suppress(OSError):
        if path.is_file():  # a pipe would wait for somebody who writes
            with path.open("rb") as file:
                return file.read(len(_MAGIC)) == _MAGIC
    return False


def check_place(path: str | os.PathLike[str]) -> None:
    """FileError where no checkpoint could be written, as far as that can be known before."""
    target = Path(os.path.realpath(path))
    check_folder(path, target.parent)
    if fault := _in_the_way(target):
        raise FileError(f"{fault}: no checkpoint can be written there")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise FileError(f"{path}: the directory {target.parent} is not writable")


def _in_the_way(target: Path) -> str:
    """What stands at the name, or at that of the one before, and is none of ours, in words; "" if nothing does.

    Whole or damaged, a checkpoint begins as such; a file without a byte is nothing that could be lost.
    """
    for file in (target, previous(target)):
        if not os.path.lexists(file):
            continue
        if not file.is_file():
            return f"{file}: exists and is not a regular file"
        try:
            with file.open("rb") as there:
                start = there.read(len(_MAGIC))
        except OSError as error:
            return f"{file}: exists and cannot be read ({error.strerror})"
        if start not in (b"", _MAGIC):
            return f"{file}: exists and is not a checkpoint of fsipetsc"
    return ""


def write(path: str | os.PathLike[str], content: bytes) -> None:
    """Make this the newest checkpoint of a name, and what was there the one before. CheckpointError: then none has changed."""
    target = Path(os.path.realpath(path))
    if fault := _in_the_way(target):
        raise CheckpointError(f"{path}: the checkpoint cannot be written: {fault}")
    fresh = _passing(target)
    try:
        fresh.unlink(missing_ok=True)
        descriptor, named = _open(fresh)
        try:
            _put(descriptor, content)
            if not named:
                _give_name(descriptor, fresh)
        finally:
            os.close(descriptor)
        _keep(target)
        os.replace(fresh, target)
        _synchronise(target.parent)
    except OSError as error:
        tidy(target)
        kept = f"; the one before is kept in {target}" if target.is_file() else ""
        raise CheckpointError(f"{path}: the checkpoint cannot be written: {error.strerror or error}{kept}") from None


def tidy(path: str | os.PathLike[str]) -> None:
    """Remove what a program of this host that was killed at the wrong moment may have left beside a checkpoint, and our own."""
    target = Path(os.path.realpath(path))
    for name in (target.name, previous(target).name):
        start = f".{name}.{socket.gethostname()}."
        for left in target.parent.glob(f"{glob.escape(start)}*.new"):
            number = left.name[len(start) : -len(".new")]
            if number.isdecimal() and (int(number) == os.getpid() or _is_gone(int(number))):
                with suppress(OSError):
                    left.unlink()


def _passing(target: Path) -> Path:
    """A name for a moment, which no other run has."""
    return target.with_name(f".{target.name}.{socket.gethostname()}.{os.getpid()}.new")


def _is_gone(number: int) -> bool:
    """Whether no process has this number."""
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):  # somebody else's
        return False
    return False


def _open(fresh: Path) -> tuple[int, bool]:
    """(descriptor, whether it has that name yet) of a new file."""
    if hasattr(os, "O_TMPFILE"):
        with suppress(OSError):  # not on all file systems
            return os.open(fresh.parent, os.O_TMPFILE | os.O_WRONLY, 0o666), False
    return os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), True


def _put(descriptor: int, content: bytes) -> None:
    rest = memoryview(content)
    while rest:
        written = os.write(descriptor, rest)
        if written <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        rest = rest[written:]
    os.fsync(descriptor)


def _give_name(descriptor: int, fresh: Path) -> None:
    folder = os.open(fresh.parent, os.O_RDONLY)
    try:  # with a folder's descriptor Python asks the system to follow the link
        os.link(f"/proc/self/fd/{descriptor}", fresh.name, src_dir_fd=folder, dst_dir_fd=folder, follow_symlinks=True)
    finally:
        os.close(folder)


def _keep(target: Path) -> None:
    """Let the present checkpoint be the one before, too."""
    if not target.exists():
        return
    kept = previous(target)
    passing = _passing(kept)
    passing.unlink(missing_ok=True)
    try:
        os.link(target, passing)
    except OSError:  # no hard links here: for a moment there is none of the name
        os.replace(target, kept)
        return
    os.replace(passing, kept)


def _synchronise(folder: Path) -> None:
    with suppress(OSError):  # not all file systems can
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
