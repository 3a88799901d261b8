"""What can stand at the outer ends of the chain of layers.

A fluid ends at an embedded boundary at a fixed Eulerian position x: the moving grid reaches over it to one ghost
point outside. A solid ends at a material point. To add a condition, write its file, a dataclass here and a line in
``fill_ghost``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc import checks
from fsipetsc.boundaries import dirichlet as _dirichlet
from fsipetsc.boundaries import open as _open
from fsipetsc.boundaries import wall as _wall
from fsipetsc.boundaries.solid_ends import solid_end
from fsipetsc.errors import InputError
from fsipetsc.operators.kernels import OPTIONS, extrapolate, lagrange

INTERFACE_END = -1
WALL, OPEN, DIRICHLET = 0, 1, 2
CLAMPED, FREE, ABSORBING = 10, 11, 12
#: degrees that a formula may have
DEGREES = (2, 3, 4, 5)
#: nodes that a formula may use, ghost point included
NODES = 8


def nodes_needed(degree: int) -> int:
    """Points inside the ghost point that a boundary needs: its formula's, and those that fill a new point."""
    return max(degree, _dirichlet.NEW_POINT + 1)


@dataclass(frozen=True)
class Wall:
    """Adiabatic no-slip wall at the Eulerian position x [m]."""

    x: float
    kind = WALL
    degree = _wall.DEGREE

    def __post_init__(self) -> None:
        checks.numbers(self, "Wall", {"x": checks.ANY})

    def data(self, t: float) -> tuple[float, ...]:
        return ()


@dataclass(frozen=True)
class Open:
    """Open end at x [m] towards gas of pressure p0 [Pa], temperature T0 [K] and velocity u0 [m/s]; see ``boundaries/open.py``.

    order: of the conditions in viscosity and conduction, 0 or 1. Raises InputError for another one.
    """

    x: float
    p0: float
    T0: float
    u0: float = 0.0
    order: int = 1
    kind = OPEN
    degree = 2

    def __post_init__(self) -> None:
        checks.numbers(self, "Open", {"x": checks.ANY, "p0": checks.POSITIVE, "T0": checks.POSITIVE, "u0": checks.ANY})
        if isinstance(self.order, bool) or self.order not in (0, 1):
            raise InputError(f"Open(order={self.order!r}): expected 0 or 1, the order of the conditions in the viscosity")

    def data(self, t: float) -> tuple[float, ...]:
        return (self.p0, self.T0, self.u0, float(self.order))


@dataclass(frozen=True)
class Dirichlet:
    """Given rho, u, T at x [m]: values(t) -> (rho, u, T) in kg/m3, m/s, K; see ``boundaries/dirichlet.py``.

    degree: of the embedded-boundary formula, 2 to 5; None: what lets the order of the operator show, see ``degree_of``.
    Raises InputError for another degree.
    """

    x: float
    values: Callable[[float], tuple[float, float, float]]
    degree: int | None = None
    kind = DIRICHLET

    def __post_init__(self) -> None:
        checks.numbers(self, "Dirichlet", {"x": checks.ANY})
        checks.function(self.values, "Dirichlet: values", "values(t) -> (rho, u, T)")
        whole = isinstance(self.degree, (int, np.integer)) and not isinstance(self.degree, bool)
        if self.degree is not None and not (whole and self.degree in DEGREES):
            raise InputError(
                f"Dirichlet(degree={self.degree!r}): expected a whole number from {DEGREES[0]} to {DEGREES[-1]}, "
                "or None for the degree that follows -fsi_order"
            )

    def data(self, t: float) -> tuple[float, ...]:
        return self.values(t)


def degree_of(end: Boundary, order: int) -> int:
    """Degree of the formulas of an end with the operator of this interior order.

    Unless the end says: 2, 3, 4, 5 for the orders 2, 4, 6, 8, one more than the closures are exact to. A degree less spoils
    the order, one more gains nothing.
    """
    return order // 2 + 1 if end.degree is None else int(end.degree)


@dataclass(frozen=True)
class SolidEnd:
    """Outer end of a solid. kind CLAMPED: velocity value [m/s]; FREE, ABSORBING: stress sigma - p = value [Pa]."""

    kind: int
    value: float
    degree = 0

    def data(self, t: float) -> tuple[float, ...]:
        return (self.value,)


def clamped(velocity: float = 0.0) -> SolidEnd:
    """Solid end that moves with a given, constant velocity [m/s]. InputError if that is no number."""
    return SolidEnd(CLAMPED, _constant(velocity, "clamped: velocity"))


def free(stress: float = 0.0) -> SolidEnd:
    """Solid end under a given, constant stress sigma - p [Pa]. InputError if that is no number."""
    return SolidEnd(FREE, _constant(stress, "free: stress"))


def absorbing(stress: float = 0.0) -> SolidEnd:
    """Solid end that lets elastic waves out, towards a solid at rest under the stress sigma - p [Pa]. InputError if that
    is no number.
    """
    return SolidEnd(ABSORBING, _constant(stress, "absorbing: stress"))


def _constant(value: float, what: str) -> float:
    if callable(value):
        raise InputError(f"{what} is {checks.described(value)}: expected a number; the ends of a solid do not change in time")
    return checks.number(value, what)


@njit(**OPTIONS)
def fill_ghost(law, layer, op, side, delta, nodes, new):
    """Give the ghost point its values: nodes[:3, 0] of (rho, u, T), from nodes[:3, k] at k points inside of it.

    nodes has the shape (5, NODES); its last two rows are scratch. delta: distance of the boundary from the ghost
    point in cells. new: the point has no values yet.
    """
    weights, slopes = nodes[3], nodes[4]
    kind, normal = layer.end_kind[side], 2.0 * side - 1.0
    lagrange(delta, layer.end_degree[side], weights, slopes)
    if new:
        degree = _wall.NEW_POINT if kind == WALL else (_open.NEW_POINT if kind == OPEN else _dirichlet.NEW_POINT)
        for k in range(3):
            nodes[k, 0] = extrapolate(nodes[k], degree)
    if kind == WALL:
        _wall.wall(law, layer, op, side, normal, delta, nodes, weights, slopes)
    elif kind == OPEN:
        _open.open_end(law, layer, side, normal, nodes)
        _open.note_gradient(law, layer, side, normal, nodes)
    elif kind == DIRICHLET:
        _dirichlet.dirichlet(law, layer, side, normal, nodes, weights)


@njit(**OPTIONS)
def note_gradient(law, layer, side, delta, nodes):
    """Note what the gradients take at a ghost point that is filled already; arguments as of ``fill_ghost``."""
    if layer.end_kind[side] == OPEN:
        _open.note_gradient(law, layer, side, 2.0 * side - 1.0, nodes)
    elif layer.end_kind[side] == DIRICHLET:
        lagrange(delta, layer.end_degree[side], nodes[3], nodes[4])
        _dirichlet.note_gradient(layer, side, nodes, nodes[3])


@njit(**OPTIONS)
def close_solid(law, layer, op, side, trace_s):
    """Apply the condition at an outer end of a solid to its end rows, counted inwards."""
    solid_end(law, layer, op, side, 2.0 * side - 1.0, layer.end_kind[side] - CLAMPED, trace_s)


Boundary = Wall | Open | Dirichlet | SolidEnd
