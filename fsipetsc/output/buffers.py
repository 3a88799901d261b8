"""What the writer keeps in memory between two writes: frames of the layers, rows of the series."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

ROWS = 512  # rows in one HDF5 chunk of a series


class LayerBuffer:
    """Frames of one layer's local points: kept frame after frame as they come, written point after point."""

    def __init__(self, layer: Mapping[str, Any], nfields: int, width: int, capacity: int) -> None:
        self.n, self.width = int(layer["n"]), width
        local = int(layer["local"])
        self.X = np.array(layer["X"], dtype=np.float64).reshape(local)
        # rows of opaque bytes move as a whole, several times faster than row by row and number by number
        self._row = np.dtype((np.void, 8 * nfields))
        self._has_x = width == nfields + 1
        row = [("fields", self._row), ("x", np.dtype("f8"))][: 1 + self._has_x]
        self._frames = np.empty((capacity, local), np.dtype(row))
        self._packed = np.empty(capacity * local * width)
        self._shape = (local, nfields)

    def put(self, k: int, values: Array, x: Array | None) -> None:
        values = np.ascontiguousarray(values, dtype=np.float64)
        if values.shape != self._shape or (x is not None) != self._has_x:
            raise ValueError(f"a frame's fields must be {self._shape}, with positions x only where x is not a field")
        self._frames["fields"][k] = values.view(self._row)[:, 0]
        if x is not None:
            self._frames["x"][k] = x

    def pack(self, count: int) -> Array:
        """The first `count` frames, (local·count·width,), point by point."""
        rows = self._frames[:count].view((np.void, 8 * self.width))
        packed = self._packed[: rows.size * self.width]
        packed.view(rows.dtype).reshape(rows.shape[::-1])[...] = rows.T
        return packed


class SeriesBuffer:
    """Rows of the per-step data that are not yet in the file."""

    def __init__(self) -> None:
        self.nbytes = 0
        self._rows = 0  # in the file
        self._blocks: list[tuple[int, dict[str, Array]]] = []

    def append(self, rows: Mapping[str, Array]) -> None:
        block = {name: np.array(values, dtype=np.float64, ndmin=1) for name, values in rows.items()}
        lengths = {len(values) for values in block.values()}
        if len(lengths) != 1:
            raise ValueError(f"series with unequal numbers of rows: { {name: v.shape for name, v in block.items()} }")
        self._blocks.append((lengths.pop(), block))
        self.nbytes += sum(values.nbytes for values in block.values())

    def write(self, file: h5py.File) -> None:
        """Append all rows to the file and forget them."""
        count = sum(k for k, _ in self._blocks)
        if not count:
            return
        group = file.require_group("series")
        trailing = {name: values.shape[1:] for _, block in self._blocks for name, values in block.items()}
        trailing.update({name: group[name].shape[1:] for name in group if name not in trailing})
        for name, tail in trailing.items():
            parts = [block[name] if name in block else np.full((k, *tail), np.nan) for k, block in self._blocks]
            append_rows(group, name, np.concatenate(parts), self._rows)
        self._rows += count
        self._blocks, self.nbytes = [], 0


def append_rows(group: h5py.Group, name: str, rows: Array, start: int) -> None:
    """Write `rows` from row `start` on; rows that a new dataset has missed are NaN."""
    tail = rows.shape[1:]
    if name not in group:
        group.create_dataset(name, (0, *tail), "f8", maxshape=(None, *tail), chunks=(ROWS, *tail), fillvalue=np.nan)
    dataset = h5py.h5d.open(group.id, name.encode())  # the short way: this is called often
    dataset.set_extent((start + len(rows), *tail))
    space = dataset.get_space()
    space.select_hyperslab((start, *(0 for _ in tail)), rows.shape)
    dataset.write(h5py.h5s.create_simple(rows.shape), space, np.ascontiguousarray(rows))
