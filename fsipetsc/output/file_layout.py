"""How the files of a result are organised, and how they are written and read.

    NAME.parts/lock          held by the run that writes
    NAME.parts/000001.h5 …   pieces: some consecutive frames and steps
    NAME.h5                  the finished result, a piece with all frames and steps

A piece has

    about            JSON text of what is known of the run: format, version, header; at its end
                     summary and errors, too
    time             (k,) times of the frames [s]
    series/NAME      (m, …) a row for each step
    layer0/X         (n,) Lagrangian grid; of blocks (n, d), places of nodes in the reference map,
                     counted with axis 0 first. In the first piece with frames, perhaps in others
    layer0/FIELD     in NAME.h5: (k, n), of blocks (k, …, n_1, n_0); NaN outside the active part
    layer0/frames    in other pieces: (n, k c), for each point the c columns of each of k frames,
                     so that every rank writes its points as one part

The columns of a layer are its fields, then x where that is not a field. HDF5's metadata has
checksums (format of HDF5 1.10): a changed byte there is an error and not a crash.
"""

import io
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count, takewhile
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import h5py
import numpy as np

from fsipetsc.checks import Array
from fsipetsc.errors import FileError, FsiError, petsc_words, reason

FORMAT, VERSION = "fsipetsc result", 4
NAMES = "names"  # attribute of the group of series: their names
LIBVER = ("v110", "v110")


@contextmanager
def damage(path: str) -> Iterator[None]:
    """Any error while a file is read, whatever it contains, becomes a FileError of one line.

    But for FileNotFoundError: a piece may be gone because the pieces have become one file.
    """
    try:
        yield
    except (FileError, FileNotFoundError, MemoryError):
        raise
    except Exception as error:
        raise FileError(f"{path}: the file is damaged: {reason(error)}") from error


def open_h5(path: str | os.PathLike[str], mode: str = "r") -> h5py.File:
    """Open without file locks: a result may be looked at while its run goes on."""
    return h5py.File(path, mode, locking=False, libver=LIBVER if mode != "r" else None)


class _Memory(io.BytesIO):
    """A file in memory, as h5py's driver for Python's file objects wants it."""

    def truncate(self, size: int | None = None) -> int:
        length = self.tell() if size is None else size
        self.write(bytes(max(0, length - self.seek(0, os.SEEK_END))))
        return super().truncate(length)


def image(fill: Callable[[h5py.File], None]) -> bytes:
    """Return the content of a new HDF5 file that `fill` has filled."""
    memory = _Memory()
    with h5py.File(memory, "w", libver=LIBVER) as file:
        fill(file)
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
    except OSError:
        with suppress(OSError):
            draft.unlink()
        raise


def piece(folder: Path, number: int, ending: str = ".h5") -> Path:
    """Return the path of a piece, which are numbered from 1 on."""
    return folder / f"{number:06d}{ending}"


def pieces(folder: Path) -> list[Path]:
    """Return the finished pieces in their order, up to the first that is missing."""
    return [*takewhile(Path.exists, (piece(folder, k) for k in count(1)))]


def read_about(file: h5py.File) -> dict[str, Any]:
    """Return what is known of the run of a piece. FileError; any exception if it is damaged."""
    about: dict[str, Any] = json.loads(file["about"][()] if "about" in file else "{}")
    if about.get("format") != FORMAT:
        raise FileError(f"{file.filename}: is not a result of fsipetsc")
    if about["version"] != VERSION:
        said = f"has the file format {about['version']}, and this fsipetsc reads {VERSION}"
        raise FileError(f"{file.filename}: {said}")
    return {"summary": {}, "errors": {}, **about}


def read_piece(path: Path) -> tuple[dict[str, Any], Array, dict[str, Array], list[Array]]:
    """Return what is known of the run, times of frames, series, and grids of layers that are there.
    FileError; any exception tells what is not as it should be.
    """

    def numbers(found: h5py.Dataset, *shape: int | None) -> Array:
        """Return numbers of this shape, in which None is any length."""
        fits = all(n in (None, m) for n, m in zip(shape, found.shape))
        if found.dtype.kind not in "iuf" or len(shape) != found.ndim or not fits:
            raise ValueError(f"{found.name} has the shape {found.shape} and the type {found.dtype}")
        values: Array = found[...]
        return values

    with open_h5(path) as file:
        about = read_about(file)
        time, series, grids = numbers(file["time"], None), {}, []
        if "series" in file:
            group, steps = file["series"], len(numbers(file["series/t"], None))
            # a list: HDF5, asked for names, crashes where a byte of a larger group has changed
            for name in [name.decode() for name in group.attrs.get(NAMES, ())] or [*group]:
                series[name] = numbers(group[name], steps, *group[name].shape[1:2])
        for k, layer in enumerate(about["header"]["layers"] if "layer0/X" in file else ()):
            found, shape = file[f"layer{k}/X"], layer["shape"]
            X = numbers(found, *(shape if found.ndim == 1 else (math.prod(shape), len(shape))))
            if not np.isfinite(X).all() or (len(shape) == 1 and np.any(np.diff(X, axis=0) <= 0)):
                raise ValueError(f"the grid in layer{k} is not ascending numbers")
            grids.append(X)
        return about, time, series, grids


def columns_of(header: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return what columns of series may be of -> the names of these in a run."""
    layers, points = header["layers"], header.get("points", ())
    return {
        "interface": list(header.get("interfaces", ())),
        "gas": [layer["name"] for layer in layers if layer["kind"] == "fluid"],
        "layer": [layer["name"] for layer in layers],
        "face": list(header.get("faces", ())),
        "point": [f"{name} at {', '.join(f'{x:g}' for x in X)}" for name, X in points],
    }


def columns(layer: Mapping[str, Any]) -> tuple[str, ...]:
    """Return names of the stored columns of a layer of the header."""
    fields = tuple(layer["fields"])
    return fields if "x" in fields else (*fields, "x")


def beside(path: str | os.PathLike[str], ending: str) -> Path:
    """Return NAME with another ending for NAME.h5; a name without .h5 is NAME as it is."""
    path = Path(path)
    return path.with_name(f"{path.name.removesuffix('.h5')}{ending}")


def check_folder(path: str | os.PathLike[str]) -> None:
    """FileError, which names the file that is to be written, unless its directory takes files."""
    folder = os.path.dirname(os.path.realpath(path))
    try:
        TemporaryFile(dir=folder).close()
    except OSError as error:
        said = f"no file can be written in the directory {folder}: {error.strerror}"
        raise FileError(f"{os.fspath(path)}: {said}") from None


@contextmanager
def writing(target: Path, what: str = "the picture") -> Iterator[None]:
    """Make the directory of a file that is written within, and name the file in a FileError."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except Exception as error:  # of PETSc and HDF5, too
        if isinstance(error, FsiError):
            raise
        words = petsc_words(error) if hasattr(error, "ierr") else reason(error)
        words = getattr(error, "strerror", None) or words
        raise FileError(f"{target}: cannot write {what}: {words}") from error
