"""Laws of materials that a case file brings: a gas, its viscosity and conductivity, the pressure of a solid, and in two
dimensions its stress.

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
from fsipetsc.physics.plane.layer import PLANE_LAYER

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
ELASTIC = {"stress": "c, F"}
ELASTIC_MORE = {"energy": "c, F", "modulus": "c, F", "constants": "record"}
#: formulas that loops call, with vectors; of stresses all are such
IN_LOOPS = ("relative", "temperature_in_loops", "pressure", "sound_speed_squared_of_energy", "pressure_in_loops")
#: of F, of differences of stress and energy; states at which these are compared
STEP = 2.0**-17
PER_STEP = 2.0**16
STATES = (1.1, 0.05, -0.08, 0.95), (0.9, -0.1, 0.07, 1.05)
#: what formulas return that do not return one number
RETURNED = {
    "relative": (2, "(mu(T)/mu, kappa(T)/kappa), two numbers"),
    "stress": (4, "(P_11, P_12, P_21, P_22), four numbers"),
    "modulus": (2, "(m0 c^2 along X, along Y), two numbers"),
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


def elastic_law(**formulas: Callable[..., Any]) -> Formulas:
    """A law of a solid in two dimensions: what ``law`` of a ``fsipetsc.PlaneSolid`` may be.

    stress(c, F) -> (P_11, P_12, P_21, P_22), dW/dF [Pa] of F = (F_11, F_12, F_21, F_22); energy(c, F) -> W [J/m3], which
    heat="elastic" asks for; modulus(c, F) -> the greatest m0 c^2 [Pa] of waves along X and along Y, by differences of the
    stress if it is missing; constants(record) -> c, (mu_e, lambda_e) if it is missing. What p_ref of the material adds,
    -p_ref (J - 1) to W, is added.
    """
    given = _compiled("elastic_law", ELASTIC, ELASTIC_MORE, formulas)

    @njit(**FORMULA)
    def energy(c, F):
        return np.nan * F[0]

    own_constants = given.get("constants", lame_constants)
    own_stress, own_energy = given["stress"], given.get("energy", energy)

    @njit(**FORMULA)
    def constants(record):
        return own_constants(record), record.p_ref

    @njit(**FORMULA)
    def stress(c, F):
        p11, p12, p21, p22 = own_stress(c[0], F)
        return p11 - c[1] * F[3], p12 + c[1] * F[2], p21 + c[1] * F[1], p22 - c[1] * F[0]

    @njit(**FORMULA)
    def energy_with_pressure(c, F):
        return own_energy(c[0], F) - c[1] * (F[0] * F[3] - F[1] * F[2] - 1.0)

    @njit(**FORMULA)
    def modulus_of_stress(c, F):
        f11, f12, f21, f22 = F
        e = STEP
        a, _, b, _ = own_stress(c, (f11 + e, f12, f21, f22))
        a_, _, b_, _ = own_stress(c, (f11 - e, f12, f21, f22))
        g, _, d, _ = own_stress(c, (f11, f12, f21 + e, f22))
        g_, _, d_, _ = own_stress(c, (f11, f12, f21 - e, f22))
        along_x = greatest(a - a_, 0.5 * ((b - b_) + (g - g_)), d - d_) * PER_STEP
        _, a, _, b = own_stress(c, (f11, f12 + e, f21, f22))
        _, a_, _, b_ = own_stress(c, (f11, f12 - e, f21, f22))
        _, g, _, d = own_stress(c, (f11, f12, f21, f22 + e))
        _, g_, _, d_ = own_stress(c, (f11, f12, f21, f22 - e))
        return along_x, greatest(a - a_, 0.5 * ((b - b_) + (g - g_)), d - d_) * PER_STEP

    own_modulus = given.get("modulus", modulus_of_stress)

    @njit(**FORMULA)
    def modulus(c, F, squared_x, squared_y):
        return own_modulus(c[0], F)

    members = {"constants": constants, "stress": stress, "energy": energy_with_pressure, "modulus": modulus}
    plain = {"constants": own_constants, "stress": own_stress, "energy": own_energy, "modulus": own_modulus}
    return Formulas(**members, plain=Formulas(**plain), knows_energy="energy" in given, own=True)


def check_energy(law: Formulas, material: Any) -> None:
    """InputError if the stress of a law of ``elastic_law`` is not the derivative of its energy, at two states of strain.

    What is no stress, or no energy, is left to ``check``.
    """
    if not law.knows_energy:
        return
    c = in_python(law.constants)(material)
    stress, energy = in_python(law.stress), in_python(law.energy)

    def rise(F: tuple[float, ...], k: int, step: float) -> float:
        more, less = (tuple(f + sign * step * (n == k) for n, f in enumerate(F)) for sign in (1.0, -1.0))
        return (energy(c, more) - energy(c, less)) / (2.0 * step)

    for F in STATES:
        try:
            P = [float(p) for p in stress(c, F)]
            float(energy(c, F))
        except (TypeError, ValueError):
            return
        for k, name in enumerate(("11", "12", "21", "22")):
            slope = (4.0 * rise(F, k, STEP) - rise(F, k, 2.0 * STEP)) / 3.0  # of nearly incompressible solids, too
            if not abs(slope - P[k]) <= 1e-6 * (material.K + max(map(abs, P))):
                where = f"{place_of(in_python(law.plain.stress))}: stress is not the derivative of energy"
                raise InputError(f"{where}: at F = {F}, P_{name} = {P[k]:g}, and energy rises by {slope:g} with F_{name}")


@njit(**FORMULA)
def lame_constants(record):
    """(mu_e, lambda_e)."""
    return record.mu_e, record.lambda_e


@njit(**FORMULA)
def greatest(a, b, d):
    """The greater eigenvalue of ((a, b), (b, d)), or 0 if that is above it."""
    half = 0.5 * (a - d)
    return max(0.5 * (a + d) + np.sqrt(half * half + b * b), 0.0)


def _law(formulas: Formulas, given: dict[str, Any], numbers: Sequence[float] | None) -> Formulas | Law:
    """Formulas with numbers, if there are some: the constants must be the user's, because no other ones look for them."""
    if numbers is None:
        return formulas
    if "constants" not in given:
        raise InputError("numbers of a law: the formula constants(record) is missing, which finds them in the record")
    return Law(formulas, numbers)  # type: ignore[arg-type]  # it looks, and makes a tuple of them


