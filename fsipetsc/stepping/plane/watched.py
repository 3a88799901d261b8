"""Chosen points of interfaces in two dimensions, after each step: motion, traction and heat flux, for the series.

Traction and heat are those of the scheme: what makes the accelerations of the end points of gas and solid one, and their rates
of temperature (fsipetsc.coupling.plane). The rates without them are found for a block of points around each one, as small
as the sweep goes through, so that no bit depends on who owns what; the owner of the gas's end point contributes what it
knows, that of the solid's the rest, and the two add up like the integrals of the ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.coupling.plane import HELD
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import in_python
from fsipetsc.parallel.plane.layout import PlaneLayout
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.plane import PlaneProblem
from fsipetsc.stepping.plane.interfaces import Line, Piece

if TYPE_CHECKING:
    from fsipetsc.stepping.plane.part import LayerPart
    from fsipetsc.stepping.plane.path import PlanePath

#: what is recorded of a point: position [m], velocity [m/s] and temperature [K] of the solid, what acts on it: traction [Pa]
#: and heat flux [W/m2], per length of the interface as it is
NAMES = tuple(f"{name}_point" for name in ("x", "y", "u", "v", "T", "t_x", "t_y", "q"))
#: unknowns of the solid behind those of the gas
_SOLID = DOF


def chosen(problem: PlaneProblem, layout: PlaneLayout, places: Sequence[float]) -> list[tuple[int, int, float]]:
    """(interface, column of the gas, X [m]) of the grid's points next to some X, on all interfaces that there are.

    InputError for an X where there is no interface.
    """
    found = []
    for X in places:
        there = []
        for number, meeting in enumerate(layout.meetings):
            left, right = problem.span(meeting.layers[1])
            if left <= X <= right:
                grid = layout.grids[meeting.layers[0]]
                column = round((X - grid.x0) / grid.h_x)
                column = column % grid.nx if grid.periodic else min(max(column, meeting.first), meeting.end - 1)
                there.append((number, column, grid.x0 + column * grid.h_x))
        if not there:
            raise InputError(f"-fsi_points {X:g}: there is no interface at this X")
        found += there
    return sorted(set(found))


class Watched:
    """Records of the chosen points. Not collective; points: as ``chosen`` gives them."""

    def __init__(self, layout: PlaneLayout, path: PlanePath, points: Sequence[tuple[int, int, float]]) -> None:
        self.points = list(points)
        self._path, self._interfaces = path, path.interfaces
        self._known: list[_Known] = []
        lines: dict[int, Line] = {}
        for n, (number, column, _) in enumerate(self.points):
            for piece, line in self._interfaces.lines():
                here = np.flatnonzero((piece.columns == column) & piece.own) if piece.number == number else ()
                for i in here:
                    line = lines.setdefault(id(piece), line or Line(layout, piece, 0))
                    self._known.append(_Known(n, layout, path, piece, int(i), line))
        self._lines = [(line, piece) for piece, own in self._interfaces.lines() if (line := lines.get(id(piece))) and not own]

    def look(self, record: np.void, t: float) -> None:
        """Add what this rank knows to the columns NAMES of a record, of the completed state at time t [s] in ``path``.

        InputError where forcing of the case's fails.
        """
        for line, piece in self._lines:
            self._interfaces.lay(line, piece)
        for known in self._known:
            known.look(record, t)


class _Known:
    """What a rank knows of point n, as the owner of the end point of the gas or of the solid; i: its number in a piece."""

    def __init__(self, n: int, layout: PlaneLayout, path: PlanePath, piece: Piece, i: int, line: Line) -> None:
        problem, meeting = layout.problem, layout.meetings[piece.number]
        self._n, self._i, self._line = n, i, line
        self._points, self._slips = path.interfaces.known(piece), path.interfaces.slips[piece.number]
        self._held, self._gas = int(piece.held[i]), piece.k == meeting.layers[0]
        self._fluid, self._solid = (problem.layers[k].material for k in meeting.layers)
        self._shared = self._fluid.kappa > 0.0 and self._solid.kappa_e > 0.0
        solid = layout.grids[meeting.layers[1]]
        self._X = solid.x0 + (piece.columns[i] - meeting.shift) * solid.h_x
        self._Y = problem.layers[meeting.layers[1]].Y[0 if meeting.rows[1] == 0 else 1]
        self._h = tuple(layout.grids[k].h_y for k in meeting.layers)
        part = path.part(piece.k)
        self._weight = part.end_weight
        row, column = int(part.record["end_y"][piece.side]), int(piece.local[i])
        self._probe, self._here = Probe(layout, part, row, column), part.held[row, column]

    def look(self, record: np.void, t: float) -> None:
        q, n = self._points[self._i].tolist(), self._n
        rates = self._probe.rates(t)
        N = self._line.normals[self._i].tolist()
        length = np.hypot(N[0], N[1])
        m_f, m_s = self._h[0] * self._weight * q[1], self._h[1] * self._weight * self._solid.m0
        traction = self._slipping(q, rates, N, m_f, m_s) if self._slips else self._sticking(q, rates, m_f, m_s)
        heat = self._heat(q, rates, m_f, m_s) if self._shared else 0.0
        for name, value in zip(NAMES[5:], (*traction, heat), strict=True):
            record[name][n] += value / length
        if not self._gas:
            # (T may have got more after gas and solid have met)
            own = self._X + q[_SOLID], self._Y + q[_SOLID + 1], *q[_SOLID + 2 : _SOLID + 4], self._here[4]
            for name, value in zip(NAMES[:5], own, strict=True):
                record[name][n] += value

    def _acceleration(self, q: list[float], rates: list[float]) -> tuple[float, float]:
        """Of the gas less that of the solid, without traction: the part that is known here; what is held has none."""
        if self._gas:
            return (rates[2] - q[2] / q[1] * rates[1]) / q[1], (rates[3] - q[3] / q[1] * rates[1]) / q[1]
        return (0.0 if self._held else -rates[2]), (0.0 if self._held == HELD else -rates[3])

    def _sticking(self, q: list[float], rates: list[float], m_f: float, m_s: float) -> list[float]:
        """Part of the traction on the solid, per reference length: (a_f - a_s) / (1/M_f + 1/M_s)."""
        held = self._held != 0, self._held == HELD
        return [a / (1.0 / m_f + (0.0 if h else 1.0 / m_s)) for a, h in zip(self._acceleration(q, rates), held, strict=True)]

    def _slipping(self, q: list[float], rates: list[float], N: list[float], m_f: float, m_s: float) -> list[float]:
        """Part of -pi N: see fsipetsc.coupling.plane, ``slide``."""
        a_x, a_y = self._acceleration(q, rates)
        apart = N[0] * a_x + N[1] * a_y
        if self._gas:
            apart += N[2] * (q[2] / q[1] - q[7]) + N[3] * (q[3] / q[1] - q[8])
        of_solid = 0.0 if self._held == HELD else 1.0 / m_s
        push = apart / ((N[0] * N[0] + N[1] * N[1]) * (1.0 / m_f + of_solid))
        return [push * N[0], push * N[1]]

    def _heat(self, q: list[float], rates: list[float], m_f: float, m_s: float) -> float:
        """Part of the heat flux into the solid, per reference length: (T_f,t - T_s,t) / (1/(M_f c) + 1/(M_s alpha))."""
        J, r, m, k, e = q[:DOF]
        law = formulas_of(self._fluid.law)
        c, rho, u, v = in_python(law.constants)(self._fluid), r / J, m / r, k / r
        T = q[_SOLID + 4]
        capacity = float(in_python(law.heat_capacity)(c, rho, T))
        if self._gas:
            kinetic = 0.5 * (u * u + v * v)
            p, p_T = (float(in_python(f)(c, rho, T)) for f in (law.pressure, law.pressure_by_temperature))
            changes = (rates[1] - rho * rates[0]) / J
            energy = (rates[4] - u * rates[2] - v * rates[3] + kinetic * rates[1] - (e / r - kinetic) * rates[1]) / r
            warming = (energy - (p - T * p_T) / (rho * rho) * changes) / capacity
        else:
            warming = -rates[4]
        return warming / (1.0 / (m_f * capacity) + 1.0 / (m_s * self._solid.alpha))


class Probe:
    """The rates of one point at an edge, without what passes the edge: those of a block of points about it.

    It is to forcing what a part of a layer is (fsipetsc.stepping.plane.edge_data). row, column: among those held.
    """

    def __init__(self, layout: PlaneLayout, part: LayerPart, row: int, column: int) -> None:
        self.k, self.end_weight, self.sides, self._part = part.k, part.end_weight, part.sides, part
        op, records = part.operator, np.array([part.record])
        self._records, self.record = records, records[0]
        size, reach = int(op["rows"] + op["p"]), 2 * int(op["p"])
        ends = (_around(at, size, *part.record[name].tolist()) for at, name in ((column, "own_x"), (row, "own_y")))
        self.record["own_x"], self.record["own_y"] = own_x, own_y = tuple(ends)
        held = layout.held(part.k)
        self.columns, self.rows = held[0][slice(*own_x)], held[1][slice(*own_y)]
        self._block = slice(*own_y), slice(*own_x)
        # rows that the derivatives do not need are left out, unless the other end's closure is near
        skipped = own_y[0] - reach if own_y[0] - reach - self.record["end_y"][0] >= op["rows"] else 0
        for name in ("own_y", "end_y", "height"):
            self.record[name] -= skipped
        self.record["first_y"] += skipped
        self._first = skipped * int(self.record["width"]) * DOF
        self._rates = np.zeros(self.own.size + 8 * DOF)
        self._at = ((row - own_y[0]) * (own_x[1] - own_x[0]) + column - own_x[0]) * DOF

    @property
    def own(self) -> np.ndarray:
        """The block's part of what the layer's part holds now."""
        return self._part.held[self._block]

    def rates(self, t: float) -> list[float]:
        """(DOF,) at time t [s], of what the part holds. InputError where forcing fails."""
        self._part.evaluate_block(self._records, self._part.y[self._first :], self._rates)
        self._part.data.force(self, t, self._rates[: self.own.size])
        return self._rates[self._at : self._at + DOF].tolist()


def _around(at: int, size: int, first: int, end: int) -> tuple[int, int]:
    """``size`` points about one between the first and the last, or all of them."""
    size = min(size, end - first)
    begin = min(max(at - size // 2, first), end - size)
    return begin, begin + size
