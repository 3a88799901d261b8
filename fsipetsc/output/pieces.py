"""The pieces of a result in the making: NAME.parts beside NAME.h5 (see `file_layout`).

A file there is written under another name and renamed when it is whole, so a kill costs the piece
in the making. At the end of the run the pieces are joined into NAME.h5 and the folder goes. Where
there is NAME.h5 it is the result, and what the folder of the same run still has is a leftover.
"""

import itertools
import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output import file_layout as layout
from fsipetsc.output.file_layout import columns, damage, open_h5
from fsipetsc.scheme.observables import SERIES

Array = np.ndarray[Any, Any]
Layers = Sequence[Mapping[str, Any]]  # as in the header
_NAMES = "names"  # attribute of the group of series: their names
_SPARE = 1 << 16  # bytes for what HDF5 needs besides the numbers
_AT_ONCE = 1 << 26  # bytes of frames that are copied at once


#: what a restart keeps of a result: frames, steps, and the time [s] at the end of the last step
Kept = tuple[int, int, float]


# the folder


def file_of(folder: Path, number: int, ending: str = ".h5") -> Path:
    """Return the piece of a number, from 1 on."""
    return folder / f"{number:06d}{ending}"


def pieces(folder: Path) -> list[Path]:
    """Return the finished pieces in their order, up to the first that is missing."""
    return [*itertools.takewhile(Path.exists, (file_of(folder, k) for k in itertools.count(1)))]


def clear(folder: Path) -> None:
    """Remove header, pieces and drafts; the lock stays."""
    for path in (folder / "header.json", *folder.glob("*.h5"), *folder.glob("*.new")):
        path.unlink(missing_ok=True)


def text_of(about: Mapping[str, Any]) -> bytes:
    """Return the text of header.json."""
    return json.dumps({"format": layout.FORMAT, "version": layout.VERSION, **about}).encode()


def read_about(path: Path, name: str = "") -> dict[str, Any]:
    """Return what is known of the run of NAME.h5 or NAME.parts. FileError, OSError."""
    if path.is_dir():
        text: Any = (path / "header.json").read_bytes()
    else:
        with open_h5(path) as file:
            text = file["about"][()] if "about" in file else b"{}"
    about = json.loads(text)
    if not isinstance(about, dict) or about.get("format") != layout.FORMAT:
        raise FileError(f"{name or path}: is not a result of fsipetsc")
    if about["version"] != layout.VERSION:
        said = f"has the file format {about['version']}, and this fsipetsc reads {layout.VERSION}"
        raise FileError(f"{name or path}: {said}")
    for part in ("header", "summary", "errors"):
        if not isinstance(about.setdefault(part, {}), dict):
            raise ValueError(f"its {part} is no table of names and values")
    return about


def run_of(path: Path) -> str | None:
    """Return the mark by which a result and its checkpoints know each other, if any. FileError."""
    if path.is_file() and not h5py.is_hdf5(path):
        return None
    with damage(str(path)):
        return read_about(path)["header"].get("run")


def check_kept(files: Sequence[Path], header: Mapping[str, Any], kept: Kept, name: Path) -> None:
    """FileError if a result is not what a checkpoint goes on from."""
    frames, rows, t = kept
    with damage(str(name)):
        content = Contents(files, header)
    found = f"{content.nframes} frames and {content.rows} steps, not {frames} and {rows}"
    if content.nframes >= frames and content.rows >= rows:
        ended = content.t[rows - 1] if rows else t  # before all steps any result fits
        if ended == t:
            return
        found = f"its step {rows} ends at t = {ended:.17g}, not {t:.17g}"
    raise FileError(f"{name} is not what the checkpoint goes on from: {found}")


# what the pieces hold


