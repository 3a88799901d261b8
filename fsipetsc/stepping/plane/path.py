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

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.sbp import OPERATOR, packed
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.dissipation import SOLID_SHARE
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import DOF, GAINED
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import USUAL, PlaneForm, equations_of, materials_of
from fsipetsc.scheme.plane.fields import SAVED
from fsipetsc.scheme.plane.laws import compiled
from fsipetsc.scheme.plane.look import WORDS
from fsipetsc.scheme.plane.sweep import ring_rows, scratch, scratch_stride
from fsipetsc.scheme.runge_kutta import Stage
from fsipetsc.stepping.plane.edge_data import EdgeData
from fsipetsc.stepping.plane.fused import AREAS, SUM, FusedSteps
from fsipetsc.stepping.plane.interfaces import Index, Interfaces
from fsipetsc.stepping.plane.natural import NaturalOrder

#: doubles by which areas begin further and further from the boundaries of pages
STAGGER = 136
#: doubles behind the points, into which vectors may reach
SLACK = 64
#: of a Runge-Kutta stage source, next, a, base, sum, b: where rates are wanted as they are
_NO_STAGE = np.empty(0), np.empty(0), 0.0, np.empty(0), np.empty(0), 0.0
#: rates, extremes and integrals, what is saved
_OF_GAS = entries.gas_rates, entries.gas_look, entries.save_gas
_OF_SOLID = entries.solid_rates, entries.solid_look, entries.save_solid


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
        mine = [k for k, dm in enumerate(layout.dms) if dm is not None]
        arrays = self.state, self.changes
        self.layers = [LayerPart(layout, k, operators(order), self._equations[k], arrays, edge_data) for k in mine]
        self._parts = {part.k: part for part in self.layers}
        self._fused: FusedSteps | None = None

    def rates(self, y: np.ndarray, f: np.ndarray, t: float) -> None:
        """f = dy/dt of this rank's part at time t [s]; y stays as it is."""
        self.apply_conditions(y, t)
        self.evaluate(t)
        f[:] = self.changes

    def evaluate(self, t: float) -> None:
        """The rates of the local parts as they are, to ``changes``, or to the stage that the parts have been told."""
        for part in self.layers:
            part.evaluate(t)
        self.interfaces.slide(self._parts)
        for part in self.layers:
            part.note_power()
            part.note_gains()

    def apply_conditions(self, y: np.ndarray, t: float) -> None:
        """Let the local parts of the layers hold this rank's part y and its halos, which fulfil all conditions."""
        self.bring(y)
        self.put_in_place(t)

    def load_completed(self, y: np.ndarray, t: float) -> None:
        """Let the local parts be what ``project`` has left of y: to meet once more would change a last bit."""
        self.state[:] = y
        self.interfaces.fetch()
        for part in self.layers:
            part.fill_halos()
        self.put_in_place(t)

    def bring(self, y: np.ndarray) -> None:
        """Let the local parts hold y and its halos, and solve for what gas and solid have together at interfaces."""
        self.state[:] = y
        self.interfaces.meet()
        for part in self.layers:
            part.fill_halos()

    def put_in_place(self, t: float) -> None:
        """What interfaces, walls and what is given make of the local parts; and the grids of gases."""
        for part in self.layers:
            self._join(part)
            part.hold(t)

    def _join(self, part: LayerPart) -> None:
        for side, points, columns in self.interfaces.of(part.k):
            part.join(side, points, columns)

    def step(self, y: np.ndarray, t: float, dt: float) -> None:
        """A fused step dt [s] from the completed solution y at t [s], whose data do not depend on time, to the local parts."""
        if self._fused is None:
            self._fused = FusedSteps(self)
        self._fused.step(y, t, dt)
        self._fused.bring()

    def project(self, y: np.ndarray, t: float, brought: bool = False) -> None:
        """Let this rank's part y fulfil all conditions, in place; what holds the points at edges counts as gained.

        brought: the local parts hold it already.
        """
        if not brought:
            self.bring(y)
        for part in self.layers:
            free = part.edges()
            self._join(part)
            met = part.edges()
            part.hold(t)
            held = part.edges()
            # gas and solid give each other momentum, and energy, where they meet
            here = held[0] - met[0], held[1] - free[1], held[2] - free[2], held[3] - met[3]
            self.layout.gains(part.k, y)[:] = self.layout.gains(part.k, self.state) + here
            self.layout.local(part.k, y)[:] = part.own
        for number, energies in self.interfaces.energies():
            self.layout.energies(number, y)[:] = energies

    @property
    def doubles(self) -> int:
        """Doubles of memory on this rank: areas and scratch of its layers, and the parts of world vectors, the solution too."""
        return 3 * self.state.size + sum(part.doubles for part in self.layers)

    def take_gains(self, y: np.ndarray) -> np.ndarray:
        """What each layer has gained on this rank since the last time, (layers, GAINED); y forgets it."""
        found = np.zeros((len(self.layout.grids), GAINED))
        for part in self.layers:
            gains = self.layout.gains(part.k, y)
            found[part.k] = gains
            gains[:] = 0.0
        return found

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
        records, ops, values, lines = self.layout.records, operators(2), np.empty(1), np.empty((2, 4, 1))
        common, found = (records, 0, ops, values, 1), []
        for layer, equations in zip(self.layout.problem.layers, self._equations, strict=True):
            gas = layer.kind == "fluid"
            work = _OF_GAS if gas else _OF_SOLID
            arguments = [(*common, values, values, *_NO_STAGE), (*common, values, values)]
            arguments.append((*common, values, values, np.empty((1, 1, 1))))
            if gas:
                points = self.interfaces.faces, 0, np.empty((1, 1)), np.empty(1, np.int64)
                work = (*work, entries.meet_at, entries.meet_sliding_at)
                arguments += [points, (*points, np.empty((1, 1)))]
            laws = [equations] + [materials_of(layer)] * (len(work) - 1)
            found += [(compiled(entry, law), given) for entry, law, given in zip(work, laws, arguments, strict=True)]
        grid, faces = np.empty((1, 1)), self.interfaces.faces
        own = [
            (entries.lay_lines, (*common, lines)),
            (entries.advance_ends, (records, 0, values, *_NO_STAGE)),
            (entries.grid_jacobian, (records, 0, values, 1, grid)),
            (entries.edges_of, (records, 0, ops, values, values)),
            (entries.pull_on, (records, 0, ops, values, values)),
            (entries.line_normals, (ops, values, 1, 1, 1, 1, 1.0, np.empty(1, np.int64), grid, grid)),
            (entries.slide_at, (faces, 0, ops, grid, grid, np.empty(1, np.int64), grid)),
        ]
        return found + own

    def destroy(self) -> None:
        """Destroy messages and vectors; before the DMDAs."""
        if self._fused is not None:
            self._fused.free()
        self.interfaces.destroy()
        for part in self.layers:
            part.destroy()
        self._world.destroy()
        self._rates.destroy()


