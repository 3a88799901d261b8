"""A result in the making: NAME.parts beside NAME.h5, a folder of finished pieces.

    lock            held by the run that writes (see `lock`)
    header.json     header; summary and errors once the run has ended
    000001.h5 ...   frames and steps since the piece before (see `file_layout`)

Each file is written under another name and renamed when it is whole: a kill costs the piece in the making. At the end
of the run the pieces are joined into NAME.h5 and the folder goes. Where there is NAME.h5 it is the result, and what the
folder of the same run still has is a leftover.
"""

from __future__ import annotations

import errno
import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from fsipetsc.errors import FileError
from fsipetsc.output import file_layout
from fsipetsc.output.file_layout import LIBVER, open_h5

Array = np.ndarray[Any, Any]
Texts = Mapping[str, Any]  # header, summary, errors
_SPARE_BYTES = 1 << 16  # for what HDF5 needs besides the numbers


class Kept(NamedTuple):
    """What a restart keeps of a result: so many frames, and rows of the series, the last of which is at time t [s]."""

    frames: int
    rows: int
    t: float


class Extent(NamedTuple):
    """First frame and row of a piece, and those behind its last ones."""

    frame: int
    row: int
    frames_end: int
    rows_end: int


def folder_of(path: str | os.PathLike[str]) -> Path:
    """NAME.parts for NAME.h5."""
    path = Path(path)
    return path.with_name(f"{path.name.removesuffix('.h5')}.parts")


def pieces(folder: Path) -> list[Path]:
    """The finished pieces in their order."""
    return sorted(path for path in folder.glob("*.h5") if path.stem.isdecimal())


def has_result(folder: Path) -> bool:
    """Whether there is anything that a run has computed."""
    return (folder / "header.json").exists() and bool(pieces(folder))


def clear(folder: Path) -> None:
    """Remove header, pieces and drafts; the lock stays."""
    for path in (folder / "header.json", *folder.glob("*.h5"), *folder.glob("*.new")):
        path.unlink(missing_ok=True)


def write_texts(folder: Path, texts: Texts) -> None:
    """Write header.json."""
    draft = folder / "header.new"
    write_whole(
        draft,
        json.dumps(
            {"format": file_layout.FORMAT, "version": file_layout.VERSION, **texts}
        ).encode(),
    )
    os.replace(draft, folder / "header.json")


def read_texts(folder: Path) -> dict[str, Any]:
    """What header.json says. ValueError if it is none of ours."""
    texts = json.loads((folder / "header.json").read_bytes())
    if not isinstance(texts, dict) or texts.get("format") != file_layout.FORMAT:
        raise ValueError("header.json is not that of a result of fsipetsc")
    return texts


def write_whole(path: Path, content: bytes, room: int = 0) -> None:
    """Write a file, with room for more bytes behind it, and let the disk have it.

    HDF5 cannot close a file on a full disk, and would crash: what it will need is reserved before. OSError.
    """
    with open(path, "wb") as file:
        file.write(content)
        file.flush()
        if room and hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(file.fileno(), len(content), room)
            except OSError as error:
                if error.errno in (
                    errno.ENOSPC,
                    errno.EDQUOT,
                    errno.EFBIG,
                ):  # others: it cannot be known here
                    raise
        os.fsync(file.fileno())


def new_piece(
    path: Path,
    first: tuple[int, int],
    times: Iterable[float],
    rows: Array | None,
    frames: Mapping[str, tuple[int, ...]],
) -> None:
    """Write a piece whose frames, name -> shape, are not filled.

    first: numbers of its first frame and row; rows: records of the series. OSError.
    """
    room = sum(8 * int(np.prod(shape)) for shape in frames.values())
    with _new_file(path, room) as file:
        file.attrs["first"] = first
        file["time"] = np.array(list(times), float)
        if rows is not None and len(rows):
            file["series"] = rows
        for name, shape in frames.items():
            file_layout.new_dataset(file, name, shape)


class _Image(io.BytesIO):
    """A file in memory; h5py's driver for Python file objects uses it."""

    def truncate(self, size: int | None = None) -> int:
        length = self.tell() if size is None else size
        if length > len(self.getbuffer()):
            self.seek(length - 1)
            self.write(b"\0")
        return super().truncate(length)


@contextmanager
def _new_file(path: Path, room: int) -> Iterator[h5py.File]:
    """A small file that is made in memory, and then written with room behind it. OSError."""
    image = _Image()
    with h5py.File(image, "w", libver=LIBVER) as file:
        file.attrs["format"], file.attrs["version"] = (
            np.bytes_(file_layout.FORMAT),
            file_layout.VERSION,
        )
        yield file
    write_whole(path, image.getvalue(), room + _SPARE_BYTES)


