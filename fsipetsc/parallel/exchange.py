"""From the solution to work arrays in which halos, ghost points and interfaces are right: compiled, one pass.

Per evaluation a rank sends the edges of its parts to its neighbours (one message per layer and side, straight
from the work array), and the traces of all interfaces go round in one small reduction. The reduction is a maximum
of 64-bit words over buffers that are zero where a rank owns nothing: exact, bit for bit, and all ranks learn the
traces and from them the frames' positions and velocities.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from mpi4py import MPI
from numba import njit

from fsipetsc.boundaries import INTERFACE_END, NODES, close_solid, fill_ghost
from fsipetsc.coupling import INTERFACE, KINDS, couple
from fsipetsc.operators.kernels import OPTIONS, scratch_rows
from fsipetsc.operators.sbp import SBPOperator, packed
from fsipetsc.parallel.layout import Layout
from fsipetsc.parallel.mpi import Requests, mpi_allreduce, mpi_startall, mpi_waitall, world_record
from fsipetsc.physics.layer import DOF, FLUID
from fsipetsc.physics.solid import solid_rhs
from fsipetsc.physics.fluid import fluid_rhs


class Plan(NamedTuple):
    """Everything that compiled code works with on this rank, as plain arrays."""

    layers: np.ndarray  # LAYER records
    faces: np.ndarray  # INTERFACE records
    op: np.ndarray  # OPERATOR record
    world: np.ndarray  # WORLD record
    work: np.ndarray  # owned points and halos of all layers
    scratch: np.ndarray  # rows for the kernels
    traces: np.ndarray  # (2, interfaces, rows, 7): sent, and received from all ranks
    nodes: np.ndarray  # (5, NODES) scratch of a ghost fill
    forcing: np.ndarray  # added to the right-hand side; empty if there is none
    requests: np.ndarray
    statuses: np.ndarray


def make_faces(layout: Layout, coupling: str) -> np.ndarray:
    """INTERFACE records of all interfaces."""
    faces = np.zeros(len(layout.problem.interfaces), INTERFACE)
    for face, (fluid, solid) in zip(faces, layout.problem.interfaces, strict=True):
        face["fluid"], face["solid"], face["coupling"] = fluid, solid, KINDS[coupling]
        face["normal"], face["h"] = (1.0 if fluid > solid else -1.0), layout.h
        for name in ("gamma", "R", "cv", "mu", "kappa"):
            face[name] = layout.records[fluid][name]
        for name in ("K", "kappa_e", "m0", "alpha", "gruneisen"):
            face[name] = layout.records[solid][name]
    return faces


def make_plan(layout: Layout, op: SBPOperator, coupling: str, forced: bool) -> tuple[Plan, Requests]:
    """The plan of this rank and the persistent requests of its halo exchange. Collective."""
    faces = make_faces(layout, coupling)
    work = np.zeros(layout.work_size)
    requests = []
    for k, record in enumerate(layout.records):
        dof, at = DOF[record["kind"]], int(record["work"])
        own = at + dof * int(record["halo_lo"])
        end = own + dof * int(record["own_hi"] - record["own_lo"])
        far, strip = end + dof * int(record["halo_hi"]), dof * layout.width
        left, right = layout.neighbours(k)
        # tags: layer and direction of travel
        if left >= 0:
            requests.append(layout.comm.Send_init(work[own : own + strip], left, 2 * k))
            requests.append(layout.comm.Recv_init(work[at:own], left, 2 * k + 1))
        if right >= 0:
            requests.append(layout.comm.Send_init(work[end - strip : end], right, 2 * k + 1))
            requests.append(layout.comm.Recv_init(work[end:far], right, 2 * k))
    persistent = Requests(requests)
    rows = max(2, op.rows)
    plan = Plan(
        layout.records,
        faces,
        np.array([packed(op.order)]),
        world_record(layout.comm),
        work,
        scratch_rows(9),
        np.zeros((2, len(faces), rows, 7)),
        np.zeros((5, NODES)),
        np.zeros(layout.local_size if forced else 0),
        persistent.handles,
        persistent.statuses,
    )
    return plan, persistent


@njit(**OPTIONS)
def layer_work(layer, work):
    """The part of the work array that holds a layer: owned points and halos."""
    dof = 3 if layer.kind == FLUID else 4
    return work[layer.work : layer.work + dof * (layer.halo_lo + layer.own_hi - layer.own_lo + layer.halo_hi)]


@njit(**OPTIONS)
def holds(layer, begin, end):
    """This rank has the points begin .. end-1 in its work array."""
    return layer.present == 1 and layer.own_lo - layer.halo_lo <= begin and end <= layer.own_hi + layer.halo_hi


@njit(**OPTIONS)
def end_of_interface(layer, on_right_side):
    """(point at the interface, step into the layer) for a layer right or left of it."""
    return (layer.lo, 1) if on_right_side else (layer.hi, -1)


@njit(**OPTIONS)
def pack_traces(plan, k):
    """Write what this rank owns of the rows at interface k into the message."""
    face, rows = plan.faces[k], plan.traces.shape[2]
    for part in range(2):
        layer = plan.layers[face.fluid if part == 0 else face.solid]
        point, step = end_of_interface(layer, (face.normal > 0.0) == (part == 0))
        if layer.present == 0 or point < layer.own_lo or point >= layer.own_hi:
            continue
        w, first = layer_work(layer, plan.work), layer.own_lo - layer.halo_lo
        dof, column = (3, 0) if part == 0 else (4, 3)
        for j in range(rows):
            for c in range(dof):
                plan.traces[0, k, j, column + c] = w[dof * (point + step * j - first) + c]


@njit(**OPTIONS)
def unpack_traces(plan, k):
    """Write the rows at interface k back into the work array, as far as this rank has them."""
    face, rows = plan.faces[k], plan.traces.shape[2]
    for part in range(2):
        layer = plan.layers[face.fluid if part == 0 else face.solid]
        if layer.present == 0:
            continue
        point, step = end_of_interface(layer, (face.normal > 0.0) == (part == 0))
        w, first = layer_work(layer, plan.work), layer.own_lo - layer.halo_lo
        dof, column = (3, 0) if part == 0 else (4, 3)
        for j in range(rows):
            i = point + step * j
            if holds(layer, i, i + 1):
                for c in range(dof):
                    w[dof * (i - first) + c] = plan.traces[1, k, j, column + c]


@njit(**OPTIONS)
def load(plan, y):
    """Copy the solution into the work array and exchange halos and traces. Collective on all ranks."""
    for layer in plan.layers:
        if layer.present == 1:
            dof = 3 if layer.kind == FLUID else 4
            count, own = dof * (layer.own_hi - layer.own_lo), layer.work + dof * layer.halo_lo
            plan.work[own : own + count] = y[layer.start : layer.start + count]
    if plan.requests.size > 0:
        mpi_startall(plan.requests.size, plan.requests.ctypes.data)
    if plan.world[0].size > 1:
        plan.traces[0] = 0.0
    for k in range(plan.faces.size):
        pack_traces(plan, k)
    if plan.world[0].size > 1:
        sent, received, world = plan.traces[0], plan.traces[1], plan.world[0]
        mpi_allreduce(sent.ctypes.data, received.ctypes.data, sent.size, world.word, world.max, world.comm)
    else:
        plan.traces[1] = plan.traces[0]
    if plan.requests.size > 0:
        mpi_waitall(plan.requests.size, plan.requests.ctypes.data, plan.statuses.ctypes.data)


@njit(**OPTIONS)
def ghost_point(layer, side):
    """(ghost point, step into the layer) at an embedded boundary."""
    return (layer.lo, 1) if side == 0 else (layer.hi, -1)


@njit(**OPTIONS)
def boundary_distance(layer, side):
    """Distance between interface and embedded boundary in cells, from the position of the frame (not by (4.25))."""
    return abs(layer.end_x[side] - layer.x_interface) / layer.h


@njit(**OPTIONS)
def fill_embedded(plan, layer, side, new):
    """Give the ghost point of a fluid layer its values, where this rank has the points that this takes."""
    G, step = ghost_point(layer, side)
    deepest = G + step * (NODES - 1)
    if not holds(layer, min(G, deepest), max(G, deepest) + 1):
        # a short layer may have fewer points than the largest formula takes
        deepest = min(max(deepest, layer.lo), layer.hi)
        if not holds(layer, min(G, deepest), max(G, deepest) + 1):
            return
    w, first = layer_work(layer, plan.work), layer.own_lo - layer.halo_lo
    nodes = plan.nodes
    for k in range(abs(deepest - G) + 1):
        i = 3 * (G + step * k - first)
        rho = w[i]
        if k == 0 and new:
            continue
        u = w[i + 1] / rho
        nodes[0, k] = rho
        nodes[1, k] = u
        nodes[2, k] = (w[i + 2] / rho - 0.5 * u * u) / layer.cv
    delta = (layer.hi - layer.lo) - boundary_distance(layer, side)
    fill_ghost(layer, plan.op[0], side, delta, nodes, new)
    i, rho, u, T = 3 * (G - first), nodes[0, 0], nodes[1, 0], nodes[2, 0]
    w[i], w[i + 1], w[i + 2] = rho, rho * u, rho * (layer.cv * T + 0.5 * u * u)


@njit(**OPTIONS)
def close_end(plan, layer, side):
    """Apply the condition at the outer end of a solid, where this rank has the rows that this takes."""
    rows = plan.traces.shape[2]
    point, step = end_of_interface(layer, side == 0)
    deepest = point + step * (rows - 1)
    if not holds(layer, min(point, deepest), max(point, deepest) + 1):
        return
    w, first = layer_work(layer, plan.work), layer.own_lo - layer.halo_lo
    trace = plan.scratch[0][: 4 * rows].reshape(rows, 4)
    for j in range(rows):
        for c in range(4):
            trace[j, c] = w[4 * (point + step * j - first) + c]
    close_solid(layer, plan.op[0], side, trace)
    for c in range(4):
        w[4 * (point - first) + c] = trace[0, c]


@njit(**OPTIONS)
def refresh(plan, y):
    """Work arrays of the solution y with ghost points filled and interfaces projected. Collective on all ranks.

    The order of SCHEME: ghost points from the raw values, then both interfaces. Also sets the frames.
    """
    load(plan, y)
    for k in range(plan.faces.size):
        face = plan.faces[k]
        plan.layers[face.fluid].x_interface = plan.traces[1, k, 0, 6]
    for k in range(plan.layers.size):
        layer = plan.layers[k]
        for side in range(2):
            if layer.end_kind[side] != INTERFACE_END:
                if layer.kind == FLUID:
                    fill_embedded(plan, layer, side, False)
                else:
                    close_end(plan, layer, side)
    for k in range(plan.faces.size):
        couple(plan.faces[k], plan.op[0], plan.traces[1, k, :, :3], plan.traces[1, k, :, 3:])
        unpack_traces(plan, k)
        plan.layers[plan.faces[k].fluid].s = plan.traces[1, k, 0, 1] / plan.traces[1, k, 0, 0]


@njit(**OPTIONS)
def evaluate(plan, y, f):
    """f = dy/dt of the semi-discrete equations (4.19), (4.20) at the projected y. Collective on all ranks."""
    refresh(plan, y)
    for k in range(plan.layers.size):
        layer = plan.layers[k]
        if layer.present == 1:
            dof = 3 if layer.kind == FLUID else 4
            part = f[layer.start : layer.start + dof * (layer.own_hi - layer.own_lo)]
            if layer.kind == FLUID:
                fluid_rhs(layer, plan.op[0], layer_work(layer, plan.work), part, plan.scratch)
            else:
                solid_rhs(layer, plan.op[0], layer_work(layer, plan.work), part, plan.scratch)
    if plan.forcing.size > 0:
        for i in range(f.size):
            f[i] += plan.forcing[i]
