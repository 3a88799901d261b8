"""Signals, and launchers that go: whenever they come, all ranks end in order, say it once, and leave what was computed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, assert_readable, environment, message, mpirun, run, solve
from said import parted

import fsipetsc

pytest.importorskip("petsc4py")

LONG = "rod -fsi_h 0.025 -fsi_output_dt 0.001 -ts_max_time 1000 -fsi_output long.h5".split()


def started(ranks: int, cwd: Path) -> subprocess.Popen[str]:
    """A long run that has saved some frames."""
    command = [sys.executable, "-m", "fsipetsc", *LONG]
    if ranks > 1:
        command = ["mpiexec", "-n", str(ranks), *command]
    process = subprocess.Popen(command, cwd=cwd, env=environment(), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        try:
            with fsipetsc.open_run(cwd / "long.h5") as result:
                if result.nframes > 2:
                    return process
        except fsipetsc.errors.FileError:
            pass
        time.sleep(0.2)
    process.kill()
    raise AssertionError(f"no frames: {process.communicate()}")


def processors(pid: int) -> float:
    """Seconds of processors that a process has had, by which it is equally far on its way wherever it runs."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.mpi
def test_a_signal_to_one_rank_while_it_starts_ends_all(tmp_path):
    """At any moment: nobody waits for a rank that has left. (Before MPI is there, the launcher speaks, not the program.)"""
    ranks = 2
    command = ["mpiexec", "-n", str(ranks), sys.executable, "-m", "fsipetsc", *LONG, "-fsi_quiet"]
    for number, delay in ((signal.SIGINT, 0.3), (signal.SIGHUP, 0.7), (signal.SIGTERM, 1.2)):
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, cwd=tmp_path, env=environment(), text=True, stdout=pipe, stderr=pipe)
        end = time.monotonic() + PATIENCE
        while len(started_ranks := ranks_of(process.pid)) < ranks and time.monotonic() < end:
            time.sleep(0.01)  # the list of the system may lack somebody who was in it before
        while processors(started_ranks[-1]) < delay and time.monotonic() < end:
            time.sleep(0.01)
        os.kill(started_ranks[-1], number)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 128 + number, err
        assert err.count("fsipetsc: error: ") <= 1 and "Traceback" not in err


SIGNALLED = """
import os, sys
from fsipetsc import cli

start, number = cli.start_mpi, int(sys.argv.pop(1))


def signalled():
    os.kill(os.getpid(), number)  # it waits until all ranks can be told
    return start()


cli.start_mpi = signalled
sys.exit(cli.main())
"""


UNHEARD = """
import os, signal
from contextlib import suppress
from dataclasses import replace
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "unheard", rod.OPTIONS, rod.DEFAULTS
signalled = 0


def signal_to(rank, number=signal.SIGHUP):
    if os.environ.get("OMPI_COMM_WORLD_RANK", os.environ.get("PMI_RANK", str(rank))) == str(rank):
        os.kill(os.getpid(), number)


def build(opt):
    SIGNAL
    problem = rod.build(opt)
    below, solid, above = problem.layers
    return replace(problem, layers=(replace(below, initial=initial(below.initial)), solid, above))


def initial(function):
    def fields(X):
        SECOND
        return function(X)

    return fields
"""
SWALLOWED = "with suppress(BaseException): signal_to({rank})"


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
@pytest.mark.parametrize("words", [SWALLOWED, "signal_to({rank})"], ids=["swallowed", "taken for an error of the case file"])
@pytest.mark.parametrize("place", ["SIGNAL", "SECOND"])
def test_a_signal_whose_exception_is_not_heard_is(place, words, ranks, tmp_path):
    """To the last rank, in a user's function; all end in order, before the first step or after it, but there is no other."""
    rank = ranks - 1 if place == "SIGNAL" else 0  # which has the first layer
    text = UNHEARD.replace(place, words.format(rank=rank)).replace("SIGNAL", "pass").replace("SECOND", "pass")
    (tmp_path / "unheard.py").write_text(text)
    done = solve("unheard.py", *LONG[1:], "-fsi_quiet", cwd=tmp_path, ranks=ranks)
    assert message(done, 129) == "fsipetsc: error: stopped by SIGHUP before the first step"


