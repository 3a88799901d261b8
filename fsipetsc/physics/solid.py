"""Elastic (elastic-plastic) solid in Lagrangian coordinates, (3.1) and (4.19).

    u_t         = (sigma - p)_X / m0 + force
    sigma_t     = K / x_X u_X,                                   K = 2 mu_e + lambda_e
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t         = u

with p(epsilon, rho) an equation of state in epsilon = alpha T and rho = m0 / x_X; p = 0 is the elastic solid.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numba import njit

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, Array, numbers
from fsipetsc.errors import InputError
from fsipetsc.operators.formulas import Formulas, in_python
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.vectors import fma
from fsipetsc.physics.gruneisen import gruneisen as gruneisen_pressure
from fsipetsc.physics.layer import SOLID
from fsipetsc.physics.material_law import Law, check_law, formulas_of, numbers_of


@dataclass(frozen=True)
class Solid:
    """Linear elastic material, with the pressure p = gruneisen * rho * epsilon, or that of another law.

    K: 2 mu_e + lambda_e [Pa]; kappa_e: heat conductivity [W/(m K)]; m0: density in the reference configuration
    [kg/m3]; alpha: specific heat [J/(kg K)]; force: body force per mass [m/s2]; gruneisen: [-];
    pressing: the law of the pressure, as ``gruneisen``, stiffened_gas(…) or mie_gruneisen(…). InputError for what is no number
    or out of range, and for gruneisen beside a law with numbers of its own.
    """

    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float = 0.0
    gruneisen: float = 0.0
    pressing: Formulas | Law = gruneisen_pressure

    def __post_init__(self) -> None:
        ranges = {"K": POSITIVE, "kappa_e": NONNEGATIVE, "m0": POSITIVE, "alpha": POSITIVE}
        numbers(self, "Solid", {**ranges, "force": ANY, "gruneisen": NONNEGATIVE})
        check_law(self.pressing, "Solid: pressing", "wave_modulus", "what pressure_law(…) returns")
        if isinstance(self.pressing, Law) and self.gruneisen != 0.0:
            raise InputError(f"Solid: gruneisen is {self.gruneisen:g} beside pressing, which has its own numbers: expected 0")

    @property
    def pressing_numbers(self) -> tuple[float, ...]:
        """Those of the law of pressure, as in a record."""
        return numbers_of(self.pressing)

    def sound_speed(self, x_X: float = 1.0, T: float = 0.0, sigma: float = 0.0) -> float:
        """Speed of the elastic waves in Lagrangian coordinates [m/s]; T and sigma matter where there is a pressure."""
        p, heat = self.pressure(T, x_X), self.alpha * self.m0
        return float(self._of_law("wave_modulus", self.K, heat, T, p, sigma, x_X) / self.m0) ** 0.5

    def pressure(self, T: float | Array, x_X: float | Array) -> Any:
        """p [Pa] at temperature T [K] and strain x_X; that of p(epsilon, rho) with epsilon = alpha T, rho = m0 / x_X."""
        return self._of_law("pressure", T, x_X)

    def _of_law(self, name: str, *values: Any) -> Any:
        """A formula of the law of pressure, by numpy."""
        law = formulas_of(self.pressing)
        return in_python(getattr(law, name))(in_python(law.constants)(self), *values)


@njit(**FORMULA)
def constants(law, layer):
    """(those of the law of pressure, force, K, 1/(alpha m0))."""
    return law.pressing.constants(layer), layer.force, layer.K, 1.0 / (layer.alpha * layer.m0)


@njit(**FORMULA)
def nothing(law, constants, q):
    """The derivatives are of unknowns alone."""
    return ()


@njit(**FORMULA)
def nowhere(layer, s, v, begin, end):
    """No values are prescribed."""


@njit(**FORMULA)
def gradients(law, layer, q, v):
    """x_X and kappa_e T_X."""
    return (q[3], q[2]), (1.0 / layer.h, layer.kappa_e / layer.h)


@njit(**FORMULA)
def flux(law, constants, i, q, v, gradients):
    """(1/x_X, sigma - p, kappa_e/x_X T_X)."""
    _, sigma, T, _ = q
    x_X, conduction = gradients
    stretch = 1.0 / x_X
    return stretch, sigma - law.pressing.pressure_in_loops(constants[0], T, stretch), conduction * stretch


@njit(**FORMULA)
def divergences(law, layer, q, f):
    """(sigma - p)_X / m0, u_X and the heat that is conducted."""
    return (f[1], q[0], f[2]), (1.0 / (layer.h * layer.m0), 1.0 / layer.h, 1.0 / layer.h)


@njit(**FORMULA)
def rate(law, constants, q, f, derivatives):
    """(u, sigma, T, x)_t."""
    _, force, K, per_heat = constants
    stretch, net, _ = f
    acceleration, u_X, heating = derivatives
    return acceleration + force, K * u_X * stretch, fma(net, u_X, heating) * per_heat, q[0]


def elastic_solid(pressing: Formulas, undivided: tuple[Formulas, ...] = ()) -> Formulas:
    """The equations for a law of pressure, as fsipetsc.scheme.sweep takes them; undivided: further terms."""
    return Formulas(
        kind=SOLID,
        pressing=pressing,
        unknowns=(0, 1, 2, 3),
        prepared=(),
        fluxes=(0, 1, 2),
        constants=constants,
        prepare=nothing,
        prescribe=nowhere,
        first=gradients,
        flux=flux,
        rates=(Formulas(unknowns=(0, 1, 2, 3), second=divergences, rate=rate),),
        undivided=undivided,
    )
