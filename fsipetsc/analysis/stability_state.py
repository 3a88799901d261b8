"""The constant state whose small disturbances the linear theory follows, of options or a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
    """Gas of density rho [kg/m3] and temperature T [K] at rest on a solid of the uniform strain
    x_X = stretch.

    Of the gas: pressure p [Pa], bulk = rho dp/drho at constant T [Pa], p_T = dp/dT at constant rho
    [Pa/K], heat_capacity at constant rho [J/(kg K)], mu [Pa s], kappa [W/(m K)]. Of the solid:
    solid_pressure p_s [Pa], solid_p_T = dp_s/dT [Pa/K], stiffness = -x_X dp_s/dx_X [Pa], modulus =
    (K + stiffness) / x_X [Pa], stress sigma = p_s - p that balances the gas [Pa], excess = T
    dp_s/dT
    - p [Pa], over which the linear equations are symmetric: sigma in Grüneisen's solid.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float
    p: float
    bulk: float
    p_T: float
    heat_capacity: float
    mu: float
    kappa: float
    solid_pressure: float
    solid_p_T: float
    stiffness: float
    modulus: float
    stress: float
    excess: float

    @property
    def weights(self) -> NDArray[np.float64]:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        solid = self.solid
        rho = self.rho
        fluid = [self.bulk / rho**2, rho, rho * self.heat_capacity / self.T]
        return np.array([*fluid, solid.m0, 1.0 / self.modulus, solid.alpha * solid.m0 / self.T])

    @property
    def scales(self) -> NDArray[np.float64]:
        """The size of each of these variables: what makes an energy of p per volume, at most rho,
        p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Constant:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value, and
        so do the pressures, if Grüneisen's law is that of the solid."""
        solid, m0 = self.solid, density_ratio * self.rho
        other = replace(solid, m0=m0, K=stiffness_ratio * self.p, alpha=solid.alpha * solid.m0 / m0)
        return at_rest(self.gas, other, self.rho, self.T, self.stretch)


def at_rest(gas: Fluid, solid: Solid, rho: float, T: float, stretch: float = 1.0) -> Constant:
    """The state, of materials with any laws.

    InputError for one in which a material has no sound, and for laws p, e of a gas that do not
    belong together.
    """
    law = gas.gas_law
    with np.errstate(all="ignore"):
        p, bulk = float(law.pressure(rho, T)), float(law.bulk_modulus(rho, T))
        p_T, c_v = float(law.pressure_by_temperature(rho, T)), float(law.heat_capacity(rho, T))
    relative = [float(value) for value in gas.relative(T)]
    law_s = solid.elastic
    p_s, stiffness = float(law_s.pressure(T, stretch)), float(law_s.stiffness(T, stretch))
    p_s_T = float(law_s.pressure_by_temperature(T, stretch))
    modulus = (solid.K + stiffness) / stretch
    found = {"p": p, "rho p_rho of the gas": bulk, "heat capacity of the gas": c_v}
    for name, value in {**found, "(K - x_X p_x) / x_X of the solid": modulus}.items():
        if not 0 < value < np.inf:
            at = f"rho = {rho:g}, T = {T:g}, x_X = {stretch:g}"
            wrong = f"{name} is {value:g}: expected a number above 0"
            raise InputError(f"the state at rest with {at}: {wrong}")
    low, high = (float(gas.internal_energy(rho * (1 + change), T)) for change in (-NEARBY, NEARBY))
    slope, wanted = rho * (high - low) / (2 * NEARBY), p - T * p_T
    if not abs(slope - wanted) <= 1e-6 * p:
        raise InputError(
            f"the law of the gas: rho^2 de/drho is {slope:g} Pa and p - T dp/dT {wanted:g} Pa at "
            f"rho = {rho:g}, T = {T:g}: expected the same, as thermodynamics has it"
        )
    # what is equal but for round-off is equal
    stress, excess = (gap if abs(gap) > 1e-12 * p else 0.0 for gap in (p_s - p, T * p_s_T - p))
    of_gas = p, bulk, p_T, c_v, gas.mu * relative[0], gas.kappa * relative[1]
    of_solid = p_s, p_s_T, stiffness, modulus
    return Constant(gas, solid, rho, T, stretch, *of_gas, *of_solid, stress, excess)


def of_options(opt: Mapping[str, Any]) -> Constant:
    """The state that the options describe."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt["fluid_gamma"], opt["fluid_R"])
    rho, T, m0, alpha = (opt[k] for k in ("fluid_rho", "fluid_T", "solid_density", "solid_alpha"))
    balanced = gas.R * rho / (m0 * alpha)  # p_s = p, sigma = 0
    gruneisen = balanced if opt["solid_eos"] == "ideal" else 0.0
    solid = Solid(opt["solid_modulus"], opt["solid_kappa"], m0, alpha, gruneisen=gruneisen)
    return at_rest(gas, solid, rho, T)


def of_problem(problem: Problem, k: int, h: float) -> Constant:
    """The state at interface k of a problem, from its initial data; h [m]: where the strain is
    taken.

    What moves there, a body force and a stress that does not balance the gas are left out.
    InputError where there is no such interface, or gas and solid have two temperatures.
    """
    known = problem.interfaces
    if not known:
        raise InputError("stability is about an interface of gas and solid: this case has none")
    if not 0 <= k < len(known):
        expected = f"expected a number from 0 to {len(known) - 1}, counted from the left"
        raise InputError(f"-stability_interface {k}: {expected}")
    gas, solid = (problem.layers[i] for i in known[k])
    right = known[k][1] < known[k][0]  # the gas lies right of the solid
    X = np.array([0.0, h]) + (solid.X[1] - h if right else solid.X[0])
    rho, _, T = given.initial(gas, np.array([gas.X[0 if right else 1]]), slice(None))
    _, _, T_s, x = given.initial(solid, X, slice(None))
    same_temperature(gas.name, T[0], solid.name, T_s[-1 if right else 0])
    stretch = float((x[1] - x[0]) / h)
    return at_rest(gas.material, solid.material, float(rho[0]), float(T[0]), stretch)


def same_temperature(gas: str, T: float, solid: str, T_s: float) -> None:
    """InputError where two layers do not begin with one temperature [K] where they meet."""
    if abs(T_s - T) > ALIKE * T:
        raise InputError(
            f"layers '{gas}' and '{solid}' begin with T = {T:.9g} K and {T_s:.9g} K where they "
            "meet: the linear theory is about a state at rest, of one temperature"
        )


def law_name(law: Any) -> str:
    """What a law is called, for people: its class, with its numbers."""
    name, _, own = type(law).__name__.partition("_")
    numbers = ", ".join(f"{value:g}" for value in law)
    return "a law of its own" if own else f"{name} ({numbers})"
