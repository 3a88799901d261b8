"""What can stand at a face of a block.

Data are numbers, or functions of place and time: f(*X, t), X the face's nodes in the reference map. `of` says which kinds
of block a condition is for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from fsipetsc import checks
from fsipetsc.checks import described
from fsipetsc.errors import InputError

#: f(*X, t) -> an array, or several
Function = Callable[..., Any]
#: a number or f(*X, t) -> an array
Datum = float | Function | None

FLUID, SOLID, BOTH = frozenset({"fluid"}), frozenset({"solid"}), frozenset({"fluid", "solid"})


@dataclass(frozen=True)
class NoSlip:
    """Wall that the gas sticks to: adiabatic, of temperature T [K], or with a heat flux into the gas [W/m2].

    At rest, or where x(*X, t) -> d positions [m] says; velocity(*X, t) -> d velocities [m/s] is found by differences of x if
    it is not given.
    """

    T: Datum = None
    heat_flux: Datum = None
    x: Function | None = None
    velocity: Function | None = None
    of: ClassVar[frozenset[str]] = FLUID

    def __post_init__(self) -> None:
        _check_heat(self)
        _check_motion(self)


@dataclass(frozen=True)
class Slip:
    """Wall along which the gas slips without heat, or a plane of symmetry. At rest, or moved as a NoSlip.

    At an edge between walls of one name there is one constraint, on the sum of their normals: a curved wall over several
    faces has one name. Walls that meet at an angle have names of their own; without a name, each face is a wall.
    """

    x: Function | None = None
    velocity: Function | None = None
    name: str = ""
    of: ClassVar[frozenset[str]] = FLUID

    def __post_init__(self) -> None:
        _check_motion(self)
        if not isinstance(self.name, str):
            raise InputError(f"Slip: name is {described(self.name)}: expected a text")


@dataclass(frozen=True)
class Open:
    """Gas of density rho [kg/m3], velocity u (d numbers) [m/s], temperature T [K] outside; waves pass by upwinding.

    u may be a function u(*X, t) -> d arrays.
    """

    rho: Datum
    u: Any
    T: Datum
    of: ClassVar[frozenset[str]] = FLUID

    def __post_init__(self) -> None:
        _datum(self, "rho", checks.POSITIVE)
        _datum(self, "T", checks.POSITIVE)
        if not callable(self.u):
            numbers = (self.u,) if isinstance(self.u, (int, float)) else tuple(self.u)
            found = tuple(v if callable(v) else checks.number(v, f"Open: u[{k}]") for k, v in enumerate(numbers))
            object.__setattr__(self, "u", found)


@dataclass(frozen=True)
class Outflow:
    """Gas flows out, against a pressure [Pa] where it is slower than sound; 0 for a flow that nowhere is."""

    pressure: Datum = 0.0
    of: ClassVar[frozenset[str]] = FLUID

    def __post_init__(self) -> None:
        _datum(self, "pressure", checks.NONNEGATIVE)


@dataclass(frozen=True)
class Given:
    """All unknowns are given: values(*X, t) -> (rho, u_1..u_d, T) of a gas, (v_1..v_d, T, x_1..x_d) of a solid.

    The face of a gas is at rest, or moved as a NoSlip.
    """

    values: Function
    x: Function | None = None
    velocity: Function | None = None
    of: ClassVar[frozenset[str]] = BOTH

    def __post_init__(self) -> None:
        checks.function(self.values, "Given: values", "values(*X, t) -> the unknowns")
        _check_motion(self)


@dataclass(frozen=True)
class Clamped:
    """The solid is held where it is, or moved to x(*X, t) -> d positions [m]; T, heat_flux as of a NoSlip."""

    x: Function | None = None
    T: Datum = None
    heat_flux: Datum = None
    of: ClassVar[frozenset[str]] = SOLID

    def __post_init__(self) -> None:
        _check_heat(self)
        checks.function(self.x, "Clamped: x", "x(*X, t) -> d positions", optional=True)


@dataclass(frozen=True)
class Free:
    """A pressure [Pa] that follows the face of the solid; T, heat_flux as of a NoSlip."""

    pressure: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None
    of: ClassVar[frozenset[str]] = SOLID

    def __post_init__(self) -> None:
        _datum(self, "pressure", checks.ANY)
        _check_heat(self)


@dataclass(frozen=True)
class Roller:
    """The solid may slide along the face's plane without friction, but not across; or a plane of symmetry."""

    of: ClassVar[frozenset[str]] = SOLID


@dataclass(frozen=True)
class Hinge:
    """A point of a solid's face that is held, while the solid may turn about it. At points of a problem, not at faces."""

    of: ClassVar[frozenset[str]] = SOLID


@dataclass(frozen=True)
class Periodic:
    """The face goes on at another one, which is this one moved by shift (d numbers) [m] and is Periodic, too.

    A block that is periodic in itself has no faces there: Block(…, periodic=(True, False)).
    """

    shift: Any
    of: ClassVar[frozenset[str]] = BOTH

    def __post_init__(self) -> None:
        numbers = (self.shift,) if isinstance(self.shift, (int, float)) else tuple(self.shift)
        found = tuple(checks.number(s, f"Periodic: shift[{k}]", unit="m") for k, s in enumerate(numbers))
        object.__setattr__(self, "shift", found)


Condition = NoSlip | Slip | Open | Outflow | Given | Clamped | Free | Roller | Hinge | Periodic


def moves(condition: Any) -> bool:
    """Whether a face moves by given data."""
    return getattr(condition, "x", None) is not None


def steady(condition: Any) -> bool:
    """Whether no data of a condition depend on time."""
    data = [value for key, value in vars(condition).items() if key != "name"]
    return not any(callable(v) for value in data for v in (value if isinstance(value, tuple) else (value,)))


def holds_energy(condition: Any) -> bool:
    """Whether neither heat nor work passes a face."""
    pressure = getattr(condition, "pressure", 0.0)
    closed = not isinstance(condition, (Open, Outflow, Given)) and not callable(pressure) and pressure == 0.0
    heat = getattr(condition, "T", None) is not None or getattr(condition, "heat_flux", None) is not None
    return closed and not heat and not moves(condition)


def _datum(record: Any, name: str, bound: str, optional: bool = False) -> None:
    """Make a datum a float, unless it is a function or, where optional, None; InputError."""
    value = getattr(record, name)
    if not (callable(value) or (optional and value is None)):
        object.__setattr__(record, name, checks.number(value, f"{type(record).__name__}: {name}", bound))


def _check_heat(record: Any) -> None:
    _datum(record, "T", checks.POSITIVE, optional=True)
    _datum(record, "heat_flux", checks.ANY, optional=True)
    if record.T is not None and record.heat_flux is not None:
        raise InputError(f"{type(record).__name__}: T and heat_flux are both given: expected one of them, or neither")


def _check_motion(record: Any) -> None:
    owner = type(record).__name__
    checks.function(record.x, f"{owner}: x", "x(*X, t) -> d positions", optional=True)
    checks.function(record.velocity, f"{owner}: velocity", "velocity(*X, t) -> d velocities", optional=True)
    if record.velocity is not None and record.x is None:
        raise InputError(f"{owner}: velocity is given, and x is not: expected both, or x alone")