class LayerPart:
    """This rank's part of layer k; arrays: the rank's parts of world vectors, state and rates."""

    def __init__(
        self, layout: PlaneLayout, k: int, ops: np.ndarray, equations: Formulas, arrays: tuple, edge_data: EdgeData
    ) -> None:
        state, rates = arrays
        self.k, self._layout, self._ops, self.data = k, layout, ops, edge_data
        self.record, self._records, self._dm = layout.records[k], layout.records, layout.dms[k]
        self._gas = self.record["kind"] == FLUID
        self.operator, self.end_weight = ops[0], float(ops[0]["norm"][0])
        self.columns, self.rows = layout.owned(k)
        width = int(self.record["width"])
        self._stride = scratch_stride(width)
        self.record["ring"] = ring_rows(ops[0], self.record)
        self._s = scratch(self._stride, int(self.record["own_x"][0]), int(self.record["ring"]))
        self._make_areas()
        self._vec = PETSc.Vec().createWithArray(layout.local(k, state).reshape(-1), bsize=DOF, comm=self._dm.comm)
        self._local = PETSc.Vec().createWithArray(self.held.reshape(-1), bsize=DOF, comm=PETSc.COMM_SELF)
        self._rates = layout.local(k, rates).reshape(-1)
        self._gains, self._gained, self._sums = layout.gains(k, rates), self.record["gained"], np.zeros(GAINED)
        self._pulled = bool(self.record["force"].any())
        self._lines = np.zeros((2, 4, width))
        layer = layout.problem.layers[k]
        self._lines[:, 1] = np.array(layer.Y)[:, None]
        evaluate, *others = _OF_GAS if self._gas else _OF_SOLID
        self._evaluate = compiled(evaluate, equations)
        self._stage = _NO_STAGE
        self._look, self._save = (compiled(entry, materials_of(layer)) for entry in others)
        self.order = NaturalOrder(self._dm)
        columns, rows = layout.held(k)
        grid = layout.grids[k]
        self._XY = np.concatenate([grid.x0 + columns * grid.h_x, grid.y0 + rows * grid.h_y])
        self.words = np.zeros(WORDS)
        # rows of the edges, among those that are held and those that are owned, and rates there
        self._edges = self.record["end_y"].tolist(), (self.record["end_y"] - self.record["own_y"][0]).tolist()
        self._first, of_rows = int(self.record["own_x"][0]), self._rates.reshape(self.own.shape)
        self._edge_rates = [of_rows[row] if 0 <= row < len(of_rows) else None for row in self._edges[1]]
        self._Y, self._m0 = layer.Y, float(self.record["m0"])
        self._kinetic = [
            (layout.energies(number, rates), side) for number, side in self.sides() if layout.energies(number, rates).size
        ]

    def sides(self) -> list[tuple[int, int]]:
        """(interface, lower or upper edge) where this layer is the solid."""
        found = [(n, meeting.layers) for n, meeting in enumerate(self._layout.meetings)]
        return [(n, int(fluid > self.k)) for n, (fluid, solid) in found if solid == self.k]

    def _make_areas(self) -> None:
        """The areas for the points that are held, of which the first one is in use then."""
        height, width = int(self.record["height"]), int(self.record["width"])
        count, apart = width * height * DOF, width * height * DOF + SLACK * DOF + STAGGER
        apart += -apart % 512 + STAGGER  # equal points of two areas must not evict each other from caches
        # one piece, for which the system may have larger pages
        self._memory = np.zeros(AREAS * apart)
        self._ys = [self._memory[n * apart : (n + 1) * apart] for n in range(AREAS)]
        self.areas = [y[:count].reshape(height, width, DOF) for y in self._ys]
        rows, columns = slice(*self.record["own_y"]), slice(*self.record["own_x"])
        self._views = [(y, held, held[rows, columns]) for y, held in zip(self._ys, self.areas, strict=True)]
        self.use(0)

    @property
    def doubles(self) -> int:
        """Doubles of memory."""
        return self._s.size + self._memory.size

    def use(self, area: int) -> None:
        """Let ``y``, ``held`` and ``own`` be an area: all points in a row, (height, width, DOF) of it, those that are owned."""
        self.y, self.held, self.own = self._views[area]

    def interface_rows(self) -> list[int]:
        """Among the rows that are owned, those at interfaces."""
        ends, kinds = self.record["end_y"] - self.record["own_y"][0], self.record["edge_y"]
        return [int(row) for row, kind in zip(ends, kinds, strict=True) if kind == INTERFACE_END and 0 <= row < len(self.own)]

    def begin_stage(self, stage: Stage, a: float, b: float) -> None:
        """Let the next evaluation of the rates k send them on: next = source + a k, SUM = base + b k."""
        ys, sums = self._ys, (self._ys[stage.base], self._ys[SUM]) if stage.base >= 0 else _NO_STAGE[3:5]
        self._stage = ys[stage.source], ys[stage.next], a, *sums, b

    def end_stage(self) -> None:
        """Send on the rates at interfaces, too; then rates are wanted as they are again."""
        entries.advance_ends(self._records, self.k, self._rates, *self._stage)
        self._stage = _NO_STAGE

    def fill_halos(self) -> None:
        """The ghost exchange of the layer, to the first area."""
        self.use(0)
        self._dm.globalToLocal(self._vec, self._local)

    def join(self, side: int, points: np.ndarray, columns: np.ndarray) -> None:
        """Put what gas and solid have together at an interface in its place."""
        row = self._edges[0][side]
        if 0 <= row < len(self.held):
            self.held[row, columns, 2:5] = points[:, 2:5] if self._gas else points[:, 7:10]
        if self._gas:
            lines = self._lines[side]
            lines[0, columns], lines[2, columns], lines[3, columns] = points[:, 5], points[:, 7], points[:, 8]
            lines[1, columns] = self._Y[side] + points[:, 6]

    def hold(self, t: float) -> None:
        """Walls and edges where unknowns are given; then the lines of the grid."""
        self.data.apply(self, t)
        if self._gas:
            entries.lay_lines(self._records, self.k, self._ops, self._s, self._stride, self._lines)

    def evaluate(self, t: float) -> None:
        """The rates at this rank's points."""
        self._gained[:] = 0.0
        self._evaluate(self._records, self.k, self._ops, self._s, self._stride, self.y, self._rates, *self._stage)
        self.data.force(self, t, self._rates)
        self.data.push(self, self._rates)

    def line(self, side: int) -> np.ndarray:
        """(4, width), the lower or upper line of a gas's grid: displacement in x, y, velocity, of the columns held."""
        return self._lines[side]

    def evaluate_block(self, records: np.ndarray, y: np.ndarray, f: np.ndarray) -> None:
        """The rates, without forcing, of a block of what is held: the owned points of records[0], a record like this part's."""
        self._evaluate(records, 0, self._ops, self._s, self._stride, y, f, *_NO_STAGE)

    def edges(self) -> np.ndarray:
        """What the points at the edges have of mass, momentum and energy now, (GAINED,)."""
        entries.edges_of(self._records, self.k, self._ops, self.y, self._sums)
        return self._sums.copy()

    def load(self, side: int, columns: np.ndarray, traction: np.ndarray, clamped: np.ndarray) -> None:
        """Add to the rates at an edge what a traction does: to those of J (rho, rho u, rho v, e), or to those of the
        velocity. What a gas gets where the solid is clamped comes from outside.
        """
        first = int(columns[0]) - self._first  # numpy is faster with a slice, which they mostly are
        together = columns[-1] - columns[0] + 1 == columns.size
        at: Index = slice(first, first + columns.size) if together else columns - self._first
        if self._gas:
            self._edge_rates[side][at, 2:5] += traction[:, :3]
        else:
            self._edge_rates[side][at, 2:4] += traction[:, 3:5]

        if self._gas and clamped.any():
            self.gain(columns[clamped], traction[clamped, 0], traction[clamped, 1])

    def gain(self, columns: np.ndarray, x: np.ndarray, y: np.ndarray, power: np.ndarray | float = 0.0) -> None:
        """Count what has been added to the rates of momentum and energy in some columns held of the lower or upper edge."""
        from_end, norm = np.abs(columns[:, None] - self.record["end_x"]).min(axis=1), self._ops[0]["norm"]
        along = np.where(from_end < self._ops[0]["rows"], norm[np.minimum(from_end, norm.size - 1)], 1.0)
        weights = along * (self.end_weight * self.record["h_x"] * self.record["h_y"])
        self._gained[1:] += (weights * x).sum(), (weights * y).sum(), (weights * power).sum()

    def note_gains(self) -> None:
        """Rates of what comes in through the edges, and by the body force."""
        self._gains[:] = self._gained
        if self._pulled:
            entries.pull_on(self._records, self.k, self._ops, self.y, self._sums)
            self._gains[:] += self._sums

    def note_power(self) -> None:
        """Rates of the kinetic energies of end points of a solid."""
        for rates, side in self._kinetic:
            f, own = self._edge_rates[side], self.own[self._edges[1][side]]
            rates[:] = self._m0 * (own[:, 2] * f[:, 2] + own[:, 3] * f[:, 3])

    def look(self) -> np.ndarray:
        """Words of fsipetsc.scheme.plane.look, of the local part as it is."""
        self._look(self._records, self.k, self._ops, self._s, self._stride, self.y, self.words)
        return self.words

    def save(self) -> np.ndarray:
        """What is saved of the points that this rank owns, (rows, columns, SAVED), of the local part as it is."""
        out = np.empty((*self.own.shape[:2], SAVED))
        self._save(self._records, self.k, self._ops, self._s, self._stride, self.y, self._XY, out)
        return out

    def stretch(self, q: np.ndarray) -> None:
        """Let the unknowns of a gas, given without J, be those with the J of the grid whose lines have been laid."""
        if self._gas:
            J = np.empty(q.shape[:2])
            entries.grid_jacobian(self._records, self.k, self._s, self._stride, J)
            q *= J[..., None]

    def destroy(self) -> None:
        self.order.destroy()
        self._vec.destroy()
        self._local.destroy()
