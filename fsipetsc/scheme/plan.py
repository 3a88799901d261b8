"""The plan of a rank: everything that compiled code works with, in four arrays.

head     one HEAD record: the operator, the world communicator, and where things stand in ``memory``
layers   LAYER records
faces    INTERFACE records
memory   one flat array of doubles: the solution as PETSc has it (interlaced), and areas in which every unknown of a
         layer stands for itself with its halos: three for the stages of a step, the first of which holds the solution
         between steps, the sum that a step builds up, forcing; and the traces of the interfaces, results, scratch

Few arrays and offsets instead of many arrays and slices: handing over an array costs compiled code as much as ten
points, a slice as much as fifty.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.boundaries import NODES
from fsipetsc.coupling import INTERFACE, KINDS
from fsipetsc.operators.kernels import ROW, scratch_size
from fsipetsc.operators.sbp import OPERATOR, SBPOperator, packed, row_length
from fsipetsc.parallel.exchange import TRACE
from fsipetsc.parallel.layout import Layout
from fsipetsc.parallel.neighbours import Neighbours
from fsipetsc.parallel.shared_memory import WORLD, world_record
from fsipetsc.physics.layer import DOF, ENDS, FLUID
from fsipetsc.scheme.extremes_and_sums import SIZE
from fsipetsc.scheme.reduction import reduced_words

_I = np.int64
HEAD = np.dtype(
    [
        ("op", OPERATOR),
        ("world", WORLD),
        ("rows", _I),  # of the traces
        ("area", _I, (5,)),  # WORK .. WORK + 2, SUM, FORCING (-1 if there is none); LAYER["work"] counts from there
        ("solution", _I),
        ("sent", _I),
        ("traces", _I),
        ("message", _I),  # doubles in either
        ("results", _I),  # of a completed step, see fsipetsc.scheme.finish_step: flags,
        ("limits", _I),
        ("states", _I),
        ("masses", _I),
        ("integrals", _I),
        ("burst", _I),  # see fsipetsc.scheme.burst
        ("journal", _I),  # of completed steps, see ``step_record``
        ("row", _I),  # doubles of one of them
        ("reduced", _I),  # number of the words that go round after a step, see fsipetsc.scheme.reduction:
        ("said", _I),  # this rank's,
        ("heard", _I),  # those of all ranks,
        ("everywhere", _I),  # and the extremes that they stand for
        ("extremes", _I),  # and sums of each layer, see fsipetsc.scheme.extremes_and_sums
        ("nodes", _I),
        ("scratch", _I),
        ("entropy", _I),  # 1: its integrals are taken, too
        ("requests", _I),  # number of them
        ("request_list", _I),  # addresses for MPI
        ("status_list", _I),
        ("halo", _I),  # points of one
        # points at the ends of a layer that the conditions read or change, or where a tile would need fluxes of the closure
        ("edge", _I),
        ("least", _I),  # points of a layer that has a middle worth tiles
    ],
    align=True,
)
#: the areas: the first three are worked in
#: (no Python ints: of a function that is given one numba compiles a version for just this value)
WORK, SUM, FORCING = np.int64(0), np.int64(3), np.int64(4)
#: stages of the fused Runge-Kutta method; after the last one comes the completion of the step
STAGES = 4
#: middles shorter than this are no gain, nor are tiles where a rank has fewer points: its caches hold them all
LEAST_MIDDLE, LEAST_TILED = 512, 8192
#: nor where ranks that wait for each other would make a step so many times as long
MOST_WAITING = 1.03
# where what stands among the results of a completed step
#: flags: a boundary changed its cell; 1 + number of a layer whose grid has no free point left,
#: that has run off its grid, or that is too short
MOVED, LOW, EXHAUSTED, TOO_SHORT = 0, 1, 2, 3
#: limits, behind the flags; SAID_STOP is what this rank has to say of STOP
RATE, BAD, STOP, SAID_STOP = 4, 5, 6, 7
#: doubles of the flags and of the limits among the results
FLAGS, LIMITS = 4, 4
#: integrals behind the masses of the fluid layers, see fsipetsc.scheme.integrals; the last two are optional
ENERGY, MOMENTUM, FORCE, IMPULSE, ENTROPY, HEATING = range(6)
INTEGRALS = 6
#: words of a burst of steps, see fsipetsc.scheme.burst
BURST = 11
#: steps that the journal holds; they must be written then. Whole chunks of the file, see output.tables
CAPACITY = 40 << 10
#: rows of scratch that the kernels use: five of the sweep, those of the terms of fsipetsc.scheme.undivided, and those that are
#: prepared for fsipetsc.scheme.two_point
SCRATCH = 19
#: doubles of a cache line, to which parts of the memory are aligned
_LINE = 8



def shares(record: np.dtype) -> tuple[str, ...]:
    """The columns of a record that are shares of the ranks, to be added up: the last ones."""
    names = record.names
    return names[names.index("mass" if "mass" in names else "energy") :]


def step_record(interfaces: int, fluids: int, entropy: bool) -> np.dtype:
    """What is noted of a step: doubles, as they stand in the memory of the plan, and as they are written to the file.

    Time after the step and its length, the rows of ``finish_step.interface_state``, and the integrals. What a problem without
    interfaces or without a fluid has none of is not there.
    """
    columns = [f"{name}_interface" for name in ("x", "u", "sigma", "T")]
    columns += [f"residual_{name}" for name in ("u", "stress", "T", "flux")]
    integrals = ["energy", "momentum", "force", "impulse"] + ["entropy", "heating"] * entropy
    several = [(name, interfaces) for name in columns] + [("mass", fluids)]
    return np.dtype(
        [("t", "f8"), ("dt", "f8")]
        + [(name, "f8", (count,)) for name, count in several if count]
        + [(name, "f8") for name in integrals]
    )


class Arrays(NamedTuple):
    """What compiled functions take as their first four arguments."""

    head: np.ndarray
    layers: np.ndarray
    faces: np.ndarray
    memory: np.ndarray


class Plan(Arrays):
    """The arrays; and compiled(function), which is a compiled function for the laws of the problem: by itself as it is."""

    compiled: Callable[[Any], Any] = staticmethod(lambda function: function)

    def start(self, name: str) -> int:
        """Where a part of the memory begins."""
        return int(self.head[name][0])

    def part(self, name: str, size: int) -> np.ndarray:
        """View of a part of the memory."""
        at = self.start(name)
        return self.memory[at : at + size]

    def work(self, k: int, area: int = WORK) -> np.ndarray:
        """View, shape (owned points and halos, dof), of layer k in an area."""
        layer = self.layers[k]
        dof, stride = DOF[layer["kind"]], int(layer["stride"])
        at = int(self.head["area"][0, area] + layer["work"])
        count = int(layer["halo_lo"] + layer["own_hi"] - layer["own_lo"] + layer["halo_hi"])
        return self.memory[at : at + dof * stride].reshape(dof, stride)[:, :count].T

    def owned(self, k: int, area: int = WORK) -> np.ndarray:
        """View, shape (owned points, dof), of layer k in an area."""
        layer = self.layers[k]
        begin = int(layer["halo_lo"])
        return self.work(k, area)[begin : begin + int(layer["own_hi"] - layer["own_lo"])]

    def ends(self, k: int, area: int = WORK) -> np.ndarray:
        """View, shape (2,), of the kinetic energies of the end points of layer k in an area; (0,) where there are none."""
        layer = self.layers[k]
        at = int(self.head["area"][0, area] + layer["work"])
        at += int(layer["halo_lo"] + layer["own_hi"] - layer["own_lo"] + layer["halo_hi"])
        return self.memory[at : at + ENDS * int(layer["ends"] >= 0)]

    @property
    def traces(self) -> np.ndarray:
        """View, shape (interfaces, rows, TRACE), of the rows at the interfaces as all ranks know them."""
        size = int(self.head["message"][0])
        return self.part("traces", size).reshape(len(self.faces), int(self.head["rows"][0]), TRACE)

    @property
    def record(self) -> np.dtype:
        """Of a step in the journal."""
        return step_record(len(self.faces), _fluids(self.layers), bool(self.head["entropy"][0]))

    @property
    def journal(self) -> np.ndarray:
        """View of the records of steps."""
        return self.part("journal", CAPACITY * int(self.head["row"][0])).view(self.record)

    @property
    def latest(self) -> np.void:
        """View of what will be the record of the last completed step, without its time."""
        names = self.record.names[2:]
        return self.part("states", int(self.head["row"][0]) - 2).view([(name, self.record[name]) for name in names])[0]


def make_faces(layout: Layout, coupling: str) -> np.ndarray:
    """INTERFACE records of all interfaces."""
    faces = np.zeros(len(layout.problem.interfaces), INTERFACE)
    for face, (fluid, solid) in zip(faces, layout.problem.interfaces, strict=True):
        face["fluid"], face["solid"], face["coupling"] = fluid, solid, KINDS[coupling]
        face["normal"], face["h"] = (1.0 if fluid > solid else -1.0), layout.records[solid]["h"]
        face["h_gas"], face["J"] = layout.records[fluid]["h"], 1.0
        face["spacing"], face["ratio"] = face["h_gas"], face["h_gas"] / face["h"]
        for name in ("gamma", "R", "cv", "mu", "kappa", "gas_numbers", "transport_numbers"):
            face[name] = layout.records[fluid][name]
        for name in ("K", "kappa_e", "m0", "alpha", "gruneisen", "pressing_numbers"):
            face[name] = layout.records[solid][name]
    return faces


def make_plan(
    layout: Layout, op: SBPOperator, coupling: str, forced: bool, entropy: bool, shared: bool, narrow: bool, shocks: float
) -> tuple[Plan, Neighbours]:
    """The plan of this rank and its neighbours, with shared memory if ``shared`` and possible. Collective."""
    faces = make_faces(layout, coupling)
    rows = row_length(op)
    message = len(faces) * rows * TRACE
    reduced = reduced_words(len(layout.records))
    neighbours = Neighbours(layout, max(message, reduced), shared)
    fluids = _fluids(layout.records)
    results = FLAGS + LIMITS + 8 * len(faces) + fluids + INTEGRALS
    row = step_record(len(faces), fluids, entropy).itemsize // 8
    areas = ["area0", "area1", "area2", "sum"] + ["forcing"] * forced
    sizes = {
        "solution": layout.local_size,
        **dict.fromkeys(areas, layout.work_size),
        "edges": neighbours.buffer,
        "sent": message,
        "traces": message,
        "burst": BURST,
        "journal": CAPACITY * row,
        "extremes": SIZE * len(layout.records),
        "everywhere": SIZE * len(layout.records),
        "said": reduced,
        "heard": reduced,
        "results": results,
        "nodes": 5 * NODES,
        "scratch": scratch_size(SCRATCH),
    }
    starts: dict[str, int] = {}
    total = 0
    for name, size in sizes.items():
        # a row's length between the parts keeps equal points of two parts from evicting each other
        starts[name], total = total, total + (size + ROW % 512 + _LINE) // _LINE * _LINE
    memory = np.zeros(total + _LINE)
    memory = memory[-memory.ctypes.data // 8 % _LINE :][:total]
    head = np.zeros(1, HEAD)
    head["op"], head["world"] = packed(op.order, narrow, shocks), world_record(layout.comm, neighbours.mailboxes)[0]
    head["rows"], head["message"], head["halo"], head["reduced"] = rows, message, layout.halo, reduced
    head["area"] = [starts.get(name, -1) for name in (*areas, "forcing")[:5]]
    for name in HEAD.names:
        if name in starts:
            head[name] = starts[name]
    edge = max(layout.halo, rows)
    least = 2 * (edge + STAGES * 2 * op.p) + LEAST_MIDDLE
    head["edge"], head["least"] = edge, (least if tiles_pay(layout, edge, least) else np.iinfo(_I).max)
    head["limits"] = head["results"] + FLAGS
    head["row"], head["entropy"] = row, entropy
    head["states"] = head["limits"] + LIMITS
    head["masses"] = head["states"] + 8 * len(faces)
    head["integrals"] = head["masses"] + fluids
    neighbours.connect(memory[starts["edges"] :][: neighbours.buffer])
    requests = neighbours.requests
    head["requests"] = requests.handles.size
    head["request_list"], head["status_list"] = requests.handles.ctypes.data, requests.statuses.ctypes.data
    return Plan(head, layout.records, faces, memory), neighbours


def tiles_pay(layout: Layout, edge: int, least: int) -> bool:
    """Whether a step should go through the middles of layers tile by tile; the same on all ranks.

    That is done after the ends, between whose stages the ranks wait for each other. So it pays only where no rank has
    much to do in the one part of the step, and another one in the other.
    """
    whole, inner = np.zeros(layout.comm.size), np.zeros(layout.comm.size)
    for pieces in layout.shares:
        for rank, begin, end in pieces:
            whole[rank] += end - begin
            inner[rank] += end - begin - 2 * edge if end - begin >= least else 0
    return bool(whole.max() >= LEAST_TILED and (whole - inner).max() + inner.max() <= MOST_WAITING * whole.max())


def _fluids(layers: np.ndarray) -> int:
    return int(np.count_nonzero(layers["kind"] == FLUID))
