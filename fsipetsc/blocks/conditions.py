"""What can stand at a face of a block.

Data are numbers, or functions of place and time: f(*X, t), X the face's nodes in the reference map.
InputError for what is no datum.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, function, number
from fsipetsc.errors import InputError

#: f(*X, t) -> an array, or several
Function = Callable[..., Any]
#: a number or f(*X, t) -> an array
Datum = float | Function | None

#: data by name: what numbers must be, and what functions return
_NUMBERS = {
    **{"T": POSITIVE, "heat_flux": ANY, "slip_length": POSITIVE},
    **{"rho": POSITIVE, "pressure": ANY, "stress": ANY},
}
_FUNCTIONS = {"x": "d positions", "velocity": "d velocities", "values": "the unknowns"}
_VECTORS = "u", "shift"


class Condition:
    """What stands at a face. Makes data floats and tuples of floats. of: kinds of block that it is
    for.
    """

    of = frozenset({"fluid", "solid"})

    def __post_init__(self) -> None:
        name, given = type(self).__name__, set()
        for field in fields(self):  # type: ignore[arg-type]
            key, value, what = field.name, getattr(self, field.name), f"{name}: {field.name}"
            if value is None and field.default is None:
                continue
            given.add(key)
            if key in _FUNCTIONS:
                function(value, what, f"{key}(*X, t) -> {_FUNCTIONS[key]}")
            elif key in _NUMBERS and not callable(value):
                bound = NONNEGATIVE if isinstance(self, Outflow) else _NUMBERS[key]
                object.__setattr__(self, key, number(value, what, bound))
            elif key in _VECTORS and not callable(value):
                items = enumerate(value if isinstance(value, (tuple, list)) else (value,))
                found = (v if callable(v) else number(v, f"{what}[{k}]") for k, v in items)
                object.__setattr__(self, key, tuple(found))
        if {"T", "heat_flux"} <= given:
            raise InputError(f"{name}: T and heat_flux are both given: expected one, or neither")
        if "velocity" in given and "x" not in given and not isinstance(self, Clamped):
            raise InputError(f"{name}: velocity is given, and x is not: expected both, or x alone")


class _OfGas(Condition):
    of = frozenset({"fluid"})


class _OfSolid(Condition):
    of = frozenset({"solid"})


@dataclass(frozen=True)
class NoSlip(_OfGas):
    """Wall that the gas sticks to: adiabatic, of temperature T [K], or with heat flux [W/m2] in.

    At rest, or where x(*X, t) -> d positions [m] says; velocity(*X, t) -> d velocities [m/s] is
    found by differences of x if it is not given.

    slip_length [m]: the gas slips along the wall with this length times the slope of its velocity
    (Navier), so that it may meet a wall, or a solid, that moves along this one.
    """

    T: Datum = None
    heat_flux: Datum = None
    x: Function | None = None
    velocity: Function | None = None
    slip_length: Datum = None


@dataclass(frozen=True)
class Slip(_OfGas):
    """Wall along which the gas slips without heat, or a plane of symmetry; moves as a NoSlip.

    Faces of one name are one wall, also around an edge; without names, those that go on smoothly.
    """

    x: Function | None = None
    velocity: Function | None = None
    name: str = ""


@dataclass(frozen=True)
class Open(_OfGas):
    """Gas of density rho [kg/m3], velocity u (d data, or u(*X, t) -> d arrays) [m/s] and
    temperature T [K] outside; waves pass by characteristics.

    order: 1 where viscosity and conduction matter to them: see docs/open-end.md.
    """

    rho: Datum
    u: Any
    T: Datum
    order: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.order not in (0, 1):
            raise InputError(f"Open: order is {self.order!r}: expected 0 or 1")


@dataclass(frozen=True)
class Outflow(_OfGas):
    """Gas flows out, against a pressure [Pa] where slower than sound; 0 where it nowhere is."""

    pressure: Datum = 0.0


@dataclass(frozen=True)
class Given(Condition):
    """All unknowns are given: values(*X, t) -> (rho, u_1..u_d, T) of a gas, (v_1..v_d, T, x_1..x_d)
    of a solid. The face of a gas is at rest, or moved as a NoSlip.
    """

    values: Function
    x: Function | None = None
    velocity: Function | None = None


@dataclass(frozen=True)
class Clamped(_OfSolid):
    """The solid is held where it is, or moved to x(*X, t) -> d positions [m]; heat as of a NoSlip.

    With velocity(*X, t) -> d velocities [m/s] alone it moves so from where it is at first.
    """

    x: Function | None = None
    T: Datum = None
    heat_flux: Datum = None
    velocity: Function | None = None


@dataclass(frozen=True)
class Free(_OfSolid):
    """A pressure [Pa] that follows the face of the solid; heat as of a NoSlip."""

    pressure: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None


@dataclass(frozen=True)
class Absorbing(_OfSolid):
    """The solid goes on beyond the face, under a stress [Pa], a tension if above 0: waves along the
    normal n pass, of pressure and of shear; of oblique ones a part is reflected. The traction per
    area at rest is stress n - Z v, Z = sqrt(m0 Q) with the acoustic tensor Q along n at the strain
    there; unstrained, Z has m0 c_p along n and m0 c_s across. Heat as of a NoSlip.

    Source: Lysmer and Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.
    """

    stress: Datum = 0.0
    T: Datum = None
    heat_flux: Datum = None


@dataclass(frozen=True)
class Roller(_OfSolid):
    """The solid slides along the face's plane without friction; or a plane of symmetry. Heat as of
    a NoSlip.
    """

    T: Datum = None
    heat_flux: Datum = None


@dataclass(frozen=True)
class Centre(Condition):
    """No face: beyond the first node, half a spacing from r = 0, is the block's mirror image. At
    side 0 of the last axis, in a problem with an axis or a centre.
    """


@dataclass(frozen=True)
class Hinge(_OfSolid):
    """A point of a solid's face that is held, among a problem's points; the solid may turn."""


@dataclass(frozen=True)
class Periodic(Condition):
    """The face goes on at another one, also Periodic: this one moved by shift (d numbers) [m].

    A block that is periodic in itself has no faces there: Block(…, periodic=(True, False)).
    """

    shift: Any


def moves(condition: Any) -> bool:
    """Whether a face moves by given data."""
    return getattr(condition, "x", None) is not None


def slides(condition: Any) -> bool:
    """Whether it is a wall that holds a gas across itself alone."""
    return isinstance(condition, Slip) or getattr(condition, "slip_length", None) is not None


def steady(condition: Any) -> bool:
    """Whether no data of a condition depend on time."""
    data = vars(condition).values()
    return not any(callable(v) for d in data for v in (d if isinstance(d, tuple) else (d,)))


def conserves_energy(condition: Any) -> bool:
    """Whether neither heat nor work passes a face."""
    names = "T", "heat_flux", "x", "velocity"
    given = any(getattr(condition, name, None) is not None for name in names)
    passes = given or isinstance(condition, (Open, Outflow, Given, Absorbing))
    return not passes and getattr(condition, "pressure", 0.0) == 0.0
