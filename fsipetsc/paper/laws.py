"""The materials of a case as NamedTuples, whose scalar methods compiled loops call.

A case builds ``Fluid`` and ``Solid`` with laws that are functions of numbers,
fsipetsc.physics.perfect_gas for one: the gas's p(rho, T), e(rho, T), ..., its mu(T)/mu and
kappa(T)/kappa, and the pressure of the solid. Here each law becomes a class of its own that holds
its constants and has its functions for methods: ``gas.law.pressure(rho, T)``.
"""

from __future__ import annotations

from types import CellType, FunctionType
from typing import Any, NamedTuple

from numba.extending import register_jitable

from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.operators.variants import digest
from fsipetsc.physics import own_laws
from fsipetsc.physics.fluid import Fluid
from fsipetsc.physics.material_law import formulas_of
from fsipetsc.physics.solid import Solid

#: functions of a law that become methods
METHODS = (
    {name for name in own_laws.GAS | own_laws.GAS_MORE if name != "constants"}
    | {name for name in own_laws.PRESSING | own_laws.PRESSING_MORE if name != "constants"}
    | set(own_laws.TRANSPORT)
)


class Gas(NamedTuple):
    """mu: 4/3 of the shear viscosity [Pa s]; kappa [W/(m K)]; force: body force per mass [m/s2].

    law: the equation of state, of rho, T, and the internal energy per mass e; transport: what mu
    and kappa are multiplied with.
    """

    law: Any
    transport: Any
    mu: float
    kappa: float
    gamma: float
    force: float

    def viscosity(self, T):
        """mu' = 4/3 mu(T)."""
        return self.mu * self.transport.relative(T)[0]

    def conductivity(self, T):
        """kappa(T)."""
        return self.kappa * self.transport.relative(T)[1]

    def velocity_and_temperature(self, rho, m, E):
        """(u, T) from (rho, rho u, e), the last one per volume."""
        u = m / rho
        return u, self.law.temperature(rho, E / rho - 0.5 * u * u)

    def total_energy(self, rho, u, T):
        """e, per volume."""
        return rho * (self.law.energy(rho, T) + 0.5 * u * u)


class Elastic(NamedTuple):
    """K = 2 mu_e + lambda_e [Pa]; kappa_e [W/(m K)]; m0 [kg/m3]; alpha [J/(kg K)]; force: body
    force per mass [m/s2].

    law: the pressure p of T and x_X.
    """

    law: Any
    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float


def gas_of(material: Fluid) -> Gas:
    """InputError for a law of the user's that cannot be compiled."""
    law, transport = (
        law_of(material.law, material, "gas"),
        law_of(material.transport, material, "transport"),
    )
    return Gas(
        law, transport, 4.0 / 3.0 * material.mu, material.kappa, material.gamma, material.force
    )


def elastic_of(material: Solid) -> Elastic:
    """InputError for a law of the user's that cannot be compiled."""
    law = law_of(material.pressing, material, "pressing")
    return Elastic(law, material.K, material.kappa_e, material.m0, material.alpha, material.force)


def check_entropy(layers: Any) -> None:
    """InputError for a gas law of the user's without a formula for the entropy."""
    for layer in layers:
        law = formulas_of(layer.material.law) if isinstance(layer.material, Fluid) else None
        if not getattr(law, "knows_entropy", True):
            what = "no formula entropy(c, rho, T), which -fsi_entropy and -fsi_check need"
            raise InputError(f"the gas law of layer '{layer.name}' has {what}")


# a class for each law

_classes: dict[str, type] = {}


def law_of(law: Any, material: Fluid | Solid, kind: str) -> Any:
    """A law of a material with its constants: its formulas are methods, of T, rho … alone.

    kind: "gas", "transport" or "pressing". InputError for one that cannot be compiled.
    """
    found = formulas_of(law)
    constants = in_python(found.constants)(material)
    name = f"Law_{digest(found)}"
    if name not in _classes:
        if getattr(found, "own", False):
            own_laws.check(found, kind)
        _classes[name] = globals()[name] = _class(
            name, found
        )  # numba's cache finds the class by its name
    return _classes[name](_floats(constants))


def __getattr__(name: str) -> type:
    """A class for a law of other runs, which numba's cache knows of."""
    if name.startswith("Law_"):
        return type(name, (), {"__module__": __name__})
    raise AttributeError(name)


def _floats(constants: Any) -> Any:
    """The same with floats for numbers."""
    return tuple(map(_floats, constants)) if isinstance(constants, tuple) else float(constants)


def _class(name: str, law: Formulas) -> type:
    base = NamedTuple(name, [("c", Any)])  # noqa: UP014  whose name is made
    methods = {n: _method(_jitable(f, {})) for n, f in vars(law).items() if n in METHODS}
    return type(name, (base,), {**methods, "__slots__": (), "__module__": __name__})


def _method(formula: Any) -> Any:
    def method(self, *values):
        return formula(self.c, *values)

    return method


def _jitable(function: Any, made: dict[int, Any]) -> Any:
    """A compiled function's source, for compiled code and Python, and so are those of this package
    that it calls."""
    plain = getattr(function, "py_func", function)
    if id(plain) not in made:
        scope = plain.__globals__
        called = {n: v for n, v in ((n, scope.get(n)) for n in plain.__code__.co_names) if _ours(v)}
        scope = {**scope, **{n: _jitable(v, made) for n, v in called.items()}}
        cells = tuple(
            CellType(_inner(cell.cell_contents, made)) for cell in plain.__closure__ or ()
        )
        copy = FunctionType(plain.__code__, scope, plain.__name__, plain.__defaults__, cells)
        made[id(plain)] = register_jitable(copy)
    return made[id(plain)]


def _inner(value: Any, made: dict[int, Any]) -> Any:
    return _jitable(value, made) if hasattr(value, "py_func") else value


def _ours(value: Any) -> bool:
    return getattr(getattr(value, "py_func", None), "__module__", "").startswith("fsipetsc.")
