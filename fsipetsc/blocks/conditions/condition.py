"""What all conditions at faces have in common, and those of gases and solids alike.

Data are numbers, or functions of place and time: f(*X, t), X the face's nodes in the reference map.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import wraps
from typing import Any, NamedTuple

from fsipetsc.checks import ANY, POSITIVE, function, number
from fsipetsc.errors import InputError

#: f(*X, t) -> an array, or several
Function = Callable[..., Any]
#: a number or f(*X, t) -> an array
Datum = float | Function | None
#: data of d numbers
VECTORS = "u", "shift"
#: what data must be that are numbers or functions
RANGES = {"T": POSITIVE, "rho": POSITIVE, "slip_length": POSITIVE}
RANGES |= dict.fromkeys(("heat_flux", "stress", "pressure"), ANY)
#: column of the record of faces (fsipetsc.scheme.face_kernels) -> names of the data in it
COLUMNS = {"heat": ("heat_flux",), "pressure": ("pressure",), "stress": ("stress",)}
COLUMNS |= {"width": ("slip_length",), "outside": ("rho", "u", "T")}


class FaceNode(NamedTuple):
    """What a formula is given at a node of a face, as symbols.

    n: outward area vector per unit of the reference coordinates, size: |n|; g: n . v of the grid's
    velocity v; wall: v where the face goes with the grid, else 0. The others are data of the
    condition there: beyond: (rho, p, u, T) outside; pressure; width: of the gas behind the face, or
    the slip length; rise: outward derivative of the outward velocity, None where order is 0.
    """

    n: Any
    size: Any
    g: Any
    wall: Any
    beyond: Any
    pressure: Any
    width: Any
    rise: Any


@dataclass(frozen=True)
class Effect:
    """What a condition adds to rates, without its data: faces of one effect share a loop.

    by: the class with its formula, if it has one. heated: heat comes in. moves: the face goes with
    the grid. first_order: viscosity and conduction matter to what leaves.
    """

    by: Any
    heated: bool = False
    moves: bool = False
    first_order: bool = False


class Checked:
    """A dataclass whose data are checked. Numbers become floats; a vector of which a component is a
    function becomes one function.

    ranges: what data must be that are numbers or functions, by name; functions: arguments and
    values of those that are functions.
    """

    ranges = RANGES
    functions: Mapping[str, str] = {}

    def __post_init__(self) -> None:
        name, given = type(self).__name__, set()
        for field in fields(self):  # type: ignore[arg-type]
            key, value, what = field.name, getattr(self, field.name), f"{name}: {field.name}"
            if value is None and field.default is None:
                continue
            given.add(key)
            if key in self.functions:
                function(value, what, key + self.functions[key])
            elif key in self.ranges and not callable(value):
                object.__setattr__(self, key, number(value, what, self.ranges[key]))
            elif key in VECTORS and not callable(value):
                object.__setattr__(self, key, _vector(value, what))
        if {"T", "heat_flux"} <= given:
            raise InputError(f"{name}: T and heat_flux are both given: expected one, or neither")

    @property
    def steady(self) -> bool:
        """Whether no data depend on time."""
        return not any(map(callable, vars(self).values()))


def _vector(value: Any, what: str) -> Any:
    """Numbers and functions as a tuple of numbers, or as one function."""
    items = enumerate(value if isinstance(value, (tuple, list)) else (value,))
    found = [v if callable(v) else number(v, f"{what}[{k}]") for k, v in items]
    functions = [v for v in found if callable(v)]
    if not functions:
        return tuple(found)
    return wraps(functions[0])(lambda *x: [v(*x) if callable(v) else v for v in found])


class Condition(Checked):
    """What stands at a face.

    of: kinds of block that it is for. part: what it is to a particle (fsipetsc.particles.members),
    "wall", "slip", "clamp", "roller". holds: it prescribes motion; all_given: all unknowns. passes:
    "gas" or "waves" where these go through. loaded: the face has a traction of its own, from which
    p_ref of the solid is taken.

    Formulas, None where there is none: leaving(gas, w, face): mass, momentum and energy that leave
    a gas of the state w; traction(gas, w, face): the force on it; pull(solid, F, T, N, v, stress):
    that on a solid per area at rest.
    """

    of: tuple[str, ...] = ("fluid", "solid")
    functions = {  # noqa: RUF012
        "x": "(*X, t) -> d positions",
        "velocity": "(*X, t) -> d velocities",
        "values": "(*X, t) -> the unknowns",
    }
    part = passes = ""
    holds = all_given = loaded = False
    leaving = traction = pull = None

    T = heat_flux = x = velocity = slip_length = None

    def __post_init__(self) -> None:
        super().__post_init__()
        slides_along = self.part == "wall" and not self.acts
        if self.velocity and not self.moves and self.part != "clamp" and not slides_along:
            name = type(self).__name__
            raise InputError(f"{name}: velocity is given, and x is not: expected both, or x alone")

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
        return not (given or self.passes) and getattr(self, "pressure", 0.0) == 0.0

    @property
    def effect(self) -> Effect | None:
        """What it adds to rates, None if nothing."""
        by, heated = type(self) if self.acts else Condition, self.heat_flux is not None
        first_order = getattr(self, "order", 0) == 1
        found = Effect(by, heated, self.acts and self.moves, first_order)
        return found if self.acts or heated else None


@dataclass(frozen=True, kw_only=True)
class Warm(Condition):
    """A face at which heat comes in or out; insulated if neither is given.

    Args:
        T: temperature [K], a number or a function of (*X, t).
        heat_flux: heat flux into the block [W/m2], likewise.
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


@dataclass(frozen=True)
class Given(Moving):
    """A face of a gas or a solid at which all unknowns are given.

    Args:
        values: `values(*X, t)` returns rho [kg/m3], d velocities [m/s], T [K] of a gas; d
            velocities [m/s], T [K], d positions [m] of a solid.
        x, velocity: of a face of a gas, as of `Moving`.
    """

    values: Function
    holds = all_given = True
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
