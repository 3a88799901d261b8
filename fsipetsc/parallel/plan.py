"""The plan of a rank: everything that compiled code works with, in four arrays.

head     one HEAD record: the operator, the world communicator, and where things stand in ``memory``
layers   LAYER records
faces    INTERFACE records
memory   one flat array of doubles: the solution, two work areas (owned points and halos of all layers), the sum that a
         Runge-Kutta step builds up, forcing, the traces of the interfaces, results, scratch

Few arrays and offsets instead of many arrays and slices: handing over an array costs compiled code as much as ten
points, a slice as much as fifty.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsipetsc.boundaries import NODES
from fsipetsc.coupling import INTERFACE, KINDS
from fsipetsc.operators.kernels import ROW, scratch_size
from fsipetsc.operators.sbp import OPERATOR, SBPOperator, packed
from fsipetsc.parallel.layout import Layout
from fsipetsc.parallel.mpi import WORLD, Requests, world_record
from fsipetsc.physics.layer import DOF

_I = np.int64
HEAD = np.dtype(
    [
        ("op", OPERATOR),
        ("world", WORLD),
        ("rows", _I),  # of the traces
        ("area", _I, (2,)),  # the work areas; LAYER["work"] counts from there
        ("solution", _I),
        ("sum", _I),
        ("forcing", _I),  # -1 if there is none
        ("sent", _I),
        ("traces", _I),
        ("message", _I),  # doubles in either
        ("flags", _I),  # results of a completed step, see fsipetsc.parallel.completion
        ("limits", _I),
        ("states", _I),
        ("masses", _I),
        ("nodes", _I),
        ("scratch", _I),
        ("local", _I),  # doubles of the solution on this rank
        ("requests", _I),  # number per work area
        ("request_list", _I, (2,)),  # addresses for MPI
        ("status_list", _I),
    ],
    align=True,
)
#: doubles of a cache line, to which parts of the memory are aligned
_LINE = 8


class Plan(NamedTuple):
    """The arrays; compiled functions take them as their first four arguments."""

    head: np.ndarray
    layers: np.ndarray
    faces: np.ndarray
    memory: np.ndarray

    def part(self, name: str, size: int) -> np.ndarray:
        """View of a part of the memory."""
        at = int(self.head[name][0])
        return self.memory[at : at + size]

    def work(self, k: int, area: int = 0) -> np.ndarray:
        """View, shape (owned points and halos, dof), of layer k in a work area."""
        layer = self.layers[k]
        dof = DOF[layer["kind"]]
        at = int(self.head["area"][0, area] + layer["work"])
        count = int(layer["halo_lo"] + layer["own_hi"] - layer["own_lo"] + layer["halo_hi"])
        return self.memory[at : at + dof * count].reshape(count, dof)

    @property
    def traces(self) -> np.ndarray:
        """View, shape (interfaces, rows, 7), of the rows at the interfaces as all ranks know them."""
        size = int(self.head["message"][0])
        return self.part("traces", size).reshape(len(self.faces), -1, 7)


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


def make_plan(layout: Layout, op: SBPOperator, coupling: str, forced: bool) -> tuple[Plan, list[Requests]]:
    """The plan of this rank and the persistent requests of its halo exchanges, one set per work area. Collective."""
    faces = make_faces(layout, coupling)
    rows = max(2, op.rows)
    message = len(faces) * rows * 7
    sizes = {
        "solution": layout.local_size,
        "area0": layout.work_size,
        "area1": layout.work_size,
        "sum": layout.local_size,
        "forcing": layout.local_size if forced else 0,
        "sent": message,
        "traces": message,
        "flags": 4,
        "limits": 6,
        "states": 8 * len(faces),
        "masses": len(layout.records) + 1,
        "nodes": 5 * NODES,
        "scratch": scratch_size(9),
    }
    starts: dict[str, int] = {}
    total = 0
    for name, size in sizes.items():
        # a row's length between the parts keeps equal points of two parts from evicting each other
        starts[name], total = total, total + (size + ROW % 512 + _LINE) // _LINE * _LINE
    memory = np.zeros(total)
    head = np.zeros(1, HEAD)
    head["op"], head["world"] = packed(op.order), world_record(layout.comm)[0]
    head["rows"], head["message"], head["local"] = rows, message, layout.local_size
    head["area"] = starts.pop("area0"), starts.pop("area1")
    for name, at in starts.items():
        head[name] = at
    if not forced:
        head["forcing"] = -1
    requests = [_requests(layout, memory[int(at) :]) for at in head["area"][0]]
    head["requests"] = requests[0].handles.size
    head["request_list"] = [r.handles.ctypes.data for r in requests]
    head["status_list"] = requests[0].statuses.ctypes.data
    return Plan(head, layout.records, faces, memory), requests


def _requests(layout: Layout, work: np.ndarray) -> Requests:
    """Sends of this rank's edges and receives into its halos, straight from and into a work area."""
    requests = []
    for k, record in enumerate(layout.records):
        dof = DOF[record["kind"]]
        own = int(record["work"]) + dof * int(record["halo_lo"])
        end = own + dof * int(record["own_hi"] - record["own_lo"])
        far, strip = end + dof * int(record["halo_hi"]), dof * layout.width
        left, right = layout.neighbours(k)
        # tags: layer and direction of travel
        if left >= 0:
            requests.append(layout.comm.Send_init(work[own : own + strip], left, 2 * k))
            requests.append(layout.comm.Recv_init(work[int(record["work"]) : own], left, 2 * k + 1))
        if right >= 0:
            requests.append(layout.comm.Send_init(work[end - strip : end], right, 2 * k + 1))
            requests.append(layout.comm.Recv_init(work[end:far], right, 2 * k))
    return Requests(requests)
