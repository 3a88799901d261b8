"""What a rank has of layers and interfaces, and what it exchanges of them with other ranks.

A layer lives on the ranks that own points of it: a DMDA on their communicator knows who owns which,
and the rates read its local vector. All ranks know its record and its material.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc import given
from fsipetsc.operators.boxed import Box
from fsipetsc.paper import rates, steps
from fsipetsc.paper.coupling import Face
from fsipetsc.paper.layout import DOF

Array = np.ndarray


class Layer:
    """Layer number k, and this rank's points of it.

    layer: what the case says; law: its material; record: of records, that of it alone. numbers, X,
    local, owned, forcing: of the points of this rank, local with halos; box: what compiled
    functions take; ranks: that own the first and the last point. Collective, as are all methods on
    ranks that have points.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        layer: Any,
        law: Any,
        records: Array,
        share: Sequence[tuple[int, int, int]],
        op: Array,
        memory: Sequence[Array],
        at: int,
    ) -> None:
        self.layer, self.law, self.op, self.records = layer, law, op, records
        self.record = record = records[0]
        self.number, self.is_gas = int(record["number"]), layer.kind == "fluid"
        self.present = bool(record["present"])
        self.ranks, dof = (share[0][0], share[-1][0]), DOF[layer.kind]
        self.numbers = own = np.arange(record["own_lo"], record["own_hi"])
        self.X = record["anchor"] + (own - record["anchor_index"]) * record["h"]
        count, before, after = len(own), int(record["halo_lo"]), int(record["halo_hi"])
        self._place = slice(at, at + dof * count)  # in this rank's part of a solution
        self.local = np.zeros((before + count + after, dof))
        self.owned = self.local[before : before + count]
        self.forcing = np.zeros((count if layer.forcing is not None else 0, dof))
        scratch = np.zeros((rates.ROWS, len(self.local) + rates.MORE))
        points = self.local, self.owned, *map(self.of, memory), self.forcing, scratch
        self.box = Box(steps.Part(op, law, records, *points))
        stage, complete = (
            (steps.gas_stage, steps.complete_gas)
            if self.is_gas
            else (steps.solid_stage, steps.complete_solid)
        )
        # rates and next stage of (number, dt); what follows a step, of (steps.Steps,)
        self.stage, self.complete = partial(stage, self.box), partial(complete, self.box)
        self._vec = PETSc.Vec().createWithArray(self.local, comm=MPI.COMM_SELF)
        self._comm = comm.Split(0 if self.present else MPI.UNDEFINED, comm.rank)
        # of the interface of a gas, among those that have points
        self._owner = len(share) - 1 if record["end_kind"][0] >= 0 else 0
        if self.present:
            sizes = np.array([end - begin for _, begin, end in share], PETSc.IntType)
            self._dm = PETSc.DMDA().create(
                dim=1,
                dof=dof,
                sizes=(int(record["n"]),),
                proc_sizes=(len(share),),
                ownership_ranges=(sizes,),
                boundary_type=PETSc.DM.BoundaryType.NONE,
                stencil_width=int(record["halo"]),
                comm=self._comm,
            )

    def of(self, array: Array) -> Array:
        """View, shape (owned points, unknowns), of this layer in this rank's part of a solution."""
        return array[self._place].reshape(-1, self.local.shape[1])

    @property
    def active(self) -> slice:
        """The active ones among the points that this rank owns."""
        own, begin, end = (int(self.record[name]) for name in ("own_lo", "lo", "hi"))
        return slice(max(begin - own, 0), max(end + 1 - own, 0))

    def set_initial(self, y: Array) -> dict[tuple[int, int], float]:
        """Fill y, (owned points, unknowns), with initial data; InputError, here alone perhaps.

        Returns (number, end) -> x [m] of the ends of a solid that this rank owns.
        """
        fields = given.initial(self.layer, self.X, self.active)
        if self.layer.exact is not None:  # what is wrong with it is not found out at the end
            given.fields(self.layer, "exact", self.X, 0.0, self.active)
        if self.is_gas:
            rho, u, T = fields
            with np.errstate(all="ignore"):  # what comes of it is monitored
                e = rho * (self.layer.material.internal_energy(rho, T) + 0.5 * u * u)
                y[:] = np.stack([rho, rho * u, e], axis=-1)
            return {}
        y[:] = np.stack(fields, axis=-1)
        first, last = self.record["own_lo"] == 0, self.record["own_hi"] == self.record["n"]
        ends = {(self.number, 0): fields[3][0]} if first else {}
        return {**ends, **({(self.number, 1): fields[3][-1]} if last else {})}

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
        self.stage(steps.RATES_ALONE, 0.0)

    def destroy(self) -> None:
        """Destroy its vector, its DMDA and the communicator of that."""
        self._vec.destroy()
        if self.present:
            self._dm.destroy()
            self._comm.Free()


class Interface:
    """Interface number k. jump: prescribed jumps; side: 1 if the gas lies right of the solid, else
    0; here: whether this rank owns gas and solid beside it; notes: see fsipetsc.paper.steps."""

    def __init__(
        self, comm: MPI.Comm, k: int, kind: int, gas: Layer, solid: Layer, notes: Array
    ) -> None:
        self.side = int(gas.number > solid.number)
        self.jump, rows, self.notes = np.zeros(4), (np.zeros((8, 3)), np.zeros((8, 4))), notes
        face = Face(kind, gas.law, solid.law, 2.0 * self.side - 1.0, float(solid.record["h"]))
        points = gas.owned, solid.owned, self.jump, *rows, notes
        self.box = Box(steps.Sides(solid.op, face, gas.records, solid.records, *points))
        # the rank with the last point of a layer has all of the rows, see parallel.block_shares
        owners = gas.ranks[1 - self.side], solid.ranks[self.side]
        self.here = [owner == comm.rank for owner in owners]
        self._messages: list[MPI.Prequest] = []  # where the two sides have different owners
        if any(self.here) and not all(self.here):
            mine = self._mine = steps.GAS if self.here[0] else steps.SOLID
            self._messages = [
                comm.Send_init(rows[mine], owners[1 - mine], k),
                comm.Recv_init(rows[1 - mine], owners[1 - mine], k),
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
