"""Runs that cannot go on, or are not allowed to start: exit status, one message that helps, and
what is left on disk.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, assert_readable, environment, message, mpirun, solve

import fsipetsc

pytest.importorskip("petsc4py")


# bad input: status 2

BAD_INPUT = {
    "unknown case": ("rood", ["'rood'; did you mean 'rod'? There are rod, "]),
    "h that misses an interface": (
        "rod -fsi_h 0.03",
        ["-fsi_h 0.03", "'rod'", "0.02941176", "0.03030303"],
    ),
    "too few points": (
        "rod -fsi_order 8 -fsi_h 0.1",
        ["11 points", "8/4", "16", "-fsi_h", "-fsi_order"],
    ),
    "far too fine": ("rod -fsi_h 1e-9", ["'below'", "cells", "-fsi_h", "too many"]),
    "file name": ("rod -fsi_output .", ["'.' for -fsi_output: expected the name of a file"]),
    "times beyond the end": (
        "box -fsi_output_times 7",
        [": 7 would not be reached", "-ts_max_time 2"],
    ),  # no unit
    "output directory": ("rod -fsi_output no/such/dir/x.h5", ["no/such/dir"]),
}


def status_of(name: str) -> int:
    return 4 if name == "output directory" else 2


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", BAD_INPUT)
def test_bad_input(name, ranks, tmp_path):
    line, words = BAD_INPUT[name]
    done = solve(*line.split(), cwd=tmp_path, ranks=ranks)
    text = message(done, status_of(name))
    for word in words:
        assert word in text
    assert "MPI_ABORT" not in done.stderr and list(tmp_path.iterdir()) == []


# the computation fails: status 3


def test_a_step_beyond_the_stability_limit(tmp_path):
    done = solve(*"rod -fsi_h 0.05 -fsi_cfl 5 -fsi_output_dt 0.002".split(), cwd=tmp_path)
    text = message(done, 3)
    for word in ("in layer '", "at x = ", "(X = ", "t = ", ", step ", "what was computed before"):
        assert word in text
    assert any(f" {field} " in text for field in ("rho", "T", "u", "x_X"))
    assert_readable(tmp_path / "rod.h5", "failed", 3.0)


@pytest.mark.parametrize("coupling", ["conservative", "projection"])
@pytest.mark.parametrize(
    ("option", "said"),
    [
        (
            "-rod_T0 20",
            [
                f"note: '{name}' is nowhere warmer than T = 20 K: "
                for name in ("below", "rod", "above")
            ],
        ),
        (
            "-rod_T0 110 -fsi_cfl 4",
            ["note: -fsi_cfl 4 is 4 times the bound on the step at t = 0 s"],
        ),
        ("-rod_T0 110", []),
    ],
)
def test_what_can_hardly_be_meant_is_questioned_at_the_start(option, said, coupling, tmp_path):
    line = f"rod -fsi_h 0.1 -ts_max_steps 1 -fsi_coupling {coupling} {option}".split()
    done = solve(*line, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    notes = [
        text
        for text in done.stdout.splitlines()
        if text.startswith("note: ") and "J has" not in text
    ]
    assert len(notes) == len(said), notes
    for note, begin in zip(notes, said, strict=True):
        assert note.startswith(begin)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_a_layer_that_becomes_too_short(ranks, tmp_path):
    """With a wall close under the rod there is soon no room for 16 points of the 8/4 operator."""
    line = "rod -fsi_h 0.0125 -fsi_order 8 -rod_wall 0.81 -rod_top 3".split()
    text = message(solve(*line, cwd=tmp_path, ranks=ranks), 3)
    for word in ("'below'", "too short", "t = ", ", step ", "x = ", "needs 16 points"):
        assert word in text
    assert_readable(tmp_path / "rod.h5", "failed", 0.5)


def test_a_failure_within_a_batch_loses_nothing(tmp_path):
    """Neither steps of the series nor of the summary, as if they had been made one by one."""
    found = []
    for watch in ((), ("-ts_monitor",)):  # which makes batches of one step
        done = solve(*"rod -fsi_h 0.025 -ts_max_time 0.5 -ts_dt 3e-4".split(), *watch, cwd=tmp_path)
        assert done.returncode == 3, done.stderr
        with fsipetsc.open_run(tmp_path / "rod.h5") as result:
            series = [result.series[name].tolist() for name in ("t", "dt", "x_interface", "mass")]
            names = "steps", "rhs_evaluations", "message"
            found.append((series, [result.summary[name] for name in names]))
    assert len(found[0][0][0]) > 2 and found[0] == found[1]
    seen = [int(line.split()[0]) for line in done.stdout.splitlines() if " TS dt " in line]
    assert seen == list(range(found[1][1][0] + 1)), "a line for each step, and for the start"


BROKEN = """
import sys
from mpi4py import MPI
from fsipetsc.cli import main
from fsipetsc.stepping import run

