"""Datasets of the result file that grow: a row per step or per frame."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

Array = np.ndarray[Any, Any]

_ROWS = 1 << 10  # rows in a chunk


def create(file: h5py.File, name: str, dtype: np.dtype[Any]) -> None:
    """An empty table."""
    # only rows that are written count: nothing needs filling, and then HDF5 takes whole chunks as they lie in memory
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((_ROWS,))
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple((0,), (h5py.h5s.UNLIMITED,))
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(dtype), space, properties)


def append(file: h5py.File, name: str, rows: Array, start: int) -> None:
    """Write ``rows`` (k,) from row ``start`` on, into a table that is made if there is none."""
    if name not in file:
        create(file, name, rows.dtype)
    dataset = h5py.h5d.open(file.id, name.encode())  # the short way: this is called often
    dataset.set_extent((start + len(rows),))
    space = dataset.get_space()
    space.select_hyperslab((start,), rows.shape)
    dataset.write(h5py.h5s.create_simple(rows.shape), space, np.ascontiguousarray(rows))
