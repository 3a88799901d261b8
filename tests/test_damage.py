"""Damaged result files: they are read, or refused with one message and status 4."""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import run

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.info import info


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A complete result; groups of more than eight names, as its series, HDF5 keeps otherwise."""
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    fsipetsc.run("mms", h=0.05, max_time=0.1, output_dt=0.01, output=path).close()
    return path


@pytest.fixture(scope="module")
def about(whole):
    with h5py.File(whole) as file:
        return json.loads(file["about"][()])


def readable(path, reason=""):
    """Whether all of it can be read; the error that is raised else has one line."""
    try:
        info(path)
        with fsipetsc.open_run(path) as result:
            for layer in result.layers:
                assert all(len(layer[name]) == result.nframes for name in layer.fields)
                layer.frame(-1)
            steps = len(result.series.get("t", ()))
            assert all(len(values) == steps for values in result.series.values())
    except FileError as error:
        assert error.status == 4 and "\n" not in str(error) and str(path) in str(error), error
        assert reason in str(error)
        return False
    return True


@pytest.fixture
def changed(whole, tmp_path):
    """changed(name, value): a result with something else, or nothing, in the place of a dataset."""

    def change(name, value=None):
        path = shutil.copy(whole, tmp_path / "run.h5")
        with h5py.File(path, "r+") as file:
            del file[name]
            if value is not None:
                file[name] = value
        return path

    return change


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
def test_one_changed_byte_crashes_no_reader(first, every, least, whole, tmp_path):
    """Each is read, or refused with status 4: metadata has checksums, numbers have none."""
    done = run("-c", FLIP, whole, tmp_path / "run.h5", first, every, cwd=Path(__file__).parent)
    assert (done.returncode, done.stderr) == (0, "")
    assert min(map(int, done.stdout.split())) > least


OTHERS = None, "text", '{"layers": [3]}', np.zeros((2, 2, 2)), np.full(5, 1j)


@pytest.mark.parametrize("name", ["about", "time", "series", "series/t", "layer1/X", "layer1/T"])
def test_datasets(name, whole, changed):
    """Missing, of another type or shape; only series may be missing, only T may be no number."""
    fates = [readable(changed(name, value)) for value in OTHERS]
    if "/" in name or name == "time":
        with h5py.File(whole) as file:
            unknown = np.nan * file[name][...]
        fates.append(readable(changed(name, unknown)))
    assert sum(fates) == (name in ("series", "layer1/T")), fates
