"""Laws that a case brings, made of plain functions of numbers.

They are scalar formulas of +, -, *, /, **, abs and numpy's functions, as np.maximum, without an
``if`` on their arguments, because they are recorded and become C (fsipetsc.kernels). Numbers in
them become text of the C code. A law whose numbers are data is an instance of a NamedTuple class
with all formulas, as those in this folder.
"""

from collections.abc import Callable, Hashable, Sequence
from functools import cache, partial, reduce, wraps
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import described, number
from fsipetsc.equations.tensors import apply
from fsipetsc.equations.vectors import add
from fsipetsc.errors import InputError, call
from fsipetsc.kernels.symbols import Record, derivative, numbers_of
from fsipetsc.materials.hyperelastic import NeoHookean
from fsipetsc.materials.solid_pressure import NoPressure
from fsipetsc.materials.stiffened_gas import PerfectGas
from fsipetsc.materials.sutherland import ConstantTransport

Formula = Callable[..., Any]
#: kind of law -> what makes one, and a class that has all formulas
GAS, SOLID = ("stiffened_gas or gas_law", PerfectGas), ("solid_law", NeoHookean)
TRANSPORT = "sutherland or transport_law", ConstantTransport


def gradient(formula, F):
    return [derivative(lambda *F: formula(F), F, way) for way in np.eye(len(F)).tolist()]


class OwnGas(NamedTuple):
    """What follows from the functions of a gas law, with names and units as in PerfectGas."""

    energy_density = PerfectGas.energy_density

    def heat_capacity(self, rho, T):
        return derivative(self.internal_energy, (rho, T), (0.0, 1.0))

    def bulk_modulus(self, rho, T):
        return rho * derivative(self.pressure, (rho, T), (1.0, 0.0))

    def pressure_by_temperature(self, rho, T):
        return derivative(self.pressure, (rho, T), (0.0, 1.0))

    def sound_speed_squared(self, rho, T):
        """dp/drho + T/(rho^2 cv) (dp/dT)^2 [m2/s2]."""
        rise = self.pressure_by_temperature(rho, T) / rho
        return self.bulk_modulus(rho, T) / rho + T * rise * rise / self.heat_capacity(rho, T)

    def entropy(self, rho, T):
        """No number: the law has none."""
        return np.nan * T