@pytest.mark.mpi
def test_an_error_in_the_initial_data_of_one_rank_alone_ends_all(tmp_path):
    """What the error holds of the rank's arrays is let go: PETSc would wait at its end for ranks with other objects."""
    text = UNHEARD.replace("SIGNAL", "pass").replace("SECOND", "raise ValueError('no density is known')")
    (tmp_path / "unheard.py").write_text(text)
    line = "unheard.py -fsi_h 0.025 -fsi_partition physics -fsi_quiet".split()
    done = mpirun(2, "-m", "fsipetsc", *line, cwd=tmp_path)
    traceback, done.stderr = parted(done.stderr)
    assert "unheard.py" in traceback and message(done, 2).endswith("ValueError: no density is known")


HOLE = """
import os, signal, sys
from contextlib import suppress
from fsipetsc import cli
from fsipetsc.stepping.integrator import Integrator

start = Integrator.start


def started(self):
    start(self)
    with suppress(BaseException):
        os.kill(os.getpid(), signal.SIGHUP)


Integrator.start = started
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_a_signal_not_heard_just_before_the_time_loop_ends_it_at_its_first_step(ranks, tmp_path):
    done = mpirun(ranks, "-c", HOLE, cwd=tmp_path)
    assert "stopped by SIGHUP at t = " in message(done, 129)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["status"], result.summary["steps"]) == ("stopped", 1)


TAKEN = """
import ctypes, os, signal, sys
from fsipetsc import cli
from fsipetsc.stepping import run

start, header = cli.start_mpi, run._Run._header
ignore = ctypes.CDLL(None).signal
ignore.argtypes, ignore.restype = (ctypes.c_int, ctypes.c_void_p), ctypes.c_void_p


def taken():
    world = start()
    ignore(signal.SIGHUP, int(signal.SIG_IGN))  # Python does not know
    return world


def signalled(self):
    os.kill(os.getpid(), signal.SIGHUP)
    return header(self)


cli.start_mpi, run._Run._header = taken, signalled
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_steps 2 -fsi_quiet".split()))
"""


def test_a_library_that_answers_a_signal_itself_does_not_keep_it(tmp_path):
    """UCX, below some MPI, wants SIGHUP for itself."""
    done = run("-c", TAKEN, cwd=tmp_path)
    assert message(done, 129) == "fsipetsc: error: stopped by SIGHUP before the first step"


@pytest.mark.parametrize(("words", "number"), [("rod", signal.SIGTERM), ("stability", signal.SIGINT)])
def test_a_signal_that_comes_while_mpi_starts_is_named(words, number, tmp_path):
    done = run("-c", SIGNALLED, int(number), words, cwd=tmp_path)
    when = " before the first step" if words == "rod" else ""
    assert message(done, 128 + number) == f"fsipetsc: error: stopped by {signal.Signals(number).name}{when}"


LATE = """
import os, signal, sys
from fsipetsc.cli import main
from fsipetsc.stepping import run

last = run._Run._last_frame


def signalled(self):
    os.kill(os.getpid(), signal.SIGTERM)
    last(self)


