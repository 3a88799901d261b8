"""How a result file is organised; shared by the writer and the reader.

    /                                   attributes format, version, case, complete
    /header, /summary, /errors          JSON text; the last two are there when the run has ended
    /time                               (nframes,) times of the saved frames; says how many frames count
    /series                             (nsteps,) records, one per time step, of numbers (t, dt, energy, …) and arrays
                                        (x_interface, …; mass); not there if there are no steps
    /segment0000/layer00/X              (n,) Lagrangian grid; of blocks (n, 1 + d), numbers of nodes and places
    /segment0000/layer00/framesA-B      (n, k·c) frames A … B: for each point, the c columns of each of the k frames
    /commits                            what can be read while the run goes on, see `commits`; of no account afterwards

The columns of a layer are its fields, then the positions x where x is not a field. A new segment begins whenever a grid
has grown. Frames share a dataset because creating one costs as much as a frame; the order point – frame – column lets
every rank write its points as one block, so that what is written does not depend on the number of ranks. In two dimensions
points are counted row by row, X is their number, and the header has shape, origin and spacing; see also `xdmf`. Of a problem
of blocks a layer is a block, points are counted with axis 0 first, and the header has their shape, (…, n_1, n_0).
"""

from __future__ import annotations

import datetime
import io
import json
import os
import re
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

from fsipetsc.output import commits, tables

FORMAT = "fsipetsc result"
CHUNK_BYTES = 2 << 20  # of frames: each is written at one go, and the system finds memory for a few MB faster than for many
VERSION = 2  # in version 1, series was a group with a dataset for each name


def open_h5(path: str | os.PathLike[str], mode: str) -> h5py.File:
    """Open with serial HDF5, without file locks: a result may be looked at while its run goes on."""
    try:
        return h5py.File(path, mode, locking=False)
    except (TypeError, ValueError):  # h5py or HDF5 too old to have the choice
        return h5py.File(path, mode)


def columns(layer: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the stored columns of a layer of the header."""
    fields = tuple(layer["fields"])
    return fields if "x" in fields else (*fields, "x")


def group_name(segment: int, layer: int) -> str:
    return f"/segment{segment:04d}/layer{layer:02d}"


def frames_name(first: int, count: int) -> str:
    """Name of the dataset of `count` frames from number `first` on."""
    return f"frames{first:08d}-{first + count - 1:08d}"


def parse_frames_name(name: str) -> tuple[int, int] | None:
    """First frame and number of frames of a dataset; None if the name is another one's."""
    match = re.fullmatch(r"frames(\d+)-(\d+)", name)
    return (int(match[1]), int(match[2]) - int(match[1]) + 1) if match else None


def chunk_places(dataset: h5py.h5d.DatasetID, n: int, rows: int) -> list[int]:
    """Where in the file the chunks of a dataset of n rows lie, `rows` in each."""
    rest = (0,) * (dataset.rank - 1)
    return [dataset.get_chunk_info_by_coord((row, *rest)).byte_offset for row in range(0, n, rows)]


def new_dataset(file: h5py.File, name: str, n: int, block: int) -> list[Any]:
    """A dataset of n points with a block of numbers each, not filled, in chunks that lie in the file already.

    Returns what a commit says of it: name, shape, points in a chunk, places of the chunks. Without filling, whatever of the
    file was there before can be written to by others at once: nobody looks yet.
    """
    rows = _share(n, -(-8 * n * block // CHUNK_BYTES))
    shape = (n, block) if block > 1 else (n,)
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((rows, *shape[1:]))
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    dataset = h5py.h5d.create(file.id, None, h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple(shape, shape), properties)
    h5py.h5o.link(dataset, file.id, name.encode(), lcpl=links)
    return [name, shape, rows, chunk_places(dataset, n, rows)]


def room_for(n: int, block: int) -> int:
    """Bytes that such a dataset takes."""
    rows = _share(n, -(-8 * n * block // CHUNK_BYTES))
    return 8 * -(-n // rows) * rows * block


def _share(n: int, parts: int) -> int:
    """Of n rows in so many chunks, or hardly fewer: HDF5 makes all chunks equally long, also the last one."""
    return -(-n // min(n, parts))


def describe(dtype: np.dtype[Any]) -> list[list[Any]]:
    """Name and shape of each column of records of doubles."""
    return [[name, list(dtype[name].shape)] for name in dtype.names or ()]


def record_type(description: list[list[Any]]) -> np.dtype[Any]:
    """The records that `describe` tells of."""
    return np.dtype([(name, "<f8", tuple(shape)) for name, shape in description])


class _Image(io.BytesIO):
    """A file in memory; h5py's driver for Python file objects uses it."""

    def truncate(self, size: int | None = None) -> int:
        length = self.tell() if size is None else size
        if length > len(self.getbuffer()):
            self.seek(length - 1)
            self.write(b"\0")
        return super().truncate(length)


def beginning(header: Mapping[str, Any], log: commits.Log) -> bytes:
    """A result of which there is no more than the header: the file, and its first commit in `log`."""
    created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
    known, image = {"created": created, **header}, _Image()
    with h5py.File(image, "w") as file:
        record = log.room(file, {"header": known})  # first, so that it is found at the beginning of the file
        file.attrs["format"], file.attrs["version"] = FORMAT, VERSION
        file.attrs["case"], file.attrs["complete"] = str(header["case"]), False
        file["header"] = json.dumps(known)
        tables.create(file, "time", np.dtype("f8"))
    content = bytearray(image.getvalue())

    def write(data: bytes, offset: int) -> None:
        content[offset : offset + len(data)] = data

    log.commit(record, write)
    return bytes(content)
