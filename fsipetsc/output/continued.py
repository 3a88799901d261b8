"""A result that a later run goes on with: what came after its checkpoint is cut off.

The part that stays is copied into a new file, which takes the name of the old one when it is whole: until then nothing has
changed, whatever happens. The old file may be that of a killed run, of which only the commits can be read.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output import commits, file_layout, tables, transaction
from fsipetsc.output.reader import damage
from fsipetsc.output.result_sources import Finished, Frames, Unfinished, open_source

Source = Finished | Unfinished


class Kept(NamedTuple):
    """What a result is to keep: so many frames, and rows of the series, the last of which is at the time t [s]."""

    frames: int
    rows: int
    t: float


class Piece(NamedTuple):
    """A dataset of frames, of which the first ones are kept."""

    frames: Frames
    kept: int


def is_of(path: Path, run: str) -> bool:
    """Whether there is a file, and it is the result of this run (header["run"]). FileError if it cannot be read."""
    if not os.path.lexists(path):
        return False
    with damage(str(path)), closing(open_source(path)) as source:
        return source.header.get("run") == run


def cut(path: Path, kept: Kept, header: Mapping[str, Any], log: commits.Log, settle: Callable[[], object]) -> int:
    """Let a result end after so many frames and rows of the series, with this header; its first commit goes to ``log``.

    settle: is called when the new file is whole, and the old one still there. Returns the number of its last segment, -1 if it
    has none. FileError if it has fewer, or others.
    """
    fresh = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        with damage(str(path)), closing(open_source(path)) as source:
            segment = _copy(source, fresh, path, kept, header, log)
        settle()
        os.replace(fresh, path)
    finally:
        fresh.unlink(missing_ok=True)
    return segment


def _copy(source: Source, fresh: Path, path: Path, kept: Kept, header: Mapping[str, Any], log: commits.Log) -> int:
    frames, rows, t = kept
    time, series = source.time()[:frames], _rows(source, rows)
    pieces = [_pieces(source, k, frames) for k in range(len(header["layers"]))]
    if len(time) < frames or len(series) < rows or any(sum(piece.kept for piece in own) < frames for own in pieces):
        found = f"{len(time)} frames and {len(series)} steps"
        raise FileError(f"{path}: is not what the checkpoint goes on from: it has {found}, not {frames} and {rows}")
    if rows and series["t"][-1] != t:  # steps of a run that went on otherwise
        found = f"its step {rows} ends at t = {series['t'][-1]:.17g}"
        raise FileError(f"{path}: is not what the checkpoint goes on from: {found}, not {t:.17g}")
    fresh.write_bytes(file_layout.beginning(header, log))
    transaction.ensure_space(fresh, path.stat().st_size + (1 << 20))
    entry: dict[str, Any] = {"time": {"rows": frames}, "frames": []}
    with h5py.File(fresh, "r+") as file:
        entry["time"]["places"] = tables.append(file, "time", time, 0)
        if rows:
            places = tables.append(file, "series", series, 0)
            entry["series"] = {"rows": rows, "places": places, "columns": file_layout.describe(series.dtype)}
        segment = -1
        for segment, group in enumerate(_segments(pieces)):
            for k, own in enumerate(group):
                for name, values in _datasets(file_layout.group_name(segment, k), own):
                    entry["frames"].append(file_layout.new_dataset(file, name, len(values), values[:1].size))
                    file[name][...] = values
        record = log.room(file, entry)
    with open(fresh, "r+b", buffering=0) as raw:
        log.commit(record, lambda data, offset: (raw.seek(offset), raw.write(data)))
        os.fsync(raw.fileno())
    return segment


def _rows(source: Source, rows: int) -> np.ndarray:
    """The first records of the series."""
    series = source.series()
    columns = {name: series.read(name)[:rows] for name in series.names}
    dtype = [(name, "<f8", values.shape[1:]) for name, values in columns.items()]
    found = np.empty(min(map(len, columns.values()), default=0), dtype)
    for name, values in columns.items():
        found[name] = values
    return found


def _pieces(source: Source, layer: int, frames: int) -> list[Piece]:
    """The datasets of a layer in their order, up to a number of frames, without a gap."""
    found, n = [], 0
    for piece in sorted(source.frames(layer), key=lambda piece: piece.first):
        if piece.first == n and n < frames:
            found.append(Piece(piece, min(piece.count, frames - n)))
            n += piece.count
    return found


def _segments(pieces: list[list[Piece]]) -> Iterator[list[list[Piece]]]:
    """For each segment, in which no grid changes, the datasets of each layer."""
    steps = list(zip(*pieces, strict=True))
    for _, group in groupby(steps, key=lambda step: [piece.frames.X.tobytes() for piece in step]):
        yield [list(own) for own in zip(*group, strict=True)]


def _datasets(group: str, pieces: list[Piece]) -> Iterator[tuple[str, np.ndarray]]:
    """(name, values) of the grid and the frames of a layer in a segment."""
    yield f"{group}/X", pieces[0].frames.X
    for (first, count, dataset, _), kept in pieces:
        columns = dataset.shape[1] // count * kept
        yield f"{group}/{file_layout.frames_name(first, kept)}", dataset[:, :columns]