ranks, frame = [int(rank) for rank in sys.argv[1:]], run._Run._frame


def broken(self, t):
    if t > 0.0035 and MPI.COMM_WORLD.rank in ranks:
        raise MemoryError
    frame(self, t)


run._Run._frame = broken
sys.exit(main("rod -fsi_h 0.1 -fsi_output_dt 0.001 -ts_max_time 0.01 -fsi_quiet".split()))
"""


@pytest.mark.parametrize("ranks", [[0], pytest.param([1], marks=pytest.mark.mpi)], ids=str)
def test_any_error_leaves_what_was_computed(ranks, tmp_path):
    """Of one rank; where one of two is alone, it ends the other, who cannot write without it."""
    n = max(ranks) + 1
    done = mpirun(n, "-c", BROKEN, *ranks, cwd=tmp_path)
    assert done.returncode == 3, done.stderr
    assert done.stderr.count("fsipetsc: error: out of memory") == 1
    if len(ranks) < n:
        return
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        np.testing.assert_allclose(result.time, [0.0, 0.001, 0.002, 0.003])
        assert result.series["t"][-1] == pytest.approx(0.004)
        assert (result.summary["status"], result.summary["message"]) == ("failed", "MemoryError")
        assert len(result.series["t"]) == result.summary["steps"]


# a disk that is full, or a place that cannot be written: status 4

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
        (("-fsi_output", "/proc/x.h5"), "no file can be written in the directory /proc"),
        (("-fsi_checkpoint", "/proc/x.h5"), "no file can be written in the directory /proc"),
        (("-fsi_restart", "no/where.h5"), "there is no such file"),
        (("-fsi_output", "no/where.h5"), "no: No such file or directory"),
    ],
)
def test_places_that_cannot_be_written(words, said, tmp_path):
    done = solve("rod", "-fsi_h", 0.1, "-ts_max_steps", 3, "-fsi_quiet", *words, cwd=tmp_path)
    message(done, 4, words[1], said)
    assert not list(Path(tmp_path).glob("*.parts"))


# what a run says of its end, and of steps that are too long


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


def box(where, *words):
    return solve("box", "-fsi_h", 0.1, "-fsi_order", 2, "-fsi_output", "r.h5", *words, cwd=where)


def test_an_end_by_the_number_of_steps_is_not_said_to_be_the_end(where):
    done = box(where, "-ts_max_steps", 1)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(where / "r.h5") as result:
        t, summary, complete = result.series["t"][-1], result.summary, result.complete
    words = f"ended by -ts_max_steps at t = {t:g}, before -ts_max_time 2"
    assert words in done.stdout
    assert (summary["status"], summary["message"], complete) == ("done", words, True), (
        "as the user wished"
    )
    assert words in solve("info", "r.h5", cwd=where).stdout


def test_steps_far_beyond_their_bound_are_noted(where):
    """Those of -ts_dt, too, and where they fail; not the default ones."""
    for words in ((), ("-ts_dt", 1e-4)):
        assert "\nnote: " not in box(where, "-ts_max_steps", 1, *words).stdout
    assert "\nnote: -ts_dt 1 is " in box(where, "-ts_max_steps", 1, "-ts_dt", 1.0).stdout
    said = box(where, "-ts_dt", 4, "-fsi_output_dt", 8).stderr
    assert "; -ts_dt 4 is " in said and " times the bound on the step at t = 0" in said
