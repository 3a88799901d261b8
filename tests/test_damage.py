"""Damaged result files: they are read, or refused with one message and status 4, and what can be
drawn is drawn."""

from __future__ import annotations

import gc
import json
import os
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import output_program as program
import pytest
from helpers import run, solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.info import info

pytest.importorskip("petsc4py")

#: what HDF5 keeps a file open for
OF_FILES = h5py.h5f.OBJ_FILE | h5py.h5f.OBJ_DATASET | h5py.h5f.OBJ_GROUP | h5py.h5f.OBJ_ATTR


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A complete result."""
    gc.collect()  # results that nobody holds any more would be closed while objects are counted
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    program.write(str(path), 12, "blocks")
    return path.read_bytes()


def read_all(path: Path) -> bool:
    """Whether all of it can be read; the error that is raised else has one line."""
    before = h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, OF_FILES)  # of results of other tests
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
        after = h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, OF_FILES)
        assert after == before, "while the error is there"
        return False
    return True


def changed(whole: bytes, path: Path, change: Callable[[h5py.File], object]) -> Path:
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def replace(name: str, value: object) -> Callable[[h5py.File], object]:
    """The change that puts something else, or nothing (None), in the place of a dataset."""

    def change(file: h5py.File) -> None:
        del file[name]
        if value is not None:
            file[name] = value

    return change


def about(whole: bytes, path: Path) -> dict:
    with h5py.File(changed(whole, path, lambda file: None)) as file:
        return json.loads(file["about"][()])


def test_what_was_cut_off_or_is_of_another_version(whole: bytes, tmp_path: Path) -> None:
    (tmp_path / "cut.h5").write_bytes(whole[:20_000])
    newer = {**about(whole, tmp_path / "newer.h5"), "version": 99}
    changed(whole, tmp_path / "newer.h5", replace("about", json.dumps(newer)))
    for name, reason in (("cut.h5", "damaged"), ("newer.h5", "newer")):
        with pytest.raises(FileError, match=reason) as caught:
            fsipetsc.open_run(tmp_path / name)
        assert caught.value.status == 4


FLIP = """
import sys
from pathlib import Path
import fsipetsc
from fsipetsc.errors import FileError
content, path = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
fates = []
for at in range(int(sys.argv[3]), len(content), int(sys.argv[4])):
    path.write_bytes(content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1:])
    try:
        with fsipetsc.open_run(path) as run:
            for layer in run.layers:
                [layer[name] for name in layer.fields]
            [run.series[name] for name in run.series]
        fates.append(0)
    except FileError:
        fates.append(4)
print(fates.count(0), fates.count(4), set(fates) - {0, 4})
"""


@pytest.mark.parametrize(
    ("first", "every", "least"), [(0, 149, 20), pytest.param(6, 13, 100, marks=pytest.mark.long)]
)
def test_one_changed_byte_crashes_no_reader(
    first: int, every: int, least: int, whole: bytes, tmp_path: Path
) -> None:
    """Each is read, or refused with status 4: metadata has checksums, numbers have none."""
    (tmp_path / "whole.h5").write_bytes(whole)
    done = run("-c", FLIP, tmp_path / "whole.h5", tmp_path / "run.h5", first, every)
    assert (done.returncode, done.stderr) == (0, "")
    read, refused, other = done.stdout.split(maxsplit=2)
    assert int(read) > least and int(refused) > least and other == "set()\n", done.stdout


OTHERS = None, "text", '{"layers": [3]}', np.zeros((2, 2, 2)), np.full(5, 1j)
#: of headers: what would be allocated by it, or is no list of names
CRAFTED = (
    ("notes", 3),
    ("created", ["today"]),
    ("interfaces", "text"),
    ("layers", [{"name": "a", "kind": "fluid", "fields": ["x"], "shape": [10**9, 10**9]}] * 3),
)


@pytest.mark.parametrize("name", ["about", "time", "series", "series/t", "layer1/X", "layer1/T"])
def test_datasets(name: str, whole: bytes, tmp_path: Path) -> None:
    """One is missing, or of another type or shape; only the series may be missing."""
    fates = [read_all(changed(whole, tmp_path / "run.h5", replace(name, x))) for x in OTHERS]
    assert sum(fates) == (1 if name == "series" else 0)


def test_texts(whole: bytes, tmp_path: Path) -> None:
    """Entries of header, summary and errors are missing, or another thing."""
    path, fates = tmp_path / "run.h5", []
    known = about(whole, path)
    for part in ("header", "summary", "errors"):
        for key in known[part]:
            for value in (3, {"a": None}):
                text = json.dumps({**known, part: {**known[part], key: value}})
                fates.append(read_all(changed(whole, path, replace("about", text))))
    assert 5 < sum(fates) < len(fates) - 5
    for key, value in CRAFTED:
        text = json.dumps({**known, "header": {**known["header"], key: value}})
        assert not read_all(changed(whole, path, replace("about", text)))


def test_numbers_that_are_none(whole: bytes, tmp_path: Path) -> None:
    def claim(file: h5py.File) -> None:
        del file["time"]
        file.create_dataset("time", (10**12,), "f8", chunks=(1024,))

    assert not read_all(changed(whole, tmp_path / "run.h5", claim)), "more than memory has"
    for name, readable in (("time", False), ("layer1/X", False), ("series/dt", True)):

        def change(file: h5py.File, name: str = name) -> None:
            file[name][5] = np.nan

        assert read_all(changed(whole, tmp_path / "run.h5", change)) == readable, name


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.h5")
    done = solve("info", "run.h5", cwd=tmp_path)
    assert done.returncode == 4 and done.stderr.count("\n") == 1, done.stderr
    assert "no regular file" in done.stderr
