"""Datasets of the result file that grow: a row per step or per frame."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

Array = np.ndarray[Any, Any]

ROWS = 1 << 10  # rows in a chunk


def create(file: h5py.File, name: str, dtype: np.dtype[Any]) -> None:
    """An empty table."""
    # only rows that are written count: nothing needs filling, and then HDF5 takes whole chunks as they lie in memory
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((ROWS,))
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple((0,), (h5py.h5s.UNLIMITED,))
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(dtype), space, properties)


def append(file: h5py.File, name: str, rows: Array, start: int) -> list[int]:
    """Write ``rows`` (k,) from row ``start`` on, into a table that is made if there is none.

    Returns where in the file the chunks lie that begin with one of these rows.
    """
    if name not in file:
        create(file, name, rows.dtype)
    dataset = h5py.h5d.open(file.id, name.encode())  # the short way: this is called often
    end = start + len(rows)
    dataset.set_extent((end,))
    space = dataset.get_space()
    space.select_hyperslab((start,), rows.shape)
    dataset.write(h5py.h5s.create_simple(rows.shape), space, np.ascontiguousarray(rows))
    begins = range(-(-start // ROWS) * ROWS, end, ROWS)
    return [dataset.get_chunk_info_by_coord((row,)).byte_offset for row in begins]
