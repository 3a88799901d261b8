"""What a step costs in messages, floating-point operations and memory: counted from the plan, without running it.

The command ``bench`` builds its cost model on these numbers, -log_view shows them, and the tests hold them against what
is really sent and touched.
"""

from __future__ import annotations

from typing import NamedTuple

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.parallel.layout import Layout
from fsipetsc.physics.layer import DOF, FLUID
from fsipetsc.scheme.plan import Plan
from fsipetsc.stepping.petsc_path import COLUMNS


class Traffic(NamedTuple):
    """What this rank sends: messages to neighbours with their bytes, and reductions over all ranks with theirs.

    On a shared node there is none of that, but turns at the mailboxes instead (fsipetsc.parallel.shared_memory).
    """

    sends: int
    sent_bytes: int
    reductions: int
    reduced_bytes: int
    turns: int = 0


class Moved(NamedTuple):
    """Doubles per unknown that a step moves between memory and caches where the state is larger than these.

    What is written has been fetched before, as processors do.
    """

    fetched: float
    written: float


#: What the parts of the memory cost in a fused step that goes over them once, tile by tile, as it does where the points of
#: a rank do not fit into caches (scheme.plan.tiles_pay); the few points at the ends of layers do not count.
PASSES = {
    "solution, from before to after the step": Moved(1, 1),
    "values in the second and the fourth stage": Moved(1, 1),
    "values in the third stage": Moved(1, 1),
    "sum of the stages": Moved(1, 1),
    "solution for PETSc": Moved(1, 1),
}


def step_traffic() -> Moved:
    """Of a whole fused step."""
    return Moved(sum(p.fetched for p in PASSES.values()), sum(p.written for p in PASSES.values()))


def stage_traffic(plan: Plan) -> Traffic:
    """Of one exchange: each stage but the first of a step begins with one, and so does the completion of the step."""
    head = plan.head[0]
    sends = sent = 0
    if head["world"]["size"] == 1:
        return Traffic(0, 0, 0, 0)
    if head["world"]["mailboxes"]:
        return Traffic(0, 0, 0, 0, 1)
    for layer in plan.layers:
        for halo in (layer["halo_lo"], layer["halo_hi"]):
            sends += int(halo > 0)
            sent += 8 * DOF[layer["kind"]] * int(halo)
    return Traffic(sends, sent, 1, 8 * int(head["message"]))


class PathTraffic(NamedTuple):
    """What this rank sends for one right-hand side of PETSc's own methods (stepping.petsc_path).

    edges: messages of DMDA's, to neighbours within layers; rows: messages across interfaces; frames: broadcasts within
    layers that it takes part in. exchanges: DMDA's, one for each layer that it has a part of.
    """

    exchanges: int
    edges: int
    edge_bytes: int
    rows: int
    row_bytes: int
    frames: int


def path_traffic(layout: Layout, plan: Plan) -> PathTraffic:
    """Of one right-hand side of PETSc's own methods."""
    exchanges = edges = edge_bytes = rows = row_bytes = frames = 0
    for layer, shares in zip(plan.layers, layout.shares, strict=True):
        exchanges += int(layer["present"])
        for halo in (layer["halo_lo"], layer["halo_hi"]):
            edges, edge_bytes = edges + int(halo > 0), edge_bytes + 8 * DOF[layer["kind"]] * int(halo)
        if layer["present"] == 1 and layer["kind"] == FLUID and len(shares) > 1:
            # of a stretched gas the places of its ends, and then their velocities
            frames += 2 * int((layer["end_kind"] == INTERFACE_END).sum()) if layer["stretched"] else 1
    for pair in layout.problem.interfaces:
        owners = [layout.shares[k][-1 if k == min(pair) else 0][0] for k in pair]
        if layout.comm.rank in owners and owners[0] != owners[1]:
            rows, row_bytes = rows + 1, row_bytes + 8 * int(plan.head["rows"][0]) * COLUMNS[owners.index(layout.comm.rank)]
    return PathTraffic(exchanges, edges, edge_bytes, rows, row_bytes, frames)


def completion_traffic(plan: Plan) -> Traffic:
    """Of the completion of a step: one exchange, and the reduction of the limits."""
    exchange = stage_traffic(plan)
    if exchange.reductions:
        return exchange._replace(reductions=2, reduced_bytes=exchange.reduced_bytes + 8 * int(plan.head["reduced"][0]))
    return exchange._replace(turns=2 * exchange.turns)


def flops(plan: Plan) -> int:
    """Floating-point operations of one evaluation of the right-hand side on this rank's points, and of its use.

    As the formulas stand, with the interior stencil everywhere: what is done twice at the ends of blocks and the
    longer rows of the closures do not count; divisions, and products added to something, count as they are written.
    """
    stencil = 3 * int(plan.head[0]["op"]["p"]) - 1
    total = 0
    for layer in plan.layers:
        points = min(layer["own_hi"], layer["hi"] + 1) - max(layer["own_lo"], layer["lo"])
        dof = DOF[layer["kind"]]
        # fluid: u, T, p and three fluxes; solid: heat flux, heating, the three rates. Then two updates per unknown.
        derivatives, point = (5, 18) if layer["kind"] == FLUID else (5, 7)
        total += max(0, int(points)) * (derivatives * stencil + point + 4 * dof)
    return total


def doubles(plan: Plan) -> int:
    """Doubles of memory of this rank, the solution included: the whole of what a time step works on."""
    return int(plan.memory.size)
