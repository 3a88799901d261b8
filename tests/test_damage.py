"""Damaged result files: they are read, or refused with one message and status 4."""

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


def readable(path):
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
        return False
    return True


#: flips one bit of every so many bytes; in a process of its own, as a reader might crash
FLIP = """
import sys
from pathlib import Path
from test_damage import readable
content, path = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
fates = []
for at in range(0, len(content), int(sys.argv[3])):
    path.write_bytes(content[:at] + bytes([content[at] ^ (1 << at % 8)]) + content[at + 1:])
    fates.append(readable(path))
print(fates.count(True), fates.count(False))
"""


@pytest.mark.parametrize(
    ("every", "least"), [(797, 4), pytest.param(13, 100, marks=pytest.mark.long)]
)
def test_one_changed_byte_crashes_no_reader(every, least, whole, tmp_path):
    """Metadata has checksums, numbers have none."""
    done = run("-c", FLIP, whole, tmp_path / "run.h5", every, cwd=Path(__file__).parent)
    assert (done.returncode, done.stderr) == (0, "")
    assert min(map(int, done.stdout.split())) > least


@pytest.mark.parametrize("name", ["about", "time", "series/t", "layer1/X"])
def test_what_is_missing_or_of_another_type_or_shape(name, whole, tmp_path):
    for value in (None, "text", np.zeros((2, 2, 2)), np.full(5, 1j)):
        path = shutil.copy(whole, tmp_path / "run.h5")
        with h5py.File(path, "r+") as file:
            del file[name]
            if value is not None:
                file[name] = value
        assert not readable(path)
    path.write_bytes(whole.read_bytes()[:20_000])
    assert not readable(path)