class Contents:
    """All frames and steps of some files, one after the other. What is read is checked:
    ValueError, which says what is not as it should be; OSError.

    header         of the result
    time, t        times of the frames, times after the steps
    series         name -> shape of what is known of a step
    X              of each layer its grid; empty where there are no frames
    """

    def __init__(self, files: Sequence[Path], header: Mapping[str, Any]) -> None:
        self._layers = [(columns(layer), tuple(layer["shape"])) for layer in header["layers"]]
        self._widths = {of: (len(names),) for of, names in layout.columns_of(header).items()}
        self.time, self.t = np.empty(0), np.empty(0)
        self.X = [np.empty(0) for _ in self._layers]
        self.series: dict[str, tuple[int, ...]] = {}
        self._counts: list[tuple[Path, int, int]] = []  # of frames and steps in each file
        for path in files:
            with open_h5(path) as file:
                self._add(path, file)
        before = -np.finfo(float).tiny
        if not np.all(np.diff(self.time, prepend=before) > 0):
            raise ValueError("the times of its frames are not ascending numbers")
        if not np.all(np.diff(self.t, prepend=before) >= 0):
            raise ValueError("the times of its steps are not ascending numbers")

    nframes = property(lambda self: len(self.time))
    rows = property(lambda self: len(self.t))

    def _add(self, path: Path, file: h5py.File) -> None:
        """Note what a file holds. A restart has computed again what files before have from its
        first frame and step on.
        """
        frames, rows = map(int, file.attrs.get("first", (0, 0)))
        if frames > self.nframes or rows > self.rows:
            raise ValueError(f"what comes before {path.name} is missing")
        time, t = _numbers(file, "time", None)[...], np.empty(0)
        if "series" in file:
            # a list: HDF5, asked for names, crashes where a byte of a larger group has changed
            names = [name.decode() for name in file["series"].attrs.get(_NAMES, ())]
            t = _numbers(file, "series/t", None)[...]
            for name in names or [*file["series"]]:
                of = SERIES[name].of if name in SERIES else ""
                self.series[name] = self._widths.get(of, ())
                _numbers(file, f"series/{name}", len(t), *self.series[name])
        for k in range(len(self.X)) if len(time) else ():
            self._check_layer(file[f"layer{k}"], k, len(time))
        self.time, self.t = (
            np.concatenate([old[:kept], new])
            for old, kept, new in ((self.time, frames, time), (self.t, rows, t))
        )
        for i, (other, n, m) in enumerate(self._counts):
            self._counts[i] = other, min(n, frames), min(m, rows)
            frames, rows = max(0, frames - n), max(0, rows - m)
        self._counts.append((path, len(time), len(t)))

    def _check_layer(self, group: h5py.Group, k: int, count: int) -> None:
        """Layer k has its grid, and as many frames as it should, of this size."""
        names, shape = self._layers[k]
        if not len(self.X[k]):
            size = shape if len(group["X"].shape) == 1 else (math.prod(shape), len(shape))
            self.X[k] = X = _numbers(group, "X", *size)[...]
            if not np.isfinite(X).all() or (len(shape) == 1 and np.any(np.diff(X, axis=0) <= 0)):
                raise ValueError(f"the grid in layer{k} is not ascending numbers")
        if "frames" in group:
            _numbers(group, "frames", len(self.X[k]), count * len(names))
        else:
            for name in names:
                _numbers(group, name, count, *shape)

    def copy_series(self, into: Mapping[str, Any]) -> None:
        """Put series into these arrays or datasets, file by file."""
        begin = 0
        for path, _, count in self._counts:
            with open_h5(path) as file:
                for name in into if count else ():
                    into[name][begin : begin + count] = file[f"series/{name}"][:count]
            begin += count

    def frames(self, k: int, names: Sequence[str], first: int, end: int) -> list[Array]:
        """Return (end - first, n) of each of these columns of layer k."""
        found: list[list[Array]] = [[] for _ in names]
        for path, count, _ in self._counts:
            a, b = max(first, 0), min(end, count)  # of this file
            first, end = first - count, end - count
            if a < b:
                with open_h5(path) as file:
                    rows = self._rows(file[f"layer{k}"], k, names, a, b)
                for parts, values in zip(found, rows):
                    parts.append(values)
        none = np.empty((0, len(self.X[k])))
        return [p[0] if len(p) == 1 else np.concatenate([none, *p]) for p in found]

    def _rows(self, group: h5py.Group, k: int, names: Sequence[str], a: int, b: int) -> list[Array]:
        """Return (b - a, n) of each column, from frame a of a file on."""
        if "frames" not in group:
            return [group[name][a:b].reshape(b - a, -1) for name in names]
        stored, _ = self._layers[k]
        table = group["frames"][:, a * len(stored) : b * len(stored)]
        table = table.reshape(-1, b - a, len(stored))
        return [table[..., stored.index(name)].T for name in names]


