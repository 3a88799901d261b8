"""Writes the result of a run in pieces: frames in parallel through PETSc's HDF5 viewer, all else by rank 0.

Frames and steps are kept in memory and written many at a time, for a write costs as much as hundreds of time steps.
How the pieces lie, and become one file: see `pieces`.
"""

from __future__ import annotations

import datetime
import json
import os
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import FileError, FsiError, is_petsc, petsc_words
from fsipetsc.output import buffers, file_layout, hdf5, pieces, xdmf
from fsipetsc.output.lock import Lock
from fsipetsc.output.pieces import Kept
from fsipetsc.output.places import check_folder
from fsipetsc.output.result_source import run_of
from fsipetsc.process.together import agree

Array = np.ndarray[Any, Any]
Result = TypeVar("Result")
Settle = Callable[[list[Path]], Mapping[Path, Path]]


class RunWriter:
    """The result of a running computation. **Collective on `comm`**.

    comm     all ranks of the run (mpi4py)
    path     of the file in the end; FileError while another run is writing it
    header   JSON-able: case, options, versions, ranks, interfaces (names), layers (name, kind, fields of each);
             units = "none" if the case is dimensionless
    after    what is kept of a result of this name and this run (header["run"]): the writer goes on behind it. Where
             there is none a new one begins.
    settle   is called on rank 0 when this run has the name, before any file is changed, with what an earlier run has left
             of the name, which it renames: old -> new names
    flush_seconds, buffer_frames, buffer_bytes
             frames are written every so many seconds (wall time; less often where that would take more than 2 % of
             them, or give thousands of pieces), and when there are about this many or this many bytes on one rank

    Set `take_series` to what hands over, on rank 0, the per-step data since the last time: an array of records, one per
    step, with "t" first; it is called by all ranks, and its array need not stay as it is.

    Every failure to write is raised as FileError on all ranks.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        path: str | os.PathLike[str],
        header: Mapping[str, Any],
        *,
        after: Kept | None = None,
        settle: Settle,
        flush_seconds: float = 2.0,
        buffer_frames: int = 256,
        buffer_bytes: int = 16 << 20,
    ) -> None:
        self.nframes = 0  # frames given so far, written or not
        self.rows = 0  # of the series, written; on rank 0
        self.take_series: Callable[[], Array | None] = lambda: None
        self._comm, self._root = comm, comm.rank == 0
        self._plane = header.get("dimension", 1) > 1
        self._widths = [len(file_layout.columns(layer)) for layer in header["layers"]]
        self._flush_seconds, self._max_frames, self._max_bytes = (
            flush_seconds,
            buffer_frames,
            buffer_bytes,
        )
        self._begun = self._last_frame = time.monotonic()
        self._next_flush = self._begun + flush_seconds
        self._buffer = buffers.FrameBuffer((), (), 1)
        self._points: list[int] = []  # of each layer, of all ranks
        self._grids_written = True
        self._times: list[float] = []  # of the frames not yet written
        self._new_rows: list[Array] = []  # likewise; on rank 0
        self._flag = np.zeros(1, np.int8)
        self._failure: str | None = None  # on rank 0, of a write that was not collective
        self._closed = False
        self._lock: Lock | None = None  # on rank 0
        self._texts: dict[str, Any] = {"header": _plain({"created": _now(), **header})}
        self.path = Path(os.path.realpath(path))
        self.folder = pieces.folder_of(self.path)
        self._number = 1  # of the next piece
        locks: list[Lock] = []
        weakref.finalize(self, _release, locks)  # whatever becomes of the run
        begun = self._on_root(lambda: self._begin(os.fspath(path), after, settle, locks))
        self.nframes, self.rows, self._segment, self._number = begun
        hdf5.be_silent()
        self._on_root(lambda: pieces.new_piece(self._draft, (0, 0), (), None, {}))
        self._open_viewer(
            lambda _: None
        )  # a file that PETSc cannot open should not be found out after hours
        self._on_root(self._draft.unlink)

    # ------------------------------------------------------------------ what the solver calls

    def start_segment(self, layers: Sequence[Mapping[str, Any]]) -> None:
        """Announce the grids of the frames to come. Collective; to be called first and whenever a grid has grown.

        Each layer has `local`, the number of points this rank owns (0 where it owns none), `n`, that of all ranks,
        and `X`, (local,) the Lagrangian coordinates in ascending order; ranks own points in the order of the ranks. Of
        blocks (local, 1 + d): numbers of points, and coordinates.
        """
        if self._times:
            self.flush()
        if self._grids_written:  # else the last segment has no frames, and this one takes its place
            self._segment += 1
        self._grids_written = False
        widths = zip(layers, self._widths, strict=True)
        largest = max(
            self._comm.allgather(sum(8 * int(layer["local"]) * width for layer, width in widths))
        )
        capacity = max(1, min(self._max_frames, self._max_bytes // max(1, largest)))
        self._points = [int(layer["n"]) for layer in layers]
        self._buffer = buffers.FrameBuffer(layers, self._widths, capacity)

    def write_frame(self, t: float, fill: Callable[[buffers.Slots], Any]) -> None:
        """Save the fields at time t. Collective.

        fill(slots) writes the columns (`file_layout.columns`) of all points of this rank there, NaN outside the active
        part.
        """
        self._check_open()
        fill(self._buffer.slots(len(self._times)))
        self._times.append(t)
        self.nframes += 1
        if self._flush_due():
            self.flush()

    def write_series(self) -> None:
        """Take the steps of `take_series`. Collective, but ranks do not wait for rank 0, which may write them."""
        self._take()
        begun = time.monotonic()
        late, large = (
            begun >= self._next_flush,
            sum(rows.nbytes for rows in self._new_rows) > self._max_bytes,
        )
        if self._root and self._failure is None and (large or (late and not self._times)):
            try:
                self._write_rows()
            except Exception as error:
                self._failure = self._explain(
                    error
                )  # raised when all ranks meet: here it would hang the others
            self._wait_after(begun)

    def flush(self) -> None:
        """Write all that is held in memory. Collective."""
        self._check_open()
        begun, count = time.monotonic(), len(self._times)
        self._take()
        if count:
            self._number = self._on_root(lambda: self._new_piece(count))
            self._open_viewer(lambda viewer: self._put_frames(viewer, count))
            self._on_root(self._publish)
            self._times.clear()
            self._grids_written = True
        else:
            self._on_root(self._write_rows)
        self._wait_after(begun)

    def finish(
        self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None = None, join: bool = True
    ) -> None:
        """Write the rest, the summary and, if known, the errors of the solution. Collective, at the end.

        join: the pieces into one file, which takes as long as it is large.
        """
        self.flush()
        self._texts |= {"summary": _plain(summary), "errors": _plain(errors or {})}
        self._on_root(lambda: self._conclude(join))
        self._buffer = buffers.FrameBuffer((), (), 1)
        self.close()

    def close(self) -> None:
        """Let other runs have the name. What was written stays. Not collective."""
        self._closed = True
        if self._lock is not None:
            self._lock.release(remove=not (self.folder / "header.json").exists())

    # ------------------------------------------------------------------ when, and failing together

    def _flush_due(self) -> bool:
        """Whether to write now: rank 0's clock decides for all. Collective."""
        if len(self._times) >= self._buffer.capacity:
            return True
        if self._root:
            now = time.monotonic()
            next_frame = now + (
                now - self._last_frame
            )  # probably; frames must not wait for one that comes late
            self._last_frame = now
            self._flag[0] = next_frame >= self._next_flush or self._failure is not None
        if self._comm.size > 1:
            self._comm.Bcast(self._flag, root=0)
        return bool(self._flag[0])

    def _wait_after(self, begun: float) -> None:
        """Set the time of the next write, by what this one took and how long the run has gone on."""
        ended = time.monotonic()
        self._next_flush = ended + max(
            self._flush_seconds, 50 * (ended - begun), 1e-3 * (ended - self._begun)
        )

    def _check_open(self) -> None:
        if self._closed:
            raise FileError(
                f"{self.path}: nothing more can be written, the result is finished or failed before"
            )

    def _on_root(self, action: Callable[[], Result]) -> Result:
        """The value of `action` on rank 0, for all ranks; its failure too. Collective."""
        return self._comm.bcast(self._together(lambda: action() if self._root else None))

    def _together(self, action: Callable[[], Result]) -> Result:
        """Run `action` on all ranks; if it fails on one, or rank 0 has failed before, raise on all. Collective."""
        value, fault = None, FileError(self._failure) if self._failure is not None else None
        try:
            value = action() if fault is None else None
        except Exception as error:
            fault = FileError(self._explain(error))
        try:
            agree(self._comm, fault)
        except FsiError:
            if self._root:
                with suppress(OSError):
                    self._draft.unlink()
            self.close()
            raise
        return value

    def _explain(self, error: Exception) -> str:
        if isinstance(error, FileError):
            return str(error)
        reason = (
            getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        )
        said = f"{self.path}: cannot write: {petsc_words(error) if is_petsc(error) else reason}"
        return f"{said}; what was written before is in {self.folder}" if self.nframes else said

    # ------------------------------------------------------------------ the files

    def _begin(
        self, path: str, after: Kept | None, settle: Settle, locks: list[Lock]
    ) -> tuple[int, int, int, int]:
        """Make the folder with its header, or go on with what is kept. On rank 0.

        Returns the frames, the rows of the series, the number of the last segment, and that of the next piece.
        """
        check_folder(path, self.path.parent)
        if self.path.is_dir():
            raise FileError(f"{path}: is a directory, not a file")
        if (
            os.path.lexists(self.path) and not self.path.is_file()
        ):  # a device or a pipe keeps its name
            raise FileError(f"{path}: exists and is not a regular file")
        if not os.access(self.path.parent, os.W_OK | os.X_OK):
            raise FileError(f"{path}: the directory {self.path.parent} is not writable")
        self._take_name(locks)
        whole, run = os.path.lexists(self.path), self._texts["header"].get("run")
        if whole and pieces.has_result(self.folder) and run_of(self.path) == run_of(self.folder):
            pieces.clear(
                self.folder
            )  # a kill came between the whole result and the end of its pieces
        own = self._plane and xdmf.earlier(
            self.path
        )  # what is none of ours is refused before anything is renamed
        found = [self.path] * whole + [self.folder] * pieces.has_result(self.folder)
        if after is not None and found and run_of(found[0]) == run:
            files = [self.path] if whole else pieces.pieces(self.folder)
            pieces.check_kept(files, after)
            settle([])
            pieces.write_texts(self.folder, self._texts)
            segment = pieces.cut(files, self.folder, after)
            if whole:
                self.path.unlink()
            numbers = [int(piece.stem) for piece in pieces.pieces(self.folder)]
            return after.frames, after.rows, segment, max(numbers, default=0) + 1
        kept = settle(found)
        if self.folder in kept:
            self._take_name(locks)
        if own:
            xdmf.make_way(self.path, kept.get(self.path))
        pieces.clear(self.folder)
        pieces.write_texts(self.folder, self._texts)
        return 0, 0, -1, 1

    def _take_name(self, locks: list[Lock]) -> None:
        before, self._lock = self._lock, Lock(self.folder, str(self.path))
        locks[:] = [self._lock]
        if before is not None:
            before.release()

    @property
    def _draft(self) -> Path:
        """The piece in the making."""
        return self.folder / f"{self._number:06d}.new"

    def _take(self) -> None:
        """Take the steps that have been made. Collective."""
        rows = self.take_series()
        if self._root and rows is not None and len(rows):
            self._new_rows.append(rows.copy())

    def _write_rows(self) -> None:
        """A piece of the series alone. On rank 0."""
        if self._new_rows:
            self._new_piece(0)
            self._publish()

    def _datasets(self, count: int) -> Iterator[tuple[str, int, Array]]:
        """What the last `count` frames need: name, layer, and this rank's points, of each dataset."""
        frames = file_layout.frames_name(self.nframes - count, count)
        for i, X in enumerate(self._buffer.X):
            group = file_layout.group_name(self._segment, i)
            if not self._grids_written:
                yield f"{group}/X", i, X
            yield f"{group}/{frames}", i, self._buffer.part(i, count)

    def _new_piece(self, count: int) -> int:
        """Begin the next piece, in which frames are not filled yet; its number. On rank 0."""
        shapes = {
            name: (self._points[i], local.shape[1])[: 1 + (local.shape[1] > 1)]
            for name, i, local in (self._datasets(count) if count else ())
        }
        rows = np.concatenate(self._new_rows) if self._new_rows else None
        first = self.nframes - len(self._times), self.rows
        pieces.new_piece(self._draft, first, self._times[:count], rows, shapes)
        return self._number

    def _publish(self) -> None:
        """Give the piece its name. On rank 0."""
        with open(self._draft, "rb") as file:
            os.fsync(file.fileno())
        os.replace(self._draft, self._draft.with_suffix(".h5"))
        self._number += 1
        self.rows += sum(map(len, self._new_rows))
        self._new_rows.clear()

    def _open_viewer(self, action: Callable[[PETSc.Viewer], Any]) -> None:
        """Do something with PETSc's viewer of the piece in the making. Collective."""
        self._try_mpi()
        viewer = PETSc.ViewerHDF5()
        self._together(lambda: viewer.create(str(self._draft), mode="a", comm=self._comm))
        try:
            action(viewer)
        finally:
            self._together(viewer.destroy)

    def _try_mpi(self) -> None:
        """Let MPI open the file (0.3 ms): PETSc could not destroy a viewer that has none. Collective."""
        files = []

        def attempt() -> None:
            try:
                files.append(MPI.File.Open(self._comm, str(self._draft), MPI.MODE_RDWR))
            except MPI.Exception as error:
                raise FileError(
                    f"{self.path}: cannot write: MPI cannot open it ({error.Get_error_string()})"
                ) from None

        self._together(attempt)  # all have opened it, or it is left alone: closing takes all
        self._together(lambda: files[0].Close())

    def _put_frames(self, viewer: PETSc.Viewer, count: int) -> None:
        """Put the last `count` frames into their datasets. Collective."""
        for name, _, local in self._datasets(count):
            self._together(lambda: self._view(viewer, name, local))  # noqa: B023

    def _view(self, viewer: PETSc.Viewer, name: str, local: Array) -> None:
        # a Vec of the world, of local length zero where the rank owns nothing: a smaller one would lose data
        size, block = (local.size, None), local.shape[1]
        vec = PETSc.Vec().createWithArray(
            np.ascontiguousarray(local), size=size, bsize=block, comm=self._comm
        )
        group, dataset = name.rsplit("/", 1)
        vec.setName(dataset)
        viewer.pushGroup(group)
        vec.view(viewer)
        viewer.popGroup()
        vec.destroy()

    def _conclude(self, join: bool) -> None:
        """Write the header with the summary, and make one file of the pieces. On rank 0."""
        pieces.write_texts(self.folder, self._texts)
        if not join:
            return
        whole = self.folder / "joined.new"
        pieces.join(pieces.pieces(self.folder), whole, self._texts)
        os.replace(whole, self.path)
        pieces.clear(self.folder)
        if self._plane:
            xdmf.write(self.path)


def _release(locks: list[Lock]) -> None:
    for lock in locks:
        lock.release()


def _now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data as JSON can say it."""

    def plain(value: Any) -> Any:
        return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)

    return json.loads(json.dumps(data, default=plain))
