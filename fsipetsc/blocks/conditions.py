"""What can stand at a face of a block: classes with their data, checks, and what they add to rates.

Data are numbers, or functions of place and time: f(*X, t), X the face's nodes in the reference map.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from fsipetsc.blocks.face_formulas import Effect, FaceNode, mixed_flux, open_flux, surface_flux
from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, check, number
from fsipetsc.equations.vectors import along, choose, dot, scale, sub
from fsipetsc.errors import InputError

Function = Callable[..., Any]
#: a number or f(*X, t) -> an array
Datum = float | Function | None
#: data of d numbers
VECTORS = "u", "shift"
#: what data must be that are numbers or functions, also those of ends (fsipetsc.boundaries)
RANGES = dict.fromkeys(("T", "T0", "rho", "p0", "slip_length"), POSITIVE)
RANGES |= dict.fromkeys(("heat_flux", "stress", "pressure", "x", "u0", "velocity"), ANY)
#: column of the record of faces (fsipetsc.scheme.face_terms) -> names of the data in it
COLUMNS = {"heat": ("heat_flux",), "pressure": ("pressure",), "stress": ("stress",)}
COLUMNS |= {"slip": ("slip_length",), "outside": ("rho", "u", "T")}


class Checked:
    """A dataclass whose data are checked; numbers become floats.

    ranges: of data; functions: those that are no numbers, fixed: those that are no functions.
    """

    ranges = RANGES
    functions: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        name = type(self).__name__
        for field in fields(self):  # type: ignore[arg-type]
            key, value, what = field.name, getattr(self, field.name), f"{name}: {field.name}"
            if key in self.functions:
                check("optional" if field.default is None else "function", value, what)
            elif (callable(value) and key not in self.fixed) or value is field.default is None:
                continue
            elif key in self.ranges:
                object.__setattr__(self, key, number(value, what, self.ranges[key]))
            elif key in VECTORS:
                items = enumerate(value if isinstance(value, (tuple, list)) else (value,))
                object.__setattr__(self, key, tuple(number(v, f"{what}[{k}]") for k, v in items))
        if getattr(self, "T", None) is not None and getattr(self, "heat_flux", None) is not None:
            raise InputError(f"{name}: T and heat_flux are both given: expected one, or neither")

    @property
    def steady(self) -> bool:
        """Whether no data depend on time."""
        return not any(map(callable, vars(self).values()))


class Condition(Checked):
    """What stands at a face: the type of all conditions.

    of: kinds of block that it is for. part: if it prescribes motion, what it is to a particle
    (fsipetsc.particles.members), "wall", "slip", "clamp", "roller"; all_given: it prescribes all
    unknowns. passes: "gas" or "waves" where these go through. loaded: the face has a traction of
    its own, from which p_ref of the solid is taken.

    Formulas, None where there is none: leaving(gas, w, face): mass, momentum and energy that leave
    a gas of the state w; traction(gas, w, face): the force on it; pull(solid, F, T, N, v, stress):
    that on a solid per area at rest.
    """

    of: tuple[str, ...] = ("fluid", "solid")
    functions = "x", "velocity", "values"
    part = passes = ""
    all_given = loaded = False
    leaving = traction = pull = None
    T = heat_flux = x = velocity = slip_length = None

    @property
    def acts(self) -> bool:
        """Whether it adds anything but heat to the rates at its faces."""
        return any((self.leaving, self.traction, self.pull))

    @property
    def moves(self) -> bool:
        """Whether its face moves by given data."""
        return self.x is not None

    @property
    def slides(self) -> bool:
        """Whether it is a wall that holds a gas across itself alone."""
        return self.part == "slip" or self.slip_length is not None

    @property
    def warms(self) -> bool:
        """Whether it prescribes the temperature at its face."""
        return self.T is not None and self.passes != "gas"

    @property
    def conserves_energy(self) -> bool:
        """Whether neither heat nor work passes a face."""
        given = any(v is not None for v in (self.T, self.heat_flux, self.x, self.velocity))
        return not (given or self.passes or self.leaving) and getattr(self, "pressure", 0.0) == 0.0

    @property
    def effect(self) -> Effect | None:
        """What it adds to rates, None if nothing."""
        by, heated = type(self) if self.acts else Condition, self.heat_flux is not None
        found = Effect(by, heated, self.acts and self.moves, getattr(self, "order", 0) == 1)
        return found if self.acts or heated else None


@dataclass(frozen=True, kw_only=True)
class Warm(Condition):
    """A face at which heat comes in or out; insulated if neither is given.

    Args:
        T: temperature [K], a number or a function of (*X, t).
        heat_flux: heat flux into the block [W/m2], likewise; of a solid per area at rest.
    """

    T: Datum = None
    heat_flux: Datum = None


@dataclass(frozen=True, kw_only=True)
class Moving(Condition):
    """A face that moves as given.

    Args:
        x: `x(*X, t)` returns d positions [m]; None: it stays where it is.
        velocity: `velocity(*X, t)` returns d velocities [m/s], the derivative of x; None: it
            follows from x.
    """

    x: Function | None = None
    velocity: Function | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        alone = self.part == "clamp" or (self.part == "wall" and not self.acts)
        if self.velocity and not (self.moves or alone):
            wrong = "velocity is given, and x is not: expected both, or x alone"
            raise InputError(f"{type(self).__name__}: {wrong}")


@dataclass(frozen=True)
class Given(Moving):
    """A face of a gas or a solid at which all unknowns are given.

    Args:
        values: `values(*X, t)` returns rho [kg/m3], d velocities [m/s], T [K] of a gas; d
            velocities [m/s], T [K], d positions [m] of a solid.
        x, velocity: of a face of a gas, as of `Moving`.
    """

    values: Function
    all_given = True
    passes = "gas"


@dataclass(frozen=True)
class Centre(Condition):
    """An axis or a centre, r = 0. It stands at side 0 of the last axis, where `symmetry` is 1 or 2.

    The first node is half a spacing from it. Beyond it is the block's mirror image.
    """


@dataclass(frozen=True)
class Periodic(Condition):
    """A face that goes on at another one, which is `Periodic`, too.

    A block that is periodic in itself has no faces there: `Block(…, periodic=(True, False))`.

    Args:
        shift: d numbers [m]: the other face is this one moved by them.
    """

    shift: Any


@dataclass(frozen=True, kw_only=True)
class NoSlip(Warm, Moving):
    """A wall that a gas sticks to: insulated, of a given temperature, or with a given heat flux.

    Heat as of `Warm`, motion as of `Moving`. With a velocity and no x the wall slides along itself,
    as a lid or a cylinder that turns. A gas without viscosity slips along any wall.

    Args:
        slip_length: length [m] with which the gas slips along the wall, a number or a function of
            (*X, t), no shorter than the distance to the nodes beside the wall: its velocity there
            is this length times its slope (Navier). So it may meet a wall, or a solid, that moves
            along this one. None: it sticks.
    """

    slip_length: Datum = None
    of = ("fluid",)
    part = "wall"

    def without_friction(self) -> Condition:
        """What it is to a gas without viscosity. One that slides along itself is at rest then."""
        motion = {"x": self.x, "velocity": self.velocity} if self.moves else {}
        return Slip(T=self.T, heat_flux=self.heat_flux, **motion)

    @property
    def acts(self) -> bool:
        return self.slip_length is not None

    @staticmethod
    def traction(gas, w, face: FaceNode):
        """The force -mu/l (u - w) |n| across n; w: velocity of the wall, l: the slip length."""
        past = sub(gas.velocity(w), face.wall)
        past = along(past, -dot(past, face.n) / (face.size * face.size), face.n)
        return scale(-gas.mu * gas.transport.viscosity(w[2]) * face.size / face.slip, past)


@dataclass(frozen=True, kw_only=True)
class Slip(Warm, Moving):
    """A wall along which a gas slips, or a plane of symmetry. Heat as of `Warm`, motion as of
    `Moving`. Faces that go on smoothly, or around a convex edge, are one wall.
    """

    of = ("fluid",)
    part = "slip"


@dataclass(frozen=True)
class Outflow(Condition):
    """A face through which gas flows out: F(U_in) passes.

    With a pressure beyond and a Mach number m < 1 through the face it is the flux of Lax and
    Friedrichs, with U_out of density and velocity of U_in and of the pressure
    p + (1 - m^2)(pressure - p); m = 0 where gas flows in.

    Args:
        pressure: pressure beyond [Pa], a number or a function of (*X, t), which is imposed where
            the flow is slower than sound; 0 where it nowhere is.
    """

    pressure: Datum = 0.0
    of = ("fluid",)
    ranges = RANGES | {"pressure": NONNEGATIVE}
    passes = "gas"

    @staticmethod
    def leaving(gas, w, face: FaceNode):
        """F(U_in), or the flux of Lax and Friedrichs."""
        n, g, pressure = face.n, face.g, face.pressure
        m = np.maximum((dot(n, gas.velocity(w)) - g) / face.size, 0.0) / gas.speed_of_sound(w)
        p = w[1] + np.maximum(1.0 - m * m, 0.0) * (pressure - w[1])
        held = gas.state(w[0], gas.velocity(w), gas.law.temperature_of(w[0], p))
        return choose(pressure == 0.0, surface_flux(gas, w, n, g), mixed_flux(gas, w, held, n, g))


@dataclass(frozen=True)
class Open(Condition):
    """An open face of a gas: waves along the normal leave, oblique ones [in part](open-end.md).

    F(U*) passes. U* = U_in where gas leaves faster than sound, U_out where it comes so; else
    p + Z N . u is that inside, p - Z N . u that outside, Z = rho c of the gas inside at the mean
    pressure of both, and rho - p/c^2, c^2 and velocities along the face those of the side that gas
    comes from. If no such gas can be, the flux of Lax and Friedrichs passes.

    Args:
        rho: density of the gas beyond [kg/m3], a number or a function of (*X, t).
        u: its velocity [m/s]: d numbers, or `u(*X, t)`, which returns d arrays.
        T: its temperature [K], likewise.
        order: order of the conditions in viscosity and conduction, 0 or 1.
    """

    rho: Datum
    u: Any
    T: Datum
    order: int = 0
    of = ("fluid",)
    passes = "gas"
    leaving = staticmethod(open_flux)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.order not in (0, 1):
            raise InputError(f"Open: order is {self.order!r}: expected 0 or 1")


@dataclass(frozen=True)
class Clamped(Warm, Moving):
    """A face of a solid that is held, or moves as given.

    Heat as of `Warm`, motion as of `Moving`. With a velocity and no x the face moves so from where
    it is at first.
    """

    of = ("solid",)
    part = "clamp"


@dataclass(frozen=True)
class Free(Warm):
    """A face of a solid under a pressure that follows it. Heat as of `Warm`.

    Args:
        pressure: pressure [Pa] per present area, a number or a function of (*X, t).
    """

    pressure: Datum = 0.0
    of = ("solid",)
    loaded = True

    @property
    def acts(self) -> bool:
        return self.pressure != 0.0


@dataclass(frozen=True)
class Absorbing(Warm):
    """A face beyond which the solid goes on: waves along the normal n leave, of pressure and of
    shear; of oblique ones a part is reflected. Heat as of `Warm`.

    The traction per area at rest is stress n - Z v, Z = sqrt(m0 Q) with the acoustic tensor Q along
    n at the strain there; unstrained, Z has m0 c_p along n and m0 c_s across.

    Source: Lysmer and Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859-877.

    Args:
        stress: normal stress of the solid beyond [Pa], a tension if above 0, a number or a function
            of (*X, t).
    """

    stress: Datum = 0.0
    of = ("solid",)
    loaded = True
    passes = "waves"

    @staticmethod
    def pull(solid, F, T, N, v, stress):
        """stress N - Z v per area at rest."""
        return along(scale(stress, N), -1.0, solid.resistance(F, T, N, v))


@dataclass(frozen=True)
class Roller(Warm):
    """A solid's face that slides without friction; also a plane of symmetry. Heat as of `Warm`."""

    of = ("solid",)
    part = "roller"


@dataclass(frozen=True)
class Hinge(Condition):
    """A held point of a face, in `points` of a `BlockProblem`; the solid may turn about it."""

    of = ()  # no condition of a face
