"""Damaged result files: they are read, or refused with one message and status 4, and what can be drawn is drawn."""

from __future__ import annotations

import gc
import json
import os
import random
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import output_program as program
import pytest
from helpers import solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.info import info

pytest.importorskip("petsc4py")

#: what HDF5 keeps a file open for
OF_FILES = h5py.h5f.OBJ_FILE | h5py.h5f.OBJ_DATASET | h5py.h5f.OBJ_GROUP | h5py.h5f.OBJ_ATTR


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A complete result."""
    gc.collect()  # or results of other tests that nobody holds any more are closed while objects are counted
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    program.write(str(path), 12, "blocks")
    return path.read_bytes()


def read_all(path: Path) -> bool:
    """Whether all of it can be read; the error that is raised else has one line."""
    before = h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, OF_FILES)  # of results that other tests look at
    try:
        info(path)
        with fsipetsc.open_run(path) as result:
            for layer in result.layers:
                assert all(len(layer[name]) == result.nframes for name in layer.fields)
                if result.nframes:
                    layer.frame(-1)
            assert all(len(result.series[name]) >= 0 for name in result.series)
            repr(result)
    except FileError as error:
        assert error.status == 4 and "\n" not in str(error) and str(path) in str(error), error
        assert h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, OF_FILES) == before, "while the error is there"
        return False
    return True


def changed(whole: bytes, path: Path, change: Callable[[h5py.File], object]) -> Path:
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def replace(name: str, value: object) -> Callable[[h5py.File], object]:
    """The change that puts something else in the place of a dataset, or nothing, if the value is None."""

    def change(file: h5py.File) -> None:
        del file[name]
        if value is not None:
            file[name] = value

    return change


@pytest.mark.long
def test_bytes(whole: bytes, tmp_path: Path) -> None:
    """Some bytes are others, or the end is missing."""
    rng, path, fates = random.Random(3), tmp_path / "run.h5", []
    for k in range(150):
        copy = bytearray(whole)
        for _ in range(rng.choice([1, 3, 10])):
            copy[rng.randrange(rng.choice([len(copy), 20_000, 3000]))] = rng.randrange(256)
        path.write_bytes(copy[: rng.randrange(len(copy))] if k % 5 == 0 else copy)
        fates.append(read_all(path))
    assert 15 < sum(fates) < 135


@pytest.mark.long
def test_datasets(whole: bytes, tmp_path: Path) -> None:
    """Each dataset is missing, or of another type or shape."""
    path, fates, names = tmp_path / "run.h5", [], []
    changed(whole, path, lambda file: file.visit(names.append))
    others = [None, "text", "[1, 2]", '{"layers": [3]}', np.float64(3), np.zeros((2, 2, 2)), np.full(5, 1j), np.array([b"a"])]
    for name in names:
        for value in others:
            fates.append(read_all(changed(whole, path, replace(name, value))))
    assert 20 < sum(fates) < len(fates) - 100


@pytest.mark.parametrize("name", ["format", "version"])
def test_attributes(whole: bytes, tmp_path: Path, name: str) -> None:
    for value in ("x", np.nan, [1, 2], b"\xff", -5, 10**9):
        read_all(changed(whole, tmp_path / "run.h5", lambda file: file.attrs.__setitem__(name, value)))  # noqa: B023
    assert not read_all(changed(whole, tmp_path / "run.h5", lambda file: file.attrs.__delitem__(name)))


def test_texts(whole: bytes, tmp_path: Path) -> None:
    """Each entry of header, summary and errors is missing, or another thing."""
    path = tmp_path / "run.h5"
    for name in ("header", "summary", "errors"):
        with h5py.File(changed(whole, path, lambda file: None)) as file:
            text = json.loads(file[name].asstr()[()])
        for key in text:
            for value in (None, 3, "x", [], {}, [None], {"a": None}, float("nan")):
                read_all(changed(whole, path, replace(name, json.dumps({**text, key: value}))))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1e300])
def test_numbers_that_are_none(whole: bytes, tmp_path: Path, value: float) -> None:
    path = tmp_path / "run.h5"

    def in_time(file: h5py.File) -> None:
        file["time"][5] = value

    def in_grid(file: h5py.File) -> None:
        file["segment0000/layer01/X"][5] = value

    for change in (in_time, in_grid):
        assert not read_all(changed(whole, path, change))
    for name in ("t", "dt", "x_interface", "energy"):

        def in_series(file: h5py.File, name: str = name) -> None:
            rows = file["series"][...]
            rows[name][7] = value
            file["series"][...] = rows

        assert read_all(changed(whole, path, in_series)), "it is there to be looked at"


def test_a_claim_of_more_than_there_can_be(whole: bytes, tmp_path: Path) -> None:
    """It would not fit into memory."""

    def change(file: h5py.File) -> None:
        del file["time"]
        file.create_dataset("time", (10**12,), "f8", chunks=(1024,))

    assert not read_all(changed(whole, tmp_path / "run.h5", change))


CRAFTED = {
    "notes": [3, {"notes": "a"}],
    "created": [["today"], 7, None],
    "interfaces": ["text", [3]],
    "layers": [
        [{"name": "a", "kind": "fluid", "fields": ["rho", "x"], "shape": [10**9, 10**9]}] * 3,
        [{"name": "a", "kind": "fluid", "fields": ["rho", "x"], "shape": [-1, 2.5]}] * 3,
    ],
}


@pytest.mark.parametrize("name", CRAFTED)
@pytest.mark.parametrize("frames", [0, 12])
def test_a_header_that_somebody_has_made(frames: int, name: str, whole: bytes, tmp_path: Path) -> None:
    """Nothing is allocated by what it claims; of a run without frames nothing is known of the points."""
    path = tmp_path / "run.h5"
    with h5py.File(changed(whole, path, lambda file: None)) as file:
        header = json.loads(file["header"].asstr()[()])

    def change(file: h5py.File, value: object) -> None:
        replace("header", json.dumps({**header, name: value}))(file)
        if not frames:
            file["time"].resize(0, axis=0) if file["time"].maxshape[0] is None else replace("time", np.empty(0))(file)
            for k in range(2):
                del file[f"segment{k:04d}"]

    for value in CRAFTED[name]:
        readable = read_all(changed(whole, path, lambda file: change(file, value)))  # noqa: B023
        assert not readable or (frames == 0 and name == "layers" and value[0]["shape"][0] > 0)


@pytest.mark.parametrize("command", ["info", "plot"])
def test_a_pipe_is_not_waited_for(tmp_path: Path, command: str) -> None:
    os.mkfifo(tmp_path / "run.h5")
    done = solve(command, "run.h5", cwd=tmp_path)
    assert done.returncode == 4 and done.stderr.count("\n") == 1 and "no regular file" in done.stderr, done.stderr
