"""Writes the result file of a run: frames in parallel through PETSc's HDF5 viewer, everything else by rank 0.

Frames and steps are kept in memory and written many at a time, for a write costs as much as hundreds of time steps.
The viewer is opened and closed for each write. What has been written is committed in the end (see `commits`): whoever reads
the file of a running or killed run finds all of the last flush, and nothing of what comes after it.

Other ways were weighed. A file for each flush, renamed when whole, has to be copied into one in the end, which costs as
much as writing it; a copy of what is overwritten, beside the file, protects who comes after a kill but not who reads at
the same time; HDF5's own single-writer mode excludes parallel writing. A commit is two small writes.
"""

from __future__ import annotations

import glob
import itertools
import json
import os
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import FileError, FsiError, is_petsc, petsc_words
from fsipetsc.output import buffers, claim, commits, continued, file_layout, hdf5, tables, transaction, xdmf
from fsipetsc.output.places import check_folder
from fsipetsc.process.together import agree

Array = np.ndarray[Any, Any]
Result = TypeVar("Result")
Identity = tuple[int, int]  # device and number of a file
Settle = Callable[[Path | None], Path | None]
SPARE_BYTES = 256 << 10  # for what HDF5 needs besides the numbers


class RunWriter:
    """The result file of a running computation. **Collective on `comm`**.

    comm     all ranks of the run (mpi4py)
    path     the file; an existing one is kept under the first free name NAME.1.h5, NAME.2.h5 … (see `kept_as`), but
             FileError is raised while another run is writing it
    header   JSON-able: case, options, versions, ranks, interfaces (names), layers (name, kind, fields of each);
             units = "none" if the case is dimensionless
    after    what of this run, by header["run"], a file of this name is to keep: the writer goes on behind it, and what else is
             in it is cut off. Where there is no such file a new one begins.
    settle   is called on rank 0 when all that can be known before is known to be well, and no file has changed; with an earlier
             result that is to be kept, None if there is none. It may give that one its new name, which it then returns
    flush_seconds, buffer_frames, buffer_bytes
             frames are written every so many seconds (wall time; less often if a write takes more than 2 % of them),
             and when there are about this many or this many bytes on one rank

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
        after: continued.Kept | None = None,
        settle: Settle = lambda earlier: None,
        flush_seconds: float = 2.0,
        buffer_frames: int = 256,
        buffer_bytes: int = 16 << 20,
    ) -> None:
        self.kept_as: Path | None = None  # new name of the earlier result of this name
        self.nframes = 0  # frames given so far, written or not
        self.take_series: Callable[[], Array | None] = lambda: None
        self._comm, self._root = comm, comm.rank == 0
        self._plane = header.get("dimension", 1) > 1
        self._widths = [len(file_layout.columns(layer)) for layer in header["layers"]]
        self._flush_seconds, self._max_frames, self._max_bytes = flush_seconds, buffer_frames, buffer_bytes
        self._last_frame = time.monotonic()
        self._next_flush = self._last_frame + flush_seconds
        self._buffer = buffers.FrameBuffer((), (), 1)
        self._points: list[int] = []  # of each layer, of all ranks
        self._grids_written = True
        self._times: list[float] = []  # of the frames not yet written
        self._flag = np.zeros(1, np.int8)
        self._release: Callable[[], Any] = lambda: None  # on rank 0: lets other runs have the name
        self._failure: str | None = None  # on rank 0, of a write that was not collective
        self._closed = False
        self._log = commits.Log()  # with what follows: on rank 0
        self._new_frames: list[list[Any]] = []  # datasets of the frames that are being written
        self.path = Path(path)
        self.path, self.kept_as, self._identity, kept = self._on_root(lambda: self._create(path, header, after, settle))
        self.nframes, self._steps, self._segment = kept
        hdf5.be_silent()
        with self._viewer():  # a file that PETSc cannot open should not be found out after hours
            pass

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
        frame_bytes = sum(8 * int(layer["local"]) * width for layer, width in zip(layers, self._widths, strict=True))
        largest = max(self._comm.allgather(frame_bytes))
        capacity = max(1, min(self._max_frames, self._max_bytes // max(1, largest)))
        self._points = [int(layer["n"]) for layer in layers]
        self._buffer = buffers.FrameBuffer(layers, self._widths, capacity)

    def write_frame(self, t: float, fill: Callable[[buffers.Slots], Any]) -> None:
        """Save the fields at time t. Collective.

        fill(slots) writes the columns (`file_layout.columns`) of all points of this rank there, NaN outside the active part.
        """
        self._check_open()
        fill(self._buffer.slots(len(self._times)))
        self._times.append(t)
        self.nframes += 1
        if self._flush_due():
            self.flush()

    def write_series(self) -> None:
        """Write what `take_series` hands over. Collective, but ranks do not wait for rank 0's write."""
        rows = self.take_series()
        if self._root and self._failure is None:
            try:  # nobody else can have the file open: all opens but this wait for rank 0
                self.path = self._locate()
                self._record(0, rows)
            except Exception as error:
                self._failure = self._explain(error)  # to be raised when all ranks meet: here, it would hang the others

    def flush(self) -> None:
        """Write all that is held in memory. Collective."""
        self._check_open()
        begun, count = time.monotonic(), len(self._times)
        self.path = self._on_root(self._locate)
        if count:
            first = self._on_root(lambda: self._prepare(count))
            self._view_frames(count)
            self._on_root(lambda: transaction.leave_to_disk(self.path, first))
        rows = self.take_series()  # not before: PETSc makes the disk take all that is new in the file
        self._on_root(lambda: self._record(count, rows))
        self._times.clear()
        self._grids_written |= count > 0
        ended = time.monotonic()  # disks differ: each write of HDF5 waits until it is there
        self._next_flush = ended + max(self._flush_seconds, 50 * (ended - begun))

    def finish(self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None = None) -> None:
        """Write the rest, the summary and, if known, the errors of the solution. Collective, at the end."""
        self.flush()
        self._on_root(lambda: self._conclude(summary, errors))
        self._release()
        self._buffer = buffers.FrameBuffer((), (), 1)
        self._closed = True

    # ------------------------------------------------------------------ when, and failing together

    def _flush_due(self) -> bool:
        """Whether to write now: rank 0's clock decides for all. Collective."""
        if len(self._times) >= self._buffer.capacity:
            return True
        if self._root:
            now = time.monotonic()
            next_frame = now + (now - self._last_frame)  # probably; frames must not wait for one that comes late
            self._last_frame = now
            self._flag[0] = next_frame >= self._next_flush or self._failure is not None
        if self._comm.size > 1:
            self._comm.Bcast(self._flag, root=0)
        return bool(self._flag[0])

    def _check_open(self) -> None:
        if self._closed:
            raise FileError(f"{self.path}: nothing more can be written, the result is finished or failed before")

    def _on_root(self, action: Callable[[], Result]) -> Result:
        """The value of `action` on rank 0, for all ranks; its failure too. Collective."""
        value: Any = None
        fault: FsiError | None = FileError(self._failure) if self._failure is not None else None
        if self._root and fault is None:
            try:
                value = action()
            except Exception as error:
                fault = FileError(self._explain(error))
        self._agree(fault)
        return self._comm.bcast(value, root=0)

    def _together(self, action: Callable[[], Any]) -> None:
        """Run `action` on all ranks; if it fails on one, raise on all. Collective."""
        fault = None
        try:
            action()
        except Exception as error:
            fault = FileError(self._explain(error))
        self._agree(fault)

    def _agree(self, fault: FsiError | None) -> None:
        """Raise the fault of any rank on all ranks. Collective."""
        try:
            agree(self._comm, fault)
        except FsiError:
            self._closed = True
            self._release()
            raise

    def _explain(self, error: Exception) -> str:
        if isinstance(error, FileError):
            return str(error)
        if is_petsc(error):
            return f"{self.path}: cannot write: {petsc_words(error)}"
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        return f"{self.path}: cannot write: {reason}"

    # ------------------------------------------------------------------ the file

    @property
    def rows(self) -> int:
        """Of the series in the file. On rank 0."""
        return self._steps

    def _create(
        self,
        path: str | os.PathLike[str],
        header: Mapping[str, Any],
        after: continued.Kept | None,
        settle: Settle,
    ) -> tuple[Path, Path | None, Identity, tuple[int, int, int]]:
        """Make the file with its header, or take one that is to be gone on with. On rank 0.

        Returns its path, the new name of an earlier one, its identity, and frames, rows of the series and number of the last
        segment that it has.
        """
        target = Path(os.path.realpath(path))
        check_folder(path, target.parent)
        if target.is_dir():
            raise FileError(f"{path}: is a directory, not a file")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise FileError(f"{path}: the directory {target.parent} is not writable")
        claimed = claim.Claim(target)
        self._release = weakref.finalize(self, claimed.release)
        if self._plane:
            xdmf.earlier(target)  # what is none refuses the run, before ``settle`` has renamed anything
        if after is not None and continued.is_of(target, header["run"]):
            segment = continued.cut(target, after, _plain(header), self._log, lambda: settle(None))
            return target, None, _identity(target), (after.frames, after.rows, segment)
        kept_as = settle(target if claim.is_there(target) else None)
        content = file_layout.beginning(_plain(header), self._log)
        while True:
            kept_as = claim.keep_earlier(target) or kept_as
            if self._plane:
                xdmf.make_way(target, kept_as)
            identity = claim.publish(target, content)
            if identity is not None:
                return target, kept_as, identity, (0, 0, -1)

    def _locate(self) -> Path:
        """The file's present path. On rank 0. A later run of the same name may have renamed it: follow it there."""
        others = self.path.parent.glob(f"{glob.escape(self.path.stem)}.*{glob.escape(self.path.suffix)}")
        for candidate in itertools.chain([self.path], others):
            if candidate.exists() and _identity(candidate) == self._identity:
                return candidate
        raise FileError(f"{self.path}: was removed or replaced while the run was writing it")

    def _datasets(self, count: int) -> Iterator[tuple[str, int, Array]]:
        """What the last `count` frames need: name, layer, and this rank's points, of each dataset."""
        frames = file_layout.frames_name(self.nframes - count, count)
        for i, X in enumerate(self._buffer.X):
            group = file_layout.group_name(self._segment, i)
            if not self._grids_written:
                yield f"{group}/X", i, X
            yield f"{group}/{frames}", i, self._buffer.part(i, count)

    def _prepare(self, count: int) -> int:
        """Create the datasets of the last `count` frames, not filled; the file's size before. On rank 0.

        PETSc could create them, but it would write zeros first, and a program killed in the midst could leave a file
        that cannot be read. Like this PETSc only puts numbers where nobody looks yet.
        """
        datasets = [(name, self._points[i], local.shape[1]) for name, i, local in self._datasets(count)]
        size = self.path.stat().st_size
        transaction.ensure_space(self.path, sum(file_layout.room_for(n, block) for _, n, block in datasets) + SPARE_BYTES)
        with transaction.changes(self.path) as file:
            self._new_frames = [file_layout.new_dataset(file, *entry) for entry in datasets]
        return size

    def _view_frames(self, count: int) -> None:
        """Put the last `count` frames into their datasets through PETSc. Collective."""

        def view(viewer: PETSc.Viewer, name: str, local: Array) -> None:
            # a Vec of the world, of local length zero where the rank owns nothing: a smaller one would lose data
            size, block = (local.size, None), local.shape[1]
            vec = PETSc.Vec().createWithArray(np.ascontiguousarray(local), size=size, bsize=block, comm=self._comm)
            group, dataset = name.rsplit("/", 1)
            vec.setName(dataset)
            viewer.pushGroup(group)
            vec.view(viewer)
            viewer.popGroup()
            vec.destroy()

        with self._viewer() as viewer:
            for name, _, local in self._datasets(count):
                self._together(lambda: view(viewer, name, local))  # noqa: B023

    @contextmanager
    def _viewer(self) -> Iterator[PETSc.Viewer]:
        """PETSc's viewer of the file. Collective."""
        self._try_mpi()
        viewer = PETSc.ViewerHDF5()
        self._together(lambda: viewer.create(str(self.path), mode="a", comm=self._comm))
        try:
            yield viewer
        finally:
            self._together(viewer.destroy)

    def _try_mpi(self) -> None:
        """Let MPI open the file (0.3 ms): PETSc could not destroy a viewer that has none. Collective."""
        files = []

        def attempt() -> None:
            try:
                files.append(MPI.File.Open(self._comm, str(self.path), MPI.MODE_RDWR))
            except MPI.Exception as error:
                raise FileError(f"{self.path}: cannot write: MPI cannot open it ({error.Get_error_string()})") from None

        self._together(attempt)  # all have opened it, or it is left alone: closing takes all
        self._together(lambda: files[0].Close())

    def _record(self, count: int, rows: Array | None) -> None:
        """Append rows of the series, then make the last `count` frames valid. On rank 0, when no viewer is open."""
        new = 0 if rows is None else len(rows)
        if new + count == 0:
            return
        entry: dict[str, Any] = {}
        with transaction.changes(self.path) as file:
            if new:
                places = tables.append(file, "series", rows, self._steps)
                entry["series"] = {"rows": self._steps + new, "places": places, "columns": file_layout.describe(rows.dtype)}
            if count:
                places = tables.append(file, "time", np.array(self._times), self.nframes - count)
                entry["time"] = {"rows": self.nframes, "places": places}
                entry["frames"] = self._new_frames
            record = self._log.room(file, entry)
        with self._raw() as write:
            self._log.commit(record, write)
        self._steps += new

    def _conclude(self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None) -> None:
        with transaction.changes(self.path) as file:
            file["summary"] = json.dumps(_plain(summary))
            if errors is not None:
                file["errors"] = json.dumps(_plain(errors))
            file.attrs["complete"] = True
        with self._raw() as write:
            self._log.end(write)
        if self._plane:
            xdmf.write(self.path)

    @contextmanager
    def _raw(self) -> Iterator[Callable[[bytes, int], None]]:
        """A function that writes bytes at an offset of the file, without HDF5."""
        descriptor = os.open(self.path, os.O_WRONLY)

        def write(data: bytes, offset: int) -> None:
            if os.pwrite(descriptor, data, offset) != len(data):
                raise OSError(f"{len(data)} bytes could not be written")

        try:
            yield write
        finally:
            os.close(descriptor)


def _identity(path: Path) -> Identity:
    status = path.stat()
    return status.st_dev, status.st_ino


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data as JSON can say it."""

    def plain(value: Any) -> Any:
        return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)

    return json.loads(json.dumps(data, default=plain))
