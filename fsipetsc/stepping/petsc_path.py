"""The right-hand side by PETSc's own means: the parallel method, to be read from top to bottom.

Every method of PETSc's (-ts_type rk, ssp, euler) asks for dy/dt here, one evaluation after the other. The fused method
(stepping.fused) computes the same numbers in one compiled piece with an exchange of its own: it is the optimisation, this is
what it stands for. A layer lives on the ranks that own points of it: a DMDA on their communicator knows who owns which.
One evaluation is four steps, of which the first three are collective:

    1  interfaces   the owners of the two sides of an interface swap the rows that D reaches from it, and each of them
                    solves the same small system                                             (Thm 4.1, Sec. 4.2)
    2  halos        DMDA fills the local vectors: twice the reach of D, because D acts twice
    3  frames       the owner of a fluid's interface point tells the layer its velocity s and its place x_I (4.20), (4.25)
    4  points       ghost points and outer ends (4.26), then the rates of all points          (4.19), (4.20)

Of a stretched gas both ends are told, their places before step 1 solves anything, because they say how long its cells are.

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions. The point arithmetic is the
same on any number of ranks, and nothing is added up over ranks: so are the results, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from petsc4py import PETSc

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.cache import compiling
from fsipetsc.parallel.layout import Layout
from fsipetsc.physics.layer import DOF, FLUID
from fsipetsc.scheme.one_layer import apply_ends, couple_rows, evaluate_rates, move_grids, place_grids
from fsipetsc.scheme.plan import SUM, Plan

#: of the rows at an interface: the unknowns of fluid and solid, and the kinetic energy of the solid's end point
COLUMNS = DOF[0], DOF[1] + 1


class PetscPath:
    """dy/dt of the world vector, which on each rank is the concatenation of its parts of the layers.

    All methods are collective on the layout's communicator.
    """

    def __init__(self, layout: Layout, plan: Plan) -> None:
        self._plan = plan
        self._state, self._rates = np.empty(layout.local_size), np.empty(layout.local_size)
        mine = [k for k, dm in enumerate(layout.dms) if dm is not None]
        self._layers = [LayerPart(layout, plan, k, self._state, self._rates) for k in mine]
        self._interfaces = [Interface(layout, plan, k, self._state) for k in range(len(plan.faces))]

    def rates(self, y: np.ndarray, f: np.ndarray) -> None:
        """f = dy/dt of this rank's part, for the boundary data, jumps and forcing set last; y stays as it is."""
        self.apply_conditions(y)
        for layer in self._layers:
            layer.evaluate()
        f[:] = self._rates

    def apply_conditions(self, y: np.ndarray) -> None:
        """Fill the plan's first work area with this rank's part y and its halos, which fulfil all conditions."""
        self._state[:] = y
        for interface in self._interfaces:
            interface.swap_rows()
        for layer in self._layers:
            layer.learn_places()
        self._plan.compiled(place_grids)(*self._plan)
        for interface in self._interfaces:
            interface.project()
        for layer in self._layers:
            layer.fill_halos()
        for layer in self._layers:
            layer.learn_velocities()
        self._plan.compiled(move_grids)(*self._plan)
        for layer in self._layers:
            layer.apply_ends()

    def destroy(self) -> None:
        """Destroy the vectors; before the DMDAs."""
        for layer in self._layers:
            layer.destroy()


class LayerPart:
    """This rank's part of layer k; state, rates: the rank's parts of world vectors.

    The ranks of the layer share the vector ``own``, whose memory is the layer's part of the state: the vector of the DMDA.
    """

    def __init__(self, layout: Layout, plan: Plan, k: int, state: np.ndarray, rates: np.ndarray) -> None:
        self._k, self._plan, self._dm, dof = k, plan, layout.dms[k], DOF[layout.records[k]["kind"]]
        self._own = PETSc.Vec().createWithArray(layout.local(k, state), bsize=dof, comm=self._dm.comm)
        # PETSc has the unknowns of a point together; the loops have each unknown by itself, in areas of the plan
        self._work, self._evaluated, self._rates = plan.work(k), plan.owned(k, SUM), layout.local(k, rates)
        self._with_halos = np.empty(self._work.shape)
        self._local = PETSc.Vec().createWithArray(self._with_halos, bsize=dof, comm=PETSc.COMM_SELF)
        # kinetic energies of end points: to the work area, and their rates from where these are
        self._ends = (plan.ends(k), layout.ends(k, state)), (layout.ends(k, rates), plan.ends(k, SUM))
        self._record, self._comm = layout.records[k], self._dm.comm.tompi4py()
        interfaces = [side for side in range(2) if self._record["end_kind"][side] == INTERFACE_END]
        tells = self._record["kind"] == FLUID and self._comm.size > 1
        self._interfaces = interfaces if tells else []

    def learn_places(self) -> None:
        """The owners of the ends of a stretched gas know from the solids where these are; the others hear of it."""
        if self._record["stretched"]:
            self._hear("end_x")

    def fill_halos(self) -> None:
        """The ghost exchange of the layer."""
        self._dm.globalToLocal(self._own, self._local)
        self._work[:] = self._with_halos
        into, ends = self._ends[0]
        into[:] = ends

    def learn_velocities(self) -> None:
        """The owner of a gas's point at an interface knows how fast it is, and of a rigid frame where; the others hear it."""
        if self._record["stretched"]:
            self._hear("end_v")
        elif self._interfaces:
            told = np.array([self._record["s"], self._record["x_interface"]])
            self._comm.Bcast(told, self._owner(self._interfaces[0]))
            self._record["s"], self._record["x_interface"] = told

    def _hear(self, name: str) -> None:
        for side in self._interfaces:
            self._comm.Bcast(self._record[name][side : side + 1], self._owner(side))

    def _owner(self, side: int) -> int:
        """Rank in the layer that has its left (0) or right end."""
        return 0 if side == 0 else self._comm.size - 1

    def apply_ends(self) -> None:
        """Ghost point and outer end, where this rank has the points that they take, in its halos perhaps."""
        self._plan.compiled(apply_ends)(*self._plan, self._k)

    def evaluate(self) -> None:
        """The rates at this rank's points."""
        self._plan.compiled(evaluate_rates)(*self._plan, self._k)
        self._rates[:] = self._evaluated
        rates, evaluated = self._ends[1]
        rates[:] = evaluated

    def destroy(self) -> None:
        self._own.destroy()
        self._local.destroy()


