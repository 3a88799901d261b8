"""Where the numbers of a result come from: from HDF5 when its run has ended, from its commits before.

Both say the same: header, summary and errors as they were given, whether the run came to its end, the times, the series,
and the datasets of each layer. What is asked of them is checked, for a file may be damaged.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output import commits, file_layout, tables
from fsipetsc.output.checkpoint_file import is_one

Array = np.ndarray
_MOST_COMPRESSED = 1000  # times: a dataset that claims more than that of what is stored is damaged


class Damaged(Exception):
    """A part of a result is not what it should be; says which part, and why."""


class Rows:
    """A dataset of a result that is being written: chunks of rows at known places of the file."""

    def __init__(self, source: Unfinished, dtype: Any, shape: Sequence[int], rows: int, places: Sequence[int]) -> None:
        self._source, self._rows, self._places = source, rows, places
        self.dtype, self.shape, self.ndim = np.dtype(dtype), tuple(shape), len(shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Array:
        """All of it, or of all rows the columns of a slice: [...], [:, first:last]."""
        columns = key[1] if isinstance(key, tuple) else slice(None)
        parts, width = [], int(np.prod(self.shape[1:], dtype=int))
        for k, place in enumerate(self._places):
            rows = min(self._rows, len(self) - k * self._rows)
            data = self._source.read(place, rows * width * self.dtype.itemsize)
            parts.append(np.frombuffer(data, self.dtype).reshape(rows, *self.shape[1:])[..., columns])
        return np.concatenate(parts) if parts else np.empty(self.shape, self.dtype)


Dataset = h5py.Dataset | Rows


class Series(NamedTuple):
    """Names of what is known of each step, and what reads one."""

    names: Sequence[str]
    read: Callable[[str], Array]


class Frames(NamedTuple):
    """A dataset of some consecutive frames of a layer, and their grid, (n,), of blocks (n, 1 + d)."""

    first: int
    count: int
    dataset: Dataset
    X: Array


class Finished:
    """A file that HDF5 can read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file = file_layout.open_h5(path, "r")
        try:
            self._begin(os.fspath(path))
        except BaseException:
            self.close()  # the error holds it open, and nobody could write to the file, not even its next run
            raise

    def _begin(self, name: str) -> None:
        attributes = self._file.attrs
        if attributes.get("format") != file_layout.FORMAT:
            what = "is a checkpoint of fsipetsc, not a result" if is_one(Path(name)) else "is not a result of fsipetsc"
            raise FileError(f"{name}: {what}")
        version = int(attributes["version"])
        if version > file_layout.VERSION:
            raise FileError(f"{name}: was written by a newer fsipetsc (file format {version}); update to read it")
        self.complete = bool(attributes["complete"])
        self.header, self.summary, self.errors = map(self._text, ("header", "summary", "errors"))

    def _text(self, name: str) -> dict[str, Any]:
        if name not in self._file:
            return {}
        content = json.loads(self._file[name].asstr()[()])
        if not isinstance(content, dict):
            raise Damaged(f"{name} is no table of names and values")
        return content

    def time(self) -> Array:
        return self._dataset("time", 1)[...]

    def series(self) -> Series:
        table = self._file.get("series", {})
        if isinstance(table, h5py.Dataset):
            names = table.dtype.names
            if not names or table.ndim != 1 or any(table.dtype[name].base.kind not in "iuf" for name in names):
                raise Damaged("series is no table of numbers")
            _check_size("series", table)
            return Series(names, lambda name: table[name])
        datasets = {name: self._dataset(f"series/{name}") for name in table}  # version 1
        steps = min(map(len, datasets.values()), default=0)
        return Series(tuple(datasets), lambda name: datasets[name][:steps])

    def frames(self, layer: int) -> Iterator[Frames]:
        """What there is of a layer's frames, in any order."""
        for name in self._file:
            group = self._file.get(f"{name}/layer{layer:02d}") if name.startswith("segment") else None
            if isinstance(group, h5py.Group) and "X" in group:
                X = self._dataset(f"{group.name}/X")[...]
                for dataset in group:
                    numbers = file_layout.parse_frames_name(dataset)
                    if numbers is not None:
                        yield Frames(*numbers, self._dataset(f"{group.name}/{dataset}", 2), X)

    def _dataset(self, name: str, ndim: int | None = None) -> h5py.Dataset:
        dataset = self._file[name]
        if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in "iuf":
            raise Damaged(f"{name} is no array of numbers")
        if dataset.ndim != ndim and (ndim or not dataset.ndim):
            raise Damaged(f"{name} has {dataset.ndim} dimensions")
        _check_size(name, dataset)
        return dataset

    def close(self) -> None:
        self._file.close()