def _numbers(group: h5py.Group, name: str, *shape: int | None) -> h5py.Dataset:
    """Return a dataset of numbers of this shape, in which None is any length. ValueError."""
    found = group[name]
    fits = all(n in (None, m) for n, m in zip(shape, found.shape))
    if found.dtype.kind not in "iuf" or len(shape) != found.ndim or not fits:
        raise ValueError(f"{name} has the shape {found.shape} and the type {found.dtype}")
    return found


# writing


def lay_out(
    path: Path,
    numbers: Mapping[str, Any],
    shapes: Mapping[str, tuple[int, ...]],
    first: tuple[int, int] | None = None,
) -> None:
    """Write a file with these datasets and others of these shapes, still to be filled. OSError.

    first: numbers of the first frame and step of a piece. PETSc, which fills it, writes to chunked
    datasets only, of less than 4 GiB a chunk.
    """
    with layout.in_memory() as (file, image):
        names = [name[7:] for name in (*numbers, *shapes) if name.startswith("series/")]
        if names:
            file.create_group("series", track_order=True).attrs[_NAMES] = np.array(names, "S")
        for name, value in numbers.items():
            file[name] = value
        for name, shape in shapes.items():
            rest = max(1, math.prod(shape[1:]))
            chunks = max(1, min(shape[0], (1 << 27) // rest)), *shape[1:]
            file.create_dataset(name, shape, "f8", chunks=None if first is None else chunks)
        if first is not None:
            file.attrs["first"] = first
    content = image.getvalue()
    room = sum(8 * math.prod(shape) + 1024 for shape in shapes.values())
    with open(path, "wb") as file:
        file.write(content)
        file.flush()
        # HDF5 crashes when it closes a file on a full disk, so what it needs is reserved before
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), len(content), room + _SPARE)


def publish(draft: Path) -> None:
    """Give a piece that is whole its name. OSError."""
    with open(draft, "rb") as file:
        os.fsync(file.fileno())
    os.replace(draft, draft.with_suffix(".h5"))


def join(files: Sequence[Path], target: Path, about: Mapping[str, Any], name: Path) -> None:
    """Make one file of what some files hold. OSError; FileError if they are damaged; name: of the
    result, in messages.
    """
    layers = about["header"]["layers"]
    try:
        with damage(str(name)):
            content = Contents(files, about["header"])
        numbers = {"about": np.bytes_(text_of(about)), "time": content.time}
        shapes = {f"series/{name}": (content.rows, *of) for name, of in content.series.items()}
        for k, layer in enumerate(layers if content.nframes else ()):
            numbers[f"layer{k}/X"] = content.X[k]
            frames = content.nframes, *layer["shape"]
            shapes |= {f"layer{k}/{name}": frames for name in columns(layer)}
        lay_out(target, numbers, shapes)
        with open_h5(target, "r+") as file:
            _fill(file, content, layers)
        with open(target, "rb") as done:
            os.fsync(done.fileno())
    except BaseException:
        with suppress(OSError):
            target.unlink()
        raise


def _fill(file: h5py.File, content: Contents, layers: Layers) -> None:
    """Put series and frames into the datasets of a whole result."""
    content.copy_series(file["series"] if content.series else {})
    for k, layer in enumerate(layers):
        names = columns(layer)
        step = max(1, _AT_ONCE // (8 * max(1, len(content.X[k])) * len(names)))
        for first in range(0, content.nframes, step):
            end = min(first + step, content.nframes)
            for name, values in zip(names, content.frames(k, names, first, end)):
                file[f"layer{k}/{name}"][first:end] = values.reshape(-1, *layer["shape"])
