"""The constant state whose small disturbances the linear theory follows: gas at rest on a solid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid


@dataclass(frozen=True)
class Constant:
    """A perfect gas of density rho [kg/m3] and temperature T [K] at rest on a solid of the same
    temperature and the uniform strain x_X = stretch; the solid's pressure p_s is Grüneisen's or 0.
    """

    gas: Fluid
    solid: Solid
    rho: float
    T: float
    stretch: float = 1.0

    @property
    def p(self) -> float:
        """Pressure of the gas [Pa]."""
        return self.rho * self.gas.R * self.T

    @property
    def solid_pressure(self) -> float:
        """p_s of the solid [Pa]; proportional to T / x_X."""
        return float(self.solid.pressure(self.T, self.stretch))

    @property
    def stress(self) -> float:
        """sigma = p_s - p, which balances the gas [Pa]."""
        difference = self.solid_pressure - self.p
        return difference if abs(difference) > 1e-12 * self.p else 0.0

    @property
    def modulus(self) -> float:
        """K^ = (K - x_X dp_s/dx_X) / x_X [Pa]."""
        return (self.solid.K + self.solid_pressure) / self.stretch

    @property
    def weights(self) -> NDArray[np.float64]:
        """W of (rho, u, T) in the fluid and (u, S, T) in the solid."""
        rho, T, solid = self.rho, self.T, self.solid
        fluid = [self.p / rho**2, rho, rho * self.gas.cv / T]
        return np.array([*fluid, solid.m0, 1.0 / self.modulus, solid.alpha * solid.m0 / T])

    @property
    def scales(self) -> NDArray[np.float64]:
        """The size of each of these variables: what makes an energy of p per volume, at most rho,
        p, T themselves."""
        limits = np.array([self.rho, np.inf, self.T, np.inf, self.p, self.T])
        return np.minimum(np.sqrt(self.p / self.weights), limits)

    def swept(self, density_ratio: float, stiffness_ratio: float) -> Constant:
        """The same with another density and stiffness of the solid; alpha m0 keeps its value, and
        so do the pressures."""
        solid, m0 = self.solid, density_ratio * self.rho
        other = replace(solid, m0=m0, K=stiffness_ratio * self.p, alpha=solid.alpha * solid.m0 / m0)
        return replace(self, solid=other)


def of_options(opt: Mapping[str, Any]) -> Constant:
    """The state that the options describe."""
    gas = Fluid(opt["fluid_mu"], opt["fluid_kappa"], opt["fluid_gamma"], opt["fluid_R"])
    rho, T, m0, alpha = (opt[k] for k in ("fluid_rho", "fluid_T", "solid_density", "solid_alpha"))
    balanced = gas.R * rho / (m0 * alpha)  # p_s = p, sigma = 0
    gruneisen = balanced if opt["solid_eos"] == "ideal" else 0.0
    solid = Solid(opt["solid_modulus"], opt["solid_kappa"], m0, alpha, gruneisen=gruneisen)
    return Constant(gas, solid, rho, T)
