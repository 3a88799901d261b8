"""Where the numbers of a result come from: NAME.h5, or the pieces of a run that goes on or was killed.

What is asked of the files is checked, for they may be damaged.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output import file_layout, pieces
from fsipetsc.output.checkpoint_file import is_one

Array = np.ndarray[Any, Any]
_MOST_COMPRESSED = 1000  # times: a dataset that claims more than that of the file is damaged


class Damaged(Exception):
    """A part of a result is not what it should be; says which part, and why."""


@contextmanager
def damage(path: str, what: str = "") -> Iterator[None]:
    """Whatever goes wrong while a file is read says that it is damaged: there is no end to what it may contain then."""
    try:
        yield
    except FileError:
        raise
    except MemoryError as error:
        raise FileError(f"{path}: {what or 'its content'} does not fit into memory") from error
    except Exception as error:
        of = f"{what} cannot be read: " if what else ""
        reason = " ".join(str(error).split())
        if not isinstance(error, (Damaged, OSError, ValueError)):
            reason = f"{type(error).__name__}: {reason}"
        closed = ", or was closed before" if what else ""
        raise FileError(f"{path}: {of}the file is damaged{closed}: {reason}") from error


class Frames:
    """Some consecutive frames of a layer, in one dataset.

    X: (n,) its grid, of blocks numbers of points, with their places, (n, d), else None; place: of it in the largest grid.
    """

    def __init__(
        self, first: int, count: int, dataset: Dataset, X: Array, places: Array | None
    ) -> None:
        self.first, self.count, self.dataset, self.X, self.places = first, count, dataset, X, places
        self.place = slice(0, len(X))


class Dataset:
    """Numbers in one of the files of a source; they are read when asked for. rows: where they are in the whole result."""

    def __init__(
        self, source: Source, path: Path, found: h5py.Dataset, rows: slice = slice(None)
    ) -> None:
        self._source, self._path, self._rows = source, path, rows
        self.name, self.shape = found.name, found.shape

    def __getitem__(self, key: Any) -> Array:
        file = self._source.open(self._path)
        values = file[self.name][key]
        return values if file.filename == str(self._path) else values[self._rows]


class Source:
    """The result of a name, as it was when it was opened. FileError where there is none. name: in messages.

    header, summary, errors   as they were given
    complete                  whether the run came to an end
    series                    names of what is known of each step
    """

    def __init__(self, path: str | os.PathLike[str], name: str) -> None:
        self._path, self._name, self._open, self._closed = Path(path), name, None, False
        self._folder = pieces.folder_of(path)
        for attempt in range(5):
            try:
                return self._read()
            except (
                FileNotFoundError
            ):  # the pieces became one file meanwhile, or a restart goes on with it
                self._shut()
                if attempt == 4:
                    raise
            except BaseException:
                self._shut()
                raise

    def _read(self) -> None:
        self._times: list[Array] = []
        self._tables: list[Dataset] = []
        self._frames: list[tuple[str, int, int, Dataset]] = []
        self._grids: dict[str, tuple[Array, Array | None]] = {}
        self.series: tuple[str, ...] = ()
        if whole := _is_file(self._path, self._folder, self._name):
            files, texts = [self._path], _texts(self.open(self._path), self._name)
        else:
            texts = pieces.read_texts(
                self._folder
            )  # before the pieces are looked for: they are of this run
            files = pieces.pieces(self._folder)
        _check_version(int(texts["version"]), self._name)
        self.header, self.summary, self.errors = (
            texts.get(name, {}) for name in ("header", "summary", "errors")
        )
        if not all(isinstance(text, dict) for text in (self.header, self.summary, self.errors)):
            raise Damaged("a text is no table of names and values")
        self.complete = bool(self.summary)
        frame = row = 0
        for path in files:
            file = self.open(path)
            found = pieces.extent(file)
            if found[:2] != (frame, row):
                if whole:
                    raise Damaged("its first frame and step are missing")
                return
            frame, row = found[2:]
            self._add(path, file, slice(found.row, found.rows_end))

    def _add(self, path: Path, file: h5py.File, rows: slice) -> None:
        """What a file holds; rows: of the series."""
        self._times.append(self._numbers(path, file, "time", 1)[...])
        if "series" in file:
            table = file["series"]
            names = (
                table.dtype.names if isinstance(table, h5py.Dataset) and table.ndim == 1 else None
            )
            if not names or any(table.dtype[name].base.kind not in "iuf" for name in names):
                raise Damaged("series is no table of numbers")
            _check_size("series", table)
            if names != (self.series or names):
                raise Damaged("the pieces have different series")
            self.series = names
            self._tables.append(Dataset(self, path, table, rows))
        for group in file_layout.layer_groups(file):
            if "X" in file[group]:
                self._grids[group] = _grid(group, self._numbers(path, file, f"{group}/X")[...])
            for _, name, first, count in file_layout.frame_sets(file, group):
                self._frames.append(
                    (group, first, count, self._numbers(path, file, f"{group}/{name}", 2))
                )

    def _numbers(self, path: Path, file: h5py.File, name: str, ndim: int | None = None) -> Dataset:
        found = file[name]
        if not isinstance(found, h5py.Dataset) or found.dtype.kind not in "iuf":
            raise Damaged(f"{name} is no array of numbers")
        if found.ndim != ndim and (ndim or not found.ndim):
            raise Damaged(f"{name} has {found.ndim} dimensions")
        _check_size(name, found)
        return Dataset(self, path, found)

    def time(self) -> Array:
        """Times of the frames."""
        return np.concatenate(self._times) if self._times else np.empty(0)

    def column(self, name: str) -> Array:
        """What is known of each step by a name."""
        return np.concatenate([table[name] for table in self._tables])

    def frames(self, layer: int) -> list[Frames]:
        """What there is of a layer's frames, in their order."""
        found = [
            Frames(first, count, dataset, *self._grids[group])
            for group, first, count, dataset in self._frames
            if group.endswith(f"/layer{layer:02d}") and group in self._grids
        ]
        return sorted(found, key=lambda frames: frames.first)

    def open(self, path: Path) -> h5py.File:
        """A file, which stays open until another one is asked for: there may be more than a program may have open.

        A piece that is gone is in NAME.h5 by now, with the same names.
        """
        if self._closed:
            raise ValueError("it was closed")
        if self._open is None or self._open[0] != path:
            self._shut()
            try:
                self._open = path, file_layout.open_h5(path)
            except FileNotFoundError:
                if path == self._path or not self._path.exists():
                    raise
                self._open = path, file_layout.open_h5(self._path)
        return self._open[1]

    def _shut(self) -> None:
        if self._open is not None:
            self._open[1].close()
        self._open = None

    def close(self) -> None:
        """What was not read yet cannot be read any more."""
        self._shut()
        self._closed = True


