"""How a result file, and each of its pieces, is organised; shared by the writer and the reader.

    /                                   attributes format, version; first = (frame, step) of a piece
    /header, /summary, /errors          JSON text, in a whole result; of pieces: see `pieces`
    /time                               (nframes,) times of the saved frames [s]
    /series                             (nsteps,) records, one per time step, of numbers (t, dt, energy, ...) and
                                        arrays (x_interface, ...; mass); not there if there are no steps
    /segment0000/layer00/X              (n,) Lagrangian grid; of blocks (n, 1 + d), numbers of nodes and places
    /segment0000/layer00/framesA-B      (n, k c) frames A ... B: for each point, the c columns of each of the k frames

The columns of a layer are its fields, then the positions x where x is not a field. A new segment begins whenever a grid
has grown, and at a restart. The order point - frame - column lets every rank write its points as one part, so the file
does not depend on the number of ranks. Of blocks points are counted with axis 0 first; the header has their shape,
(..., n_1, n_0).

All of HDF5's metadata bears checksums (format of HDF5 1.10), so a changed byte there is an error and not a crash.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import h5py
import numpy as np

FORMAT = "fsipetsc result"
VERSION = 2
LIBVER = ("v110", "v110")
_LARGEST_CHUNK = 1 << 30  # bytes; HDF5 allows less than 4 GiB


class FrameSet(NamedTuple):
    """A dataset of consecutive frames of a layer."""

    group: str
    dataset: str
    first: int
    count: int


def open_h5(path: str | os.PathLike[str], mode: str = "r") -> h5py.File:
    """Open with serial HDF5, without file locks: a result may be looked at while its run goes on."""
    return h5py.File(path, mode, locking=False, libver=LIBVER if mode != "r" else None)


def columns(layer: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the stored columns of a layer of the header."""
    fields = tuple(layer["fields"])
    return fields if "x" in fields else (*fields, "x")


def group_name(segment: int, layer: int) -> str:
    """Group of a layer in a segment."""
    return f"/segment{segment:04d}/layer{layer:02d}"


def frames_name(first: int, count: int) -> str:
    """Dataset of `count` frames from number `first` on."""
    return f"frames{first:08d}-{first + count - 1:08d}"


def layer_groups(file: h5py.File) -> list[str]:
    """Names of all groups of layers, in ascending order."""
    return [
        f"/{segment}/{layer}"
        for segment in file
        if segment.startswith("segment") and isinstance(file.get(segment), h5py.Group)
        for layer in file[segment]
        if isinstance(file[segment].get(layer), h5py.Group)
    ]


def frame_sets(file: h5py.File, group: str) -> Iterator[FrameSet]:
    """The frames in the group of a layer."""
    for name in file[group]:
        if match := re.fullmatch(r"frames(\d{8,})-(\d{8,})", name):
            yield FrameSet(group, name, int(match[1]), int(match[2]) - int(match[1]) + 1)


def new_dataset(file: h5py.File, name: str, shape: tuple[int, ...]) -> None:
    """Doubles that are not filled: PETSc, which writes to chunked datasets only, puts the numbers there."""
    row = 8 * int(np.prod(shape[1:], dtype=int))
    chunk = (max(1, min(shape[0], _LARGEST_CHUNK // row)), *shape[1:])
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk(chunk)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape)
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F64LE, space, properties, lcpl=links)


def describe(dtype: np.dtype[Any]) -> list[list[Any]]:
    """Name and shape of each column of records of doubles."""
    return [[name, list(dtype[name].shape)] for name in dtype.names or ()]
