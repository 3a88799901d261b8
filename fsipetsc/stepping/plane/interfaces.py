"""Interfaces in two dimensions: what this rank needs of their two sides is fetched here, and solved here.

Before the rates, the unknowns of gas and solid at points of interfaces (fsipetsc.coupling.plane, ``meet``). Where the gas
slips along the solid, after them the rates of both, too: the traction between the two makes their normal accelerations one
(``slide``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from fsipetsc.boundaries import plane as edges
from fsipetsc.coupling import INTERFACE
from fsipetsc.coupling.plane import COLUMNS, HELD, HELD_X, RATES
from fsipetsc.operators.prepared import Prepared
from fsipetsc.operators.rows import MARGIN
from fsipetsc.parallel.plane.layout import Meeting, PlaneLayout
from fsipetsc.physics.plane.layer import DOF, NOWHERE
from fsipetsc.scheme.plane import entries
from fsipetsc.scheme.plane.equations import materials_of
from fsipetsc.scheme.plane.laws import compiled


@dataclass(frozen=True)
class Piece:
    """A piece of interface ``number`` as layer k needs it, whose lower (0) or upper edge it is.

    columns: of the gas; local: the same among those that the rank holds of layer k; inside: those that are; own: those
    whose points at the interface the rank owns; at: where they stand among all points, where both layers need the same columns
    they are the same; held: HELD and the like.
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

    def __init__(self, layout: PlaneLayout, piece: Piece, reach: int, normals: np.ndarray | None = None) -> None:
        meeting = layout.meetings[piece.number]
        grid, record = layout.grids[meeting.layers[0]], layout.records[piece.k]
        shift = 0 if piece.k == meeting.layers[0] else meeting.shift
        first = int(record["first_x"]) + shift - reach
        count = int(record["width"]) + 2 * reach
        if not grid.periodic:
            end = min(first + count, grid.nx)
            first = max(first, 0)
            count = end - first
        places = piece.local + (int(record["first_x"]) + shift - first)
        stride = count + 2 * MARGIN
        ends = (-NOWHERE, NOWHERE) if grid.periodic else (-first, grid.nx - 1 - first)
        self.normals = np.zeros((piece.columns.size, 4)) if normals is None else normals
        #: what compiled functions get of it: normals, scratch, how it lies there, places of the points on it
        self.arguments = self.normals, np.zeros(8 * stride + 2 * MARGIN), stride, count, *ends, grid.h_x, places

    def lay(self, operators: np.ndarray, points: np.ndarray) -> None:
        """Find N = Ja2 = (-y_xi, x_xi) and its rate at the points, from where they are and how the solid moves."""
        entries.line_normals(operators, points, *self.arguments)


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
        first = {piece.at.start: piece for piece in reversed(self.pieces)}
        self._distinct = [piece for piece in self.pieces if first[piece.at.start] is piece]
        total = max((piece.at.stop for piece in self.pieces), default=0)
        self.points, self._normals = np.zeros((total, COLUMNS)), np.zeros((total, 4))
        self._held, self._numbers = np.zeros(total, np.int64), np.zeros(total, np.int64)
        #: numbers in the world vector of all that is known of the points, and of the rates where gases slip
        self.wanted = np.zeros((total, COLUMNS), np.int64)
        for piece in self._distinct:
            self._held[piece.at], self._numbers[piece.at] = piece.held, piece.number
            self.wanted[piece.at] = self._unknowns(piece)
        sliding = [self._own(piece) for piece in self.pieces if self.slips[piece.number]]
        self._sliding = np.unique(np.concatenate([np.empty(0, np.int64), *sliding]))
        self.wanted_rates = self.wanted[self._sliding][:, [1, 2, 3, 7, 8]]
        self.tractions = np.zeros((self._sliding.size, RATES))
        self._scatters = [_Scatter(world, self.wanted, self.points)]
        if any(self.slips):
            self._scatters.append(_Scatter(rates, self.wanted_rates, self.tractions))
        slipping = [piece for piece in self._distinct if self.slips[piece.number]]
        self._lines = {p.at.start: Line(layout, p, self._reach, self._normals[p.at]) for p in slipping}
        self.meetings = [self._meeting(piece) for piece in self._distinct]
        of_sliding = np.stack([self._numbers[self._sliding], self._sliding], axis=1)
        arrays = self.faces, of_sliding, operators, self.points, self.tractions, self._held, self._normals
        self.sliding = [Prepared(entries.slide_at, *arrays)] if self._sliding.size else []

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
        side = int(meeting.layers[1 if gas else 0] > k)
        alike = (p.at for p in self.pieces if p.number == number and np.array_equal(p.columns, columns))
        start = max((piece.at.stop for piece in self.pieces), default=0)
        at = next(alike, slice(start, start + columns.size))
        self.pieces.append(Piece(number, k, side, columns, local, inside, owned, at, self._holding(meeting, columns)))

    def _own(self, piece: Piece) -> np.ndarray:
        """Numbers of its points that the rank owns."""
        return piece.at.start + np.flatnonzero(piece.own)

    def _meeting(self, piece: Piece) -> Prepared:
        """The call that solves for what gas and solid have together at the points of a piece."""
        entry = entries.meet_sliding_at if self.slips[piece.number] else entries.meet_at
        fluid, _ = self._layout.problem.interfaces[piece.number]
        entry = compiled(entry, materials_of(self._layout.problem.layers[fluid]))
        arguments = self.faces, piece.number, self.points[piece.at], self._held[piece.at]
        if not self.slips[piece.number]:
            return Prepared(entry, *arguments)
        return Prepared(entry, *arguments, self._operators, *self._lines[piece.at.start].arguments)

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

    def meet(self) -> None:
        """Fetch the points, and solve for what gas and solid have together. Collective."""
        self.fetch()
        for meet in self.meetings:
            meet()

    def fetch(self) -> None:
        """Fetch the points; of a completed step, which have met already, that is all. Collective."""
        if self.slips:
            self._scatters[0].fetch()

    def slide(self) -> None:
        """Fetch the rates where gases slip, and find the tractions on both sides. Collective."""
        if any(self.slips):
            self._scatters[1].fetch()
            for slide in self.sliding:
                slide()

    def joined(self, k: int) -> np.ndarray:
        """Of layer k (n, 3): numbers of the points that it joins, their columns among those held, lower or upper edge."""
        found = [np.empty((0, 3), np.int64)]
        for piece in self._of(k):
            inside = np.flatnonzero(piece.inside)
            found.append(np.stack([piece.at.start + inside, piece.local[inside], np.full(inside.size, piece.side)], axis=1))
        return np.concatenate(found)

    def loaded(self, k: int) -> np.ndarray:
        """Of layer k (n, 4): numbers of the tractions on points of this rank, columns, edge, whether the solid is clamped."""
        found = [np.empty((0, 4), np.int64)]
        for piece in self._of(k):
            if self.slips[piece.number]:
                numbers, local = np.searchsorted(self._sliding, self._own(piece)), piece.local[piece.own]
                held = (piece.held[piece.own] == HELD).astype(np.int64)
                found.append(np.stack([numbers, local, np.full(local.size, piece.side), held], axis=1))
        return np.concatenate(found)

    def _of(self, k: int) -> list[Piece]:
        return [piece for piece in self.pieces if piece.k == k]

    def known(self, piece: Piece) -> np.ndarray:
        """(points, COLUMNS), what is known of the points of a piece, after ``meet`` what they have together."""
        return self.points[piece.at]

    def lines(self) -> list[tuple[Piece, Line | None]]:
        """All pieces; of those where the gas slips the line, which ``meet`` lays."""
        return [(piece, self._lines.get(piece.at.start)) for piece in self.pieces]

    def lay(self, line: Line, piece: Piece) -> None:
        """Lay another line for a piece, through its points as they are."""
        line.lay(self._operators, self.points[piece.at])

    def ends(self) -> np.ndarray:
        """Of the end points of solids that this rank owns (n, 2): where their kinetic energies stand in its part of the
        solution, their numbers.
        """
        found, places = [np.empty((0, 2), np.int64)], np.arange(self._layout.local_size)
        found += [np.stack([self._layout.energies(p.number, places), self._own(p)], axis=1) for p in self._of_solids()]
        return np.concatenate(found)

    def heights(self) -> list[tuple[int, np.ndarray]]:
        """(interface, y of these points)."""
        layers = self._layout.problem.layers
        return [(p.number, layers[p.k].Y[p.side] + self.points[p.at][p.own, 6]) for p in self._of_solids()]

    def _of_solids(self) -> list[Piece]:
        meetings = self._layout.meetings
        return [p for p in self.pieces if p.k == meetings[p.number].layers[1] and p.own.any()]

    def destroy(self) -> None:
        """Destroy what PETSc has made for it."""
        for scatter in self._scatters:
            scatter.destroy()


class _Scatter:
    """Fetches some numbers of a world vector, those wanted on this rank, into an array. Collective."""

    def __init__(self, world: PETSc.Vec, wanted: np.ndarray, into: np.ndarray) -> None:
        indices = wanted.ravel()
        self._world, self._vec = world, PETSc.Vec().createWithArray(into, comm=PETSc.COMM_SELF)
        self._from = PETSc.IS().createGeneral(indices.astype(PETSc.IntType), comm=world.comm)
        self._to = PETSc.IS().createStride(indices.size, 0, 1, comm=PETSc.COMM_SELF)
        self._scatter = PETSc.Scatter().create(world, self._from, self._vec, self._to)

    def fetch(self) -> None:
        self._scatter.scatter(self._world, self._vec)

    def destroy(self) -> None:
        for thing in (self._scatter, self._from, self._to, self._vec):
            thing.destroy()
