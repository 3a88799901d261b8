"""Nobody reads what is printed, or it cannot be written: a run goes on, and what is printed for
its own sake says so.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
from helpers import PATIENCE, environment

import fsipetsc

pytest.importorskip("petsc4py")

#: prints far more than what one who leaves after a line has read, in many writes
RUN = "rod -fsi_h 0.1 -ts_max_steps 300 -ts_monitor".split()
COMPUTES = f"{sys.executable} -m fsipetsc {' '.join(RUN)}"


def shell(line: str, cwd) -> tuple[int, str]:
    """(status, stderr) of a line for bash."""
    given = {"cwd": cwd, "env": environment(), "stdin": subprocess.DEVNULL, "timeout": PATIENCE}
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, **given)
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("line", "said"),
    [(f"{COMPUTES} >/dev/full", 1), (f"{COMPUTES} | head -n 0; exit ${{PIPESTATUS[0]}}", 0)],
)
def test_a_run_goes_on(line, said, tmp_path):
    status, err = shell(line, tmp_path)
    assert (status, err.count("\n")) == (0, said), err
    assert ("No space left on device" in err) == bool(said)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["steps"] == 300


@pytest.mark.parametrize("arguments", ["rod -help", "stability -no_such"])
def test_what_prints_for_its_own_sake_says_that_it_cannot(arguments, tmp_path):
    status, err = shell(f"{sys.executable} -m fsipetsc {arguments} >/dev/full", tmp_path)
    assert status == (4 if "help" in arguments else 2)
    assert err.count("fsipetsc: error: ") == err.count("\n") == 1, err
