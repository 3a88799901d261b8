"""The elastic solid of the paper, in one dimension, (3.1) and (4.19).

    u_t          = (sigma - p)_X / m0 + force
    sigma_t      = K / x_X u_X,                               K = 2 mu_e + lambda_e
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t          = u

with p(epsilon, rho) an equation of state in epsilon = alpha T and rho = m0 / x_X; p = 0 is the
elastic solid.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, numbers
from fsipetsc.errors import InputError
from fsipetsc.materials import own
from fsipetsc.materials.solid_pressure import ConstantPressure, Gruneisen


class Elastic(NamedTuple):
    """The solid as formulas, for numbers, arrays and symbols. law: the pressure p of
    J = x_X, T, m0 and alpha; the rest is as in ``Solid``."""

    law: Any
    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float

    def pressure(self, T, x_X):
        """p [Pa]."""
        return self.law.pressure(x_X, T, self.m0, self.alpha)

    def pressure_by_temperature(self, T, x_X):
        """dp/dT at constant x_X [Pa/K]."""
        return self.law.pressure_by_temperature(x_X, T, self.m0, self.alpha)

    def stiffness(self, T, x_X):
        """-x_X dp/dx_X at constant T [Pa]."""
        return self.law.stiffness(x_X, T, self.m0, self.alpha)

    def wave_modulus(self, T, p, sigma, x_X):
        """m0 c^2 [Pa] of elastic waves in Lagrangian coordinates: what (3.1b-d) make of
        (sigma - p)_t over u_X, (K - x_X p_x + x_X p_T (p - sigma)/(alpha m0))/x_X."""
        p_T, heat = self.pressure_by_temperature(T, x_X), self.alpha * self.m0
        return (self.K + self.stiffness(T, x_X) + x_X * p_T * (p - sigma) / heat) / x_X


@dataclass(frozen=True)
class Solid:
    """The elastic material of a layer in one dimension, whose stress sigma grows as K ln x_X.

    It also has a pressure p, which is 0 unless a law is given: the stress is sigma - p.

    Source: B. Sjögreen and J. W. Banks, Commun. Comput. Phys. 13 (2013), (3.1) and (4.19).

    Args:
        K: 2 mu_e + lambda_e [Pa].
        kappa_e: heat conductivity [W/(m K)].
        m0: density in the reference state [kg/m3].
        alpha: specific heat [J/(kg K)].
        force: body force per mass [m/s2].
        gruneisen: G of the pressure p = G rho alpha T; 0: p = 0.
        pressing: its law without gruneisen, as `mie_gruneisen` and `pressure_law` return it.
    """

    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float = 0.0
    gruneisen: float = 0.0
    pressing: Any = None

    def __post_init__(self) -> None:
        ranges = {"K": POSITIVE, "kappa_e": NONNEGATIVE, "m0": POSITIVE, "alpha": POSITIVE}
        numbers(self, "Solid", {**ranges, "force": ANY, "gruneisen": NONNEGATIVE})
        if self.pressing is not None and self.gruneisen != 0.0:
            problem = f"gruneisen is {self.gruneisen:g} beside pressing: expected 0"
            raise InputError(f"Solid: {problem}")
        self.pressure_law  # noqa: B018  (checks it)

    @property
    def pressure_law(self) -> Any:
        """The pressure as a formula."""
        if self.pressing is not None:
            return own.checked_law(self.pressing, "Solid: pressing", own.PRESSURE)
        return Gruneisen(self.gruneisen) if self.gruneisen > 0.0 else ConstantPressure()

    @property
    def elastic(self) -> Elastic:
        """The material as formulas."""
        numbers = self.K, self.kappa_e, self.m0, self.alpha, self.force
        return Elastic(self.pressure_law, *numbers)

    def pressure(self, T: Any, x_X: Any = 1.0) -> Any:
        """The pressure p [Pa] at T [K] and the stretch x_X, numbers or arrays of one shape."""
        return self.elastic.pressure(T, x_X)

    def sound_speed(self, x_X: float = 1.0, T: float = 0.0, sigma: float = 0.0) -> float:
        """Speed of small waves in Lagrangian coordinates [m/s], without conduction, at the stretch
        x_X, the temperature T [K] and the stress sigma [Pa].
        """
        solid = self.elastic
        return float(solid.wave_modulus(T, solid.pressure(T, x_X), sigma, x_X) / self.m0) ** 0.5
