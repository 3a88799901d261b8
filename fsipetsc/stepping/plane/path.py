"""The right-hand side in two dimensions by PETSc's own means: the parallel method, to be read from top to bottom.

One evaluation is three steps; the first is collective on all ranks that have part in an interface, the second on the ranks
of a layer:

    1  interfaces   one VecScatter fetches, for each rank that needs them, the unknowns of gas and solid at the points of
    interfaces:
                    each of these solves the same small system point by point          (fsipetsc.coupling.plane)
    2  halos        DMDA fills the local vectors: twice the reach of D, because D acts twice
    3  points       interface rows, walls and what is given are put in place; the grids of gases are laid between the lines that
                    their edges have become; then the rates of all points              (fsipetsc.scheme.plane.sweep)

The ranks of a gas that have no part of its edge need the lines, too: they fetch them in step 1 themselves, so that nothing
has to be told along the columns. The arithmetic of a point is the same on any number of ranks, and nothing is added up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from petsc4py import PETSc

from fsipetsc.operators.prepared import Prepared
from fsipetsc.operators.sbp import OPERATOR, packed
from fsipetsc.parallel.plane.areas import Areas
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.dissipation import SOLID_SHARE
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import GAINED
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import USUAL, PlaneForm, equations_of
from fsipetsc.scheme.plane.fields import SAVED
from fsipetsc.scheme.plane.look import WORDS
from fsipetsc.scheme.plane.sweep import ring_rows, scratch
from fsipetsc.stepping.plane.compiled import needed
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.fused import FusedSteps
from fsipetsc.stepping.plane.interfaces import Interfaces
from fsipetsc.stepping.plane.part import LayerPart


def operators(order: int) -> np.ndarray:
    """(2,) OPERATOR: as it is, and loose at its ends: without the boundary flux, h a_0 D_00 = 1/2."""
    both = np.array([packed(order)] * 2, OPERATOR)
    both[1]["closure"][0, 0] += 1.0 / both[1]["norm"][0]
    both[1]["columns"][0, 0] = both[1]["closure"][0, 0]
    return both


class PlanePath:
    """dy/dt of the world vector. All methods are collective on the layout's communicator. InputError as of ``equations_of``."""

    def __init__(self, layout: PlaneLayout, order: int, edge_data: EdgeData, form: PlaneForm = USUAL) -> None:
        self.layout = layout
        self._equations = [equations_of(layer, form) for layer in layout.problem.layers]
        layout.records["dissipation"] = form.dissipation / 2.0**order
        layout.records["shocks"] = np.where(layout.records["kind"] == FLUID, 0.5, SOLID_SHARE) * form.shocks
        self.state, self.changes = np.zeros(layout.local_size), np.zeros(layout.local_size)
        self._world, self._rates = (PETSc.Vec().createWithArray(own, comm=layout.comm) for own in (self.state, self.changes))
        self.interfaces = Interfaces(layout, operators(order), self._world, self._rates)
        self.areas = Areas(layout)
        shocks = [int(hasattr(equations, "dissipation")) for equations in self._equations]
        layout.records["ring"] = [
            1 if dm is None else ring_rows(operators(order)[0], record, behind)
            for dm, record, behind in zip(layout.dms, layout.records, shocks, strict=True)
        ]
        self._scratch = scratch(int(layout.records["ring"].max()))  # of one layer after the other: caches know it already
        common, vectors = (self._scratch, self.areas, self.interfaces), (self.state, self.changes)
        sums, self.words = np.zeros((len(layout.grids), 3, GAINED)), np.zeros((len(layout.grids), WORDS))
        self.layers = [
            LayerPart(layout, k, operators(order), self._equations[k], *common, vectors, edge_data, (sums[k], self.words[k]))
            for k, dm in enumerate(layout.dms)
            if dm is not None
        ]
        #: where what layers gain stands in this rank's part of the solution
        self.gains = np.array([layout.gains_begin(k) for k in range(len(layout.grids))])
        points = layout.records, self.areas.memory, np.array(self.areas.begin), layout.starts
        others = layout.records, self.gains, sums, self.interfaces.points, self.interfaces.ends(), self.state
        self._put_points = Prepared(entries.put_away_points, *points)
        self._put_others = Prepared(entries.put_away_others, *others)
        self._conducts = any(layer.kind == "solid" and layer.material.kappa_e > 0.0 for layer in layout.problem.layers)
        self._fused: FusedSteps | None = None

    def rates(self, y: np.ndarray, f: np.ndarray, t: float) -> None:
        """f = dy/dt of this rank's part at time t [s]; y stays as it is."""
        self.apply_conditions(y, t)
        self.evaluate(t)
        f[:] = self.changes

    def evaluate(self, t: float) -> None:
        """The rates of the local parts as they are, to ``changes``."""
        for part in self.layers:
            part.evaluate(t)
        self.interfaces.slide()
        for part in self.layers:
            part.end()

    def apply_conditions(self, y: np.ndarray, t: float) -> None:
        """Let the local parts of the layers hold this rank's part y and its halos, which fulfil all conditions."""
        self.bring(y)
        self.put_in_place(t)

    def load_completed(self, y: np.ndarray, t: float) -> None:
        """Let the local parts be what ``project`` has left of y: to meet once more would change a last bit. And look, as fused
        steps need it.
        """
        self.state[:] = y
        self.interfaces.fetch()
        for part in self.layers:
            part.fill_halos()
        self.put_in_place(t)
        self.look()

    def look(self, mend: bool = False) -> None:
        """At the completed local parts, see ``LayerPart.look``; mend: after a fused step."""
        for part in self.layers:
            part.look(mend)
        if mend and self._conducts:
            self._fused.share()

    def bring(self, y: np.ndarray) -> None:
        """Let the local parts hold y and its halos, and solve for what gas and solid have together at interfaces."""
        self.state[:] = y
        self.interfaces.meet()
        for part in self.layers:
            part.fill_halos()

    def put_in_place(self, t: float) -> None:
        """What interfaces, walls and what is given make of the local parts; and the grids of gases."""
        for part in self.layers:
            part.settle(t)

    def step(self, y: np.ndarray, dt: float) -> None:
        """A fused step dt [s] of the local parts, whose data do not depend on time, from a completed solution to a raw one.

        y: this rank's part of the solution; only what stands behind the points is read.
        """
        if self._fused is None:
            self._fused = FusedSteps(self)
        self._fused.step(y, dt)

    def project(self, y: np.ndarray, t: float) -> None:
        """Let this rank's part y fulfil all conditions, in place; what holds the points at edges counts as gained."""
        self.bring(y)
        self.complete(y, t)
        self.put_points(y)

    def complete(self, y: np.ndarray, t: float) -> None:
        """The same for the local parts, which hold y already; of y only what stands behind the points of the layers."""
        for part in self.layers:
            part.complete(t)
        self._put_others(y)

    def put_points(self, y: np.ndarray) -> None:
        """Let the points of y be those of the local parts."""
        self._put_points(y)

    @property
    def doubles(self) -> int:
        """Doubles of memory on this rank: areas and scratch of its layers, and the parts of world vectors, the solution too."""
        return 3 * self.state.size + self.areas.memory.size + self._scratch.size + sum(part.doubles for part in self.layers)

    def part(self, k: int) -> LayerPart | None:
        """This rank's part of layer k, if it has one."""
        return next((part for part in self.layers if part.k == k), None)

    def saved_numbers(self) -> list[np.ndarray]:
        """Numbers of the points of each layer that ``saved`` has on this rank, row by row of the whole layer."""
        parts = [self.part(k) for k in range(len(self.layout.grids))]
        return [np.empty(0) if part is None else part.order.numbers.astype(float) for part in parts]

    def saved(self) -> list[np.ndarray]:
        """What is saved of these points, (points, SAVED), layer by layer; the local parts must be up to date."""
        parts = [self.part(k) for k in range(len(self.layout.grids))]
        return [np.empty((0, SAVED)) if part is None else part.order.reorder(part.save()) for part in parts]

    def entries(self) -> list[tuple[Any, tuple[Any, ...]]]:
        """Compiled functions of all layers, with arguments of the types that they get."""
        return needed(self.layout, self._equations, self.interfaces.faces, operators(2))

    def destroy(self) -> None:
        """Destroy messages and vectors; before the DMDAs."""
        if self._fused is not None:
            self._fused.free()
        self.interfaces.destroy()
        for part in self.layers:
            part.destroy()
        self._world.destroy()
        self._rates.destroy()
