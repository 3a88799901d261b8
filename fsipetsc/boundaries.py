"""What can stand at the outer ends of the chain of layers.

In the paper's method (fsipetsc.paper.ends) a gas ends at an embedded boundary at a fixed Eulerian
position x: the moving grid reaches over it to one ghost point outside. A solid ends at a material
point.
"""

from collections.abc import Callable
from dataclasses import dataclass

from fsipetsc import checks
from fsipetsc.errors import InputError

#: what is asked of the heat at an end
INSULATED, GIVEN_T, GIVEN_FLUX = 0, 1, 2
INTERFACE_END = -1
WALL, OPEN, DIRICHLET = 0, 1, 2
CLAMPED, FREE, ABSORBING = 10, 11, 12
#: a number, or a function of time
Timed = float | Callable[[float], float]


@dataclass(frozen=True)
class Wall:
    """No-slip wall at the Eulerian position x [m]: adiabatic, of temperature T [K], or with a heat
    flux [W/m2] into the gas.

    x, T, heat_flux: numbers or functions of t [s], from t = 0 to the end of the run. velocity:
    function of t, [m/s], of a wall that moves: the derivative of x; else it is taken from
    differences of x(t). A wall that moves, or does not insulate, needs a stretched gas layer, and
    makes it one. Heat matters only to a gas that conducts it. InputError for what is of the wrong
    kind.
    """

    x: Timed
    T: Timed | None = None
    heat_flux: Timed | None = None
    velocity: Callable[[float], float] | None = None
    kind = WALL
    degree = 2

    def __post_init__(self) -> None:
        _check(self, "Wall", "x", "x")
        checks.function(self.velocity, "Wall: velocity", "velocity(t) [m/s]", optional=True)
        if self.velocity is not None and not self.moves:
            expected = "expected a function x(t) [m], too"
            raise InputError(f"Wall: velocity is given, but x is a number: {expected}")

    @property
    def moves(self) -> bool:
        """The wall does not stay where it is."""
        return callable(self.x)


@dataclass(frozen=True)
class Open:
    """Open end at x [m] towards gas of pressure p0 [Pa], temperature T0 [K] and velocity u0 [m/s];
    see docs/open-end.md.

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
        positive, any_ = checks.POSITIVE, checks.ANY
        checks.numbers(self, "Open", {"x": any_, "p0": positive, "T0": positive, "u0": any_})
        if self.order not in (0, 1):
            expected = "expected 0 or 1, the order of the conditions in the viscosity"
            raise InputError(f"Open(order={self.order!r}): {expected}")


@dataclass(frozen=True)
class Dirichlet:
    """Given rho, u, T at x [m]: values(t) -> (rho, u, T) in kg/m3, m/s, K; see docs/open-end.md.

    degree: of the embedded-boundary formula, 2 to 5; None: see ``degree_of``. InputError for what
    is not valid.
    """

    x: float
    values: Callable[[float], tuple[float, float, float]]
    degree: int | None = None
    kind = DIRICHLET

    def __post_init__(self) -> None:
        checks.numbers(self, "Dirichlet", {"x": checks.ANY})
        checks.function(self.values, "Dirichlet: values", "values(t) -> (rho, u, T)")
        if self.degree not in (None, 2, 3, 4, 5):
            expected = "expected 2, 3, 4, 5, or None: by -fsi_order"
            raise InputError(f"Dirichlet(degree={self.degree!r}): {expected}")


@dataclass(frozen=True)
class SolidEnd:
    """Outer end of a solid. kind CLAMPED: velocity value [m/s]; FREE, ABSORBING: stress sigma - p
    = value [Pa].

    Insulated, or of temperature T [K], or with a heat flux [W/m2] into the solid. All numbers or
    functions of t [s]. InputError for what is neither.
    """

    kind: int
    value: Timed
    T: Timed | None = None
    heat_flux: Timed | None = None
    degree = 0

    def __post_init__(self) -> None:
        name = {CLAMPED: "clamped", FREE: "free", ABSORBING: "absorbing"}[self.kind]
        _check(self, name, "value", "velocity" if self.kind == CLAMPED else "stress")


Boundary = Wall | Open | Dirichlet | SolidEnd


def clamped(
    velocity: Timed = 0.0, *, T: Timed | None = None, heat_flux: Timed | None = None
) -> SolidEnd:
    """Solid end that moves with a given velocity [m/s]; see SolidEnd."""
    return SolidEnd(CLAMPED, velocity, T, heat_flux)


def free(
    stress: Timed = 0.0, *, T: Timed | None = None, heat_flux: Timed | None = None
) -> SolidEnd:
    """Solid end under a given stress sigma - p [Pa]; see SolidEnd."""
    return SolidEnd(FREE, stress, T, heat_flux)


def absorbing(
    stress: Timed = 0.0, *, T: Timed | None = None, heat_flux: Timed | None = None
) -> SolidEnd:
    """Solid end that lets elastic waves out, towards a solid at rest under this sigma - p [Pa]; see
    SolidEnd.
    """
    return SolidEnd(ABSORBING, stress, T, heat_flux)


def _check(end: Wall | SolidEnd, owner: str, needed: str, argument: str) -> None:
    """InputError if what is given is neither a number within its range nor a function; numbers
    become floats. argument: what a user calls the needed one.
    """
    if end.T is not None and end.heat_flux is not None:
        expected = "expected one of them, or neither for an insulated end"
        raise InputError(f"{owner}: T and heat_flux are given: {expected}")
    for name in (needed, "T", "heat_flux"):
        value, bound = getattr(end, name), checks.POSITIVE if name == "T" else checks.ANY
        if not callable(value) and (name == needed or value is not None):
            said = f"{owner}: {argument if name == needed else name}"
            object.__setattr__(end, name, checks.number(value, said, bound))


def degree_of(end: Boundary, order: int) -> int:
    """Degree of the formulas of an end with the operator of this interior order.

    Unless the end says: 2, 3, 4, 5 for the orders 2, 4, 6, 8, one more than the closures are exact
    to. A degree less spoils the order, one more gains nothing.
    """
    return order // 2 + 1 if end.degree is None else end.degree


def heat_of(end: Boundary) -> tuple[int, Timed]:
    """(INSULATED, GIVEN_T or GIVEN_FLUX, what is given) at an end."""
    for kind, name in ((GIVEN_T, "T"), (GIVEN_FLUX, "heat_flux")):
        value = getattr(end, name, None)
        if value is not None:
            return kind, value
    return INSULATED, 0.0


def in_time(end: Boundary) -> bool:
    """Whether something that is given at an end is a function of time."""
    return any(map(callable, vars(end).values()))


def closes(end: Boundary) -> bool:
    """Whether neither mass nor energy goes through an end."""
    if heat_of(end)[0] != INSULATED or in_time(end):
        return False
    solid = isinstance(end, SolidEnd) and end.kind != ABSORBING and end.value == 0.0
    return solid or isinstance(end, Wall)
