"""What a rank has of layers and interfaces, and what it exchanges of them with other ranks.

A layer lives on the ranks that own points of it: a DMDA on their communicator knows who owns which,
and the rates read its local vector. All ranks know its record and its material.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.operators.boxed import Box
from fsipetsc.paper import rates, steps
from fsipetsc.paper.coupling import Face
from fsipetsc.paper.laws import law_of
from fsipetsc.paper.layout import Layout

Array = np.ndarray


class Layer:
    """Layer k. Attributes: number, is_gas, present (this rank owns points of it), record, and
    records of it alone; arrays of
    the points of this rank: local with halos, ``owned`` those without; forcing; box, what compiled
    functions take."""

    def __init__(self, layout: Layout, k: int, op: Array, y: Array, total: Array, rates_: Array):
        layer, record = layout.problem.layers[k], layout.records[k : k + 1]
        self.number, self.is_gas = k, layer.kind == "fluid"
        self.records, self.record = record, record[0]
        self.law, self.op = law_of(layer.material), op
        self.present = bool(self.record["present"])
        self._dm, own = layout.dms[k], [layout.local(k, array) for array in (y, total, rates_)]
        count, before = len(own[0]), int(self.record["halo_lo"])
        self.local = np.zeros((before + count + int(self.record["halo_hi"]), layout.dof[k]))
        self.owned = self.local[before : before + count]
        self.forcing = np.zeros((count if layer.forcing is not None else 0, layout.dof[k]))
        scratch = np.zeros((rates.ROWS, len(self.local) + rates.MORE))
        points = self.local, self.owned, *own, self.forcing, scratch
        self.box = Box(steps.Part(op, self.law, record, *points))
        self._comm = self._dm.comm.tompi4py() if self.present else MPI.COMM_SELF
        # of the interface of a gas
        self._owner = self._comm.size - 1 if self.record["end_kind"][0] >= 0 else 0
        self._vec = PETSc.Vec().createWithArray(self.local, comm=MPI.COMM_SELF)
        gas = steps.gas_stage, steps.gas_rates, steps.complete_gas
        solid = steps.solid_stage, steps.solid_rates, steps.complete_solid
        stage, self._rates, complete = gas if self.is_gas else solid
        # rates and next stage of (number, dt); what follows a step, of (steps.Steps,)
        self.stage, self.complete = partial(stage, self.box), partial(complete, self.box)

    def exchange(self) -> None:
        """After interfaces are coupled: the outer ends of a solid; all ranks of a gas hear of its
        frame, (4.20), (4.25) and PETSc fills the halos."""
        if not self.is_gas:
            steps.close(self.box)
        elif self._comm.size > 1:
            told = np.array([self.record["s"], self.record["x_interface"]])
            self._comm.Bcast(told, self._owner)
            self.record["s"], self.record["x_interface"] = told
        self.fill_halos()

    def fill_halos(self) -> None:
        """PETSc's ghost exchange."""
        self._dm.localToLocal(self._vec, self._vec)

    def rates(self) -> None:
        """Rates, of any stage."""
        if self.is_gas:
            steps.fill(self.box)
        self._rates(self.box)

    def destroy(self) -> None:
        """Destroy its vector."""
        self._vec.destroy()


class Interface:
    """Interface number k. jump: prescribed jumps; side: 1 if the gas lies right of the solid, else
    0; here: whether this rank owns gas and solid beside it; notes: see fsipetsc.paper.steps."""

    def __init__(self, layout: Layout, k: int, kind: int, op: Array, layers, notes: Array):
        gas, solid = (layers[n] for n in layout.problem.interfaces[k])
        self.side = int(gas.number > solid.number)
        self.jump, rows, self.notes = np.zeros(4), (np.zeros((8, 3)), np.zeros((8, 4))), notes
        records = [layout.records[layer.number :][:1] for layer in (gas, solid)]
        face = Face(kind, gas.law, solid.law, 2.0 * self.side - 1.0, float(solid.record["h"]))
        points = gas.owned, solid.owned, self.jump, *rows, notes
        self.box = Box(steps.Sides(op, face, *records, *points))
        # the rank with the last point of a layer has all of the rows, see parallel.block_shares
        first = min(gas.number, solid.number)
        owners = [layout.shares[v.number][-1 if v.number == first else 0][0] for v in (gas, solid)]
        self.here = [owner == layout.comm.rank for owner in owners]
        self._messages: list[MPI.Prequest] = []  # where the two sides have different owners
        if any(self.here) and not all(self.here):
            mine = self._mine = steps.GAS if self.here[0] else steps.SOLID
            self._messages = [
                layout.comm.Send_init(rows[mine], owners[1 - mine], k),
                layout.comm.Recv_init(rows[1 - mine], owners[1 - mine], k),
            ]

    def begin(self) -> None:
        """Send the rows of this rank's side to the owner of the other one."""
        if self._messages:
            steps.move_side(self.box, self._mine, False)
            MPI.Prequest.Startall(self._messages)

    def couple(self) -> None:
        """Couple the two sides in the stage: each owner solves the same small system."""
        if all(self.here):
            steps.couple_here(self.box)
        elif self._messages:
            MPI.Prequest.Waitall(self._messages)
            steps.couple(self.box)
            steps.move_side(self.box, self._mine, True)

    def note(self) -> None:
        """Let the owner of the solid note the interface."""
        if self.here[1]:
            steps.note(self.box)
        else:
            self.notes[:] = -np.inf

    def destroy(self) -> None:
        """Free its messages."""
        for message in self._messages:
            message.Free()
