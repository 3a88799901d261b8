"""Interfaces in two dimensions: what this rank needs of their two sides is fetched here, and solved here.

Before the rates, the unknowns of gas and solid at points of interfaces (fsipetsc.coupling.plane, ``meet``). Where the gas
slips along the solid, after them the rates of both, too: the traction between the two makes their normal accelerations one
(``slide``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc

from fsipetsc.boundaries import plane as edges
from fsipetsc.coupling import INTERFACE
from fsipetsc.coupling.plane import COLUMNS, HELD, HELD_X, RATES
from fsipetsc.operators.rows import MARGIN
from fsipetsc.parallel.plane.layout import Meeting, PlaneLayout
from fsipetsc.physics.plane.layer import DOF, NOWHERE
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import materials_of
from fsipetsc.scheme.plane.laws import compiled
from fsipetsc.scheme.plane.sweep import scratch_stride

#: of what is known of a point, the kinetic energy of the solid
_KINETIC = 10
#: of some points out of several: numpy is faster with slices
Index = slice | np.ndarray


def together(chosen: np.ndarray) -> Index:
    """What is True, as a slice where that can be, else by numbers."""
    return as_slice(np.flatnonzero(chosen))


def as_slice(numbers: np.ndarray) -> Index:
    """Numbers that follow each other, as a slice; others as they are."""
    if numbers.size and np.all(np.diff(numbers) == 1) and numbers[0] >= 0:
        return slice(int(numbers[0]), int(numbers[-1]) + 1)
    return numbers


@dataclass(frozen=True)
class Piece:
    """A piece of interface ``number`` as layer k needs it, whose lower (0) or upper edge it is.

    columns: of the gas; local: the same among those that the rank holds of layer k; inside: those that are; own: those
    whose points at the interface the rank owns; at: where they stand among all points; held: HELD and the like.
    """

    number: int
    k: int
    side: int
    columns: np.ndarray
    local: np.ndarray
    inside: np.ndarray
    own: np.ndarray
    at: slice
    held: np.ndarray


class Line:
    """The edge of a gas at an interface, or a stretch of it, with its normals; for a piece where the gas slips."""

    def __init__(self, layout: PlaneLayout, piece: Piece, reach: int) -> None:
        meeting = layout.meetings[piece.number]
        grid, record = layout.grids[meeting.layers[0]], layout.records[piece.k]
        shift = 0 if piece.k == meeting.layers[0] else meeting.shift
        first = int(record["first_x"]) + shift - reach
        count = int(record["width"]) + 2 * reach
        if not grid.periodic:
            end = min(first + count, grid.nx)
            first = max(first, 0)
            count = end - first
        self._places = piece.local + (int(record["first_x"]) + shift - first)
        self._stride, self._count, self._h = scratch_stride(count), count, grid.h_x
        self._ends = (-NOWHERE, NOWHERE) if grid.periodic else (-first, grid.nx - 1 - first)
        self._s = np.zeros(8 * self._stride + 2 * MARGIN)
        self.normals = np.zeros((piece.columns.size, 4))

    def lay(self, operators: np.ndarray, points: np.ndarray) -> None:
        """Find N = Ja2 = (-y_xi, x_xi) and its rate at the points, from where they are and how the solid moves."""
        line = self._s, self._stride, self._count, *self._ends, self._h
        entries.line_normals(operators, *line, self._places, points, self.normals)


class Interfaces:
    """All pieces of a rank. state, rates: its parts of world vectors. Collective on the layout's communicator."""

    def __init__(self, layout: PlaneLayout, operators: np.ndarray, world: PETSc.Vec, rates: PETSc.Vec) -> None:
        self._layout, self._operators = layout, operators
        self.faces = np.zeros(len(layout.meetings), INTERFACE)
        self.slips = [layout.problem.slips(fluid) for fluid, _ in layout.problem.interfaces]
        self.pieces: list[Piece] = []
        for number, meeting in enumerate(layout.meetings):
            self._face(number)
            for k in meeting.layers:
                self._add(number, k, meeting)
        total = sum(piece.columns.size for piece in self.pieces)
        self._points = np.zeros((total, COLUMNS))
        everything = [self._unknowns(piece) for piece in self.pieces]
        fetched = [piece.own & self.slips[piece.number] for piece in self.pieces]
        wanted = [self._rates_of(piece, own) for piece, own in zip(self.pieces, fetched, strict=True)]
        self._sliding = np.zeros((sum(int(own.sum()) for own in fetched), RATES))
        self._fetched = [(together(own), int(own.sum())) for own in fetched]
        self._scatters = [_Scatter(world, everything, self._points)]
        if any(self.slips):
            self._scatters.append(_Scatter(rates, wanted, self._sliding))
        self._lines = [Line(layout, piece, self._reach) if self.slips[piece.number] else None for piece in self.pieces]
        self._inside: dict[int, list[tuple[Piece, Index, Index]]] = {k: [] for k in range(len(layout.grids))}
        for piece in self.pieces:
            inside = together(piece.inside)
            self._inside[piece.k].append((piece, inside, as_slice(piece.local[inside])))
        fluids = [layout.problem.layers[fluid] for fluid, _ in layout.problem.interfaces]
        entry = [entries.meet_sliding_at if slips else entries.meet_at for slips in self.slips]
        self._meet = [compiled(e, materials_of(fluid)) for e, fluid in zip(entry, fluids, strict=True)]

    @property
    def _reach(self) -> int:
        """Columns beyond those held that normals need."""
        return int(self._operators[0]["p"])

    def _face(self, number: int) -> None:
        layout, face = self._layout, self.faces[number]
        fluid, solid = layout.meetings[number].layers
        gas, elastic = layout.problem.layers[fluid].material, layout.problem.layers[solid].material
        face["h"], face["h_gas"], face["J"] = layout.grids[solid].h_y, layout.grids[fluid].h_y, 1.0
        for name in ("gamma", "R", "cv", "mu", "kappa", "gas_numbers", "transport_numbers"):
            face[name] = getattr(gas, name)
        for name in ("kappa_e", "m0", "alpha"):
            face[name] = getattr(elastic, name)

    def _add(self, number: int, k: int, meeting: Meeting) -> None:
        """Note the piece of an interface that this rank needs as a part of layer k, if there is one."""
        layout, gas, record = self._layout, k == meeting.layers[0], self._layout.records[k]
        row = meeting.rows[0 if gas else 1]
        if layout.dms[k] is None or not (gas or row in layout.held(k)[1]):
            return
        beyond = self._reach if self.slips[number] else 0
        local = np.arange(-beyond, int(record["width"]) + beyond)
        columns = local + int(record["first_x"]) + (0 if gas else meeting.shift)
        if layout.grids[k].periodic:
            columns %= layout.grids[meeting.layers[0]].nx
        here = (columns >= meeting.first) & (columns < meeting.end)
        columns, local = columns[here], local[here]
        if not columns.size:
            return
        owned = (local >= record["own_x"][0]) & (local < record["own_x"][1]) & (row in layout.owned(k)[1])
        inside = (local >= 0) & (local < record["width"])
        start = self.pieces[-1].at.stop if self.pieces else 0
        side = int(meeting.layers[1 if gas else 0] > k)
        at, held = slice(start, start + columns.size), self._holding(meeting, columns)
        self.pieces.append(Piece(number, k, side, columns, local, inside, owned, at, held))

    def _holding(self, meeting: Meeting, columns: np.ndarray) -> np.ndarray:
        """What holds the points in some columns of the gas: the ends of the solid, and walls of the gas."""
        held, last = np.zeros(columns.size, np.int64), self._layout.grids[meeting.layers[0]].nx - 1
        gas, solid = (self._layout.problem.layers[k] for k in meeting.layers)
        at = ((solid.left, meeting.first), (solid.right, meeting.end - 1), (gas.left, 0), (gas.right, last))
        for end, column in at:
            if end.kind == edges.ROLLER:
                held[(columns == column) & (held == 0)] = HELD_X
            elif end.kind in (edges.CLAMPED, edges.NO_SLIP):
                held[columns == column] = HELD
        return held

    def _unknowns(self, piece: Piece) -> np.ndarray:
        """(points, COLUMNS) numbers in the world vector."""
        layout, meeting, columns = self._layout, self._layout.meetings[piece.number], piece.columns
        gas = layout.index(meeting.layers[0], columns, meeting.rows[0])
        solid = layout.index(meeting.layers[1], columns - meeting.shift, meeting.rows[1])
        energies = layout.index_of_energies(piece.number, columns - meeting.shift)
        return np.concatenate([gas[:, None] + np.arange(DOF), solid[:, None] + np.arange(DOF), energies[:, None]], axis=1)

    def _rates_of(self, piece: Piece, chosen: np.ndarray) -> np.ndarray:
        """(points, RATES) numbers in the world vector: of J (rho, rho u, rho v) of the gas, of the velocity of the solid."""
        numbers = self._unknowns(piece)[chosen]
        return numbers[:, [1, 2, 3, 7, 8]]

    def meet(self) -> None:
        """Fetch the points, and solve for what gas and solid have together. Collective."""
        if not self.slips:
            return
        self._scatters[0].fetch()
        for piece, line in zip(self.pieces, self._lines, strict=True):
            points, meet = self._points[piece.at], self._meet[piece.number]
            if line is None:
                meet(self.faces, piece.number, points, piece.held)
            else:
                line.lay(self._operators, points)
                meet(self.faces, piece.number, points, piece.held, line.normals)

    def fetch(self) -> None:
        """Fetch the points of a completed step, which have met already. Collective."""
        if self.slips:
            self._scatters[0].fetch()

    def slide(self, parts: dict[int, Any]) -> None:
        """Fetch the rates where gases slip, and give both sides the traction between them; parts: k -> LayerPart.
        Collective.
        """
        if not any(self.slips):
            return
        self._scatters[1].fetch()
        at = 0
        for piece, line, (chosen, count) in zip(self.pieces, self._lines, self._fetched, strict=True):
            if count:
                fetched, points = self._sliding[at : at + count], self._points[piece.at][chosen]
                held, normals = piece.held[chosen], line.normals[chosen]
                entries.slide_at(self.faces, piece.number, self._operators, points, fetched, held, normals)
                parts[piece.k].load(piece.side, piece.local[chosen], fetched, held == HELD)
            at += count

    def of(self, k: int) -> list[tuple[int, np.ndarray, np.ndarray]]:
        """(lower or upper edge, points, their columns among those held) of layer k."""
        return [(p.side, self._points[p.at][inside], columns) for p, inside, columns in self._inside[k]]

    def known(self, piece: Piece) -> np.ndarray:
        """(points, COLUMNS), what is known of the points of a piece, after ``meet`` what they have together."""
        return self._points[piece.at]

    def lines(self) -> list[tuple[Piece, Line | None]]:
        """All pieces; of those where the gas slips the line, which ``meet`` lays."""
        return list(zip(self.pieces, self._lines, strict=True))

    def lay(self, line: Line, piece: Piece) -> None:
        """Lay another line for a piece, through its points as they are."""
        line.lay(self._operators, self._points[piece.at])

    def energies(self) -> list[tuple[int, np.ndarray]]:
        """(interface, kinetic energies of the end points of its solid that this rank owns)."""
        return [(p.number, self._points[p.at][p.own, _KINETIC]) for p in self._of_solids()]

    def heights(self) -> list[tuple[int, np.ndarray]]:
        """(interface, y of these points)."""
        layers = self._layout.problem.layers
        return [(p.number, layers[p.k].Y[p.side] + self._points[p.at][p.own, 6]) for p in self._of_solids()]

    def _of_solids(self) -> list[Piece]:
        meetings = self._layout.meetings
        return [p for p in self.pieces if p.k == meetings[p.number].layers[1] and p.own.any()]

    def destroy(self) -> None:
        """Destroy what PETSc has made for it."""
        for scatter in self._scatters:
            scatter.destroy()


class _Scatter:
    """Fetches some numbers of a world vector, those wanted on this rank, into an array. Collective."""

    def __init__(self, world: PETSc.Vec, wanted: list[np.ndarray], into: np.ndarray) -> None:
        indices = np.concatenate([np.empty(0, np.int64), *(numbers.ravel() for numbers in wanted)])
        self._world, self._vec = world, PETSc.Vec().createWithArray(into, comm=PETSc.COMM_SELF)
        self._from = PETSc.IS().createGeneral(indices.astype(PETSc.IntType), comm=world.comm)
        self._to = PETSc.IS().createStride(indices.size, 0, 1, comm=PETSc.COMM_SELF)
        self._scatter = PETSc.Scatter().create(world, self._from, self._vec, self._to)

    def fetch(self) -> None:
        self._scatter.scatter(self._world, self._vec)

    def destroy(self) -> None:
        for thing in (self._scatter, self._from, self._to, self._vec):
            thing.destroy()
