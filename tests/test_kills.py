"""Runs that signals stop or kill end in order, and go on with the same bits.

Processes signal themselves at named places (signalled_program.py)."""

import fcntl
import json
import random
import signal
from contextlib import suppress

import pytest
from helpers import REPOSITORY, assert_readable, computed, different, message, mpirun, run, well

import fsipetsc

PROGRAM = REPOSITORY / "tests" / "signalled_program.py"
LINE = "rod -fsi_coupling projection -fsi_h 0.05 -ts_max_time 0.1 -fsi_output_dt 0.01".split()
LINE.append("-fsi_quiet")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return computed(tmp_path_factory.mktemp("whole"), "whole.h5", *LINE).path


@pytest.mark.parametrize(
    ("ranks", "rank", "count", "number"),
    [(1, 0, 4, signal.SIGINT), (2, 0, 1, signal.SIGHUP), (2, 1, 4, signal.SIGTERM)],
)
def test_a_run_that_a_signal_stopped_goes_on(ranks, rank, count, number, whole, tmp_path):
    """One message, 128 + signal, frame and checkpoint of the last step; on other ranks."""
    place = json.dumps([["frame", count, rank, number]])
    done = mpirun(ranks, PROGRAM, place, *LINE, cwd=tmp_path)
    words = f"stopped by {number.name} at t = ", "rod.h5", "the checkpoint in rod.checkpoint.h5"
    message(done, 128 + number, *words)
    assert_readable(tmp_path / "rod.h5", "stopped", 0.1)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert not result.complete and result.nframes in (count, count + 1)
        assert count > 1 or result.summary["steps"] == 1
        assert result.time[-1] == result.series["t"][-1] == result.summary["t"]
    computed(tmp_path, "rod.h5", *LINE, "-fsi_restart", "auto", ranks=3 - ranks)
    assert different(whole, tmp_path / "rod.h5", same_ranks=False) == []


def test_a_second_sigint_ends_at_once_and_one_after_the_last_step_ends_nothing(tmp_path):
    twice = [["frame", 4, 0, signal.SIGINT]] * 2
    done = run(PROGRAM, json.dumps(twice), *LINE, cwd=tmp_path)
    assert done.returncode == -signal.SIGINT  # 130 in a shell
    late = [["frame", 11, 0, signal.SIGTERM], ["join", 1, 0, signal.SIGTERM]]
    well(run(PROGRAM, json.dumps(late), *LINE, cwd=tmp_path))
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["status"] == "done"


#: case -> command line, steps from one checkpoint to the next
CASES = {
    "rod": ("rod -fsi_coupling projection -fsi_h 0.05 -ts_max_time 0.9 -fsi_output_dt 0.01", 40),
    "blast": ("blast -fsi_h 0.125 -fsi_order 2 -ts_max_time 4 -fsi_output_dt 0.04", 4),
}
#: ranks, [place, which time, rank, signal]; a signal below 0 goes to mpiexec
KILLS = [
    (2, ["frame", 2, 1, signal.SIGKILL]),
    (1, ["checkpoint", 2, 0, signal.SIGKILL]),
    (2, ["piece", 3, 0, -signal.SIGKILL]),
    (2, ["join", 1, 0, signal.SIGKILL]),  # at the beginning: of what is kept
    (1, ["join", 2, 0, signal.SIGKILL]),  # at the end
    (2, ["clear", 2, 0, signal.SIGKILL]),  # at the end
    (1, ["clear", 1, 0, signal.SIGKILL]),  # at the beginning: of what was left there
]


def ends_as(whole, words):
    """The run goes on to its end, has the same bits as the whole one, and leaves nothing else."""
    folder = whole.parent
    computed(folder, "run.h5", *words)
    assert different(whole, folder / "run.h5", same_ranks=False) == []
    left = {path.name for path in folder.iterdir() if path.suffix != ".xdmf"}
    assert left == {"whole.h5", "run.h5", "run.checkpoint.h5"}, left


@pytest.mark.parametrize(
    ("case", "kills"),
    [
        *(("rod", KILLS), ("blast", [(1, ["join", 1, 0, signal.SIGKILL])])),
        *(pytest.param(case, 25, marks=pytest.mark.long) for case in CASES),
    ],
)
def test_a_run_that_is_killed_goes_on(case, kills, tmp_path):
    """25: so often, in any order, in runs one after the other."""
    line, steps = CASES[case]
    computed(tmp_path, "whole.h5", *line.split())
    words = [*line.split(), "-fsi_restart", "auto", "-fsi_checkpoint_steps", str(steps)]
    quiet = "-fsi_quiet", "-fsi_output", "run.h5"
    for ranks, place in random.Random(1).choices(KILLS, k=25) if kills == 25 else kills:
        done = mpirun(ranks, PROGRAM, json.dumps([place]), *words, *quiet, cwd=tmp_path)
        # ranks whose mpiexec was killed may still run: they have the lock
        with suppress(FileNotFoundError), (tmp_path / "run.parts" / "lock").open() as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
        if (tmp_path / "run.h5").exists() or (tmp_path / "run.parts/000001.h5").exists():
            with fsipetsc.open_run(tmp_path / "run.h5") as result:
                for layer in result.layers:
                    assert all(layer[name].shape[0] == result.nframes for name in layer.fields)
        if done.returncode == 0:  # it ended before the place
            assert kills == 25, place
            ends_as(tmp_path / "whole.h5", words)
            for path in tmp_path.glob("run*"):
                path.unlink()
    ends_as(tmp_path / "whole.h5", words)


STOPPED = """
import signal, sys, time
from fsipetsc.errors import ComputationError, FileError, Interrupted
from fsipetsc.process import together as ending
from fsipetsc.process.launch import start_mpi
from fsipetsc.process.together import together

def run():
    if sys.argv[1] == "none":
        return
    raise Interrupted(signal.SIGTERM, "stopped by SIGTERM at t = 1")  # as by a signal

world, sleep = start_mpi(), time.sleep
notes = world.Dup()
if sys.argv[1] == "run" and world.rank == 0:  # which has spoken; rank 1 is the one that ends all
    ending.done_asleep = lambda request, patience: sleep(patience + 60.0)
elif sys.argv[1] == "run" and world.rank == 1:
    usual = ending.done_asleep
    ending.done_asleep = lambda request, patience: usual(request, patience / 20.0)
try:
    together(world, run if world.rank < 2 else lambda: None, asleep=True)
except KeyboardInterrupt as error:
    sys.exit(ending.end_together(error, notes))
kinds = FileError, ComputationError, FileError
sys.exit(ending.end_together(kinds[world.rank]("of this rank"), notes))
"""


@pytest.mark.parametrize(
    ("place", "status", "said"),
    [("run", 143, "stopped by SIGTERM at t = 1"), ("none", 4, "of this rank")],
)
def test_all_ranks_end_in_order(place, status, said, tmp_path):
    """A run is stopped while rank 2 sleeps; all fail, each in its way."""
    done = mpirun(3, "-c", STOPPED, place, cwd=tmp_path)
    message(done, status, said)
    if place != "run":  # there MPI_Abort ends the rank that sleeps, of which Open MPI 5 tells
        assert "MPI_ABORT" not in done.stderr
