"""Writes the result of a run in pieces: frames in parallel through PETSc's HDF5 viewer, the rest
by rank 0. Frames and steps are kept in memory and written many at a time, for a write costs as much
as hundreds of time steps.

A file in the folder NAME.parts is written under another name and renamed when it is whole, so a
kill costs the piece in the making. At its end the run joins the pieces into NAME.h5, which is the
result wherever it is, and removes the folder. A restart makes of what it keeps of a result NAME.h5
again, which then becomes the first piece.
"""

import fcntl
import json
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import IO, Any, NamedTuple
from uuid import uuid4

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.checks import Array
from fsipetsc.errors import FileError, FsiError
from fsipetsc.output import file_layout as layout
from fsipetsc.output.file_layout import beside, publish
from fsipetsc.output.reader import open_run
from fsipetsc.output.xdmf import write_xdmf
from fsipetsc.process.together import Result, together

#: a piece is written after so many frames, bytes of a rank, or seconds
FRAMES, BYTES, SECONDS = 256, 64 << 20, 2.0
_SPARE = 1 << 16  # bytes for what HDF5 needs besides the numbers
_CHUNK = 1 << 27  # numbers: PETSc writes to chunked datasets only, of less than 4 GiB a chunk


class Kept(NamedTuple):
    """What a restart keeps of a result of this mark: frames, rows of series, t [s] at their end."""

    mark: str
    frames: int
    rows: int
    t: float