def extent(file: h5py.File) -> Extent:
    """What a piece, or a whole result, holds."""
    frame, row = (int(number) for number in file.attrs.get("first", (0, 0)))
    return Extent(
        frame,
        row,
        frame + len(file["time"]),
        row + (len(file["series"]) if "series" in file else 0),
    )


def in_order(files: Iterable[Path]) -> Iterator[tuple[Path, Extent]]:
    """Those of the files that follow on one another without a gap."""
    frame = row = 0
    for path in files:
        with open_h5(path) as file:
            found = extent(file)
        if found[:2] != (frame, row):
            return
        frame, row = found[2:]
        yield path, found


def join(files: list[Path], target: Path, texts: Texts) -> None:
    """Make one file of a whole result from pieces. OSError."""
    parts = list(in_order(files))
    end = parts[-1][1] if parts else Extent(0, 0, 0, 0)
    _copied([path for path, _ in parts], target, texts, Extent(0, 0, *end[2:]))


def check_kept(files: list[Path], kept: Kept) -> None:
    """FileError unless the pieces have these frames and rows."""
    parts, t = list(in_order(files)), None
    for path, (_, row, _, rows_end) in parts:
        if row < kept.rows <= rows_end:
            with open_h5(path) as file:
                t = float(file["series"]["t"][kept.rows - row - 1])
    frames, rows = parts[-1][1][2:] if parts else (0, 0)
    found = f"{frames} frames and {rows} steps, not {kept.frames} and {kept.rows}"
    if frames >= kept.frames and rows >= kept.rows:
        if kept.rows == 0 or t == kept.t:
            return
        found = f"its step {kept.rows} ends at t = {t:.17g}, not {kept.t:.17g}"
    raise FileError(
        f"{files[0].parent if files else 'it'} is not what the checkpoint goes on from: {found}"
    )


def cut(files: list[Path], folder: Path, kept: Kept) -> int:
    """Let the folder have what is kept of these files, which are its pieces or a whole result; number of its last segment."""
    segment, parts = -1, list(in_order(files))
    for path in set(pieces(folder)) - {path for path, _ in parts}:
        path.unlink()
    for path, (frame, row, frames_end, rows_end) in reversed(parts):
        beyond = frames_end > kept.frames or rows_end > kept.rows
        if path.parent == folder and beyond and frame >= kept.frames and row >= kept.rows:
            path.unlink()
            continue
        if beyond or path.parent != folder:
            draft = folder / "cut.new"
            _copied(
                [path],
                draft,
                {},
                Extent(frame, row, min(frames_end, kept.frames), min(rows_end, kept.rows)),
            )
            path = path if path.parent == folder else folder / "000001.h5"
            os.replace(draft, path)
        with open_h5(path) as file:
            segment = max(
                [segment, *(int(group[8:12]) for group in file_layout.layer_groups(file))]
            )
    return segment


def _copied(files: list[Path], target: Path, texts: Texts, kept: Extent) -> None:
    """Copy what is kept of some pieces into a new file."""
    try:
        with _new_file(target, sum(path.stat().st_size + _SPARE_BYTES for path in files)) as file:
            file.attrs["first"] = kept[:2]
            for name, text in texts.items():
                file[name] = np.bytes_(json.dumps(text))
            file.create_dataset("time", (kept.frames_end - kept.frame,), "f8")
        with open_h5(target, "r+") as out:
            for path in files:
                with open_h5(path) as file:
                    _copy(file, out, kept)
        with open(target, "rb") as done:
            os.fsync(done.fileno())
    except BaseException:
        with suppress(OSError):
            target.unlink()
        raise


def _copy(file: h5py.File, out: h5py.File, kept: Extent) -> None:
    here = extent(file)
    frames = slice(here.frame - kept.frame, min(here.frames_end, kept.frames_end) - kept.frame)
    rows = slice(here.row - kept.row, min(here.rows_end, kept.rows_end) - kept.row)
    out["time"][frames] = file["time"][: frames.stop - frames.start]
    if rows.stop > rows.start:
        table = file["series"]
        if "series" not in out:
            out.create_dataset("series", (kept.rows_end - kept.row,), table.dtype)
        out["series"][rows] = table[: rows.stop - rows.start]
    for group in file_layout.layer_groups(file):
        own = out.require_group(group)
        if "X" in file[group]:
            file.copy(f"{group}/X", own, "X")
        for _, name, first, count in file_layout.frame_sets(file, group):
            if first + count <= kept.frames_end:
                file.copy(f"{group}/{name}", own, name)
            elif first < kept.frames_end:
                whole, some = file[group][name], kept.frames_end - first
                own[file_layout.frames_name(first, some)] = whole[
                    :, : whole.shape[1] // count * some
                ]
