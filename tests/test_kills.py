"""Runs that are stopped or killed go on as if nothing had been.

Signals come at named places of the run, which it sends to itself (signalled_program.py); at random:
`scripts/soak kill`.
"""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import pytest
from helpers import REPOSITORY, assert_readable, message, mpirun, run, solve
from kill_cycles import cycles
from test_restart import different

import fsipetsc

pytest.importorskip("petsc4py")

pytestmark = pytest.mark.mpi

PROGRAM = REPOSITORY / "tests" / "signalled_program.py"
LINE = "rod -fsi_h 0.05 -ts_max_time 0.1 -fsi_output_dt 0.01 -fsi_quiet".split()


def signalled(
    ranks: int, folder: Path, places: list[list[object]], *words: object
) -> subprocess.CompletedProcess[str]:
    """The rod on so many ranks, which get signals at these places (signalled_program.py)."""
    return mpirun(ranks, PROGRAM, json.dumps(places), *LINE, *words, cwd=folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    done = solve(*LINE, "-fsi_output", "whole.h5", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "whole.h5"


@pytest.mark.parametrize(
    ("ranks", "rank", "number"),
    [(1, 0, signal.SIGINT), (2, 0, signal.SIGHUP), (2, 1, signal.SIGTERM)],
)
def test_a_run_that_a_signal_stopped_goes_on(ranks, rank, number, whole, tmp_path):
    """One message, 128 + signal, a frame and a checkpoint of the last step; then on another number
    of ranks.
    """
    done = signalled(ranks, tmp_path, [["frame", 4, rank, number]])
    message(
        done,
        128 + number,
        f"stopped by {number.name} at t = ",
        "rod.h5",
        "the checkpoint in rod.checkpoint.h5",
    )
    assert_readable(tmp_path / "rod.h5", "stopped", 0.1)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert not result.complete and result.nframes in (4, 5)
        assert result.time[-1] == result.series["t"][-1] == result.summary["t"], (
            "the last state is saved"
        )
    done = solve(*LINE, "-fsi_restart", "auto", cwd=tmp_path, ranks=3 - ranks)
    assert (done.returncode, done.stderr) == (0, "")
    assert different(whole, tmp_path / "rod.h5", same_ranks=False) == []


KILLS = [
    (2, ["frame", 2, 1, signal.SIGKILL]),
    (1, ["checkpoint", 2, 0, signal.SIGKILL]),
    (2, ["begun", 1, 0, signal.SIGKILL]),
    (3, ["fill", 2, 2, signal.SIGKILL]),
    (2, ["piece", 3, 0, -signal.SIGKILL]),
    (2, ["begin", 1, 0, signal.SIGTERM]),
    (1, ["clear", 1, 0, signal.SIGKILL]),  # of what is kept there is a copy
    (1, ["join", 2, 0, signal.SIGKILL]),
    (2, ["clear", 2, 0, signal.SIGKILL]),
]


@pytest.mark.parametrize(("case", "kills"), [("rod", KILLS), ("blast", KILLS[3:])])
def test_a_run_that_is_killed_goes_on(case, kills, tmp_path):
    """A frame, a checkpoint, a piece, a whole result half written; each time on another number of
    ranks: the same bits.
    """
    said = cycles(tmp_path, case, kills)
    assert len(said) == len(kills)


SLOW = """
import signal
from dataclasses import replace
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "slow", rod.OPTIONS, rod.DEFAULTS


def build(opt):
    problem = rod.build(opt)
    below, solid, above = problem.layers
    return replace(problem, layers=(replace(below, forcing=forcing), solid, above))


def forcing(X, t):
    if t > 0:  # within a step
        for name in ("once", "twice"):
            signal.raise_signal(signal.SIGINT)
            open(name, "w").close()
    return 0 * X, 0 * X, 0 * X
"""


def test_a_second_sigint_ends_at_once(tmp_path):
    """The first one lets the step end; the second does not wait for it."""
    (tmp_path / "slow.py").write_text(SLOW)
    done = run("-m", "fsipetsc", "slow.py", "-fsi_quiet", "-fsi_mapping", "rigid", cwd=tmp_path)
    assert done.returncode == -signal.SIGINT  # 130 in a shell
    assert (tmp_path / "once").exists() and not (tmp_path / "twice").exists()
