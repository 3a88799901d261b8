"""The right-hand side, with PETSc's ghost exchange: what is done, to be read from top to bottom.

A layer lives on the ranks that own points of it: a DMDA on their communicator knows who owns which,
and the rates read its local vectors. One evaluation:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from
                    it, and each of them solves the same small system      (Thm 4.1, Sec. 4.2)
    2  frames       the owner of a gas's interface point tells the layer its velocity s and its
                    place x_I                                              (4.20), (4.25)
    3  halos        DMDA fills the local vectors: twice the reach of D, because D acts twice
    4  points       ghost points (4.26), then the rates of all points      (4.19), (4.20)

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions.
The point arithmetic is the same on any number of ranks, and nothing is added up over ranks: so are
the results, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.boxed import Box
from fsipetsc.paper import batch, entries, rates
from fsipetsc.paper.coupling import Face
from fsipetsc.paper.laws import Elastic, Gas
from fsipetsc.paper.layer import DOF, FLUID, Part
from fsipetsc.paper.layout import Layout

Array = np.ndarray


class RightHandSide:
    """dy/dt of the world vector, and the arrays that a step works in. All methods are collective.

    Arrays of this rank's doubles: stage, on which the conditions are imposed; y: the solution's own
    memory; total, k. layers: those that this rank has a part of. forced: layers with forcing;
    rooms: (1,), ROOM of fsipetsc.paper.batch.
    """

    def __init__(
        self,
        layout: Layout,
        op: Array,
        laws: Sequence[Gas | Elastic],
        kind: int,
        y: Array,
        forced: Sequence[bool],
        rooms: Array,
    ) -> None:
        self.op, self.y, self.rooms = op, y, rooms
        self.stage, self.total, self.k = (np.zeros(layout.local_size) for _ in range(3))
        here = [k for k, dm in enumerate(layout.dms) if dm is not None]
        self.layers = [LayerPart(layout, self, k, laws[k], forced[k]) for k in here]
        self.interfaces = [
            Interface(layout, self, k, laws, kind)
            for k in range(len(layout.problem.interfaces))
        ]

    def fulfil_conditions(self) -> None:
        """Let the stage, and the local vectors with it, fulfil all conditions but for ghost points,
        which are filled later."""
        for interface in self.interfaces:
            interface.begin()
        for interface in self.interfaces:
            interface.couple()
        for layer in self.layers:
            layer.close_end()
        for layer in self.layers:
            layer.fill_halos()

    def evaluate(self, f: Array, filled: bool = False) -> None:
        """Rates of a state that fulfils the conditions, to this rank's part f; filled: so do the
        ghost points."""
        for layer in self.layers:
            layer.evaluate(f, filled)

    def rates(self, y: Array, f: Array) -> None:
        """f = dy/dt of this rank's part, for the boundary data, jumps and forcing set last; y stays
        as it is."""
        self.stage[:] = y
        self.fulfil_conditions()
        self.evaluate(f)

    def keep_ghosts(self) -> None:
        """Let the stage have what ghost points got."""
        for layer in self.layers:
            layer.part.stage[:] = layer.owned

    def advance(self, number: int, dt: float) -> None:
        """What stage ``number`` of the classical Runge-Kutta method does with its rates k."""
        batch.advance(self.y, self.k, self.stage, self.total, number, dt)

    def destroy(self) -> None:
        """Destroy vectors and messages; before the DMDAs."""
        for interface in self.interfaces:
            interface.destroy()
        for layer in self.layers:
            layer.destroy()


class LayerPart:
    """This rank's part of layer k of a right-hand side."""

    def __init__(
        self, layout: Layout, rhs: RightHandSide, k: int, law: Gas | Elastic, forced: bool
    ) -> None:
        self.number, self._layout, self.op, self._dm = k, layout, rhs.op, layout.dms[k]
        self.record, self.law, self._rooms = layout.records[k : k + 1], law, rhs.rooms
        record, dof = self.record[0], DOF[layout.records[k]["kind"]]
        self.is_gas = bool(record["kind"] == FLUID)
        count = int(record["own_hi"] - record["own_lo"])
        points = count + int(record["halo_lo"] + record["halo_hi"])
        self.local = np.zeros((points, dof))
        self.owned = self.local[int(record["halo_lo"]) : int(record["halo_lo"]) + count]
        self.forcing = np.zeros((count if forced else 0, dof))
        scratch = np.zeros((rates.ROWS, points + rates.MORE))
        arrays = (self.own(array) for array in (rhs.y, rhs.stage, rhs.total, rhs.k))
        self.part = Part(law, self.record, self.forcing, scratch, *arrays)
        self._global = PETSc.Vec().createWithArray(self.part.stage, bsize=dof, comm=self._dm.comm)
        self._local = PETSc.Vec().createWithArray(self.local, bsize=dof, comm=PETSc.COMM_SELF)
        self._comm = self._dm.comm.tompi4py()
        self.side = 1 if record["end_kind"][0] == INTERFACE_END else 0  # where a gas ends

    @cached_property
    def box(self) -> Box:
        """What compiled calls take of it."""
        memory = self.local, self.part.stage, self.forcing, self.part.scratch, self._rooms
        return Box(entries.LayerData(self.op, self.law, self.record, *memory))

    def own(self, array: Array) -> Array:
        """View, shape (owned points, unknowns), of the layer in this rank's part of a solution."""
        return self._layout.local(self.number, array)

    def close_end(self) -> None:
        """What comes before the exchange: the outer ends of a solid; all ranks of a gas hear of the
        frame."""
        if not self.is_gas:
            entries.close_end(self.box)
        elif self._comm.size > 1:
            record, owner = self.record[0], 0 if self.side == 1 else self._comm.size - 1
            told = np.array([record["s"], record["x_interface"]])
            self._comm.Bcast(told, owner)
            record["s"], record["x_interface"] = told

    def fill_halos(self) -> None:
        """The ghost exchange of the layer."""
        self._dm.globalToLocal(self._global, self._local)

    def fill_ghost(self) -> None:
        """The embedded boundary of a gas, wherever its ghost point is needed."""
        if self.is_gas:
            entries.fill(self.box, self.side)

    def evaluate(self, f: Array, filled: bool) -> None:
        """The rates at this rank's points; filled: the ghost point has its values."""
        if self.is_gas:
            entries.evaluate_gas(self.box, -1 if filled else self.side, self.own(f))
        else:
            entries.evaluate_solid(self.box, self.own(f))

    def destroy(self) -> None:
        self._global.destroy()
        self._local.destroy()


