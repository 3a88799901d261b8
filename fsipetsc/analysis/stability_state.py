"""The constant state whose small disturbances the linear theory follows, and where it comes from in a case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc import given
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.problem import Problem

#: temperatures of gas and solid that differ by less than this fraction are one
ALIKE = 1e-6
#: change of rho, as a fraction, with which de/drho is taken
NEARBY = 1e-4


@dataclass(frozen=True)
class Constant:
    """The constant state and the materials: gas of density rho [kg/m3] and temperature T [K] at rest on a solid.

    The solid has the same temperature, the uniform strain x_X = stretch, and the stress that balances the gas. Of any laws:
    what the linear equations need of them are the properties. InputError for a state in which a material has no sound, and for
    laws p, e of a gas that do not belong together.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float = 1.0

    def __post_init__(self) -> None:
        found = {"p": self.p, "rho p_rho of the gas": self.bulk, "heat capacity of the gas": self.heat_capacity}
        found["(K - x_X p_x) / x_X of the solid"] = self.modulus
        for name, value in found.items():
            if not 0 < value < np.inf:
                at = f"rho = {self.rho:g}, T = {self.T:g}, x_X = {self.stretch:g}"
                raise InputError(f"the state at rest with {at}: {name} is {value:g}: expected a number above 0")
        at = [self.rho * (1 + change) for change in (-NEARBY, NEARBY)]
        energies = [float(self.gas.internal_energy(rho, self.T)) for rho in at]
        slope, wanted = self.rho * (energies[1] - energies[0]) / (2 * NEARBY), self.p - self.T * self.p_T
        if not abs(slope - wanted) <= 1e-6 * self.p:
            raise InputError(
                f"the law of the gas: rho^2 de/drho is {slope:g} Pa and p - T dp/dT {wanted:g} Pa at rho = {self.rho:g}, T = "
                f"{self.T:g}: expected the same, as thermodynamics has it and the linear theory takes it"
            )

    def _of_gas(self, name: str) -> float:
        with np.errstate(all="ignore"):
            return float(getattr(self.gas.gas_law, name)(self.rho, self.T))

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self._of_gas("pressure")

    @property
    def bulk(self) -> float:
        """rho dp/drho of the gas at constant T [Pa]."""
        return self._of_gas("bulk_modulus")

    @property
    def p_T(self) -> float:
        """dp/dT of the gas at constant rho [Pa/K]."""
        return self._of_gas("pressure_by_temperature")

    @property
    def heat_capacity(self) -> float:
        """Of the gas, at constant rho [J/(kg K)]."""
        return self._of_gas("heat_capacity")

    @property
    def sound_speed(self) -> float:
        """Of the gas [m/s]."""
        return float(self.gas.sound_speed(self.T, self.rho))

    @property
    def mu(self) -> float:
        """Viscosity of the gas at T [Pa s]."""
        return self.gas.mu * float(self.gas.relative(self.T)[0])

    @property
    def kappa(self) -> float:
        """Conductivity of the gas at T [W/(m K)]."""
        return self.gas.kappa * float(self.gas.relative(self.T)[1])

    @property
    def solid_pressure(self) -> float:
        """p_s [Pa]."""
        return float(self.solid.pressure(self.T, self.stretch))

    @property
    def solid_p_T(self) -> float:
        """dp_s/dT at constant strain [Pa/K]."""
        return float(self.solid.pressure_by_temperature(self.T, self.stretch))

    @property
    def stiffness(self) -> float:
        """-x_X dp_s/dx_X at constant T [Pa]."""
        return float(self.solid.stiffness(self.T, self.stretch))

    @property
    def stress(self) -> float:
        """sigma [Pa] of the solid, by sigma - p_s = -p; 0 where the pressures are equal but for round-off."""
        stress = self.solid_pressure - self.p
        return stress if abs(stress) > 1e-12 * self.p else 0.0

    @property
    def excess(self) -> float:
        """T dp_s/dT - p [Pa], over which the linear equations are symmetric; that is sigma for Grüneisen's law."""
        excess = self.T * self.solid_p_T - self.p
        return excess if abs(excess) > 1e-12 * self.p else 0.0

    @property
    def modulus(self) -> float:
        """(K - x_X dp_s/dx_X) / x_X [Pa]: S_t over u_X."""
        return (self.solid.K + self.stiffness) / self.stretch

    @property
    def weights(self) -> NDArray[np.float64]:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        solid = self.solid
        fluid = [self.bulk / self.rho**2, self.rho, self.rho * self.heat_capacity / self.T]
        return np.array([*fluid, solid.m0, 1.0 / self.modulus, solid.alpha * solid.m0 / self.T])

    @property
    def scales(self) -> NDArray[np.float64]:
        """The size of each of these variables: what makes an energy of p per volume, at most rho, p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)


def of_problem(problem: Problem, k: int, h: float) -> Constant:
    """The state at interface k of a problem, from its initial data; h [m]: where the strain is taken.

    What moves there, a body force and a stress that does not balance the gas are left out. InputError where there is no
    such interface, or gas and solid have two temperatures.
    """
    known = problem.interfaces
    if not known:
        raise InputError("stability is about an interface between gas and solid: this case has none")
    if not 0 <= k < len(known):
        raise InputError(f"-stability_interface {k}: expected a number from 0 to {len(known) - 1}, counted from the left")
    gas, solid = (problem.layers[i] for i in known[k])
    right = known[k][1] < known[k][0]  # the gas lies right of the solid
    X = np.array([0.0, h]) + (solid.X[1] - h if right else solid.X[0])
    rho, _, T = given.initial(gas, np.array([gas.X[0 if right else 1]]), slice(None))
    _, _, T_s, x = given.initial(solid, X, slice(None))
    end = -1 if right else 0
    same_temperature(gas.name, T[0], solid.name, T_s[end])
    return Constant(gas.material, solid.material, float(rho[0]), float(T[0]), float((x[1] - x[0]) / h))


def same_temperature(gas: str, T: float, solid: str, T_s: float) -> None:
    """InputError where two layers do not begin with one temperature [K] where they meet."""
    if abs(T_s - T) > ALIKE * T:
        raise InputError(
            f"layers '{gas}' and '{solid}' begin with T = {T:.9g} K and {T_s:.9g} K where they meet: the linear "
            "theory is about a state at rest, of one temperature"
        )


def described_law(law: Any) -> str:
    """What a law is called, for people: its class, with its numbers."""
    name, _, own = type(law).__name__.partition("_")
    return "a law of its own" if own else f"{name} ({', '.join(f'{value:g}' for value in law)})"