def run_of(path: Path) -> str | None:
    """By which a result, NAME.h5 or NAME.parts, and its checkpoints know each other. FileError if it cannot be read."""
    with damage(str(path)):
        if path.is_dir():
            return pieces.read_texts(path)["header"].get("run")
        if not h5py.is_hdf5(path):
            return None
        with file_layout.open_h5(path) as file:
            return _texts(file, str(path))["header"].get("run") if "header" in file else None


def _is_file(path: Path, folder: Path, name: str) -> bool:
    """Whether there is NAME.h5, or else NAME.parts. FileError if neither is, or it can be no result."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        if (folder / "header.json").exists():
            return False
        if path.exists():  # by now
            raise
        raise FileError(f"{name}: there is no such file") from None
    except OSError as error:
        raise FileError(f"{name}: may not be read: {error.strerror}") from error
    if not stat.S_ISREG(mode):  # a pipe would wait for somebody who writes
        what = "a directory" if stat.S_ISDIR(mode) else "no regular file"
        raise FileError(f"{name}: is {what}, not a result file")
    if not os.access(path, os.R_OK):
        raise FileError(f"{name}: may not be read: Permission denied")
    if not h5py.is_hdf5(path):
        raise FileError(f"{name}: is not an HDF5 file")
    return True


def _texts(file: h5py.File, name: str) -> dict[str, Any]:
    """What header.json says of a result in pieces. FileError if it is no result."""
    kind = file.attrs.get("format")
    if (kind.decode() if isinstance(kind, bytes) else kind) != file_layout.FORMAT:
        what = (
            "is a checkpoint of fsipetsc, not a result"
            if is_one(Path(file.filename))
            else "is not a result of fsipetsc"
        )
        raise FileError(f"{name}: {what}")
    _check_version(int(file.attrs["version"]), name)
    names = [name for name in ("header", "summary", "errors") if name in file]
    return {
        "version": file.attrs["version"],
        **{name: json.loads(file[name].asstr()[()]) for name in names},
    }


def _grid(group: str, X: Array) -> tuple[Array, Array | None]:
    """Numbers, or coordinates, and the places of blocks."""
    numbers, places = (X, None) if X.ndim == 1 else (X[:, 0], X[:, 1:])
    if not len(X) or not np.all(np.isfinite(X)) or np.any(np.diff(numbers) <= 0):
        raise Damaged(f"the grid in {group} is not ascending numbers")
    return numbers, places


def _check_version(version: int, name: str) -> None:
    if version > file_layout.VERSION:
        raise FileError(
            f"{name}: was written by a newer fsipetsc (file format {version}); update to read it"
        )


def _check_size(name: str, dataset: h5py.Dataset) -> None:
    size = dataset.size * dataset.dtype.itemsize
    if size > _MOST_COMPRESSED * max(1024, os.path.getsize(dataset.file.filename)):
        raise Damaged(f"{name} claims to have {size:.3g} bytes")
