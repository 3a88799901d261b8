"""A rank's part of one layer in two dimensions: its points, and what is done to them in a stage."""

from __future__ import annotations

from typing import Any

import numpy as np
from petsc4py import PETSc

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.prepared import Prepared
from fsipetsc.parallel.plane.areas import SUM, WORK, Areas
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import DOF, GAINED
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import materials_of
from fsipetsc.scheme.plane.fields import SAVED
from fsipetsc.scheme.plane.kinetic import kept_size
from fsipetsc.scheme.plane.laws import compiled
from fsipetsc.scheme.runge_kutta import Stage
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.interfaces import Interfaces
from fsipetsc.stepping.plane.natural import NaturalOrder

#: of a Runge-Kutta stage source, next, base, sum, all stages, what is kept; a, b: where rates are wanted as they are
NO_STAGE = (*(np.empty(0) for _ in range(4)), (np.empty(0), np.empty(0), np.empty(0)), np.empty(0))
NO_FACTORS = 0.0, 0.0
#: rates, extremes and integrals, what is saved
OF_GAS = entries.gas_rates, entries.gas_look, entries.save_gas
OF_SOLID = entries.solid_rates, entries.solid_look, entries.save_solid


class LayerPart:
    """This rank's part of layer k. scratch: room for rows during a call. vectors: the rank's parts of world vectors, solution
    and rates; notes: (3, GAINED) for what points at edges have, (WORDS,) for extremes and integrals.

    y, held, own: the points of the first area, the one that the solution is in after a step: all in a row, (height, width, DOF)
    of it, those that are owned.
    """

    def __init__(
        self,
        layout: PlaneLayout,
        k: int,
        operators: np.ndarray,
        equations: Formulas,
        scratch: np.ndarray,
        areas: Areas,
        interfaces: Interfaces,
        vectors: tuple[np.ndarray, np.ndarray],
        edge_data: EdgeData,
        notes: tuple[np.ndarray, np.ndarray],
    ) -> None:
        state, changes = vectors
        self._sums, self.words = notes
        self.k, self._layout, self._ops, self.data, self._areas = k, layout, operators, edge_data, areas
        self.record, self._records, self._dm = layout.records[k], layout.records, layout.dms[k]
        self._gas, layer, grid = self.record["kind"] == FLUID, layout.problem.layers[k], layout.grids[k]
        self.operator, self.end_weight = operators[0], float(operators[0]["norm"][0])
        self.columns, self.rows = layout.owned(k)
        width = int(self.record["width"])
        self.y, self.held = areas.unknowns(k), areas.points(k)
        self.own = self.held[slice(*self.record["own_y"]), slice(*self.record["own_x"])]
        self._vec = PETSc.Vec().createWithArray(layout.local(k, state).reshape(-1), bsize=DOF, comm=self._dm.comm)
        self._local = PETSc.Vec().createWithArray(self.held.reshape(-1), bsize=DOF, comm=PETSc.COMM_SELF)
        self._rates = layout.local(k, changes).reshape(-1)
        self._gained = self.record["gained"]
        self._lines = np.zeros((2, 4, width))
        self._lines[:, 1] = np.array(layer.Y)[:, None]
        evaluate, *others = OF_GAS if self._gas else OF_SOLID
        self._evaluate = compiled(evaluate, equations)
        law = materials_of(layer)
        look, self._save, self._settle_entry = (compiled(entry, law) for entry in (*others, entries.settle))
        self.order = NaturalOrder(self._dm)
        columns, rows = layout.held(k)
        self._XY = np.concatenate([grid.x0 + columns * grid.h_x, grid.y0 + rows * grid.h_y])
        self._common = self._records, k, operators, scratch
        self._joined = interfaces.points, interfaces.joined(k)
        rooms = np.zeros(GAINED), changes, layout.gains_begin(k)
        self._ending = interfaces.tractions, interfaces.loaded(k), self._kinetic(), *rooms
        self._settle, self._settle_noting = self.settling(WORK), self.settling(WORK, self._sums)
        self._to_rates = Prepared(self._evaluate, *self._common, self.y, self._lines, self._rates, *NO_STAGE, *NO_FACTORS)
        self._kept = np.zeros(0 if self._gas else kept_size(self.rows.size, self.columns.size))
        self._look = Prepared(look, *self._common, self.y, self._lines, self.words, self._kept)
        self._end = self._ending_of(self.y, *NO_STAGE)

    def sides(self) -> list[tuple[int, int]]:
        """(interface, lower or upper edge) where this layer is the solid."""
        found = [(n, meeting.layers) for n, meeting in enumerate(self._layout.meetings)]
        return [(n, int(fluid > self.k)) for n, (fluid, solid) in found if solid == self.k]

    def _kinetic(self) -> np.ndarray:
        """(n, 3), of end points of a solid at interfaces where the rate of their kinetic energy stands, column, edge."""
        found, first = [np.empty((0, 3), np.int64)], int(self.record["own_x"][0])
        for number, side in self.sides():
            places = np.arange(self._layout.local_size)
            at = self._layout.energies(number, places)
            found.append(np.stack([at, first + np.arange(at.size), np.full(at.size, side)], axis=1))
        return np.concatenate(found)

    def settling(self, area: int, sums: np.ndarray | None = None) -> Prepared:
        """The call that puts what interfaces and edges have in its place in an area; sums: what is noted of edges. ``settle``
        does so where data depend on time.
        """
        sums = np.empty((0, GAINED)) if sums is None else sums
        y, heights = self._areas.unknowns(self.k, area), np.array(self._layout.problem.layers[self.k].Y)
        arguments = *self._joined, self._lines, heights, *self.data.held[self.k], sums
        return Prepared(self._settle_entry, *self._common[:3], y, *arguments)

    def _ending_of(self, y: np.ndarray, *stage: Any) -> Prepared:
        """The call that is due when rates of the points y are there."""
        return Prepared(entries.end_stage, *self._common[:3], y, self._rates, *self._ending, *stage)

    def in_stage(self, stage: Stage) -> tuple[Prepared, Prepared]:
        """The calls that make the rates k of a stage, next = source + a k, at edges SUM = base + b k, and end it, by a, b."""
        y, source, onward = (self._areas.unknowns(self.k, area) for area in (stage.area, stage.source, stage.next))
        both, stages = NO_STAGE[2:4], NO_STAGE[4]
        if stage.base >= 0:
            both = tuple(self._areas.unknowns(self.k, area) for area in (stage.base, SUM))
        else:
            stages = tuple(self._areas.unknowns(self.k, area) for area in range(WORK + 1, SUM))
        arrays = source, onward, *both, stages, self._kept
        rates = Prepared(self._evaluate, *self._common, y, self._lines, self._rates, *arrays)
        return rates, self._ending_of(y, *arrays)

    def fill_halos(self) -> None:
        """The ghost exchange of the layer, to the first area."""
        self._dm.globalToLocal(self._vec, self._local)

    def settle(self, t: float) -> None:
        """Let interfaces, walls and what is given at time t [s] have the points as they want them, and the lines of grids."""
        self._settle_by(self._settle, t)

    def complete(self, t: float) -> None:
        """``settle``, and note what the points at edges have before, between and after what interfaces and edges do."""
        self._settle_by(self._settle_noting, t)
        if self.data.moves(self.k):
            entries.edges_of(self._records, self.k, self._ops, self.y, self._sums[2])

    def _settle_by(self, settle: Prepared, t: float) -> None:
        self.data.refresh(self.k, t)
        settle()
        self.data.lay(self, t)

    def evaluate(self, t: float) -> None:
        """The rates at this rank's points."""
        self._to_rates()
        self.data.force(self, t, self._rates)
        self.data.push(self, self._rates)

    def end(self) -> None:
        """What is left to do for rates when interfaces have been looked at."""
        self._end(*NO_FACTORS)

    def line(self, side: int) -> np.ndarray:
        """(4, width), the lower or upper line of a gas's grid: displacement in x, y, velocity, of the columns held."""
        return self._lines[side]

    def evaluate_block(self, records: np.ndarray, y: np.ndarray, f: np.ndarray) -> None:
        """The rates, without forcing, of a block of what is held: the owned points of records[0], a record like this part's."""
        self._evaluate(records, 0, *self._common[2:], y, self._lines, f, *NO_STAGE, *NO_FACTORS)

    def gain(self, columns: np.ndarray, x: np.ndarray, y: np.ndarray, power: np.ndarray) -> None:
        """Count what has been added to the rates of momentum and energy in some columns held of the lower or upper edge."""
        from_end, norm = np.abs(columns[:, None] - self.record["end_x"]).min(axis=1), self.operator["norm"]
        along = np.where(from_end < self.operator["rows"], norm[np.minimum(from_end, norm.size - 1)], 1.0)
        weights = along * (self.end_weight * self.record["h_x"] * self.record["h_y"])
        self._gained[1:] += (weights * x).sum(), (weights * y).sum(), (weights * power).sum()

    def look(self, mend: bool = False) -> np.ndarray:
        """Words of fsipetsc.scheme.plane.look, of the local part as it is; mend: the temperature of a solid makes up for what
        a fused step, the last one after another look, has not kept of its energy.
        """
        self._look(mend)
        return self.words

    def save(self) -> np.ndarray:
        """What is saved of the points that this rank owns, (rows, columns, SAVED), of the local part as it is."""
        out = np.empty((*self.own.shape[:2], SAVED))
        self._save(*self._common, self.y, self._lines, self._XY, out)
        return out

    def stretch(self, q: np.ndarray) -> None:
        """Let the unknowns of a gas, given without J, be those with the J of the grid whose lines have been laid."""
        if self._gas:
            J = np.empty(q.shape[:2])
            entries.grid_jacobian(*self._common, self._lines, J)
            q *= J[..., None]

    @property
    def doubles(self) -> int:
        """Doubles of memory that nothing else counts."""
        return self._kept.size

    def destroy(self) -> None:
        self.order.destroy()
        self._vec.destroy()
        self._local.destroy()
