"""The file of a checkpoint: numbers and a text, never code; what was written whole is read, and nothing else.

    the first 512 bytes   the words "fsipetsc checkpoint 1", the SHA-256 and the length of all that follows, in letters
    from there on         an HDF5 file: /header, JSON text, and a dataset for each array

HDF5 passes over the first 512 bytes, so h5dump and h5py open the file as it is. The checksum holds every byte.

A checkpoint is written under another name, synchronised, and renamed; the one before stays as NAME.previous.h5. What
stands at these names and is no checkpoint is never touched.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
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
    if len(fields) == 5 and fields[2].isdigit() and int(fields[2]) > VERSION:
        version = int(fields[2])
        raise FileError(
            f"{name}: is a checkpoint of format {version}, which this fsipetsc does not know, or damaged"
        )
    if head != _head(body):
        length = fields[4] if len(fields) == 5 else b""
        cut = length.isdigit() and int(length) > len(body)
        what = (
            f"it ends after {len(content)} of {int(length) + _HEAD} bytes"
            if cut
            else "its checksum is another one"
        )
        raise FileError(f"{name}: the checkpoint is damaged: {what}")
    try:
        with h5py.File(io.BytesIO(body), "r") as file:
            arrays = {key: dataset[...] for key, dataset in file.get("arrays", {}).items()}
            header = json.loads(file["header"].asstr()[()])
        if any(array.dtype.kind not in "fiu" for array in arrays.values()) or not isinstance(
            header, dict
        ):
            raise ValueError("an array holds no numbers, or the header is no table")
        return Checkpoint(header, arrays)
    except Exception as error:  # its checksum is right: somebody has made it so
        raise FileError(
            f"{name}: is not a checkpoint of fsipetsc: {' '.join(str(error).split())}"
        ) from None


def _head(body: bytes) -> bytes:
    lines = (
        b"%s%d" % (_MAGIC, VERSION),
        hashlib.sha256(body).hexdigest().encode(),
        b"%d" % len(body),
    )
    return b"\n".join(lines).ljust(_HEAD, b"\0")


def previous(path: str | os.PathLike[str]) -> Path:
    """Where the checkpoint before the last one is: NAME.previous.h5 for NAME.h5."""
    path = Path(path)
    return path.with_name(f"{path.stem}.previous{path.suffix}")


def read(path: str | os.PathLike[str]) -> Checkpoint:
    """The checkpoint in a file. FileError."""
    name = os.fspath(path)
    try:
        descriptor = os.open(
            path, os.O_RDONLY | os.O_NONBLOCK
        )  # a pipe would wait for somebody who writes
        with os.fdopen(descriptor, "rb") as file:
            start = file.read(len(_MAGIC))
            content = start + (file.read() if start == _MAGIC else b"")  # of what is ours
    except FileNotFoundError:
        hint = f"; the one before it is there: {previous(path)}" if previous(path).is_file() else ""
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
    try:
        draft_of(path).touch()
        draft_of(path).unlink()
    except OSError as error:
        raise FileError(f"{path}: no checkpoint can be written there: {error.strerror}") from None


def _in_the_way(target: Path) -> str:
    """What stands at the name, or at that of the one before, and is none of ours, in words; "" if nothing does."""
    for file in (target, previous(target)):
        if os.path.lexists(file) and not file.is_file():
            return f"{file}: exists and is not a regular file"
        if file.exists() and file.stat().st_size and not is_one(file):
            return f"{file}: exists and is not a checkpoint of fsipetsc"
    return ""


def draft_of(path: str | os.PathLike[str]) -> Path:
    """The name under which a checkpoint is written."""
    target = Path(os.path.realpath(path))
    return target.with_name(f".{target.name}.new")


def write(path: str | os.PathLike[str], content: bytes) -> None:
    """Make this the newest checkpoint of a name, and what was there the one before. CheckpointError: then none has changed."""
    target, draft = Path(os.path.realpath(path)), draft_of(path)
    if fault := _in_the_way(target):
        raise CheckpointError(f"{path}: the checkpoint cannot be written: {fault}")
    try:
        with open(draft, "wb") as file:
            _put(file.fileno(), content)
        if target.exists():
            os.replace(target, previous(target))
        os.replace(draft, target)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        kept = f"; the one before is kept in {target}" if target.is_file() else ""
        raise CheckpointError(
            f"{path}: the checkpoint cannot be written: {error.strerror or error}{kept}"
        ) from None


def _put(descriptor: int, content: bytes) -> None:
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(descriptor, rest) :]
    os.fsync(descriptor)