class Interface:
    """Interface number k. jump: prescribed jumps; f, s: the rows of its two sides, of those ranks
    that own one."""

    def __init__(
        self,
        layout: Layout,
        rhs: RightHandSide,
        k: int,
        laws: Sequence[Gas | Elastic],
        kind: int,
    ) -> None:
        self._op, self._comm, self._rooms, room = rhs.op, layout.comm, rhs.rooms, rhs.rooms[0]
        gas, solid = layout.problem.interfaces[k]
        side = 1 if gas > solid else 0
        self.face = Face(
            kind,
            laws[gas],
            laws[solid],
            1.0 if gas > solid else -1.0,
            float(layout.records[solid]["h"]),
        )
        self.jump, self.f, self.s = room["jumps"][side], room["f"][side], room["s"][side]
        self._records = [layout.records[n : n + 1] for n in (gas, solid)]
        self._parts = [layout.local(n, rhs.stage) for n in (gas, solid)]
        # the rank with the last point of a layer has all of the rows, see
        # fsipetsc.parallel.partition
        self.owners = [layout.shares[n][-1 if n == min(gas, solid) else 0][0] for n in (gas, solid)]
        self.here = [owner == self._comm.rank for owner in self.owners]
        self.side = side
        self._messages: list[MPI.Prequest] = []  # where the two sides have different owners
        if any(self.here) and not all(self.here):
            self._mine = 0 if self.here[0] else 1
            rows, other = (self.f, self.s), self.owners[1 - self._mine]
            self._messages = [
                self._comm.Send_init(rows[self._mine], other, k),
                self._comm.Recv_init(rows[1 - self._mine], other, k),
            ]

    @cached_property
    def box(self) -> Box:
        """What compiled calls take of it."""
        rows = self.f, self.s, self._rooms
        sides = self.jump, *self._records, *self._parts
        return Box(entries.SidesData(self._op, self.face, *sides, *rows))

    def couple_apart(self) -> None:
        """Couple as the owners of the two sides do where these are two; what comes of it is
        nothing."""
        for side in (entries.GAS, entries.SOLID):
            entries.take_side(self.box, side)
            entries.couple_side(self.box, side)

    def begin(self) -> None:
        """Send the rows of this rank's side to the owner of the other one."""
        if self._messages:
            entries.take_side(self.box, self._mine)
            MPI.Prequest.Startall(self._messages)

    def couple(self) -> None:
        """Couple the two sides in the stage; the record of the gas has the frame's velocity and
        place then."""
        if all(self.here):
            entries.join(self.box)
        elif self._messages:
            MPI.Prequest.Waitall(self._messages)
            entries.couple_side(self.box, self._mine)

    def destroy(self) -> None:
        """Free its messages."""
        for message in self._messages:
            message.Free()
