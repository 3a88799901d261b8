"""The file of a checkpoint: numbers and a text, never code; what was written whole is read.

    the first 512 bytes   "fsipetsc checkpoint 6", the SHA-256 and the length of all that follows
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

from fsipetsc.checks import Array
from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import damage, image, put

_MAGIC = b"fsipetsc checkpoint "
VERSION = 6
_HEAD = 512  # bytes: HDF5 looks for its own beginning at this place, too


class CheckpointError(FileError):
    """A checkpoint could not be written; the result may well be."""


def head_of(body: bytes) -> bytes:
    """Return what a checkpoint begins with: version, checksum and length of what follows."""
    sha = hashlib.sha256(body).hexdigest()
    return f"{_MAGIC.decode()}{VERSION}\n{sha}\n{len(body)}".encode().ljust(_HEAD, b"\0")


def is_one(path: Path) -> bool:
    """Tell whether there is a file that begins as a checkpoint does, whole or damaged. OSError."""
    if not path.is_file():  # a pipe would wait for a writer
        return False
    with path.open("rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return header and arrays of a checkpoint. FileError, also if a byte is not as written."""
    path = Path(path)
    try:
        if path.exists() and not is_one(path):
            raise FileError(f"{path}: is not a checkpoint of fsipetsc")
        content = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    body = content[_HEAD:]
    if content[:_HEAD] != head_of(body):
        raise FileError(f"{path}: the checkpoint is damaged, or of another version of fsipetsc")
    with damage(str(path)), h5py.File(io.BytesIO(body), "r") as file:
        arrays = {key: found[...] for key, found in file.get("arrays", {}).items()}
        return json.loads(file["header"].asstr()[()]), arrays


def write(
    path: str | os.PathLike[str], header: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
    """Make this the checkpoint of a name. CheckpointError: then what was there is unchanged."""
    found = {"header": json.dumps(header), **{f"arrays/{k}": of for k, of in arrays.items()}}
    target, body = Path(os.path.realpath(path)), image(found)
    try:
        put(target, head_of(body) + body)
    except OSError as error:
        kept = f"; the one before is kept in {target}" if target.is_file() else ""
        said = f"{path}: the checkpoint cannot be written: {error.strerror or error}{kept}"
        raise CheckpointError(said) from None
