"""A disk that is full, or a place that cannot be written: status 4, one message, and what was
written can be read.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from helpers import PATIENCE, environment, message, solve

import fsipetsc

pytest.importorskip("petsc4py")

LINE = "-m fsipetsc rod -fsi_h 0.05 -ts_max_time 0.05 -fsi_output_dt 1e-4 -fsi_quiet"


@pytest.mark.parametrize("size", [1, 2000])
def test_a_result_that_grows_too_large(size, tmp_path):
    """The system refuses files beyond so many kB, compiled code among them: it is there before."""
    first = solve("rod", "-fsi_h", 0.05, "-ts_max_steps", 1, "-fsi_output", "a.h5", cwd=tmp_path)
    assert first.returncode == 0
    line = f"ulimit -f {size}; exec {sys.executable} {LINE}"
    given = {
        "cwd": tmp_path,
        "env": environment({"PYTHONDONTWRITEBYTECODE": "1"}),
        "stdin": subprocess.DEVNULL,
        "timeout": PATIENCE,
    }
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, **given)
    message(done, 4, "rod.h5: cannot write: ", "File too large")
    if size > 1:
        with fsipetsc.open_run(tmp_path / "rod.h5") as result:
            assert result.nframes > 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-fsi_output", "/proc/x.h5"), "cannot write: No such file"),
        (("-fsi_checkpoint", "/proc/x.h5"), "no checkpoint can be written there: No such file"),
        (("-fsi_restart", "no/where.h5"), "there is no such file"),
        (("-fsi_output", "no/where.h5"), "does not exist"),
    ],
)
def test_places_that_cannot_be_written(words, said, tmp_path):
    done = solve("rod", "-fsi_h", 0.1, "-ts_max_steps", 3, "-fsi_quiet", *words, cwd=tmp_path)
    message(done, 4, words[1], said)
    assert not list(Path(tmp_path).glob("*.parts"))