class RunWriter:
    """The result of a running computation. **Collective on `comm`**; FileError on all ranks.

    path            of the file in the end; FileError while another run is writing it
    header          JSON-able: case, options, versions, ranks, interfaces, layers (name, kind,
                    fields, shape of each), units …
    grids           of each layer the places (local, d) of the points that this rank owns; ranks own
                    points in order
    take_series     hands over, on rank 0, the steps since the last time, as an array of records
                    with "t" first, which may be overwritten later. All ranks call it
    after           what a restart keeps of a result of this name; if it is there it goes on
    checkpoint      of another run, if there is one: it gets a new name, as an earlier result does
    """

    def __init__(
        self,
        comm: MPI.Comm,
        path: str | os.PathLike[str],
        header: Mapping[str, Any],
        grids: Sequence[Array],
        take_series: Callable[[], Array],
        after: Kept | None = None,
        checkpoint: Path | None = None,
    ) -> None:
        self._comm, self._root, self._take_series = comm, comm.rank == 0, take_series
        # empty when they are written
        self._grids = [X[:, 0] if X.shape[1] == 1 else X for X in grids]
        self._points = [math.prod(layer["shape"]) for layer in header["layers"]]  # of all ranks
        widths = [len({*layer["fields"], "x"}) for layer in header["layers"]]
        size = 8 * int(np.dot(self._points, widths))
        self._capacity = max(1, min(FRAMES, BYTES * comm.size // max(1, size)))
        self._begun = time.monotonic()
        self._next_flush = self._begun + SECONDS  # rank 0's clock decides for all
        self._frames: list[list[Array]] = []  # not yet written: of each layer (local, columns)
        self._times: list[float] = []  # of these
        self._new_rows: list[Array] = []  # likewise; on rank 0
        self._lock: IO[str] | None = None  # on rank 0
        self._about = {**layout.RESULT, "header": {**header}}
        self.path = Path(os.path.realpath(path))
        self.folder = beside(self.path, ".parts")
        self.mark = ""  # on rank 0: by which this result and its checkpoints know each other
        self.moved: list[tuple[Path, Path]] = []  # likewise: old, new names of an earlier run's
        self._draft = self.folder / "draft.new"
        self._number = 1  # of the next piece, on rank 0
        try:
            #: frames given; on rank 0 rows of the series written
            self.nframes, self.rows = self._on_root(lambda: self._begin(after, checkpoint))
        except FsiError:
            self.close()
            raise

    def write_frame(self, t: float, fields: Sequence[Array]) -> None:
        """Save the fields at time t: of each layer (local, columns) of the points of this rank,
        which may have none. NaN outside the active part. Collective.
        """
        self._frames.append([np.array(of, float) for of in fields])
        self._times.append(t)
        self.nframes += 1
        self.flush(now=len(self._frames) >= self._capacity)

    def flush(self, now: bool = True) -> None:
        """Take the steps made; write all that is held in memory, now or when due. Collective."""
        begun, rows = time.monotonic(), self._take_series()
        if self._root and len(rows):
            self._new_rows.append(rows.copy())
        held, due = bool(self._frames or self._new_rows), now or begun >= self._next_flush
        if self._comm.bcast(held and due):
            self._piece()
            done = time.monotonic()
            # writing takes at most 2 % of the time, and a long run has some hundred pieces at most
            self._next_flush = done + max(SECONDS, 50 * (done - begun), 0.01 * (done - self._begun))

    def finish(self, summary: Mapping[str, Any], errors: Any, join: bool) -> None:
        """Write how the run has ended; join the pieces into one file if wanted. Collective."""
        self._about |= {"summary": summary, "errors": errors or {}}
        self._piece()
        if join:
            self._on_root(self._join)

    def close(self) -> None:
        """Let other runs have the name. What was written stays. Not collective."""
        if self._lock and not self._lock.closed:
            with suppress(OSError):
                self._draft.unlink(missing_ok=True)
                if not layout.pieces(self.folder):
                    os.unlink(self._lock.name)
                    self.folder.rmdir()
            self._lock.close()

    def _piece(self) -> None:
        """Write a piece with all that is held in memory. Collective."""
        parts = {}  # name of a dataset -> what this rank has of it, with so many points of all
        for k, n in enumerate(self._points if self._frames else ()):
            frames = np.concatenate([frame[k] for frame in self._frames], axis=1)
            parts[f"layer{k}/frames"] = frames, n
            if self._grids:
                parts[f"layer{k}/X"] = self._grids[k], n
        content: dict[str, Any] = {"time": np.array(self._times)}
        content |= {name: (n, *local.shape[1:]) for name, (local, n) in parts.items()}
        if self._new_rows:
            rows = np.concatenate(self._new_rows)
            content |= {f"series/{name}": rows[name] for name in rows.dtype.names}
        self._on_root(lambda: self._lay_out(content, _CHUNK))
        if parts:
            # HDF5 would print what it met on its way to a file that this rank cannot open
            self._together(lambda: open(self._draft, "r+b").close())
            viewer = PETSc.ViewerHDF5()
            self._together(lambda: viewer.create(str(self._draft), mode="a", comm=self._comm))
            for name, (local, _) in parts.items():
                self._together(partial(self._view, viewer, name, local))
            self._together(viewer.destroy)
            self._grids.clear()
        self._on_root(lambda: publish(self._draft, layout.piece(self.folder, self._number)))
        self._number += 1
        self.rows += sum(map(len, self._new_rows))
        for written in (self._frames, self._times, self._new_rows):
            written.clear()

    def _view(self, viewer: PETSc.Viewer, name: str, local: Array) -> None:
        """Write this rank's part of a dataset."""
        # a Vec of the world, of local length zero where the rank owns nothing: that of a part of
        # the ranks would lose data
        sizes = {"size": (local.size, None), "bsize": math.prod(local.shape[1:])}
        vec = PETSc.Vec().createWithArray(np.ascontiguousarray(local), **sizes, comm=self._comm)
        group, dataset = name.split("/")
        vec.setName(dataset)
        viewer.pushGroup(f"/{group}")
        vec.view(viewer)
        viewer.popGroup()
        vec.destroy()

    def _on_root(self, action: Callable[[], Result]) -> Result:
        """Return the value of `action` on rank 0, for all ranks; its failure too. Collective."""
        return self._comm.bcast(self._together(lambda: action() if self._root else None))

    def _together(self, action: Callable[[], Result]) -> Result:
        """Run `action` on all ranks; if it fails on one, raise on all. Collective."""
        return together(self._comm, layout.writing(self.path, "the result")(action))

    def _lay_out(self, content: Mapping[str, Any], chunk: int = 0) -> None:
        """Write a draft with this content, in which tuples are shapes of what is to be filled."""
        words = json.dumps(self._about, default=lambda v: getattr(v, "tolist", v.__str__)())
        image = layout.image({"about": np.bytes_(words), **content}, chunk)
        room = sum(8 * math.prod(of) + 1024 for of in content.values() if isinstance(of, tuple))
        with open(self._draft, "wb") as file:
            file.write(image)
            file.flush()
            # HDF5 crashes when it closes a file on a full disk, so what it needs is reserved before
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), len(image), room + _SPARE)

    def _begin(self, after: Kept | None, checkpoint: Path | None) -> tuple[int, int]:
        """Make the folder; what is not kept gets a new name. Return the frames and rows kept."""
        if os.path.lexists(self.path) and not self.path.is_file():  # such as /dev/null
            raise FileError(f"{self.path}: exists and is not a regular file")
        self._lock = lock(self.folder, str(self.path))
        found = {self.path: self.path, layout.piece(self.folder, 1): self.folder}
        there = {file: whole for file, whole in found.items() if file.exists()}
        others = [of for file, of in there.items() if after is None or _mark(file) != after.mark]
        kept = after if len(others) < len(there) else None
        self.mark = kept.mark if kept else uuid4().hex
        self._about["header"] |= {"run": self.mark}
        self.moved += [(file, set_aside(file)) for file in others]
        if self.folder in others:  # the lock goes with it
            self._lock.close()
            self._lock = lock(self.folder, str(self.path))
        if kept:
            self._join(kept)
            os.replace(self.path, layout.piece(self.folder, 1))
            self._number = 2
        else:  # pieces behind a gap, which a kill has left
            clear(self.folder)
        if checkpoint is not None:
            self.moved.append((checkpoint, set_aside(checkpoint)))
        return (kept.frames, kept.rows) if kept else (0, 0)

    def _join(self, kept: Kept | None = None) -> None:
        """Make one file of all pieces, or of what is kept. OSError; FileError if it is lost."""
        run = open_run(self.path)
        ends = run.series.get("t", np.empty(0))
        frames, rows = (kept.frames, kept.rows) if kept else (run.nframes, len(ends))
        ended = ends[rows - 1] if 0 < rows <= len(ends) else math.nan
        if kept and (run.nframes < frames or (rows and ended != kept.t)):
            found = f"it has {run.nframes} frames, and its step {rows} ends at t = {ended:.17g}"
            what = f"{self.path} is not what the checkpoint goes on from"
            raise FileError(f"{what}: {found}, not {kept.t:.17g}")
        self._about["header"]["created"] = run.header["created"]  # a restart keeps it
        content: dict[str, Any] = {"time": run.time[:frames]}
        content |= {f"series/{name}": (rows, *of.shape[1:]) for name, of in run.series.items()}
        layers = dict(enumerate(run.layers if frames else ()))
        for k, layer in layers.items():
            content[f"layer{k}/X"] = layer.places.reshape(-1, len(layer.shape)).squeeze()
            content |= {f"layer{k}/{name}": (frames, *layer.shape) for name in layer.fields}
        self._lay_out(content)
        with layout.open_h5(self._draft, "r+") as file:
            for name, values in run.series.items():
                file[f"series/{name}"][:] = values[:rows]
            for k, layer in layers.items():
                step = max(1, BYTES // (8 * math.prod(layer.shape) * len(layer.fields)))
                for first in range(0, frames, step):
                    end = min(first + step, frames)
                    for name, values in zip(layer.fields, layer.read(layer.fields, first, end)):
                        file[f"layer{k}/{name}"][first:end] = values
        publish(self._draft, self.path)
        clear(self.folder)
        if run.dimension > 1 and not kept:
            write_xdmf(run)


def _mark(file: Path) -> str | None:
    """Return the mark by which a result and its checkpoints know each other, if any."""
    with suppress(FileError), layout.opened(file, layout.RESULT) as (_, about):
        return str(about["header"]["run"])
    return None  # it is no result, or damaged


def lock(folder: Path, name: str) -> IO[str]:
    """Make a folder in which this program alone writes until it closes the file, or ends in
    whatever way; a file system without locks stops nobody. FileError if another run has it.
    """
    folder.mkdir(exist_ok=True)
    file = (folder / "lock").open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        said = "another run is writing it; give this one a name of its own with -fsi_output"
        raise FileError(f"{name}: {said}") from None
    except OSError:  # no locks here
        pass
    return file


def clear(folder: Path) -> None:
    """Remove pieces, the last one first, and drafts; the lock stays."""
    for path in (*sorted(folder.glob("*.h5"), reverse=True), *folder.glob("*.new")):
        path.unlink()


def set_aside(file: Path) -> Path:
    """Rename NAME.h5, or NAME.parts, with a free number, as NAME.1.h5; return that. OSError."""
    ending = file.suffix * (file.suffix in (".h5", ".parts"))
    stem = str(file).removesuffix(ending)
    endings, number = (ending, ".h5", ".parts"), 1
    while any(os.path.lexists(f"{stem}.{number}{of}") for of in endings):
        number += 1
    return file.rename(f"{stem}.{number}{ending}")
