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

Interfaces come before halos, so that neighbours of an owner get rows that fulfil the conditions. The point arithmetic is the
same on any number of ranks, and nothing is added up over ranks: so are the results, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from petsc4py import PETSc

from fsipetsc.operators.cache import compiling
from fsipetsc.parallel.layout import Layout
from fsipetsc.physics.layer import DOF, FLUID
from fsipetsc.scheme.one_layer import apply_ends, couple_rows, evaluate_rates
from fsipetsc.scheme.plan import SUM, Plan


class PetscPath:
    """dy/dt of the world vector, which on each rank is the concatenation of its parts of the layers.

    All methods are collective on the layout's communicator.
    """

    def __init__(self, layout: Layout, plan: Plan) -> None:
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
            interface.project()
        for layer in self._layers:
            layer.fill_halos()
        for layer in self._layers:
            layer.learn_frame()
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
        self._frame = [layout.records[name][k : k + 1] for name in ("s", "x_interface")]
        self._told = np.empty(len(self._frame))
        self._comm = self._dm.comm.tompi4py()
        self._tells = layout.records[k]["kind"] == FLUID and self._comm.size > 1
        self._owner = self._comm.size - 1 if k == 0 else 0  # of the interface: a fluid is the first layer or the last

    def fill_halos(self) -> None:
        """The ghost exchange of the layer."""
        self._dm.globalToLocal(self._own, self._local)
        self._work[:] = self._with_halos

    def learn_frame(self) -> None:
        """The owner of a fluid's interface point has set the frame in its record; the others hear of it."""
        if self._tells:
            self._told[0], self._told[1] = self._frame[0][0], self._frame[1][0]
            self._comm.Bcast(self._told, self._owner)
            self._frame[0][0], self._frame[1][0] = self._told

    def apply_ends(self) -> None:
        """Ghost point and outer end, where this rank has the points that they take, in its halos perhaps."""
        self._plan.compiled(apply_ends)(*self._plan, self._k)

    def evaluate(self) -> None:
        """The rates at this rank's points."""
        self._plan.compiled(evaluate_rates)(*self._plan, self._k)
        self._rates[:] = self._evaluated

    def destroy(self) -> None:
        self._own.destroy()
        self._local.destroy()


class Interface:
    """Interface k between a fluid and a solid; ``state``: this rank's part of the world vector."""

    def __init__(self, layout: Layout, plan: Plan, k: int, state: np.ndarray) -> None:
        self._k, self._plan, self._comm = k, plan, layout.comm
        layers, count = layout.problem.interfaces[k], int(plan.head["rows"][0])
        self._rows = [np.empty((count, dof)) for dof in DOF]  # of fluid and solid, counted from the interface
        self._owners, self._own = [], []
        for layer in layers:
            left = layer == min(layers)  # of the interface; the rank with the last point there has all the rows, see partition
            self._owners.append(layout.shares[layer][-1 if left else 0][0])
            part = layout.local(layer, state)
            self._own.append((part[::-1] if left else part)[:count])
        self._here = [owner == self._comm.rank for owner in self._owners]
        self._frame = [layout.records[name][layers[0] : layers[0] + 1] for name in ("s", "x_interface")]

    def project(self) -> None:
        """Swap rows with the owner of the other side, project both sides, and keep what is this rank's."""
        if not any(self._here):
            return
        (fluid, solid), (s, x_interface) = self._rows, self._frame
        for here, rows, own in zip(self._here, self._rows, self._own, strict=True):
            if here:
                rows[:] = own
        if not all(self._here):
            mine, other = (0, 1) if self._here[0] else (1, 0)
            rank = self._owners[other]
            self._comm.Sendrecv(self._rows[mine], rank, recvbuf=self._rows[other], source=rank)
        x_interface[0] = solid[0, 3]  # of the solid's particle there
        self._plan.compiled(couple_rows)(*self._plan, self._k, fluid, solid)
        s[0] = fluid[0, 1] / fluid[0, 0]
        for here, rows, own in zip(self._here, self._rows, self._own, strict=True):
            if here:
                own[:] = rows


def compile_entries(plan: Plan, announce: Callable[[str], None]) -> None:
    """Compile what is called here, or load it, without a call of it; announce: says what takes so long."""
    rows = [np.empty((int(plan.head["rows"][0]), dof)) for dof in DOF]
    entries: tuple[tuple[Callable, tuple], ...] = ((apply_ends, (0,)), (evaluate_rates, (0,)), (couple_rows, (0, *rows)))
    with compiling(plan.compiled(evaluate_rates), announce):
        for entry, arguments in entries:
            plan.compiled(entry).compile(tuple(numba.typeof(argument) for argument in (*plan, *arguments)))