class Interface:
    """Interface k between a fluid and a solid; ``state``: this rank's part of the world vector."""

    def __init__(self, layout: Layout, plan: Plan, k: int, state: np.ndarray) -> None:
        self._k, self._plan, self._comm = k, plan, layout.comm
        layers, count = layout.problem.interfaces[k], int(plan.head["rows"][0])
        self._rows = [np.zeros((count, columns)) for columns in COLUMNS]  # counted from the interface
        self._owners, self._own = [], []
        for layer in layers:
            left = layer == min(layers)  # of the interface; the rank with the last point there has all the rows, see partition
            self._owners.append(layout.shares[layer][-1 if left else 0][0])
            part = layout.local(layer, state)
            self._own.append((part[::-1] if left else part)[:count])
        self._here = [owner == self._comm.rank for owner in self._owners]
        self._side = 0 if layers[0] > layers[1] else 1  # of the gas on which the interface is
        energies = layout.ends(layers[1], state)
        self._energy = energies[1 - self._side : 2 - self._side]
        self._record, self._face = layout.records[layers[0]], plan.faces[k]

    def swap_rows(self) -> None:
        """Swap rows with the owner of the other side; where the solid ends is where the interface is."""
        if not any(self._here):
            return
        for here, rows, own in zip(self._here, self._rows, self._own, strict=True):
            if here:
                rows[:, : own.shape[1]] = own
        if self._here[1] and len(self._energy):
            self._rows[1][0, -1] = self._energy[0]
        if not all(self._here):
            mine, other = (0, 1) if self._here[0] else (1, 0)
            rank = self._owners[other]
            self._comm.Sendrecv(self._rows[mine], rank, recvbuf=self._rows[other], source=rank)
        self._record["x_interface"] = self._record["end_x"][self._side] = self._rows[1][0, 3]

    def project(self) -> None:
        """Project both sides, and keep what is this rank's."""
        if not any(self._here):
            return
        if self._record["stretched"] and not all(self._here):
            self._tell_spacing()
        fluid, solid = self._rows
        self._plan.compiled(couple_rows)(*self._plan, self._k, fluid, solid)
        self._record["end_v"][self._side] = fluid[0, 1] / fluid[0, 0]
        if not self._record["stretched"]:
            self._record["s"] = self._record["end_v"][self._side]
        for here, rows, own in zip(self._here, self._rows, self._own, strict=True):
            if here:
                own[:] = rows[:, : own.shape[1]]
        if self._here[1] and len(self._energy):
            self._energy[0] = solid[0, -1]

    def _tell_spacing(self) -> None:
        """The owner of the gas's side, which knows both ends of the gas, tells the owner of the solid's how long a cell is."""
        told = np.array([self._face[name] for name in ("J", "spacing", "ratio")])
        if self._here[0]:
            self._comm.Send(told, self._owners[1])
        else:
            self._comm.Recv(told, self._owners[0])
            self._face["J"], self._face["spacing"], self._face["ratio"] = told


def compile_entries(plan: Plan, announce: Callable[[str], None]) -> None:
    """Compile what is called here, or load it, without a call of it; announce: says what takes so long."""
    rows = [np.empty((int(plan.head["rows"][0]), columns)) for columns in COLUMNS]
    entries: tuple[tuple[Callable, tuple], ...] = (
        *((place_grids, ()), (move_grids, ())),
        *((apply_ends, (0,)), (evaluate_rates, (0,)), (couple_rows, (0, *rows))),
    )
    with compiling(plan.compiled(evaluate_rates), announce):
        for entry, arguments in entries:
            plan.compiled(entry).compile(tuple(numba.typeof(argument) for argument in (*plan, *arguments)))
