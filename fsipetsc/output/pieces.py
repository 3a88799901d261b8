"""The pieces of a result in the making: NAME.parts beside NAME.h5 (see `file_layout`).

A file there is written under another name and renamed when it is whole, so a kill costs the piece
in the making. At the end of the run the pieces are joined into NAME.h5 and the folder goes. Where
there is NAME.h5 it is the result, and what the folder of the same run still has is a leftover.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output.contents import Contents
from fsipetsc.output.file_layout import (
    FORMAT,
    VERSION,
    Damaged,
    columns,
    damage,
    in_memory,
    open_h5,
    write_whole,
)

Array = np.ndarray[Any, Any]
Layers = Sequence[Mapping[str, Any]]  # as in the header
_SPARE = 1 << 16  # bytes for what HDF5 needs besides the numbers
_AT_ONCE = 1 << 26  # bytes of frames that are copied at once


class Kept(NamedTuple):
    """What a restart keeps of a result: frames, steps, and the time [s] at the end of the last."""

    frames: int
    rows: int
    t: float


def folder_of(path: str | os.PathLike[str]) -> Path:
    """NAME.parts for NAME.h5."""
    return beside(path, ".parts")


def beside(path: str | os.PathLike[str], ending: str) -> Path:
    """NAME with another ending for NAME.h5; a name without .h5 is NAME as it is."""
    path = Path(path)
    return path.with_name(f"{path.name.removesuffix('.h5')}{ending}")


def file_of(folder: Path, number: int, ending: str = ".h5") -> Path:
    """The piece of a number, from 1 on."""
    return folder / f"{number:06d}{ending}"


def pieces(folder: Path) -> list[Path]:
    """The finished pieces in their order, up to the first that is missing."""
    found = sorted(path for path in folder.glob("*.h5") if path.stem.isdecimal())
    return [path for k, path in enumerate(found) if int(path.stem) == k + 1]


def has_result(folder: Path) -> bool:
    """Whether there is anything that a run has computed."""
    return (folder / "header.json").exists() and bool(pieces(folder))


def clear(folder: Path) -> None:
    """Remove header, pieces and drafts; the lock stays."""
    for path in (folder / "header.json", *folder.glob("*.h5"), *folder.glob("*.new")):
        path.unlink(missing_ok=True)


def write_header(folder: Path, about: Mapping[str, Any]) -> None:
    """Write header.json. OSError."""
    draft = folder / "header.new"
    write_whole(draft, _text(about))
    os.replace(draft, folder / "header.json")


def read_about(path: Path, name: str = "") -> dict[str, Any]:
    """What is known of the run of NAME.h5 or NAME.parts. FileError with the name; OSError."""
    if path.is_dir():
        text: Any = (path / "header.json").read_bytes()
    else:
        with open_h5(path) as file:
            text = file["about"][()] if "about" in file else b"{}"
    about = json.loads(text)
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise FileError(f"{name or path}: is not a result of fsipetsc")
    version = about["version"]
    if version != VERSION:
        which = "newer" if version > VERSION else "older"
        raise FileError(
            f"{name or path}: was written by a{'n' * (which == 'older')} {which} fsipetsc "
            f"(file format {version}, not {VERSION})"
        )
    for part in ("header", "summary", "errors"):
        if not isinstance(about.setdefault(part, {}), dict):
            raise Damaged(f"its {part} is no table of names and values")
    return about


def run_of(path: Path) -> str | None:
    """The mark by which a result and its checkpoints know each other; None if there is none.

    FileError if it cannot be read.
    """
    if path.is_file() and not h5py.is_hdf5(path):
        return None
    with damage(str(path)):
        return read_about(path)["header"].get("run")


def new_piece(
    path: Path,
    first: tuple[int, int],
    times: Sequence[float],
    rows: Array | None,
    shapes: Mapping[str, tuple[int, ...]],
) -> None:
    """Write a piece whose datasets of these shapes are still to be filled. OSError.

    first: numbers of its first frame and step; rows: records of the series. PETSc writes to chunked
    datasets only, of less than 4 GiB a chunk.
    """
    with in_memory() as (file, image):
        file.attrs["first"] = first
        file["time"] = np.array(times, float)
        if rows is not None:
            series = file.create_group("series", track_order=True)
            for name in rows.dtype.names or ():
                series[name] = rows[name]
        for name, shape in shapes.items():
            rest = int(np.prod(shape[1:]))
            chunk = max(1, min(shape[0], (1 << 30) // (8 * rest)))
            file.create_dataset(name, shape, "f8", chunks=(chunk, *shape[1:]))
    room = 8 * sum(int(np.prod(shape)) for shape in shapes.values())
    write_whole(path, image.getvalue(), room + _SPARE)


def join(folder: Path, target: Path, about: Mapping[str, Any]) -> None:
    """Make one file of the pieces in a folder. OSError, FileError."""
    layers = about["header"]["layers"]
    try:
        with damage(str(folder)):
            content = Contents(pieces(folder), layers)
        shapes, room = _shapes(content, layers), _SPARE
        with in_memory() as (file, image):
            file["about"], file["time"] = np.bytes_(_text(about)), content.time
            if content.rows:
                file.create_group("series", track_order=True)
            for name, shape in shapes.items():
                file.create_dataset(name, shape, "f8")
                room += 8 * int(np.prod(shape)) + 1024
        write_whole(target, image.getvalue(), room)
        with open_h5(target, "r+") as file:
            _fill(file, content, layers)
        content.close()
        with open(target, "rb") as done:
            os.fsync(done.fileno())
    except BaseException:
        with suppress(OSError):
            target.unlink()
        raise


def check_kept(path: Path, files: Sequence[Path], layers: Layers, kept: Kept) -> bool:
    """Whether the files have more than a restart keeps; FileError if less. path: of the result."""
    with damage(str(path)):
        content = Contents(files, layers)
        frames, rows = content.nframes, content.rows
        enough = frames >= kept.frames and rows >= kept.rows
        t = content.series("t")[kept.rows - 1] if enough and kept.rows else kept.t
        content.close()
    if not enough or t != kept.t:
        found = f"its step {kept.rows} ends at t = {t:.17g}, not {kept.t:.17g}"
        if not enough:
            found = f"{frames} frames and {rows} steps, not {kept.frames} and {kept.rows}"
        raise FileError(f"{path} is not what the checkpoint goes on from: {found}")
    return (frames, rows) != (kept.frames, kept.rows)


def _shapes(content: Contents, layers: Layers) -> dict[str, tuple[int, ...]]:
    """The datasets of a whole result, name -> shape."""
    rows, names = content.rows, content.names.items()
    found = {f"series/{name}": (rows, *rest) for name, rest in names if rows}
    for k, layer in enumerate(layers if content.nframes else ()):
        found[f"layer{k}/X"] = content.X[k].shape
        for name in columns(layer):
            found[f"layer{k}/{name}"] = content.nframes, *layer.get("shape", content.X[k].shape)
    return found


def _fill(file: h5py.File, content: Contents, layers: Layers) -> None:
    """Put the numbers into the datasets of a whole result."""
    for name in file.get("series", ()):
        file[f"series/{name}"][...] = content.series(name)
    for k, layer in enumerate(layers if content.nframes else ()):
        group, names, X = file[f"layer{k}"], columns(layer), content.X[k]
        group["X"][...] = X
        step = max(1, _AT_ONCE // (8 * len(X) * len(names)))
        for first in range(0, content.nframes, step):
            end = min(first + step, content.nframes)
            for name, values in zip(names, content.frames(k, names, first, end)):
                group[name][first:end] = values.reshape(-1, *group[name].shape[1:])


def _text(about: Mapping[str, Any]) -> bytes:
    return json.dumps({"format": FORMAT, "version": VERSION, **about}).encode()
