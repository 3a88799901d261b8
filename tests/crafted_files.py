"""Checkpoints and results with something in them that does not belong there, at random.

Checksums and HDF5 are right: it is the content that was tampered with. tests/test_crafted_files.py
has what becomes of them.
"""

import copy
import json
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fsipetsc.output import checkpoint_file

#: what comes into the place of an entry of a header
VALUES = None, 3, -1, 1.5, True, float("nan"), float("inf"), 10**30, "text", "", [], [3], {}
VALUES += ({"a": None}, [["text", [1]]], [None, None])


def entries(table: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where all that a header holds is, as keys and numbers one below the other."""
    inner = table.items() if isinstance(table, dict) else enumerate(table)
    for key, value in inner:
        yield *place, key
        if isinstance(value, (dict, list)):
            yield from entries(value, (*place, key))


def other_header(chance: random.Random, header: dict[str, Any]) -> tuple[dict[str, Any], str]:
    """A header of which one entry is missing or another thing, and what was done."""
    header = copy.deepcopy(header)
    depth = chance.choice((1, 2, 9))  # else most entries would be options
    *above, last = chance.choice([place for place in entries(header) if len(place) <= depth])
    table = header
    for key in above:
        table = table[key]
    if chance.random() < 0.3:
        del table[last]
        return header, f"without {[*above, last]}"
    table[last] = copy.deepcopy(chance.choice(VALUES))
    return header, f"{[*above, last]} is {table[last]!r}"


def one_is(array: np.ndarray, value: float) -> np.ndarray:
    found = array.astype(float)
    found.flat[found.size // 2 : found.size // 2 + 1] = value
    return found


#: name of what is done to an array -> what comes of it
ARRAYS = {
    "shorter": lambda a: a[:-1] if a.ndim else a,
    "longer": lambda a: np.concatenate([a, a[-1:]]) if a.ndim and len(a) else np.zeros(1),
    "empty": lambda a: a[:0] if a.ndim else a,
    "flat": np.ravel,
    "of one more axis": lambda a: a[..., None],
    "one number": lambda a: np.float64(1.0),
    "transposed": np.transpose,
    "backwards": lambda a: a[::-1],
    "of float32": lambda a: a.astype("f4"),
    "of whole numbers": lambda a: np.nan_to_num(a).astype("i8"),
    "complex": lambda a: a.astype(complex),
    "of texts": lambda a: np.full(a.shape, b"text"),
    "of truth": lambda a: a.astype(bool),
    "NaN": lambda a: np.full(a.shape, np.nan),
    "with a NaN": lambda a: one_is(a, np.nan),
    "with an inf": lambda a: one_is(a, np.inf),
    "with 1e300": lambda a: one_is(a, 1e300),
    "-1": lambda a: np.full(a.shape, -1, a.dtype),
}


def crafted_checkpoint(chance: random.Random, whole: Path, target: Path) -> str:
    """Write a checkpoint with another header or array than the whole one; what was done."""
    header, arrays = checkpoint_file.read(whole)
    if chance.random() < 0.5:
        header, done = other_header(chance, header)
    else:
        name, what = chance.choice(sorted(arrays)), chance.choice(sorted([*ARRAYS, "missing"]))
        array, done = arrays.pop(name), f"{name} {what}"
        if what != "missing":
            arrays[name] = ARRAYS[what](array)
    checkpoint_file.write(target, header, arrays)
    return done


def crafted_result(chance: random.Random, whole: Path, target: Path) -> str:
    """The same of a result."""
    shutil.copy(whole, target)
    with h5py.File(target, "r+") as file:
        if chance.random() < 0.5:
            about, done = other_header(chance, json.loads(file["about"][()]))
            del file["about"]
            file["about"] = np.bytes_(json.dumps(about).encode())
            return done
        names: list[str] = []
        file.visititems(lambda name, found: names.append(name))
        name = chance.choice(sorted({*names} - {"about"}))
        what = chance.choice(sorted([*ARRAYS, "missing", "a group"]))
        array = file[name][...] if isinstance(file[name], h5py.Dataset) else np.zeros(2)
        del file[name]
        if what == "a group":
            file.create_group(name)
        elif what != "missing":
            file[name] = ARRAYS[what](array)
        return f"{name} {what}"
