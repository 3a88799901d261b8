"""What a time step costs, in numbers that are the same on every machine: allocations, calls, messages, memory traffic.

Guards against a change that makes a step slower without making it wrong. Times are measured by the command ``bench``.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers import mpirun, run

pytest.importorskip("petsc4py")

PROGRAM = Path(__file__).with_name("counting_program.py")


def counts(*tasks: str, ranks: int = 1, **env: str) -> list[list[dict]]:
    """What counting_program.py prints: for each task a dict for each rank."""
    start = run if ranks == 1 else lambda *words, **more: mpirun(ranks, *words, **more)
    done = start(PROGRAM, *tasks, env=env)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


_MESSAGES, _BOXES = "messages -fsi_partition balanced -fsi_shared_memory 0", "messages -fsi_partition balanced"
#: ranks -> what is counted on them, one after the other in one process each
SENT = {
    1: ("messages", "path -fsi_partition auto"),
    2: (_MESSAGES, _BOXES, "path -fsi_partition physics", "path -fsi_partition balanced"),
    4: (_MESSAGES, _BOXES, "path -fsi_partition balanced"),
}


@pytest.fixture(scope="module")
def sent():
    """sent(ranks, task): of SENT, a dict for each rank."""
    kept: dict[int, dict[str, list[dict]]] = {}

    def get(ranks: int, task: str) -> list[dict]:
        if ranks not in kept:
            kept[ranks] = dict(zip(SENT[ranks], counts(*SENT[ranks], ranks=ranks), strict=True))
        assert len(kept[ranks][task]) == ranks
        return kept[ranks][task]

    return get


@pytest.mark.parametrize(("order", "burst"), [(4, 1), (4, 50), (8, 50)])
def test_a_burst_of_steps_is_one_call_that_allocates_nothing(order, burst):
    task = f"allocations -fsi_order {order} -fsi_burst {burst} -ts_max_steps 201"
    ((count,),) = counts(task, NUMBA_NRT_STATS="1")
    assert count["calls"] == 1 / burst
    assert count["in_kernels"] == 0
    assert count["empty_call"] <= 4, "the four arrays of the plan"
    assert count["python_bytes"] < 8, "what a step leaves behind in Python: counters that grow, nothing else"


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 4])
def test_messages_of_a_step(sent, ranks):
    """As many as the plan says, and no more than four neighbourly exchanges and five reductions."""
    for count in sent(ranks, _MESSAGES):
        sends, _, reductions, reduced_bytes, turns = count["said"]
        calls, numbers = count["calls"], count["numbers"]
        assert calls["MPI_Allreduce"] == 10 * reductions
        assert 8 * numbers["MPI_Allreduce"] == 10 * reduced_bytes
        assert numbers["MPI_Startall"] == numbers["MPI_Waitall"] == 2 * 10 * sends, "each message is sent and received"
        assert reductions <= 5 and turns == count["turns"] == 0
        assert 0 < sends <= 4 * 2
        assert calls["MPI_Startall"] <= 10 * 4


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 4])
def test_ranks_of_a_node_send_no_messages(sent, ranks):
    """They meet at their mailboxes instead, as often as they would in reductions."""
    for count in sent(ranks, _BOXES):
        assert count["calls"] == {}
        assert count["said"] == [0, 0, 0, 0, 5] and count["turns"] == 10 * 5


@pytest.mark.mpi
@pytest.mark.parametrize(("ranks", "partition"), [(1, "auto"), (2, "physics"), (2, "balanced"), (4, "balanced")])
def test_messages_of_petscs_own_methods(sent, ranks, partition):
    """A right-hand side is one of DMDA's exchanges for each layer, rows across interfaces, and the frame told within fluids."""
    listed = sent(ranks, f"path -fsi_partition {partition}")
    for count in listed:
        said, calls = count["said"], count["calls"]
        assert count["petsc"] == [10 * said["exchanges"], 10 * said["edges"], 10 * said["edge_bytes"]]
        assert calls.get("Sendrecv", 0) == 10 * said["rows"] and calls.get("Sendrecv bytes", 0) == 10 * said["row_bytes"]
        assert calls.get("Bcast", 0) == 10 * said["frames"]
    total = {name: sum(count["said"][name] for count in listed) for name in listed[0]["said"]}
    layers, interfaces = 3, 2
    assert total["exchanges"] >= layers and total["rows"] == (2 * interfaces if partition == "physics" else total["rows"])
    if ranks == 1:
        assert total == {**dict.fromkeys(total, 0), "exchanges": layers}
    elif partition == "balanced":
        assert total["edges"] == 2 * (total["exchanges"] - layers), "one way and the other at each cut within a layer"
        assert total["frames"] > 0


def test_one_rank_sends_nothing(sent):
    (count,) = sent(1, "messages")
    assert count["calls"] == {} and count["said"] == [0, 0, 0, 0, 0] and count["turns"] == 0


@pytest.mark.parametrize(("order", "h"), [(4, 0.0025), (8, 0.00125)])
def test_passes_over_memory(order, h):
    """Where the state fits into no cache: as often as fsipetsc.stepping.counts says, to within the ends of layers."""
    ((count,),) = counts(f"traffic -fsi_order {order} -fsi_h {h} -fsi_spare 0", NUMBA_DISABLE_JIT="1")
    assert count["fetched"] == pytest.approx(count["said_fetched"], rel=0.08)
    assert count["written"] == pytest.approx(count["said_written"], rel=0.08)
    assert count["said_fetched"] <= 5 and count["said_written"] <= 5


def test_memory_per_point():
    """Of a whole run with its first and last frame: what it takes more if the grid is finer."""
    from fsipetsc.bench.around_the_loop import doubles_per_point

    assert doubles_per_point((50_000, 500_000)) <= 40
