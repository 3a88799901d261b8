"""Laws of materials that a case file in one dimension brings: a gas, its viscosity and conductivity, the pressure of a solid.

Of blocks: fsipetsc.materials.own.

A law is functions of numbers that numba can compile: they are compiled for numbers and for vectors of points
(fsipetsc.operators.vectors), so they have no ``if`` on their arguments; +, -, *, /, ** and numpy's sqrt, exp and log do. c is
what ``constants(record)`` returns; the record has the numbers of the material, and as gas_numbers, transport_numbers or
pressing_numbers those that are given to the law as ``numbers`` (fsipetsc.physics.material_law), which are not compiled in.
All raise InputError, with file and line, for what is no function of the right arguments.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numba import njit, typeof, types

from fsipetsc.blame import compilers_words, place_of, place_of_error
from fsipetsc.checks import described
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.vectors import vector
from fsipetsc.physics import constant_transport, gruneisen, perfect_gas
from fsipetsc.physics.layer import LAYER
from fsipetsc.physics.material_law import Law

#: what a law of each kind must have, and what follows if it is not given: name -> arguments
TRANSPORT = {"relative": "T"}
#: the same where the law has constants
TRANSPORT_OF_RECORD = {"relative": "c, T", "constants": "record"}
GAS = {
    "temperature": "c, rho, e",
    "energy": "c, rho, T",
    "pressure": "c, rho, T",
    "density": "c, p, T",
    "temperature_of_pressure": "c, rho, p",
    "heat_capacity": "c, rho, T",
    "pressure_by_temperature": "c, rho, T",
    "bulk_modulus": "c, rho, T",
}
GAS_MORE = {
    "constants": "record",
    "temperature_in_loops": "c, rho, e",
    "sound_speed_squared": "c, rho, T",
    "sound_speed_squared_of_energy": "c, rho, e",
    "pressure_of_energy": "c, rho, E",
    "bulk_modulus_of_energy": "c, rho, E",
    "entropy": "c, rho, T",
}
PRESSING = {"pressure": "c, T, x_X", "pressure_by_temperature": "c, T, x_X", "stiffness": "c, T, x_X"}
PRESSING_MORE = {
    "constants": "record",
    "pressure_in_loops": "c, T, stretch",
    "wave_modulus": "c, K, heat, T, p, sigma, x_X",
}
#: formulas that loops call, with vectors; of stresses all are such
IN_LOOPS = ("relative", "temperature_in_loops", "pressure", "sound_speed_squared_of_energy", "pressure_in_loops")
#: what formulas return that do not return one number
RETURNED = {
    "relative": (2, "(mu(T)/mu, kappa(T)/kappa), two numbers"),
}


def transport_law(
    relative: Callable[..., Any], constants: Callable[..., Any] | None = None, numbers: Sequence[float] | None = None
) -> Formulas | Law:
    """A law of what mu and kappa of the material are multiplied with: relative(T) -> (of mu, of kappa), T in K.

    With constants(record) -> c, it is relative(c, T).
    """
    if constants is not None:
        given = _compiled("transport_law", TRANSPORT_OF_RECORD, {}, {"relative": relative, "constants": constants})
        return _law(Formulas(**given, own=True), given, numbers)
    given = _compiled("transport_law", TRANSPORT, {}, {"relative": relative})
    of_temperature = given["relative"]

    @njit(**FORMULA)
    def of_record(c, T):
        return of_temperature(T)

    law = Formulas(constants=constant_transport.constants, relative=of_record, of_temperature=of_temperature, own=True)
    return _law(law, given, numbers)


def gas_law(*, numbers: Sequence[float] | None = None, **formulas: Callable[..., Any]) -> Formulas | Law:
    """A law of a gas; what each formula is, says fsipetsc.physics.perfect_gas.

    Those of GAS are needed; the others follow from them but for the entropy, which is not a number without a formula.
    """
    given = _compiled("gas_law", GAS, GAS_MORE, formulas)
    temperature, pressure = given["temperature"], given["pressure"]
    heat_capacity, bulk_modulus = given["heat_capacity"], given["bulk_modulus"]
    pressure_by_temperature = given["pressure_by_temperature"]

    @njit(**FORMULA)
    def sound_speed_squared(c, rho, T):
        p_T = pressure_by_temperature(c, rho, T)
        return bulk_modulus(c, rho, T) / rho + T * p_T * p_T / (rho * rho * heat_capacity(c, rho, T))

    of_T = given.get("sound_speed_squared", sound_speed_squared)

    @njit(**FORMULA)
    def sound_speed_squared_of_energy(c, rho, e):
        return of_T(c, rho, temperature(c, rho, e))

    @njit(**FORMULA)
    def pressure_of_energy(c, rho, E):
        return pressure(c, rho, temperature(c, rho, E / rho))

    @njit(**FORMULA)
    def bulk_modulus_of_energy(c, rho, E):
        return bulk_modulus(c, rho, temperature(c, rho, E / rho))

    @njit(**FORMULA)
    def entropy(c, rho, T):
        return np.nan * T

    follows = {
        "constants": perfect_gas.constants,
        "temperature_in_loops": temperature,
        "sound_speed_squared": sound_speed_squared,
        "sound_speed_squared_of_energy": sound_speed_squared_of_energy,
        "pressure_of_energy": pressure_of_energy,
        "bulk_modulus_of_energy": bulk_modulus_of_energy,
        "entropy": entropy,
    }
    return _law(Formulas(**{**follows, **given}, knows_entropy="entropy" in given, own=True), given, numbers)


def pressure_law(*, numbers: Sequence[float] | None = None, **formulas: Callable[..., Any]) -> Formulas | Law:
    """A law of the pressure of a solid; what each formula is, says fsipetsc.physics.gruneisen.

    Those of PRESSING are needed; the others follow from them.
    """
    given = _compiled("pressure_law", PRESSING, PRESSING_MORE, formulas)
    pressure, stiffness = given["pressure"], given["stiffness"]
    pressure_by_temperature = given["pressure_by_temperature"]

    @njit(**FORMULA)
    def pressure_in_loops(c, T, stretch):
        return pressure(c, T, 1.0 / stretch)

    @njit(**FORMULA)
    def wave_modulus(c, K, heat, T, p, sigma, x_X):
        heating = x_X * pressure_by_temperature(c, T, x_X) / heat
        return (K + stiffness(c, T, x_X) + heating * (p - sigma)) / x_X

    follows = {
        "constants": gruneisen.constants,
        "pressure_in_loops": pressure_in_loops,
        "wave_modulus": wave_modulus,
    }
    return _law(Formulas(**{**follows, **given}, own=True), given, numbers)


def _law(formulas: Formulas, given: dict[str, Any], numbers: Sequence[float] | None) -> Formulas | Law:
    """Formulas with numbers, if there are some: the constants must be the user's, because no other ones look for them."""
    if numbers is None:
        return formulas
    if "constants" not in given:
        raise InputError("numbers of a law: the formula constants(record) is missing, which finds them in the record")
    return Law(formulas, numbers)  # type: ignore[arg-type]  # it looks, and makes a tuple of them