class OwnSolid(NamedTuple):
    """What follows from the functions of a solid law, as in NeoHookean."""

    def wave_modulus(self, F):
        """Upper bound of m0 c^2 [Pa]: the largest row of dP/dF."""
        sizes = (tuple(map(abs, slopes)) for slopes in gradient(self.stress, F))
        return reduce(np.maximum, reduce(add, sizes))

    def acoustic_tensor(self, F, N):
        d = len(N)
        ways = [[N[m % d] if m // d == k else 0.0 for m in range(d * d)] for k in range(d)]
        columns = [apply(derivative(lambda *F: self.stress(F), F, way), N) for way in ways]
        return tuple(column[i] for i in range(d) for column in columns)

    def energy(self, F):
        """None: heat 'elastic' is refused."""
        return 0.0


def gas_law(
    *,
    pressure: Formula,
    internal_energy: Formula,
    temperature: Formula,
    density: Formula,
    temperature_of: Formula,
    entropy: Formula | None = None,
) -> Any:
    """A gas law of your own, for `Fluid(law=…)`, made of functions of numbers.

    [Materials](materials.md#a-gas-or-transport-law-of-your-own) says what they may use.

    Args:
        pressure: `pressure(rho, T)` [Pa].
        internal_energy: `internal_energy(rho, T)` [J/kg].
        temperature: `temperature(rho, e)` [K].
        density: `density(p, T)` [kg/m3].
        temperature_of: `temperature_of(rho, p)` [K].
        entropy: `entropy(rho, T)` [J/(kg K)]; None: the law has no entropy.
    """
    return _law_of(OwnGas, "gas_law", 2, **locals())


def transport_law(viscosity: Formula, conductivity: Formula | None = None) -> Any:
    """A law of viscosity and conductivity of your own, for `Fluid(transport=…)`.

    Args:
        viscosity: `viscosity(T)` returns mu(T)/mu at T [K].
        conductivity: `conductivity(T)` returns kappa(T)/kappa; None: the same function.
    """
    conductivity = conductivity or viscosity
    return _law_of(ConstantTransport, "transport_law", 1, **locals())


def solid_law(*, stress: Formula, energy: Formula | None = None) -> Any:
    """A solid law of your own, for `ElasticSolid(law=…)`, made of functions of numbers.

    [Materials](materials.md#a-stress-of-your-own) says what they may use, and has an example. F and
    P are d*d numbers, row by row. p_ref of the solid is not in it, but on faces.

    Args:
        stress: `stress(F)` returns P = dW/dF [Pa].
        energy: `energy(F)` returns W [J/m3]; it is needed for `heat="elastic"`.
    """
    return _law_of(OwnSolid, "solid_law", 0, **locals())


def _law_of(kind: type, maker: str, arguments: int, **formulas: Formula | None) -> Any:
    """The law of functions, also of those without a hash, as numpy's polynomials. InputError."""
    unhashed = {k: f for k, f in formulas.items() if callable(f) and not isinstance(f, Hashable)}
    hashed = {k: partial(f) for k, f in unhashed.items()}
    return _cached_law(kind, maker, arguments, **formulas | hashed)


@cache
def _cached_law(kind: type, maker: str, arguments: int, **formulas: Formula | None) -> Any:
    """The law of functions of so many numbers, 0: they are checked later, or None; one law for the
    same functions, so that gases of it may meet. InputError.
    """
    given = {name: formula for name, formula in formulas.items() if formula is not None}
    for name, formula in given.items() if arguments else ():
        _check(f"{maker}: {name}", formula, _symbols(arguments), numbers_of)
    return type(maker, (kind,), {name: staticmethod(formula) for name, formula in given.items()})()


def checked_law(law: Any, what: str, kind: tuple[str, type]) -> Any:
    """The law with floats as its numbers; InputError if it lacks a formula of its kind, or has
    numbers out of its ``ranges``.
    """
    makers, like = kind
    others = {*like._fields, *dir(tuple)}
    names = (name for name in dir(like) if name[0] != "_" and name not in others)
    wrong = [f"has no '{name}'" for name in names if not hasattr(law, name)]
    if wrong or not isinstance(law, tuple):
        found = f"{what} is {described(law)}, which {[*wrong, 'is no NamedTuple'][0]}"
        raise InputError(f"{found}: expected what {makers} returns, or a law like that")
    law = type(law)(*(float(v) if type(v) is int else v for v in law))
    bounds = law.ranges() if hasattr(law, "ranges") else ()
    for name, value, bound in zip(law._fields, law, bounds):
        law = law._replace(**{name: number(value, f"{what}: {name}", bound)})
    return law


def checked_pressure(law: Any, what: str) -> Any:
    """The law of a pressure as `checked_law` has it; InputError, too, if it returns no number."""
    law = checked_law(law, what, ("gruneisen or mie_gruneisen", NoPressure))
    _check(f"{what}: pressure", law.pressure, _symbols(4), numbers_of)
    return law


def knows_entropy(law: Any) -> bool:
    return type(law).entropy is not OwnGas.entropy


def knows_energy(law: Any) -> bool:
    return type(law).energy is not OwnSolid.energy


@np.errstate(all="ignore")
def check_inverses(law: Any, rho: Any, T: Any, owner: str) -> None:
    """InputError if formulas of a gas law of a case are not inverse to each other at some states.

    rho, T: (n,) densities [kg/m3] and temperatures [K].
    """
    p, e = law.pressure(rho, T), law.internal_energy(rho, T)
    _agree(f"{owner}: temperature(rho, internal_energy(rho, T))", law.temperature(rho, e), T)
    _agree(f"{owner}: temperature_of(rho, pressure(rho, T))", law.temperature_of(rho, p), T)
    _agree(f"{owner}: density(pressure(rho, T), T)", law.density(p, T), rho)


@np.errstate(all="ignore")
def check_transport(law: Any, T: Any, owner: str) -> None:
    """InputError if viscosity or conductivity is below 0, or no number, at some T (n,) [K]."""
    for name in ("viscosity", "conductivity"):
        found = np.broadcast_to(getattr(law, name)(T), np.shape(T))
        for i in np.flatnonzero(~(found >= 0.0))[:1]:
            said = f"{name}({T[i]:g}) is {found[i]:g}"
            raise InputError(f"{owner}: {said}: expected a number that is not below 0")


@np.errstate(all="ignore")
def check_solid_law(law: Any, d: int) -> None:
    """InputError if the stress of a law of a case has not d*d numbers or is not dW/dF."""
    if not isinstance(law, OwnSolid):
        return
    n = d * d
    F = tuple((np.eye(d).ravel() + 0.03 * np.cos(np.arange(n))).tolist())
    nodes = [np.full(2, entry) for entry in F]

    def of_nodes(found: Any) -> Any:
        return np.broadcast_arrays(*(found if isinstance(found, tuple) else (found,)), nodes[0])

    for name, count in ("stress", n), ("energy", 0):
        what, formula = f"solid_law: {name}", getattr(law, name)
        _check(what, formula, [_symbols(n)], partial(numbers_of, count=count))
        _check(f"{what} of entries that are arrays", formula, [tuple(nodes)], of_nodes)
    P = law.stress(F)
    slopes = gradient(law.energy, F) if knows_energy(law) else P
    wrong = f"solid_law: stress is not the derivative of energy: at F = {F} that"
    _agree(wrong, slopes, P, 1e-5 * max(*map(abs, P), law.wave_modulus(F)))


def _agree(what: str, found: Any, wanted: Any, least: Any = 0.0) -> None:
    """InputError if numbers differ by more than a part of 1e-6 of those wanted, and ``least``."""
    found, wanted, least = np.broadcast_arrays(found, wanted, least)
    wrong = ~(np.abs(found - wanted) <= 1e-6 * np.abs(wanted) + least)  # also what is no number
    if wrong.any():
        raise InputError(f"{what} is {found[wrong][0]:.6g}: expected {wanted[wrong][0]:.6g}")


def _symbols(count: int) -> tuple[Any, ...]:
    return tuple(map(Record().given, (f"x{k}" for k in range(count))))


def _check(what: str, formula: Formula, given: Sequence[Any], returns: Formula) -> None:
    """InputError if a formula cannot take what is given, or ``returns`` refuses what it returns."""
    call(wraps(formula)(lambda *numbers: returns(formula(*numbers))), tuple(given), what)
