"""How the files of a result are organised, and how they are written and read.

    NAME.parts/lock          held by the run that writes
    NAME.parts/000001.h5 …   pieces: some consecutive frames and steps
    NAME.h5                  the finished result, a piece with all frames and steps

A piece has

    about            JSON text: format, version, header; at the end of a run summary and errors, too
    time             (k,) times of the frames [s]
    series/NAME      (m, …) a row for each step
    layer0/X         (n,) Lagrangian grid; of blocks (n, d), places of nodes in the reference map,
                     counted with axis 0 first. In the first piece with frames, perhaps in others
    layer0/FIELD     in NAME.h5: (k, n), of blocks (k, …, n_1, n_0); NaN outside the active part
    layer0/frames    in other pieces: (n, k c), for each point the c columns of each of k frames,
                     so that every rank writes its points as one part

The columns of a layer are its fields, then x where that is not a field. A changed byte of HDF5's
metadata, which has checksums (format of HDF5 1.10), is an error and not a crash.

A checkpoint, which is numbers and a text and never code, has

    about            JSON text: format, version, header, names of arrays
    arrays/NAME      each array
    sha256           of the text and the numbers
"""

import hashlib
import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import count, takewhile
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import h5py
import numpy as np

from fsipetsc.checks import Array
from fsipetsc.errors import FileError, FsiError, petsc_words, reason, short

#: what our files say of themselves
RESULT = {"format": "fsipetsc result", "version": 4}
CHECKPOINT = {"format": "fsipetsc checkpoint", "version": 12}
NAMES = "names"  # attribute of the group of series: their names
LIBVER = ("v110", "v110")


@contextmanager
def damage(path: str) -> Iterator[None]:
    """Any error while a file is read, whatever it contains, becomes a FileError of one line."""
    try:
        yield
    except (FileError, MemoryError):
        raise
    except FileNotFoundError:  # pieces have become one file, or another file has the name
        raise FileError(f"{path}: has changed since it was opened; open it again") from None
    except Exception as error:
        said = f"the file is damaged, or none of fsipetsc: {reason(error)}"
        raise FileError(f"{path}: {said}") from error


