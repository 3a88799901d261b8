"""What can stand at the outer ends of layers in one dimension. An end says which condition of a
block it is, and what it gives to the paper's method (fsipetsc.paper.ends).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any

from fsipetsc.blocks import conditions

#: a number, or a function of time
Timed = float | Callable[[float], Any]


class Boundary(conditions.Checked):
    """What stands at an outer end of a kind of layer, ``of``.

    given: names of data beside heat and the place. degree: of the formulas of an embedded boundary;
    0: by the order of the operator.
    """

    of = "fluid"
    given: tuple[str, ...] = ()
    degree = 2

    @property
    def heated(self) -> str:
        """Which of T and heat_flux is given, by name; "" where the end is insulated."""
        names = (name for name in ("T", "heat_flux") if getattr(self, name, None) is not None)
        return next(names, "")

    def condition(self, material: Any) -> conditions.Condition:
        """The condition of a block of this material that this is."""
        raise NotImplementedError

    def data(self, ask: Callable[[str, Sequence[str]], Any]) -> list[Any]:
        """Five: all of ``given``, of `values` rho, u, T; then zeros; at last the temperature [K] or
        heat flux [W/m2]. ask(name, names): a datum, or so many.
        """
        several, found = {"values": ("rho", "u", "T")}, list[Any]()
        for name in self.given:
            value = ask(name, several.get(name, ()))
            found.extend(value if name in several else [value])
        return [*found, *[0.0] * (4 - len(found)), ask(self.heated, ()) if self.heated else 0.0]

    def _of_place(self, name: str, then: Callable[[Any], Any] = lambda v: v) -> Any:
        """A datum as a condition has it, changed by ``then``; a function of t gets X, too."""
        given = getattr(self, name)
        if not callable(given):
            return None if given is None else then(given)
        called = wraps(given)(lambda X, t: then(given(t)))
        called.owner = type(self).__name__  # type: ignore[attr-defined]
        return called

    def _warm(self) -> dict[str, Any]:
        return {name: self._of_place(name) for name in ("T", "heat_flux")}


@dataclass(frozen=True)
class Wall(Boundary):
    """A wall that a gas sticks to: insulated, of a given temperature, or with a given heat flux.

    All data are numbers, or functions of t [s] from 0 to the end of the run. A wall that moves, or
    does not insulate, needs `-fsi_coupling conservative`. Unless a gas conducts, heat stays there.

    Args:
        x: position [m].
        T: temperature [K]; None: it is not given.
        heat_flux: heat flux into the gas [W/m2]; None: it is not given.
        velocity: of a wall that moves [m/s], the derivative of x; None: it follows from x.
    """

    x: Timed
    T: Timed | None = None
    heat_flux: Timed | None = None
    velocity: Callable[[float], Any] | None = None
    functions = ("velocity",)

    @property
    def moves(self) -> bool:
        """The wall does not stay where it is."""
        return callable(self.x) or self.velocity is not None

    def condition(self, material: Any) -> conditions.Condition:
        x = self._of_place("x", lambda x: (x,)) if callable(self.x) else None
        velocity = self._of_place("velocity", lambda u: (u,))
        return conditions.NoSlip(**self._warm(), x=x, velocity=velocity)


@dataclass(frozen=True)
class Open(Boundary):
    """An open end of a gas, through which waves leave; [how](open-end.md).

    Args:
        x: position [m].
        p0: pressure of the gas beyond [Pa].
        T0: its temperature [K].
        u0: its velocity [m/s].
        order: order of the conditions in viscosity and conduction, 0 or 1.
    """

    x: float
    p0: float
    T0: float
    u0: float = 0.0
    order: int = 1
    given = "p0", "T0", "u0", "order"
    fixed = "x", "p0", "T0", "u0"

    def __post_init__(self) -> None:
        super().__post_init__()
        conditions.Open(self.p0, self.u0, self.T0, self.order)  # checks the order

    def condition(self, material: Any) -> conditions.Condition:
        rho = float(material.gas_law.density(self.p0, self.T0))
        return conditions.Open(rho, (self.u0,), self.T0, self.order)


@dataclass(frozen=True)
class Dirichlet(Boundary):
    """An end of a gas at which all unknowns are given; [how many are imposed](open-end.md).

    Args:
        x: position [m].
        values: `values(t)` returns rho [kg/m3], u [m/s], T [K] at t [s].
    """

    x: float
    values: Callable[[float], Sequence[Any]]
    given = ("values",)
    degree = 0
    functions = ("values",)
    fixed = ("x",)

    def condition(self, material: Any) -> conditions.Condition:
        return conditions.Given(self._of_place("values"))


@dataclass(frozen=True, kw_only=True)
class SolidEnd(Boundary):
    """An outer end of a solid: `clamped(…)`, `free(…)` or `absorbing(…)`.

    All data are numbers, or functions of t [s]. Without T and heat_flux the end is insulated.

    Args:
        T: temperature [K]; None: it is not given.
        heat_flux: heat flux into the solid [W/m2]; None: it is not given.
    """

    T: Timed | None = None
    heat_flux: Timed | None = None
    of = "solid"


@dataclass(frozen=True)
class clamped(SolidEnd):
    """An end of a solid that moves with a given velocity. T and heat_flux: see `SolidEnd`.

    Args:
        velocity: velocity [m/s].
    """

    velocity: Timed = 0.0
    given = ("velocity",)

    def condition(self, material: Any) -> conditions.Condition:
        velocity = self._of_place("velocity", lambda u: (u,))
        moving = velocity if callable(velocity) else lambda X, t: velocity
        return conditions.Clamped(velocity=moving if velocity != (0.0,) else None, **self._warm())


@dataclass(frozen=True)
class free(SolidEnd):
    """An end of a solid under a given stress. T and heat_flux: see `SolidEnd`.

    Args:
        stress: sigma - p [Pa]; under an outer pressure p0 it is -p0.
    """

    stress: Timed = 0.0
    given = ("stress",)

    def condition(self, material: Any) -> conditions.Condition:
        return conditions.Free(self._of_place("stress", lambda stress: -stress), **self._warm())


@dataclass(frozen=True)
class absorbing(SolidEnd):
    """An end of a solid that lets elastic waves out. T and heat_flux: see `SolidEnd`.

    Args:
        stress: sigma - p of the solid at rest beyond [Pa].
    """

    stress: Timed = 0.0
    given = ("stress",)

    def condition(self, material: Any) -> conditions.Condition:
        return conditions.Absorbing(self._of_place("stress"), **self._warm())