def check(law: Formulas, kind: str, in_loops: Sequence[str] = ()) -> None:
    """Compile each formula of a law that a user has given: InputError, with file and line, where that fails.

    kind: "gas", "transport" or "pressing"; in_loops: of formulas that loops call beside those that they always do.
    """
    plain = getattr(law, "of_temperature", None)  # what a user has given, not what calls it
    transport = TRANSPORT if plain else TRANSPORT_OF_RECORD
    known = {"gas": GAS | GAS_MORE, "transport": transport, "pressing": PRESSING | PRESSING_MORE}[kind]
    record = typeof(np.zeros(1, LAYER)[0])
    loops = (*IN_LOOPS, *in_loops)
    c: tuple[Any, ...] = ()
    for name in sorted(known, key=lambda name: name != "constants"):
        function = plain or getattr(law, name)
        if name == "constants":
            c = (_returned(function, (record,), name),)
            continue
        count = len(known[name].split(",")) - len(c)
        for number in (types.float64, vector) if name in loops else (types.float64,):
            found = _returned(function, c + (number,) * count, name)
            size, wanted = RETURNED.get(name, (1, "a number"))
            parts = (found,) if size == 1 else tuple(getattr(found, "types", ()))
            if not (all(map(_is_number, parts)) and len(parts) == size):
                raise InputError(f"{place_of(in_python(function))}: {name} returns {_in_words(found)}: expected {wanted}")


def _is_number(kind: Any) -> bool:
    """Whether a type is that of a number or a vector."""
    return isinstance(kind, (types.Float, types.Integer)) or kind == vector


def _in_words(kind: Any) -> str:
    if kind == types.none:
        return "nothing (is its return missing?)"
    return f"{len(kind)} values" if isinstance(kind, types.BaseTuple) else f"a value of the type {kind}"


def _returned(function: Any, arguments: tuple[Any, ...], name: str) -> Any:
    """The type that a formula returns for arguments of these types."""
    try:
        function.compile(arguments)
        return function.overloads[arguments].signature.return_type
    except Exception as error:  # numba's, of many kinds
        plain = in_python(function)
        vectors = any(vector in (a, getattr(a, "dtype", None)) for a in arguments)
        of = "vectors of points" if vectors else "numbers"
        words = f"{name} cannot be compiled for {of}: {compilers_words(error)}"
        raise InputError(f"{place_of_error(error, plain)}: {words}") from error


def _compiled(
    what: str, needed: dict[str, str], more: dict[str, str], formulas: dict[str, Callable[..., Any]]
) -> dict[str, Any]:
    """The formulas as compiled code calls them, after a look at their names and arguments."""
    known = {**needed, **more}
    for name in (*formulas, *needed):
        if name not in known:
            raise InputError(f"{what}: there is no formula '{name}': expected {', '.join(known)}")
        if name not in formulas:
            raise InputError(f"{what}: the formula {name}({known[name]}) is missing")
    found = {}
    for name, function in formulas.items():
        plain = in_python(function)
        if not inspect.isfunction(plain):
            raise InputError(f"{what}: {name} is {described(function)}: expected a function {name}({known[name]})")
        count, wanted = len(inspect.signature(plain).parameters), len(known[name].split(","))
        if count != wanted:
            form = f"{name}({known[name]})"
            raise InputError(f"{place_of(plain)}: {name} of {what} takes {count} argument{'s' * (count != 1)}: expected {form}")
        ours = plain.__module__.startswith("fsipetsc.") and plain is not function
        found[name] = function if ours else njit(**{**FORMULA, "_nrt": True})(plain)  # it may make arrays
    return found