@contextmanager
def writing(target: Path, what: str = "the picture") -> Iterator[None]:
    """Make the directory of a file that is written within, and name the file in a FileError."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except FsiError:
        raise
    except Exception as error:  # of PETSc and HDF5, too
        words = petsc_words(error) if hasattr(error, "ierr") else reason(error)
        words = getattr(error, "strerror", None) or words
        raise FileError(f"{target}: cannot write {what}: {words}") from error


def check_folder(path: str | os.PathLike[str]) -> None:
    """FileError unless the directory of a file that is to be written takes files."""
    folder = os.path.dirname(os.path.realpath(path))
    try:
        TemporaryFile(dir=folder).close()
    except OSError as error:
        said = f"no file can be written in the directory {folder}: {error.strerror}"
        raise FileError(f"{os.fspath(path)}: {said}") from None


def open_h5(path: str | os.PathLike[str], mode: str = "r") -> h5py.File:
    """Open without file locks: a result may be looked at while its run goes on."""
    return h5py.File(path, mode, locking=False, libver=LIBVER if mode != "r" else None)


def stamp_of(file: h5py.File) -> tuple[int, ...]:
    """By which an open file is known that nobody has replaced or changed."""
    found = os.fstat(file.id.get_vfd_handle())
    return found.st_ino, found.st_mtime_ns, found.st_size


@contextmanager
def opened(path: Path, kind: Mapping[str, Any]) -> Iterator[tuple[h5py.File, dict[str, Any]]]:
    """Open a file of this kind, and read what it says about itself; any error is a FileError."""
    called = short(path)
    if not path.is_file():  # a pipe would wait for a writer
        what = "is no regular file" if path.exists() else "there is no such file"
        raise FileError(f"{called}: {what}")
    with damage(called), open_h5(path) as file:
        about = json.loads(file["about"][()] if "about" in file else "{}")
        if not kind.items() <= about.items():
            what = f"{kind['format'].split()[-1]} of fsipetsc in format {kind.get('version')}"
            of = about.get("format", "").split()[-1:]
            own = f"a {of[0]} in format {about['version']}" if of else "a file of others"
            raise FileError(f"{called}: is not a {what}, but {own}")
        yield file, about


def image(content: Mapping[str, Any], most: int = 0) -> bytes:
    """Return an HDF5 file with these datasets. A tuple is the shape of one that is still to be
    filled, in chunks of at most so many numbers; 0: not in chunks.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=LIBVER) as file:
        if names := [name[7:] for name in content if name.startswith("series/")]:
            file.create_group("series", track_order=True).attrs[NAMES] = np.array(names, "S")
        for name, of in content.items():
            if isinstance(of, tuple):
                rows = max(1, min(of[0], most // max(1, int(np.prod(of[1:])))))
                file.create_dataset(name, of, "f8", chunks=(rows, *of[1:]) if most else None)
            else:
                file[name] = of
    return memory.getvalue()


def publish(draft: Path, path: Path) -> None:
    """Give a file that is whole its name. OSError."""
    with open(draft, "rb") as file:
        os.fsync(file.fileno())
    os.replace(draft, path)


def put(path: Path, content: bytes) -> None:
    """Make this the content of a file. OSError: then what was there is unchanged."""
    draft = path.with_name(f".{path.name}.new")
    try:
        draft.write_bytes(content)
        publish(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def beside(path: str | os.PathLike[str], ending: str) -> Path:
    """Return NAME with another ending for NAME.h5; a name without .h5 is NAME as it is."""
    return Path(f"{Path(path)}".removesuffix(".h5") + ending)


def piece(folder: Path, number: int) -> Path:
    """Return the path of a piece, which are numbered from 1 on."""
    return folder / f"{number:06d}.h5"


def pieces(folder: Path) -> list[Path]:
    """Return the finished pieces in their order, up to the first that is missing."""
    return [*takewhile(Path.exists, (piece(folder, k) for k in count(1)))]


def numbers(found: h5py.Dataset, rows: int | None = None) -> Array:
    """Return numbers in one dimension or two, with so many rows if that is known. ValueError."""
    if found.dtype.kind not in "iuf" or found.ndim not in (1, 2) or rows not in (None, len(found)):
        raise ValueError(f"{found.name} has the shape {found.shape} and the type {found.dtype}")
    return np.array(found)


class CheckpointError(FileError):
    """A checkpoint could not be written; the result may well be."""


def _sum(text: bytes, arrays: Mapping[str, Array]) -> bytes:
    """Return the checksum of what a checkpoint holds."""
    found = hashlib.sha256(text)
    for array in arrays.values():
        found.update(np.ascontiguousarray(array))
    return found.hexdigest().encode()


def read_checkpoint(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return header and arrays of a checkpoint. FileError, also if they are not as written."""
    with opened(Path(path), CHECKPOINT) as (file, about):
        # HDF5, asked for names, crashes where a byte of many names has changed
        arrays = {name: file[f"arrays/{name}"][...] for name in about["arrays"]}
        if file["sha256"][()] != _sum(file["about"][()], arrays):
            raise FileError(f"{path}: the file is damaged")
        return about["header"], arrays


def write_checkpoint(path: str | Path, header: dict[str, Any], arrays: Mapping[str, Any]) -> None:
    """Make this the checkpoint of a name. CheckpointError: then what was there is unchanged."""
    target = Path(os.path.realpath(path))
    text = json.dumps({**CHECKPOINT, "header": header, "arrays": [*arrays]}).encode()
    about = {"about": np.bytes_(text), "sha256": np.bytes_(_sum(text, arrays))}
    try:
        put(target, image(about | {f"arrays/{name}": of for name, of in arrays.items()}))
    except OSError as error:
        kept = f"; the one before is kept in {target}" if target.is_file() else ""
        said = f"{path}: the checkpoint cannot be written: {error.strerror or error}{kept}"
        raise CheckpointError(said) from None
