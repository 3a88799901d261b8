"""Writes the result of a run in pieces: frames in parallel through PETSc's HDF5 viewer, the rest
by rank 0.

Frames and steps are kept in memory and written many at a time, for a write costs as much as
hundreds of time steps.
"""

import fcntl
import itertools
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.errors import FileError, FsiError, petsc_words, reason
from fsipetsc.output import pieces
from fsipetsc.output.file_layout import beside, check_folder, columns, put
from fsipetsc.output.pieces import Kept
from fsipetsc.output.reader import Layer, Run, open_run
from fsipetsc.process.together import together

Array = np.ndarray[Any, Any]
Result = TypeVar("Result")
#: a piece is written after so many frames, bytes of a rank, or seconds
FRAMES, BYTES, SECONDS = 256, 64 << 20, 2.0


class RunWriter:
    """The result of a running computation. **Collective on `comm`**.

    comm            all ranks of the run (mpi4py)
    path            of the file in the end; FileError while another run is writing it
    header          JSON-able: case, options, versions, ranks, interfaces (names), layers (name,
                    kind, fields of each; of blocks shape); units = "none" without dimensions
    grids           of each layer `n`, the number of points of all ranks, and `X`, (local,) the
                    Lagrangian coordinates of those that this rank owns in ascending order, of
                    blocks (local, d) the places of the nodes; ranks own points in their order
    take_series     hands over, on rank 0, the steps since the last time, as an array of records
                    with "t" first, which need not stay as it is. All ranks call it
    after           what is kept of a result of this name and this run (header["run"]): the writer
                    goes on after it. Where there is none a new one begins
    checkpoint      of another run, if there is one: it gets a new name, as an earlier result does
    moved           on rank 0, old and new names of what an earlier run has left

    Every failure to write is raised as FileError on all ranks.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        path: str | os.PathLike[str],
        header: Mapping[str, Any],
        grids: Sequence[Mapping[str, Any]],
        take_series: Callable[[], Array],
        after: Kept | None = None,
        checkpoint: Path | None = None,
    ) -> None:
        self._comm, self._root, self._take_series = comm, comm.rank == 0, take_series
        self._widths = [len(columns(layer)) for layer in header["layers"]]
        size = 8 * sum(int(grid["n"]) * width for grid, width in zip(grids, self._widths))
        self._capacity = max(1, min(FRAMES, BYTES * comm.size // max(1, size)))
        self._begun = time.monotonic()
        self._next_flush = self._begun + SECONDS
        self._grids, self._grids_written = list(grids), False
        self._frames: list[list[Array]] = []  # not yet written: of each layer (local, columns)
        self._times: list[float] = []  # of these
        self._new_rows: list[Array] = []  # likewise; on rank 0
        self._lock: Lock | None = None  # on rank 0
        self._about: dict[str, Any] = {"header": _plain(header)}
        self.path = Path(os.path.realpath(path))
        self.folder = beside(self.path, ".parts")
        self.moved: list[tuple[Path, Path]] = []
        self._number = 1
        #: frames given; on rank 0 rows of the series written; number of the next piece
        self.nframes, self.rows, self._number = self._on_root(
            lambda: self._begin(os.fspath(path), after, checkpoint)
        )

    def write_frame(self, t: float, fields: Mapping[int, Array]) -> None:
        """Save the fields at time t: of layers, by number, (local, columns) of the points of this
        rank, if it has some. NaN outside the active part. Collective.
        """
        none = [np.empty((0, width)) for width in self._widths]
        self._frames.append([np.array(fields.get(k, none[k]), float) for k in range(len(none))])
        self._times.append(t)
        self.nframes += 1
        if len(self._frames) >= self._capacity or self._late():
            self.flush()

    def write_series(self) -> None:
        """Take the steps that have been made, and write them if it is time. Collective."""
        self._take()
        if self._late():
            self.flush()

    def flush(self) -> None:
        """Write all that is held in memory. Collective."""
        begun = time.monotonic()
        self._take()
        if not self._comm.bcast(bool(self._frames or self._new_rows)):
            return
        parts = list(self._datasets())
        self._on_root(lambda: self._new_piece({name: shape for name, shape, _ in parts}))
        if parts:
            viewer = PETSc.ViewerHDF5()
            # HDF5 would print what it met on its way to a file that this rank cannot open
            self._together(lambda: open(self._draft, "r+b").close())
            self._together(lambda: viewer.create(str(self._draft), mode="a", comm=self._comm))
            for name, _, local in parts:
                self._together(partial(view, self._comm, viewer, name, local))
            self._together(viewer.destroy)
            self._grids_written = True
        self._on_root(lambda: pieces.publish(self._draft))
        self.rows += sum(map(len, self._new_rows))
        self._number += 1
        for written in (self._frames, self._times, self._new_rows):
            written.clear()
        now = time.monotonic()
        # writing takes at most 2 % of the time, and a long run has at most some hundred pieces
        self._next_flush = now + max(SECONDS, 50 * (now - begun), 0.01 * (now - self._begun))

    def finish(
        self, summary: Mapping[str, Any], errors: Mapping[str, Any] | None = None, join: bool = True
    ) -> None:
        """Write the rest, the summary and, if known, the errors of the solution; join the pieces
        into one file, which takes as long as it is large. Collective.
        """
        self.flush()
        self._about |= {"summary": _plain(summary), "errors": _plain(errors or {})}
        self._on_root(lambda: self._conclude(join))
        self.close()

    def close(self) -> None:
        """Let other runs have the name. What was written stays. Not collective."""
        if self._lock is not None:
            self._lock.release(remove=not (self.folder / "header.json").exists())

    # failing together

    def _late(self) -> bool:
        """Tell whether it is time to write: rank 0's clock decides for all. Collective."""
        return bool(self._comm.bcast(self._root and time.monotonic() >= self._next_flush))

    def _on_root(self, action: Callable[[], Result]) -> Result:
        """Return the value of `action` on rank 0, for all ranks; its failure too. Collective."""
        return self._comm.bcast(self._together(lambda: action() if self._root else None))

    def _together(self, action: Callable[[], Result]) -> Result:
        """Run `action` on all ranks; if it fails on one, raise on all. Collective."""

        def explained() -> Result:
            try:
                return action()
            except FileError:
                raise
            except Exception as error:
                words = petsc_words(error) if hasattr(error, "ierr") else reason(error)
                words = getattr(error, "strerror", None) or words
                before = f"; what was written before is in {self.folder}" * (self._number > 1)
                raise FileError(f"{self.path}: cannot write: {words}{before}") from error

        try:
            return together(self._comm, explained)
        except FsiError:
            if self._root:
                with suppress(OSError):
                    self._draft.unlink()
            self.close()
            raise

    # the files, on rank 0

    def _begin(
        self, path: str, after: Kept | None, checkpoint: Path | None
    ) -> tuple[int, int, int]:
        """Make the folder with its header, or go on with what is kept; the frames, the rows of the
        series, and the number of the next piece.
        """
        check_folder(path)
        if os.path.lexists(self.path) and not self.path.is_file():  # a device keeps its name
            raise FileError(f"{path}: exists and is not a regular file")
        self._lock = Lock(self.folder, str(self.path))
        header, whole = self._about["header"], os.path.lexists(self.path)
        in_pieces = (self.folder / "header.json").exists() and bool(pieces.pieces(self.folder))
        if whole and in_pieces:  # what a kill has left of the same run's pieces is cleared below
            in_pieces = pieces.run_of(self.path) != pieces.run_of(self.folder)
        found = [self.path] * whole + [self.folder] * in_pieces
        frames, rows, goes_on = 0, 0, False
        if after is not None and found and pieces.run_of(found[0]) == header.get("run"):
            files = [self.path] if whole else pieces.pieces(self.folder)
            pieces.check_kept(files, header, after, self.path)
            (frames, rows, _), goes_on = after, True
            del found[0]
        for file in ([] if checkpoint is None else [checkpoint]) + found:
            self.moved.append((file, set_aside(file)))
            if file == self.folder:  # the lock has gone with it
                self._lock.release()
                self._lock = Lock(self.folder, str(self.path))
        if whole or not goes_on:
            pieces.clear(self.folder)
        put(self.folder / "header.json", pieces.text_of(self._about))
        if whole and goes_on:
            os.replace(self.path, pieces.file_of(self.folder, 1))
        number = len(pieces.pieces(self.folder)) + 1
        if goes_on:  # a piece without frames: what came after the checkpoint is given up
            draft = pieces.file_of(self.folder, number, ".new")
            pieces.lay_out(draft, {"time": np.empty(0)}, {}, (frames, rows))
            pieces.publish(draft)
        return frames, rows, number + goes_on

    @property
    def _draft(self) -> Path:
        return pieces.file_of(self.folder, self._number, ".new")

    def _take(self) -> None:
        """Take the steps that have been made. Collective."""
        rows = self._take_series()
        if self._root and len(rows):
            self._new_rows.append(rows.copy())

    def _datasets(self) -> Iterator[tuple[str, tuple[int, ...], Array]]:
        """Yield what the frames that are held need: name, shape, and this rank's part."""
        for k, layer in enumerate(self._grids if self._frames else ()):
            n, X = int(layer["n"]), np.asarray(layer["X"], float)
            if not self._grids_written:
                X = X[:, 0] if X.shape[1:] == (1,) else X
                yield f"layer{k}/X", (n, *X.shape[1:]), X
            local = np.concatenate([frame[k] for frame in self._frames], axis=1)
            yield f"layer{k}/frames", (n, local.shape[1]), local

    def _new_piece(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        numbers = {"time": np.array(self._times, float)}
        if self._new_rows:
            rows = np.concatenate(self._new_rows)
            numbers |= {f"series/{name}": rows[name] for name in rows.dtype.names}
        first = self.nframes - len(self._times), self.rows
        pieces.lay_out(self._draft, numbers, shapes, first)

    def _conclude(self, join: bool) -> None:
        """Write the header with the summary, and make one file of the pieces."""
        put(self.folder / "header.json", pieces.text_of(self._about))
        if join:
            whole = self.folder / "joined.new"
            pieces.join(pieces.pieces(self.folder), whole, self._about, self.path)
            os.replace(whole, self.path)
            pieces.clear(self.folder)
            if self._about["header"].get("dimension", 1) > 1:
                write_xdmf(self.path)


def view(comm: MPI.Comm, viewer: PETSc.Viewer, name: str, local: Array) -> None:
    """Write this rank's part of a dataset of the piece in the making. Collective."""
    # a Vec of the world, of local length zero where the rank owns nothing: that of a part of
    # the ranks would lose data
    width = local.shape[1] if local.ndim > 1 else 1
    vec = PETSc.Vec().createWithArray(
        np.ascontiguousarray(local), size=(local.size, None), bsize=width, comm=comm
    )
    group, dataset = name.split("/")
    vec.setName(dataset)
    viewer.pushGroup(f"/{group}")
    vec.view(viewer)
    viewer.popGroup()
    vec.destroy()


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data as JSON can say it."""
    return json.loads(json.dumps(data, default=lambda v: getattr(v, "tolist", v.__str__)()))


class Lock:
    """The right to write in a folder, which is made if need be, until `release`. The system takes
    it back when the program ends in whatever way; a file system without locks gives it to all.

    FileError if another run has it; OSError where no folder can be made.
    """

    def __init__(self, folder: Path, what: str) -> None:
        self.path = folder / "lock"
        folder.mkdir(exist_ok=True)
        self._file = self.path.open("a")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            said = "another run is writing it; give this one a name of its own with -fsi_output"
            raise FileError(f"{what}: {said}") from None
        except OSError:  # no locks here
            pass

    def release(self, remove: bool = False) -> None:
        """Let other runs have the name. remove: the folder, if nothing else is in it."""
        if remove and not self._file.closed:
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()
        self._file.close()


def set_aside(file: Path) -> Path:
    """Give NAME.h5 or NAME.parts the first number that no result has, as NAME.1.h5 or NAME.1.parts,
    which it returns. OSError.
    """
    ending = file.suffix if file.suffix in (".h5", ".parts") else ""
    stem = file.name.removesuffix(ending)
    for k in itertools.count(1):
        names = [file.with_name(f"{stem}.{k}{last}") for last in ("", ".h5", ".parts")]
        if not any(map(os.path.lexists, names)):
            break
    return file.rename(file.with_name(f"{stem}.{k}{ending}"))


# NAME.xdmf beside the result of blocks in two or three dimensions, for ParaView and VTK. It holds
# no numbers: a collection over time of collections of blocks, each a curvilinear grid, in two
# dimensions one point deep (with a 2DSMesh, VTK's reader takes no vectors). The datasets have all
# frames; a HyperSlab takes one of them.

_HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n'


def write_xdmf(path: Path) -> None:
    """Write it beside a finished result. FileError if another file has the name; OSError."""
    target = beside(path, ".xdmf")
    if target.exists() and not target.read_text(errors="replace").startswith(_HEAD):
        raise FileError(f"{target}: is no XDMF of a result, and is left; {path} is complete")
    with open_run(path) as run:
        put(target, "".join(_xdmf(run)).encode())


def _xdmf(run: Run) -> Iterator[str]:
    file = escape(os.path.basename(run.path))
    name = quoteattr(run.case)
    yield _HEAD + f'<Domain><Grid Name={name} GridType="Collection" CollectionType="Temporal">\n'
    for frame, t in enumerate(run.time):
        yield f'<Grid Name="frame {frame}" GridType="Collection" CollectionType="Spatial">\n'
        yield f'<Time Value="{float(t)!r}"/>\n'
        for k, layer in enumerate(run.layers):
            yield from _xdmf_block(layer, f"{file}:/layer{k}", frame, run.nframes)
        yield "</Grid>\n"
    yield "</Grid></Domain>\n</Xdmf>\n"


def _xdmf_block(layer: Layer, group: str, frame: int, nframes: int) -> Iterator[str]:
    d, shape = len(layer.shape), " ".join(map(str, layer.shape))
    grid = f"1 {shape}" if d == 2 else shape

    def slab(field: str) -> str:
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{grid}">'
            f'<DataItem Dimensions="3 {d + 1}" Format="XML">'
            f"{frame}{' 0' * d} 1{' 1' * d} 1 {shape}</DataItem>"
            f'<DataItem Dimensions="{nframes} {shape}" NumberType="Float" Precision="8" '
            f'Format="HDF">{group}/{field}</DataItem></DataItem>'
        )

    def joined(fields: str) -> str:
        """Return vectors of these components."""
        function = ", ".join(f"${k}" for k in range(d))
        return (
            f'<DataItem ItemType="Function" Function="JOIN({function})" Dimensions="{grid} {d}">'
            f"{''.join(map(slab, fields[:d]))}</DataItem>"
        )

    yield f'<Grid Name={quoteattr(layer.name)} GridType="Uniform">\n'
    yield f'<Topology TopologyType="3DSMesh" Dimensions="{grid}"/>\n'
    yield f'<Geometry GeometryType="{"XYZ"[:d]}">{joined("xyz")}</Geometry>\n'
    attribute = '<Attribute Name="{}" AttributeType="{}" Center="Node">{}</Attribute>\n'
    for name in layer.fields:
        if name not in "xyz"[:d]:
            yield attribute.format(name, "Scalar", slab(name))
    yield attribute.format("velocity", "Vector", joined("uvw"))
    yield "</Grid>\n"
