"""The file of a checkpoint: numbers and a text, never code; what was written whole is read.

    the first 512 bytes   "fsipetsc checkpoint 5", the SHA-256 and the length of all that follows
    from there on         an HDF5 file: /header, JSON text, and a dataset arrays/NAME for each array

HDF5 passes over the first 512 bytes, so h5dump and h5py open the file as it is. The checksum is of
every byte. A checkpoint is written under another name and renamed when it is whole.
"""

import hashlib
import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import check_folder, damage, in_memory, put

Array = np.ndarray[Any, Any]
_MAGIC = b"fsipetsc checkpoint "
VERSION = 5
_HEAD = 512  # bytes: HDF5 looks for its own beginning at this place, too


class CheckpointError(FileError):
    """A checkpoint could not be written; the result may well be."""


class Arrays(dict[str, Array]):
    """Name -> array of a checkpoint. FileError for one that is missing."""

    def __init__(self, path: str, file: h5py.File) -> None:
        super().__init__({name: found[...] for name, found in file.get("arrays", {}).items()})
        self._path = path

    def __missing__(self, name: str) -> Array:
        raise FileError(f"{self._path}: the checkpoint is damaged: it has no array {name}")


def unpack(content: bytes, name: str) -> tuple[dict[str, Any], Arrays]:
    """Header and arrays in a file's content. FileError if a byte is not as written."""
    if not content.startswith(_MAGIC):
        raise FileError(f"{name}: is not a checkpoint of fsipetsc")
    head, body = content[:_HEAD], content[_HEAD:]
    if head != head_of(body):
        raise FileError(f"{name}: the checkpoint is damaged, or of another version of fsipetsc")
    with damage(name), h5py.File(io.BytesIO(body), "r") as file:
        return json.loads(file["header"].asstr()[()]), Arrays(name, file)


def head_of(body: bytes) -> bytes:
    """What a checkpoint begins with: version, checksum and length of what follows."""
    sha = hashlib.sha256(body).hexdigest()
    return f"{_MAGIC.decode()}{VERSION}\n{sha}\n{len(body)}".encode().ljust(_HEAD, b"\0")


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], Arrays]:
    """Header and arrays of a checkpoint. FileError."""
    path = Path(path)
    try:
        content = b"" if path.exists() and not is_one(path) else path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    return unpack(content, str(path))


def is_one(path: Path) -> bool:
    """Whether there is a file that begins as a checkpoint does, whole or damaged. OSError."""
    if not path.is_file():  # a pipe would wait for a writer
        return False
    with path.open("rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def check_place(path: str | os.PathLike[str]) -> None:
    """FileError without a folder that can be written to, or where something else has the name."""
    check_folder(path)
    target = Path(os.path.realpath(path))
    try:
        empty = not target.exists() or (target.is_file() and not target.stat().st_size)
        if not empty and not is_one(target):
            raise FileError(f"{path}: exists and is not a checkpoint of fsipetsc")
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None


def write(
    path: str | os.PathLike[str], header: Mapping[str, Any], arrays: Mapping[str, Array]
) -> None:
    """Make this the checkpoint of a name. CheckpointError: then what was there is unchanged."""
    target = Path(os.path.realpath(path))
    with in_memory() as (file, image):
        file["header"] = json.dumps(header)
        for name, array in arrays.items():
            file[f"arrays/{name}"] = array
    try:
        put(target, head_of(image.getvalue()) + image.getvalue())
    except OSError as error:
        kept = f"; the one before is kept in {target}" if target.is_file() else ""
        reason = error.strerror or error
        raise CheckpointError(f"{path}: the checkpoint cannot be written: {reason}{kept}") from None
