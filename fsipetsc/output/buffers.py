"""What the writer keeps in memory between two writes: frames of the layers, rows of the series."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

ROWS = 2048  # rows in one HDF5 chunk of a series


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
        if count == 1:
            return self._frames[0].view(np.float64)
        rows = self._frames[:count].view((np.void, 8 * self.width))
        packed = self._packed[: rows.size * self.width]
        packed.view(rows.dtype).reshape(rows.shape[::-1])[...] = rows.T
        return packed


class SeriesBuffer:
    """Rows of the per-step data that are not yet in the file."""

    def __init__(self) -> None:
        self.nbytes = 0
        self._written, self._count = 0, 0  # rows in the file; rows here
        self._parts: dict[str, list[tuple[int, Array]]] = {}  # name -> first row and rows of each part

    def append(self, rows: Mapping[str, Array]) -> None:
        """Keep rows, not copied: their arrays must not change any more."""
        block = {name: np.atleast_1d(np.asarray(values, dtype=np.float64)) for name, values in rows.items()}
        if len({len(values) for values in block.values()}) != 1:
            raise ValueError(f"series with unequal numbers of rows: { {name: v.shape for name, v in block.items()} }")
        for name, values in block.items():
            self._parts.setdefault(name, []).append((self._count, values))
            self.nbytes += values.nbytes
        self._count += len(values)

    def write(self, file: h5py.File) -> None:
        """Append all rows to the file and forget them."""
        if not self._count:
            return
        group = file.require_group("series")
        for name in [*self._parts, *(name for name in group if name not in self._parts)]:
            parts = self._parts.get(name, [])
            if sum(len(values) for _, values in parts) == self._count:
                rows = np.concatenate([values for _, values in parts])
            else:
                tail = parts[0][1].shape[1:] if parts else group[name].shape[1:]
                rows = np.full((self._count, *tail), np.nan)
                for first, values in parts:
                    rows[first : first + len(values)] = values
            append_rows(group, name, rows, self._written)
        self._written += self._count
        self._count, self._parts, self.nbytes = 0, {}, 0


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
