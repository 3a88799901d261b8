"""The numbers of a result, whether they are in one file or in pieces. What is read is checked."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.output.file_layout import Damaged, columns, open_h5

Array = np.ndarray[Any, Any]
_MOST_COMPRESSED = 1000  # a dataset that claims more than so many times its file is damaged


class Piece(NamedTuple):
    """What counts of a file: frames from number `frame` on with their times, and `rows` steps from
    number `row` on.
    """

    path: Path
    frame: int
    time: Array
    row: int
    rows: int


class Contents:
    """All frames and steps of some pieces, each of which takes the place of what earlier ones have
    from its first frame and step on. Damaged, OSError.

    files    in their order; layers: as in the header
    time     (nframes,)
    rows     number of steps; names: series -> shape of what is known of a step
    X        of each layer its grid; empty where there are no frames
    """

    def __init__(self, files: Sequence[Path], layers: Sequence[Mapping[str, Any]]) -> None:
        self.names: dict[str, tuple[int, ...]] = {}
        self.nframes = self.rows = 0
        self._columns = [columns(layer) for layer in layers]
        self._shapes = [layer.get("shape") for layer in layers]
        self._open: tuple[Path, h5py.File] | None = None
        self._pieces: list[Piece] = []
        self.X = [np.empty(0) for _ in layers]
        try:
            for path in files:
                self._add(path)
        finally:
            self.close()
        self.time = np.concatenate([np.empty(0), *(piece.time for piece in self._pieces)])
        if not np.all(np.isfinite(self.time)) or np.any(np.diff(self.time) < 0):
            raise Damaged("the times of its frames are not ascending numbers")

    def _add(self, path: Path) -> None:
        """See what a file holds."""
        file = self._opened(path)
        frame, row = (int(number) for number in file.attrs.get("first", (0, 0)))
        if not (0 <= frame <= self.nframes and 0 <= row <= self.rows):
            raise Damaged(f"what comes before {path.name} is missing")
        for j, piece in enumerate(self._pieces):  # what is given up of them
            time, rows = piece.time[: max(0, frame - piece.frame)], max(0, row - piece.row)
            self._pieces[j] = piece._replace(time=time, rows=min(rows, piece.rows))
        time, rows = _numbers(file, "time", 1)[...], self._steps(file)
        for k in range(len(self.X)) if len(time) else ():
            self._check_layer(file, k, len(time))
        self._pieces.append(Piece(path, frame, time, row, rows))
        self.nframes, self.rows = frame + len(time), row + rows

    def _steps(self, file: h5py.File) -> int:
        """How many steps a file has, all of whose series have the same length."""
        if "series" not in file:
            return 0
        shapes = {name: _numbers(file, f"series/{name}").shape for name in file["series"]}
        names = {name: shape[1:] for name, shape in shapes.items()}
        steps = {shape[0] for shape in shapes.values()}
        if "t" not in names or len(steps) != 1 or names != (self.names or names):
            raise Damaged("its series do not fit together")
        self.names = names
        return steps.pop()

    def _check_layer(self, file: h5py.File, k: int, count: int) -> None:
        """Layer k has its grid, and as many frames as it should, of this size."""
        group, names, shape = f"layer{k}", self._columns[k], self._shapes[k]
        if f"{group}/X" in file or not len(self.X[k]):
            X: Array = _numbers(file, f"{group}/X")[...]
            rises = shape is not None or np.all(np.diff(X) > 0)
            if not len(X) or not np.isfinite(X).all() or not rises:
                raise Damaged(f"the grid in {group} is not ascending numbers")
            if shape is not None and X.shape not in ((math.prod(shape), len(shape)), (*shape,)):
                raise Damaged(f"the grid in {group} has the shape {X.shape}")
            if not len(self.X[k]):
                self.X[k] = X
            # a restart on another machine may have other last bits
            if not np.allclose(X, self.X[k], rtol=0.0, atol=1e-9 * float(np.ptp(self.X[k]))):
                raise Damaged(f"{group} has another grid than before")
        wanted = dict.fromkeys(names, (count, *(shape or self.X[k].shape)))
        if "frames" in file[group]:
            wanted = {"frames": (len(self.X[k]), count * len(names))}
        for name, expected in wanted.items():
            if (found := _numbers(file, f"{group}/{name}").shape) != expected:
                raise Damaged(f"{group}/{name} has the shape {found}")

    def series(self, name: str) -> Array:
        """(rows, …) what is known of each step by a name."""
        pieces = [piece for piece in self._pieces if piece.rows]
        found = [self._opened(p.path)[f"series/{name}"][: p.rows] for p in pieces]
        return np.concatenate([np.empty((0, *self.names[name])), *found])

    def frames(self, k: int, names: Sequence[str], first: int, end: int) -> list[Array]:
        """(end - first, n) of each of these columns of layer k."""
        found = [np.empty((end - first, len(self.X[k]))) for _ in names]
        for piece in self._pieces:
            a, b = max(first, piece.frame), min(end, piece.frame + len(piece.time))
            if a < b:
                group = self._opened(piece.path)[f"layer{k}"]
                rows = self._rows(group, k, names, a - piece.frame, b - piece.frame)
                for into, values in zip(found, rows):
                    into[a - first : b - first] = values
        return found

    def _rows(self, group: h5py.Group, k: int, names: Sequence[str], a: int, b: int) -> list[Array]:
        """(b - a, n) of each column, from frame a of a file on."""
        if "frames" not in group:
            return [group[name][a:b].reshape(b - a, -1) for name in names]
        width = len(self._columns[k])
        table = group["frames"][:, a * width : b * width].reshape(-1, b - a, width)
        return [table[..., self._columns[k].index(name)].T for name in names]

    def _opened(self, path: Path) -> h5py.File:
        """A file, which stays open until another one is asked for: they may be too many."""
        if self._open is None or self._open[0] != path:
            self.close()
            self._open = path, open_h5(path)
        return self._open[1]

    def close(self) -> None:
        """Close the file that is open, if any."""
        if self._open is not None:
            self._open[1].close()
        self._open = None


def _numbers(file: h5py.File, name: str, ndim: int | None = None) -> h5py.Dataset:
    """A dataset of numbers, no larger than the file can hold."""
    found = file[name]
    if not isinstance(found, h5py.Dataset) or found.dtype.kind not in "iuf" or not found.ndim:
        raise Damaged(f"{name} is no array of numbers")
    size = found.size * found.dtype.itemsize
    if size > _MOST_COMPRESSED * max(1024, os.path.getsize(file.filename)):
        raise Damaged(f"{name} claims to have {size:.3g} bytes")
    if found.ndim != (ndim or found.ndim):
        raise Damaged(f"{name} has {found.ndim} dimensions")
    return found
