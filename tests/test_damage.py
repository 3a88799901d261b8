"""Damaged result files: they are read, or refused with one message and status 4."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import run

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.info import info


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A complete result; groups of more than eight names, as its series, HDF5 keeps otherwise."""
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    fsipetsc.run("mms", h=0.05, max_time=0.1, output_dt=0.01, output=path).close()
    return path.read_bytes()


def readable(path: Path, reason: str = "") -> bool:
    """Whether all of it can be read; the error that is raised else has one line."""
    try:
        info(path)
        with fsipetsc.open_run(path) as result:
            for layer in result.layers:
                assert all(len(layer[name]) == result.nframes for name in layer.fields)
                layer.frame(-1)
            assert all(len(result.series[name]) >= 0 for name in result.series)
    except FileError as error:
        assert error.status == 4 and "\n" not in str(error) and str(path) in str(error), error
        assert reason in str(error)
        return False
    return True


@pytest.fixture
def changed(whole: bytes, tmp_path: Path) -> Callable[..., Path]:
    """changed(name, value): a result with something else, or nothing, in the place of a dataset."""

    def change(name: str, value: object = None) -> Path:
        path = tmp_path / "run.h5"
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            del file[name]
            if value is not None:
                file[name] = value
        return path

    return change


@pytest.fixture
def known(whole: bytes, tmp_path: Path) -> tuple[h5py.File, dict]:
    """The result as a file, and what it says about itself."""
    (tmp_path / "whole.h5").write_bytes(whole)
    with h5py.File(tmp_path / "whole.h5") as file:
        yield file, json.loads(file["about"][()])


def test_what_was_cut_off_is_of_another_version_or_no_file(whole, known, changed, tmp_path):
    (tmp_path / "cut.h5").write_bytes(whole[:20_000])
    assert not readable(tmp_path / "cut.h5", "damaged")
    assert not readable(changed("about", json.dumps({**known[1], "version": 99})), "file format 99")
    with h5py.File(path := changed("time"), "r+") as file:
        file.create_dataset("time", (10**12,), "f8", chunks=(1024,))
    assert not readable(path, "claims to have"), "more than memory has"
    os.mkfifo(tmp_path / "pipe.h5")
    assert not readable(tmp_path / "pipe.h5", "no regular file"), "nobody waits for a writer"


FLIP = """
import sys
from pathlib import Path
from test_damage import readable
content, path = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
fates = []
for at in range(int(sys.argv[3]), len(content), int(sys.argv[4])):
    path.write_bytes(content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1:])
    fates.append(readable(path))
print(fates.count(True), fates.count(False))
"""


@pytest.mark.parametrize(
    ("first", "every", "least"), [(0, 149, 20), pytest.param(6, 13, 100, marks=pytest.mark.long)]
)
def test_one_changed_byte_crashes_no_reader(first, every, least, known, tmp_path) -> None:
    """Each is read, or refused with status 4: metadata has checksums, numbers have none."""
    words = tmp_path / "whole.h5", tmp_path / "run.h5", first, every
    done = run("-c", FLIP, *words, cwd=Path(__file__).parent)
    assert (done.returncode, done.stderr) == (0, "")
    assert min(map(int, done.stdout.split())) > least


OTHERS = None, "text", '{"layers": [3]}', np.zeros((2, 2, 2)), np.full(5, 1j)
#: of headers: what would be allocated by it, or is no list of names
CRAFTED = {
    "notes": 3,
    "created": ["today"],
    "interfaces": "text",
    "layers": [{"name": "a", "kind": "fluid", "fields": ["x"], "shape": [10**9, 10**9]}] * 3,
}


@pytest.mark.parametrize("name", ["about", "time", "series", "series/t", "layer1/X", "layer1/T"])
def test_datasets(name, known, changed) -> None:
    """One is missing, or of another type or shape; only the series may be missing, only what is
    computed may be no number.
    """
    fates = [readable(changed(name, value)) for value in OTHERS]
    if "/" in name or name == "time":
        fates.append(readable(changed(name, np.nan * known[0][name][...])))
    assert sum(fates) == (name in ("series", "series/t", "layer1/T")), fates


def test_texts(known, changed) -> None:
    """Entries of header, summary and errors are missing, or another thing."""

    def with_entry(part: str, key: str, value: object) -> bool:
        about = {**known[1], part: {**known[1][part], key: value}}
        return readable(changed("about", json.dumps(about)))

    parts = [(part, key) for part in ("header", "summary", "errors") for key in known[1][part]]
    fates = [with_entry(*entry, value) for entry in parts for value in (3, {"a": None})]
    assert 5 < sum(fates) < len(fates) - 5
    assert not any(with_entry("header", key, value) for key, value in CRAFTED.items())