class Unfinished:
    """A file whose run goes on or was killed: what it had committed when it was opened."""

    complete = False

    def __init__(self, descriptor: int, commit: commits.Commit) -> None:
        self._descriptor: int | None = descriptor
        self.summary: dict[str, Any] = {}
        self.errors: dict[str, Any] = {}
        self._tables: dict[str, tuple[int, list[int]]] = {"time": (0, []), "series": (0, [])}  # rows, places of chunks
        self._type, self._datasets = np.dtype([]), {}
        for entry in commits.entries(descriptor, commit):
            self.header = entry.get("header") or self.header
            for name, places in self._tables.items():
                if name in entry:
                    self._tables[name] = entry[name]["rows"], places[1] + entry[name]["places"]
            if "series" in entry:
                self._type = file_layout.record_type(entry["series"]["columns"])
            for name, shape, rows, places in entry.get("frames", ()):
                self._datasets[name] = Rows(self, "<f8", shape, rows, places)

    def _table(self, name: str, dtype: Any) -> Rows:
        rows, places = self._tables[name]
        return Rows(self, dtype, (rows,), tables.ROWS, places)

    def time(self) -> Array:
        return self._table("time", "<f8")[...]

    def series(self) -> Series:
        table = self._table("series", self._type)
        return Series(self._type.names or (), lambda name: table[...][name])

    def frames(self, layer: int) -> Iterator[Frames]:
        """What there is of a layer's frames, in any order."""
        grids = {name: rows[...] for name, rows in self._datasets.items() if name.endswith(f"/layer{layer:02d}/X")}
        for name, rows in self._datasets.items():
            group, last = name.rsplit("/", 1)
            numbers = file_layout.parse_frames_name(last)
            if numbers is not None and f"{group}/X" in grids:
                yield Frames(*numbers, rows, grids[f"{group}/X"])

    def read(self, place: int, size: int) -> bytes:
        if self._descriptor is None:
            raise ValueError("it was closed")
        data = os.pread(self._descriptor, size, place)
        if len(data) < size:
            raise OSError("it ends too early")
        return data

    def close(self) -> None:
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)

    __del__ = close


def open_source(path: str | os.PathLike[str]) -> Finished | Unfinished:
    """What tells of the file. Raises FileError if there is no file or it is not ours, others if it is damaged."""
    name = os.fspath(path)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would wait for somebody who writes
    except FileNotFoundError as error:
        raise FileError(f"{name}: there is no such file") from error
    except OSError as error:
        raise FileError(f"{name}: may not be read: {error.strerror}") from error
    try:
        mode = os.fstat(descriptor).st_mode
        if not stat.S_ISREG(mode):
            raise FileError(f"{name}: is {'a directory' if stat.S_ISDIR(mode) else 'no regular file'}, not a result file")
        commit = commits.newest(descriptor)
        if commit is not None and not commit.ended:
            owned, descriptor = descriptor, -1
            return Unfinished(owned, commit)
    finally:
        if descriptor >= 0:
            os.close(descriptor)
    if not h5py.is_hdf5(path):
        raise FileError(f"{name}: is not an HDF5 file")
    return Finished(path)


def _check_size(name: str, dataset: h5py.Dataset) -> None:
    size = dataset.size * dataset.dtype.itemsize
    if size > _MOST_COMPRESSED * max(1024, dataset.id.get_storage_size()):
        raise Damaged(f"{name} claims to have {size:.3g} bytes")