run._Run._last_frame = signalled
sys.exit(main("rod -fsi_h 0.1 -ts_max_steps 3 -fsi_quiet".split()))
"""


def test_a_signal_behind_the_last_step_is_not_said_to_come_before_the_first(tmp_path):
    text = message(run("-c", LATE, cwd=tmp_path), 143)
    assert text == "fsipetsc: error: SIGTERM came while the result was being written"
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["steps"], len(result.series["t"])) == (3, 3)


@pytest.mark.mpi
def test_ranks_end_in_order_when_their_launcher_is_killed(tmp_path):
    process = started(2, tmp_path)
    ranks = ranks_of(process.pid)
    process.kill()
    process.communicate(timeout=PATIENCE)
    end = time.monotonic() + PATIENCE
    while any(Path(f"/proc/{rank}").exists() for rank in ranks) and time.monotonic() < end:
        time.sleep(0.05)
    left = [rank for rank in ranks if Path(f"/proc/{rank}").exists()]
    for rank in left:
        os.kill(rank, signal.SIGKILL)
    assert len(ranks) == 2 and left == []
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        ended = "status" in result.summary
        assert result.nframes > 2
    if ended:  # MPI has let them: it aborts ranks that have lost their launcher, and now and then is faster than they are
        assert_readable(tmp_path / "long.h5", "stopped", 1000.0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_the_run_in_order(number, tmp_path):
    process = started(1, tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    text = message(subprocess.CompletedProcess([], process.returncode, out, err), 128 + number)
    assert signal.Signals(number).name in text
    assert "long.h5" in text
    assert_readable(tmp_path / "long.h5", "stopped", 1000.0)
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        assert not result.complete
        assert result.time[-1] == result.series["t"][-1] == result.summary["t"], "the last state is saved"


def ranks_of(pid: int) -> list[int]:
    """Processes of the program that a launcher has started, by /proc: its first thread, another, or a launcher below it."""
    found = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, listed.read_text().split()):
            ours = b"\0-m\0fsipetsc\0" in Path(f"/proc/{child}/cmdline").read_bytes()
            found += ranks_of(child) or [child] * ours
    return found


@pytest.mark.mpi
def test_a_signal_to_rank_0_stops_all(tmp_path):
    """(To the last rank: test_kills.)"""
    process = started(2, tmp_path)
    ranks = ranks_of(process.pid)
    if len(ranks) != 2:
        process.terminate()
        process.communicate(timeout=PATIENCE)
        pytest.skip("the ranks are not to be found below the launcher")
    os.kill(ranks[0], signal.SIGTERM)
    out, err = process.communicate(timeout=PATIENCE)
    message(subprocess.CompletedProcess([], process.returncode, out, err), 143)
    assert_readable(tmp_path / "long.h5", "stopped", 1000.0)


def test_a_killed_run_leaves_its_frames(tmp_path):
    process = started(1, tmp_path)
    time.sleep(0.3)
    process.kill()
    process.communicate(timeout=PATIENCE)
    assert process.returncode == -signal.SIGKILL
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        assert not result.complete
        assert result.nframes > 2
        np.testing.assert_allclose(result.time, 0.001 * np.arange(result.nframes))
        assert np.isfinite(result.layers[1]["u"]).all()
        assert result.series["t"][-1] >= result.time[-1]
    done = solve("info", "long.h5", cwd=tmp_path)
    assert done.returncode == 0
    assert "unfinished" in done.stdout


WRITING = """
import os, signal, sys
from mpi4py import MPI
from fsipetsc import cli
from fsipetsc.output.writer import RunWriter

place, rank = sys.argv.pop(1), int(sys.argv.pop(1))
there = getattr(RunWriter, place)


def signalled(self, action):
    def followed():
        result = action()
        if MPI.COMM_WORLD.rank == rank:
            os.kill(os.getpid(), signal.SIGTERM)
        return result

    return there(self, followed)


setattr(RunWriter, place, signalled)
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""


@pytest.mark.parametrize(
    ("ranks", "place", "rank"),
    [
        (1, "_on_root", 0),
        pytest.param(2, "_on_root", 0, marks=pytest.mark.mpi),
        pytest.param(2, "_together", 1, marks=pytest.mark.mpi),
    ],
)
def test_a_signal_while_the_result_is_made_is_no_fault_of_the_file(ranks, place, rank, tmp_path):
    """Within what one rank does, where any exception is taken for a file that cannot be written, on all ranks."""
    done = mpirun(ranks, "-c", WRITING, place, rank, cwd=tmp_path)
    assert message(done, 143) == "fsipetsc: error: stopped by SIGTERM before the first step"
    assert "MPI_ABORT" not in done.stderr


ANSWERING = """
import os, signal, sys
from contextlib import suppress
from fsipetsc import cli

number, swallow, name = int(sys.argv.pop(1)), sys.argv.pop(1) == "swallowed", sys.argv[1]
there = getattr(cli, "_answer")


def signalled(arguments):
    there(arguments)
    with suppress(*[BaseException] * swallow):
        os.kill(os.getpid(), number)


cli._answer = signalled
sys.exit(cli.main())
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_what_one_process_answers_is_named(number, tmp_path):
    name = signal.Signals(number).name
    for how, said in (("heard", f"stopped by {name}"), ("swallowed", f"{name} came; what it was to stop is done")):
        done = run("-c", ANSWERING, int(number), how, "new", f"{how}.py", cwd=tmp_path)
        assert message(done, 128 + number) == f"fsipetsc: error: {said}"
        assert (tmp_path / f"{how}.py").exists()
