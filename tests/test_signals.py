"""Signals at named places before, within and after a run: all ranks end in order, and say it once.

Each process sends them to itself, so that they come there and nowhere else. (Between the steps:
tests/test_kills.py.)
"""

from __future__ import annotations

import pytest
from helpers import message, mpirun, run

import fsipetsc

pytest.importorskip("petsc4py")

FAILING = """
from dataclasses import replace
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "failing", rod.OPTIONS, rod.DEFAULTS


def build(opt):
    problem = rod.build(opt)
    below, solid, above = problem.layers
    return replace(problem, layers=(replace(below, initial=initial(below.initial)), solid, above))


def initial(function):
    def fields(X):
        raise ValueError("no density is known")
        return function(X)

    return fields
"""


@pytest.mark.mpi
def test_an_error_in_the_initial_data_of_one_rank_alone_ends_all(tmp_path):
    """What the error holds of the rank's arrays is let go: PETSc would wait at its end for ranks
    with other objects.
    """
    (tmp_path / "failing.py").write_text(FAILING)
    line = "failing.py -fsi_h 0.025 -fsi_partition physics -fsi_quiet".split()
    done = mpirun(2, "-m", "fsipetsc", *line, cwd=tmp_path)
    said = message(done, 2)
    assert "failing.py, line " in said and said.endswith("ValueError: no density is known")


STOPPED = """
import signal, sys
from fsipetsc.errors import Interrupted, RanksError
from fsipetsc.process.failure import end_together
from fsipetsc.process.launch import start_mpi
from fsipetsc.verify.command import on_as_many


def run(ranks):
    if ranks.size > 2:
        raise RanksError("too many")
    if sys.argv[1] == "run":  # as a run ends that a signal has stopped
        raise Interrupted(signal.SIGTERM, "stopped by SIGTERM at t = 1")
    signal.raise_signal(signal.SIGINT)


world = start_mpi()
notes = world.Dup()
try:
    on_as_many(world, run)
except KeyboardInterrupt as error:
    sys.exit(end_together(error, notes))
"""


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("place", "status", "said"),
    [("run", 143, "stopped by SIGTERM at t = 1"), ("set-up", 130, "stopped by SIGINT")],
)
def test_ranks_that_sleep_are_ended_by_those_that_a_signal_has_stopped(
    place, status, said, tmp_path
):
    """Where it came to these alone: by MPI_Abort, 10 s later, and rank 0 says why."""
    message(mpirun(3, "-c", STOPPED, place, cwd=tmp_path), status, said)


#: a SIGINT of all ranks in the set-up: rank 0 compiles, rank 1 sleeps and ends first
SET_UP = """
import signal, time
import fsipetsc
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.process import together
from fsipetsc.process.launch import start_mpi

sleep, rank = time.sleep, start_mpi().rank


def stopped(self, announce):
    sleep(2.0)
    signal.raise_signal(signal.SIGINT)


def woken(seconds):
    signal.raise_signal(signal.SIGINT)


if rank == 0:
    BlockState.compile = stopped
else:
    together.time.sleep = woken
try:
    fsipetsc.run("rod", h=0.1, coupling="conservative")
except KeyboardInterrupt:
    print("ended", rank, flush=True)
"""


@pytest.mark.mpi
def test_all_ranks_that_are_stopped_in_the_set_up_end_in_order(tmp_path):
    done = mpirun(2, "-c", SET_UP, cwd=tmp_path)
    assert (done.returncode, sorted(done.stdout.split())) == (0, ["0", "1", "ended", "ended"])
    assert "MPI_ABORT" not in done.stderr and "stopped by SIGINT" in done.stderr


#: a signal between the start of a run and its time loop; SIGNAL: its name
STARTED = """
import signal, sys
import fsipetsc
from fsipetsc import cli
from fsipetsc.stepping.integrator import Integrator

start = Integrator.start


def started(self):
    start(self)
    signal.raise_signal(signal.SIGNAL)


Integrator.start = started
"""
HOLE = (
    STARTED.replace("SIGNAL", "SIGHUP")
    + """
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""
)


@pytest.mark.mpi
def test_a_signal_not_heard_just_before_the_time_loop_ends_it_at_its_first_step(tmp_path):
    done = mpirun(2, "-c", HOLE, cwd=tmp_path)
    assert "stopped by SIGHUP at t = " in message(done, 129)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["status"], result.summary["steps"]) == ("stopped", 1)


LATE = """
import signal, sys
from fsipetsc.cli import main
from fsipetsc.stepping import run

flush = run._Run._flush


def signalled(self):
    signal.raise_signal(signal.SIGTERM)
    flush(self)


run._Run._flush = signalled
sys.exit(main("rod -fsi_h 0.1 -ts_max_steps 3 -fsi_quiet".split()))
"""


def test_a_run_whose_steps_are_done_ends_as_ever_whatever_comes(tmp_path):
    done = run("-c", LATE, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["status"], len(result.series["t"])) == ("done", 3)


SWEEP = (
    STARTED.replace("SIGNAL", "SIGTERM")
    + """
try:
    fsipetsc.run("rod", h=0.1, max_time=1000)
except fsipetsc.FsiError:
    print("swallowed")
except KeyboardInterrupt as error:
    print(error.status, error)
"""
)


def test_a_sweep_that_goes_on_after_an_error_does_not_go_on_after_a_sigterm(tmp_path):
    done = run("-c", SWEEP, cwd=tmp_path)
    assert done.stdout.startswith("143 stopped by SIGTERM at t = "), done.stdout + done.stderr
