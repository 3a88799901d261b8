"""Signals at named places before, within and behind a run: all ranks end in order, say it once, and leave what was computed.

Each process sends them to itself, so that they come there and nowhere else. (Between the steps: tests/test_kills.py.)
"""

from __future__ import annotations

import signal

import pytest
from helpers import message, mpirun, run, solve
from said import parted

import fsipetsc

pytest.importorskip("petsc4py")

LONG = "rod -fsi_h 0.025 -fsi_output_dt 0.001 -ts_max_time 1000 -fsi_output long.h5".split()


SIGNALLED = """
import signal, sys
from fsipetsc import cli

start, number = cli.start_mpi, int(sys.argv.pop(1))


def signalled():
    signal.raise_signal(number)  # it waits until all ranks can be told
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
        signal.raise_signal(number)


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
        signal.raise_signal(signal.SIGHUP)


Integrator.start = started
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""


@pytest.mark.mpi
def test_a_signal_not_heard_just_before_the_time_loop_ends_it_at_its_first_step(tmp_path):
    done = mpirun(2, "-c", HOLE, cwd=tmp_path)
    assert "stopped by SIGHUP at t = " in message(done, 129)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["status"], result.summary["steps"]) == ("stopped", 1)


def test_a_signal_that_comes_while_mpi_starts_is_named(tmp_path):
    done = run("-c", SIGNALLED, int(signal.SIGTERM), "rod", cwd=tmp_path)
    assert message(done, 143) == "fsipetsc: error: stopped by SIGTERM before the first step"


LATE = """
import os, signal, sys
from fsipetsc.cli import main
from fsipetsc.stepping import run

last = run._Run._last_frame


def signalled(self):
    signal.raise_signal(signal.SIGTERM)
    last(self)


run._Run._last_frame = signalled
sys.exit(main("rod -fsi_h 0.1 -ts_max_steps 3 -fsi_quiet".split()))
"""


def test_a_signal_behind_the_last_step_is_not_said_to_come_before_the_first(tmp_path):
    text = message(run("-c", LATE, cwd=tmp_path), 143)
    assert text == "fsipetsc: error: SIGTERM came while the result was being written"
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["steps"], len(result.series["t"])) == (3, 3)


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
            signal.raise_signal(signal.SIGTERM)
        return result

    return there(self, followed)


setattr(RunWriter, place, signalled)
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""


@pytest.mark.mpi
def test_a_signal_while_the_result_is_made_is_no_fault_of_the_file(tmp_path):
    """Within what one rank does, where any exception is taken for a file that cannot be written, on all ranks."""
    done = mpirun(2, "-c", WRITING, "_together", 1, cwd=tmp_path)
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
        signal.raise_signal(number)


cli._answer = signalled
sys.exit(cli.main())
"""


def test_a_signal_to_what_one_process_answers_is_named(tmp_path):
    for how, said in (("heard", "stopped by SIGINT"), ("swallowed", "SIGINT came; what it was to stop is done")):
        done = run("-c", ANSWERING, int(signal.SIGINT), how, "new", f"{how}.py", cwd=tmp_path)
        assert message(done, 130) == f"fsipetsc: error: {said}"
        assert (tmp_path / f"{how}.py").exists()