def check(law: Formulas, kind: str, in_loops: Sequence[str] = ()) -> None:
    """Compile each formula of a law that a user has given: InputError, with file and line, where that fails.

    kind: "gas", "transport", "pressing" or "elastic"; in_loops: of formulas that loops call beside those that they always do.
    """
    plain = getattr(law, "of_temperature", None)  # what a user has given, not what calls it
    transport = TRANSPORT if plain else TRANSPORT_OF_RECORD
    pressing, elastic = PRESSING | PRESSING_MORE, ELASTIC | ELASTIC_MORE
    known = {"gas": GAS | GAS_MORE, "transport": transport, "pressing": pressing, "elastic": elastic}[kind]
    record = typeof(np.zeros(1, PLANE_LAYER if kind == "elastic" else LAYER)[0])
    loops = tuple(known) if kind == "elastic" else (*IN_LOOPS, *in_loops)
    c: tuple[Any, ...] = ()
    for name in sorted(known, key=lambda name: name != "constants"):
        function = plain or getattr(law, name)
        if name == "constants":
            c = (_returned(function, (record,), name),)
            continue
        count = len(known[name].split(",")) - len(c)
        for number in (types.float64, vector) if name in loops else (types.float64,):
            argument = types.UniTuple(number, 4) if kind == "elastic" else number
            found = _returned(function, c + (argument,) * count, name)
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
