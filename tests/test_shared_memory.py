"""How ranks of a node meet in shared memory: what each learns, turn after turn, whoever is late."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import PATIENCE, environment, mpirun

pytest.importorskip("petsc4py")

#: begins a command where /dev/shm has room for next to nothing, which nobody else notices
SMALL = ["unshare", "-m", "sh", "-c", "mount -t tmpfs -o size=4k tmpfs /dev/shm && exec \"$@\"", "sh"]


def may_mount() -> bool:
    try:
        return subprocess.run([*SMALL, "true"], capture_output=True, timeout=PATIENCE).returncode == 0
    except OSError:
        return False


PROGRAM = """
import json, sys, time
import numpy as np
from mpi4py import MPI
from numba import njit
from fsipetsc.parallel import shared_memory as module
from fsipetsc.parallel.shared_memory import largest, make_mailboxes, share_a_node, world_record

WORDS, TURNS = 40, 400
comm = MPI.COMM_WORLD
FAULTS = {
    "one without room": {"free_space": lambda: 4096.0 if comm.rank == 1 else np.inf},
    "one without": {"unified": lambda window: comm.rank != 1},
}


@njit(cache=True)
def meet(worlds, memory):
    base = memory.ctypes.data
    largest(worlds[0], base, base + 8 * WORDS, WORDS)


def given(rank, turn):
    values = np.random.default_rng([rank, turn]).standard_normal(WORDS)
    values[turn % WORDS :: 7] = np.nan if rank == turn % comm.size else 0.0
    return values


def results(how):
    kept = dict(vars(module))
    vars(module).update(FAULTS.get(how, {}))
    mailboxes = make_mailboxes(comm, 8 * WORDS) if how != "messages" else None
    vars(module).update(kept)
    worlds, memory, wrong = world_record(comm, mailboxes), np.zeros(2 * WORDS), 0
    for turn in range(TURNS):
        if turn % 50 == 7 * comm.rank:
            time.sleep(0.002)  # everybody is late at times
        memory[:WORDS] = given(comm.rank, turn)
        meet(worlds, memory)
        words = [given(rank, turn).view(np.uint64) for rank in range(comm.size)]
        wrong += not np.array_equal(memory[WORDS:].view(np.uint64), np.max(words, axis=0))
    if mailboxes is not None:
        mailboxes.free()
    return comm.gather((share_a_node(comm), mailboxes is not None, wrong))


found = {how: results(how) for how in sys.argv[1:]}
if comm.rank == 0:
    print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory) -> Path:
    """A file, so that what it compiles is kept."""
    path = tmp_path_factory.mktemp("meeting") / "meeting.py"
    path.write_text(PROGRAM)
    return path


def meet(program: Path, ranks: int, *hows: str, **env: str) -> dict[str, list[list]]:
    """By how they meet, one way after the other, of each rank: whether all are on one node, whether they have mailboxes,
    and turns in which it learnt something wrong."""
    done = mpirun(ranks, program, *hows, env=env)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])  # behind what a library says: UCX, of a root without /sys


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [3, 4])  # two meet below
def test_all_learn_the_largest_of_each_word(program, ranks):
    """Bit for bit, as whole numbers without sign: also of what is not a number. Where one rank can have no box, by messages."""
    wanted = {"mailboxes": True, "messages": False} | ({"one without": False, "one without room": False} if ranks == 3 else {})
    assert meet(program, ranks, *wanted) == {how: [[True, boxes, 0]] * ranks for how, boxes in wanted.items()}


@pytest.mark.mpi
@pytest.mark.skipif(not may_mount(), reason="only root can make a small /dev/shm, and not everywhere")
def test_where_shared_memory_is_too_small_messages_are_sent(program):
    """Open MPI 4.1 would leave one rank waiting for the other."""
    command = [*SMALL, "mpiexec", "-n", "2", sys.executable, program, "boxes"]
    env = environment({"OMPI_MCA_btl": "self,tcp"})  # messages through shared memory have no room either
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"boxes": [[True, False, 0]] * 2}


@pytest.mark.mpi
def test_where_the_library_has_no_shared_windows_messages_are_sent(program):
    """Open MPI without the component that makes them; another library takes no notice of the variable."""
    found = meet(program, 2, "mailboxes", OMPI_MCA_osc="^sm")["mailboxes"]
    assert [(together, wrong) for together, _, wrong in found] == [(True, 0)] * 2
    assert found[0][1] == found[1][1]
