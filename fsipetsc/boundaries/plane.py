"""What can stand at an edge of a layer in two dimensions.

The layers of a problem lie one above the other; each has a left and a right edge in X, the lowest one a lower, the topmost an
upper edge. Numbers of kinds are those of ``edge_x``, ``edge_y`` and ``beside`` of a PLANE_LAYER; ``INTERFACE_END`` is that of
an interface, as in one dimension.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fsipetsc import checks
from fsipetsc.checks import Array, Fields
from fsipetsc.errors import InputError

NO_SLIP, SLIP, OPEN, OUTFLOW = 0, 1, 2, 3
CLAMPED, FREE, ROLLER = 4, 5, 6
GIVEN, PERIODIC = 7, 8
GAS, SOLID = frozenset({NO_SLIP, SLIP, OPEN, OUTFLOW, GIVEN, PERIODIC}), frozenset({CLAMPED, FREE, ROLLER, GIVEN, PERIODIC})


@dataclass(frozen=True)
class Periodic:
    """The layers go on: what leaves at one side of X comes in at the other. Both sides of all layers, or of none."""

    kind = PERIODIC


#: x(X, t) -> (x, y) [m], velocity(X, t) -> (u, v) [m/s] of points of a wall
Moving = Callable[[Array, float], Fields]


@dataclass(frozen=True)
class NoSlip:
    """Wall that the gas sticks to: adiabatic, or of temperature T [K], a number or a function T(X, Y, t).

    At rest, or, as the lower or upper edge of a problem, where x(X, t) -> (x, y) [m] says; velocity(X, t) -> (u, v) [m/s] is
    found by differences of x if it is not given.
    """

    T: float | Callable[[Array, Array, float], Array] | None = None
    x: Moving | None = None
    velocity: Moving | None = None
    kind = NO_SLIP

    def __post_init__(self) -> None:
        _check_motion(self, "NoSlip")
        if self.T is not None and not callable(self.T):
            object.__setattr__(self, "T", checks.number(self.T, "NoSlip: T", checks.POSITIVE))


@dataclass(frozen=True)
class Slip:
    """Wall along which the gas slips without heat, or the plane of a symmetry. At rest, or moved as a NoSlip."""

    x: Moving | None = None
    velocity: Moving | None = None
    kind = SLIP

    def __post_init__(self) -> None:
        _check_motion(self, "Slip")


@dataclass(frozen=True)
class Open:
    """Gas of this density [kg/m3], velocity [m/s] and temperature [K] outside; the faster waves pass by upwinding."""

    rho: float
    u: float
    v: float
    T: float
    kind = OPEN

    def __post_init__(self) -> None:
        ranges = {"rho": checks.POSITIVE, "u": checks.ANY, "v": checks.ANY, "T": checks.POSITIVE}
        checks.numbers(self, "Open", ranges)


@dataclass(frozen=True)
class Outflow:
    """Gas flows out. Nothing is said of it where it does so faster than sound; where it is slower, as in boundary layers, there
    is this pressure [Pa] beyond; 0 for a flow that nowhere is.
    """

    pressure: float = 0.0
    kind = OUTFLOW

    def __post_init__(self) -> None:
        checks.numbers(self, "Outflow", {"pressure": checks.NONNEGATIVE})


@dataclass(frozen=True)
class Clamped:
    """The solid is held where it is."""

    kind = CLAMPED


@dataclass(frozen=True)
class Free:
    """A pressure [Pa] that follows the edge of the solid; at the sides in X it must be 0."""

    pressure: float = 0.0
    kind = FREE

    def __post_init__(self) -> None:
        checks.numbers(self, "Free", {"pressure": checks.ANY})


@dataclass(frozen=True)
class Roller:
    """The solid may slide along the edge without friction, but not across; or the plane of a symmetry."""

    kind = ROLLER


@dataclass(frozen=True)
class Given:
    """All unknowns are given: values(X, Y, t) -> (rho, u, v, T) of a gas, (u, v, T, x, y) of a solid. The edge of a gas is at
    rest, or moved as a NoSlip.
    """

    values: Callable[[Array, Array, float], Fields]
    x: Moving | None = None
    velocity: Moving | None = None
    kind = GIVEN

    def __post_init__(self) -> None:
        _check_motion(self, "Given")
        checks.function(self.values, "Given: values", "values(X, Y, t) -> the unknowns")


def _check_motion(end: NoSlip | Slip | Given, name: str) -> None:
    """InputError where what moves an edge are no functions."""
    checks.function(end.x, f"{name}: x", "x(X, t) -> (x, y)", optional=True)
    checks.function(end.velocity, f"{name}: velocity", "velocity(X, t) -> (u, v)", optional=True)
    if end.velocity is not None and end.x is None:
        raise InputError(f"{name}: velocity is given, and x is not: expected both, or x alone")


def moves(end: Edge | None) -> bool:
    """Whether an edge of a gas moves by itself."""
    return getattr(end, "x", None) is not None


def holds_energy(end: Edge) -> bool:
    """Whether neither heat nor work passes an edge."""
    still = isinstance(end, (NoSlip, Slip, Periodic, Clamped, Roller)) or (isinstance(end, Free) and end.pressure == 0.0)
    return still and getattr(end, "T", None) is None and not moves(end)


Edge = Periodic | NoSlip | Slip | Open | Outflow | Clamped | Free | Roller | Given
