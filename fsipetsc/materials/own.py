"""Laws that a case file brings: plain functions of numbers, or a NamedTuple class like those here.

They are scalar formulas of +, -, *, /, **, abs and numpy's functions, as np.maximum, without an
``if`` on their arguments, because they are recorded and become C (fsipetsc.kernels). A law with
numbers of its own is an instance of a NamedTuple class with the formulas as methods; one without is
made of functions here.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cache, reduce
from itertools import chain, count, islice
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import described
from fsipetsc.equations.tensors import apply
from fsipetsc.equations.vectors import add, zeros
from fsipetsc.errors import InputError, place_in, place_of, reason
from fsipetsc.kernels.formula import number_of, numbers_of
from fsipetsc.kernels.symbols import NotRecorded, Record, Symbol, derivatives, replay
from fsipetsc.materials.hyperelastic import NeoHookean
from fsipetsc.materials.perfect_gas import PerfectGas
from fsipetsc.materials.power_law import ConstantTransport
from fsipetsc.materials.solid_pressure import ConstantPressure

Formula = Callable[..., Any]
Named = tuple[str, Formula]


class _Gas:
    """What is not given of a gas law."""

    def energy_density(self, rho, T):
        """rho e [J/m3]."""
        return rho * self.internal_energy(rho, T)

    def heat_capacity(self, rho, T):
        """de/dT [J/(kg K)]."""
        return along(self, lambda law, x: law.internal_energy(*x), (rho, T), (0.0, 1.0))

    def bulk_modulus(self, rho, T):
        """rho dp/drho [Pa]."""
        return rho * along(self, lambda law, x: law.pressure(*x), (rho, T), (1.0, 0.0))

    def pressure_by_temperature(self, rho, T):
        """dp/dT [Pa/K]."""
        return along(self, lambda law, x: law.pressure(*x), (rho, T), (0.0, 1.0))

    def sound_speed_squared(self, rho, T):
        """dp/drho + T/(rho^2 cv) (dp/dT)^2 [m2/s2]."""
        slope = self.pressure_by_temperature(rho, T) / rho
        return self.bulk_modulus(rho, T) / rho + T * slope * slope / self.heat_capacity(rho, T)

    def entropy(self, rho, T):
        """No number: the law has none."""
        return np.nan * T


def along(law, formula, numbers, direction):
    """The derivative of formula(law, numbers) along a direction, exactly: the formula is recorded,
    and its derivative follows from that. Numbers of the direction that are floats become constants.
    """
    record, known = Record(), dict[Symbol, Any]()

    def given(value):
        """What stands for a number, or for all of a tuple of them."""
        if isinstance(value, tuple):
            made = [given(part) for part in value]
            return type(value)(*made) if hasattr(value, "_fields") else tuple(made)
        if isinstance(value, (bool, str)) or value is None:
            return value
        symbol = record.given(f"x{len(known)}")
        known[symbol] = value
        return symbol

    step = given(0.0)
    ways = (n if isinstance(n, float) else given(n) for n in direction)
    moved = tuple(given(x) + step * way for x, way in zip(numbers, ways, strict=True))
    found = formula(given(law), moved)
    several = isinstance(found, (tuple, list, np.ndarray))
    slopes = replay(derivatives(found if several else (found,), step), known)
    return tuple(slopes) if several else slopes[0]


def gradient(law, formula, F):
    """The derivatives of formula(law, F) by each number of F."""
    ways = (tuple(float(m == n) for m in range(len(F))) for n in range(len(F)))
    return [along(law, formula, F, way) for way in ways]


class _Solid:
    """What is not given of a solid law."""

    def wave_modulus(self, F):
        """Upper bound of m0 c^2 [Pa]: the largest row of dP/dF."""
        rows = zeros(F)
        for slopes in gradient(self, lambda law, F: law.stress(F), F):
            rows = add(rows, tuple(abs(slope) for slope in slopes))
        return reduce(np.maximum, rows)

    def acoustic_tensor(self, F, N):
        """Q_ik = N_j N_l dP_ij/dF_kl [Pa]."""
        d, columns = len(N), []
        for k in range(d):
            ways = tuple(N[m % d] if m // d == k else 0.0 for m in range(d * d))
            columns.append(apply(along(self, lambda law, F: law.stress(F), F, ways), N))
        return tuple(columns[k][i] for i in range(d) for k in range(d))

    def energy(self, F):
        """None: heat 'elastic' is refused."""
        return 0.0


class _Pressure:
    """What is not given of a pressure of a solid."""

    def pressure_by_temperature(self, J, T, m0, alpha):
        """dp/dT [Pa/K]."""
        way = 0.0, 1.0, 0.0, 0.0
        return along(self, lambda law, x: law.pressure(*x), (J, T, m0, alpha), way)

    def stiffness(self, J, T, m0, alpha):
        """-J dp/dJ [Pa]."""
        way = 1.0, 0.0, 0.0, 0.0
        return -J * along(self, lambda law, x: law.pressure(*x), (J, T, m0, alpha), way)


class Kind(NamedTuple):
    """A kind of law. maker: what makes one of functions. like: a law that has all its formulas.
    derived: those that a case need not give.
    """

    maker: str
    like: type
    derived: type = object

    def forms(self) -> dict[str, str]:
        """Names of all formulas -> their arguments, as in "rho, T"."""
        every = _formulas(self.like).items()
        return {name: ", ".join([*inspect.signature(of).parameters][1:]) for name, of in every}


GAS, SOLID = Kind("gas_law", PerfectGas, _Gas), Kind("solid_law", NeoHookean, _Solid)
TRANSPORT = Kind("transport_law", ConstantTransport)
PRESSURE = Kind("pressure_law", ConstantPressure, _Pressure)


def _formulas(cls: type) -> dict[str, Formula]:
    """The methods of a class by name."""
    names = chain(*(vars(base) for base in reversed(cls.__mro__)))
    every = {name: getattr(cls, name) for name in names if name[0] != "_"}
    return {name: of for name, of in every.items() if isinstance(of, FunctionType)}


def gas_law(**formulas: Formula) -> Any:
    """A gas law of your own, for `Fluid(law=…)`, made of functions of numbers.

    [Materials](materials.md#a-gas-or-transport-law-of-your-own) says what they may use.

    Args:
        formulas: needed are `pressure(rho, T)` [Pa], `internal_energy(rho, T)` [J/kg],
            `temperature(rho, e)` [K], `density(p, T)` [kg/m3], `temperature_of(rho, p)` [K].
            Without `entropy(rho, T)` [J/(kg K)] the law has no entropy. These follow if they are
            missing: `energy_density(rho, T)` [J/m3], `heat_capacity(rho, T)` [J/(kg K)],
            `bulk_modulus(rho, T)`, rho dp/drho at constant T [Pa],
            `pressure_by_temperature(rho, T)` [Pa/K], `sound_speed_squared(rho, T)` [m2/s2].
    """
    return _law_of(GAS, formulas)


def transport_law(viscosity: Formula, conductivity: Formula | None = None) -> Any:
    """A law of viscosity and conductivity of your own, for `Fluid(transport=…)`.

    Args:
        viscosity: `viscosity(T)` returns mu(T)/mu at T [K].
        conductivity: `conductivity(T)` returns kappa(T)/kappa; None: the same function.
    """
    return _law_of(TRANSPORT, {"viscosity": viscosity, "conductivity": conductivity or viscosity})


def solid_law(**formulas: Formula) -> Any:
    """A solid law of your own, for `ElasticSolid(law=…)`, made of functions of numbers.

    [Materials](materials.md#a-stress-of-your-own) says what they may use, and has an example. F and
    P are d*d numbers, row by row. p_ref of the solid is not in it, but on faces.

    Args:
        formulas: `stress(F)` returns P = dW/dF [Pa] and is needed. `energy(F)` returns W [J/m3]; it
            is needed for `heat="elastic"`. `wave_modulus(F)`, the largest m0 c^2 [Pa], and
            `acoustic_tensor(F, N)`, the d*d numbers N_j N_l dP_ij/dF_kl [Pa], follow from the
            stress if they are missing.
    """
    return _law_of(SOLID, formulas)


def pressure_law(pressure: Formula, **more: Formula) -> Any:
    """A law of the pressure of a solid of your own, for `pressing=…` of either solid.

    Args:
        pressure: `pressure(J, T, m0, alpha)` returns p [Pa]: J is the volume over that at rest,
            T [K] the temperature, m0 [kg/m3] the density at rest, alpha [J/(kg K)] the specific
            heat.
        more: of the same arguments `pressure_by_temperature`, dp/dT [Pa/K], and `stiffness`,
            -J dp/dJ [Pa]; they follow from the pressure if they are missing.
    """
    return _law_of(PRESSURE, {"pressure": pressure, **more})


def checked_law(law: Any, what: str, kind: Kind) -> Any:
    """The law, with the formulas that its class lacks; InputError if it is no law of this kind."""
    cls = type(law)
    if not (isinstance(law, tuple) and hasattr(cls, "_fields")):
        raise InputError(f"{what} is {described(law)}: expected what {kind.maker}(…) returns")
    given, names = _formulas(cls), _formulas(kind.like).keys()
    if cls.__module__.startswith("fsipetsc.") and names <= given.keys():
        return law
    _check(what, kind, {name: given[name] for name in names & given.keys()}, "self, ")
    methods = *_formulas(kind.derived).items(), *given.items()
    made = _class(cls.__name__, cls._fields, methods, ())(*_floats([*law]))
    for name, form in kind.forms().items() if kind is not SOLID else ():
        _check_recorded(f"{what}: {name}", getattr(made, name), [0] * (1 + form.count(",")))
    return made


def _floats(of: Any) -> Any:
    """Numbers as floats, also those in tuples; bools say what is recorded, and stay."""
    if isinstance(of, list) or type(of) is tuple:
        return type(of)(map(_floats, of))
    return float(of) if isinstance(of, (int, float)) and not isinstance(of, bool) else of


def knows_entropy(law: Any) -> bool:
    """Whether a gas law has an entropy."""
    return type(law).entropy is not _Gas.entropy


def knows_energy(law: Any) -> bool:
    """Whether a solid law has an energy."""
    return type(law).energy is not _Solid.energy


def check_inverses(law: Any, rho: Any, T: Any, owner: str) -> None:
    """InputError if formulas of a gas law of a case are not inverse to each other at some states.

    rho, T: (n,) densities [kg/m3] and temperatures [K].
    """
    if not hasattr(type(law), "of_case"):
        return
    with np.errstate(all="ignore"):
        p, e = law.pressure(rho, T), law.internal_energy(rho, T)
        pairs = {
            "temperature(rho, internal_energy(rho, T))": (law.temperature(rho, e), T, "T"),
            "temperature_of(rho, pressure(rho, T))": (law.temperature_of(rho, p), T, "T"),
            "density(pressure(rho, T), T)": (law.density(p, T), rho, "rho"),
        }
        for formula, (found, wanted, name) in pairs.items():
            wrong = ~(np.abs(found - wanted) <= 1e-6 * wanted)
            if np.any(wrong):
                at = int(np.argmax(wrong))
                numbers = (np.broadcast_to(a, wrong.shape).flat[at] for a in (rho, T, found))
                where = "at rho = {:.6g}, T = {:.6g} it is {:.6g}".format(*numbers)
                raise InputError(f"{owner}: {formula}: {where}: expected {name}")


def check_solid_law(law: Any, d: int) -> None:
    """InputError if the stress of a law of a case has not d*d numbers or is not dW/dF."""
    if not hasattr(type(law), "of_case"):
        return
    n = d * d
    shapes = {"stress": ((n,), n), "energy": ((n,), 0), "wave_modulus": ((n,), 0)}
    for name, shape in {**shapes, "acoustic_tensor": ((n, d), n)}.items():
        _check_recorded(f"solid_law: {name}", getattr(law, name), *shape)
    F = tuple((np.eye(d).ravel() + 0.03 * np.cos(np.arange(n))).tolist())
    P = law.stress(F)
    if not np.isfinite(P).all():
        raise InputError(f"stress of a solid law is {described(P)} at F = {F}")
    slopes = gradient(law, lambda law, F: law.energy(F), F) if knows_energy(law) else P
    for k, slope in enumerate(slopes):
        if not abs(slope - P[k]) <= 1e-5 * max(*map(abs, P), law.wave_modulus(F)):
            words = f"P[{k}] = {P[k]:g}, and energy rises by {slope:g} with F[{k}]"
            wrong = f"stress is not the derivative of energy: at {F}, {words}"
            raise InputError(f"a solid law: {wrong}")


def _law_of(kind: Kind, formulas: Mapping[str, Formula]) -> Any:
    """A law without numbers, of functions."""
    _check(kind.maker, kind, formulas, "")
    for name, formula in formulas.items() if kind is not SOLID else ():  # F depends on d
        given = [0] * len(inspect.signature(formula).parameters)
        _check_recorded(f"{kind.maker}: {name}", formula, given)
    derived = tuple(_formulas(kind.derived).items())
    return _class(kind.maker, (), derived, tuple(formulas.items()))()


def _check(what: str, kind: Kind, given: Mapping[str, Formula], first: str) -> None:
    """InputError for a formula that is missing, unknown or has not its arguments."""
    forms, derived = kind.forms(), _formulas(kind.derived)
    for name in forms:
        if name not in given and name not in derived:
            raise InputError(f"{what}: the formula {name}({forms[name]}) is missing")
    for name, formula in given.items():
        if name not in forms:
            raise InputError(f"{what}: no formula '{name}': expected {', '.join(forms)}")
        form = f"{name}({first}{forms[name]})"
        if not inspect.isfunction(formula):
            raise InputError(f"{what}: {name} is {described(formula)}: expected a function {form}")
        found = ", ".join(inspect.signature(formula).parameters)
        if found.count(",") != form.count(","):
            raise InputError(f"{what}: {name}({found}): expected {form}")


def _check_recorded(what: str, formula: Formula, given: Sequence[int], wanted: int = 0) -> None:
    """InputError if a formula cannot be recorded, or does not return what it should. given, wanted:
    its arguments and what it returns: 0 for a number, else a tuple of so many numbers.
    """
    record = Record()
    numbers = iter(record.given(f"x{k}") for k in count())
    arguments = [tuple(islice(numbers, n)) if n else next(numbers) for n in given]
    try:
        found = formula(*arguments)
        numbers_of(found, wanted) if wanted else number_of(found)
    except Exception as error:  # of the user's function
        inside = place_in(error)
        told = isinstance(error, NotRecorded) and inside  # the error says where
        place = "" if told else f"{inside or place_of(formula)}: "
        raise InputError(f"{what}: {place}{reason(error)}") from error


@cache
def _class(
    name: str, fields: tuple[str, ...], methods: tuple[Named, ...], functions: tuple[Named, ...]
) -> type:
    """A NamedTuple class of a law of a case, with these formulas; one for the same formulas.
    functions do not take the law.
    """
    made = NamedTuple(name, [(field, Any) for field in fields])
    made.__module__ = __name__
    for key, formula in (*methods, *((key, staticmethod(of)) for key, of in functions)):
        setattr(made, key, formula)
    made.of_case = True
    return made
