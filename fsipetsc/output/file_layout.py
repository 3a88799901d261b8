"""How the files of a result are organised, and how they are written and read.

    NAME.parts/lock          held by the run that writes (see `writer`)
    NAME.parts/header.json   what is known of the run: format, version, header, summary, errors
    NAME.parts/000001.h5 …   pieces: some consecutive frames and steps
    NAME.h5                  the finished result, a piece with all frames and steps

A piece has

    about            the text of header.json; in NAME.h5 only
    attribute first  numbers of its first frame and step; none in NAME.h5. What pieces before have
                     from there on, a restart has given up
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
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import h5py

from fsipetsc.errors import FileError

FORMAT, VERSION = "fsipetsc result", 4
LIBVER = ("v110", "v110")


@contextmanager
def damage(path: str, what: str = "") -> Iterator[None]:
    """Any error while a file is read, whatever it contains, becomes a FileError of one line.

    But for FileNotFoundError: a piece may be gone because the pieces have become one file.
    """
    try:
        yield
    except (FileError, FileNotFoundError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())
        if not isinstance(error, (OSError, ValueError)):
            reason = f"{type(error).__name__}: {reason}"
        of = f"{what} cannot be read: " if what else ""
        raise FileError(f"{path}: {of}the file is damaged: {reason}") from error


def open_h5(path: str | os.PathLike[str], mode: str = "r") -> h5py.File:
    """Open without file locks: a result may be looked at while its run goes on."""
    return h5py.File(path, mode, locking=False, libver=LIBVER if mode != "r" else None)


class _Image(io.BytesIO):
    """A file in memory, as h5py's driver for Python's file objects wants it."""

    def truncate(self, size: int | None = None) -> int:
        length = self.tell() if size is None else size
        self.write(bytes(max(0, length - self.seek(0, os.SEEK_END))))
        return super().truncate(length)


@contextmanager
def in_memory() -> Iterator[tuple[h5py.File, io.BytesIO]]:
    """A new HDF5 file, and what has its content, `getvalue()`, when the context has ended."""
    image = _Image()
    with h5py.File(image, "w", libver=LIBVER) as file:
        yield file, image


def put(path: Path, content: bytes) -> None:
    """Make this the content of a file. OSError: then what was there is unchanged."""
    draft = path.with_name(f".{path.name}.new")
    try:
        with open(draft, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, path)
    except OSError:
        with suppress(OSError):
            draft.unlink()
        raise


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
    except OSError as error:
        raise FileError(f"{target}: cannot write {what}: {error.strerror or error}") from error
