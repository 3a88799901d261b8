"""Shocks in a gas and in the elastic rod before it, with exact solutions.

sod: the left half of Sod's shock tube, with a rod under the low pressure in the place of the right
half; at t = 0 nothing holds them apart any more. A fan goes into the gas, a shock into the rod.

strong: a piston drives a shock of Mach number `shock_mach` through the gas. It hits the light rod:
a shock goes back into the gas and one on into the rod. At t = 0 the shock is at x = 0.7, spread
over a few points, as the dissipation spreads it, so that it sends no waves after it.

The wall or piston is on the left; the right end of the rod is clamped (sod), or free under the
pressure of the gas ahead. The exact solution (fsipetsc.cases.riemann) is that without viscosity and
conduction, until a wave comes to one of these ends. Errors are in L1: a shock has order 1.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsipetsc import Fluid, FluidLayer, Option, Problem, Solid, SolidLayer, Wall, clamped, free
from fsipetsc.cases import riemann
from fsipetsc.cases.common import Opt, gas_of, materials, solid_of
from fsipetsc.cases.riemann import GasState, GasWave, SolidState, SolidWave, behind_shock
from fsipetsc.checks import Array, Fields
from fsipetsc.options import above_one

OPTIONS = (
    Option("shock_problem", str, "sod", "", "which problem", ("sod", "strong")),
    Option("shock_mach", float, 3.0, "", "strong: Mach number of the shock", check=above_one),
    Option("shock_ratio", float, 10.0, "", "sod: ratio of the pressures", check=above_one),
    *materials(fluid_mu=0.0, fluid_kappa=0.0),
    *materials(solid_modulus=4.0, solid_density=0.5, solid_alpha=1.0),
)
DEFAULTS = {"fsi_h": 0.005, "ts_max_time": 0.3, "fsi_output_dt": 0.01, "fsi_norm": "L1"}
DEFAULTS |= {"fsi_shock": 1.4, "fsi_dissipation": 2.0}

GAMMA, R = 1.4, 1.0
#: density of the gas of high pressure; the gas of low pressure in Sod's tube, whose pressure is
#: that on the rod; the rod's temperature
DENSE, LOW, T_ROD = 1.0, GasState(0.125, 0.0, 0.1), 1.0
#: the wall, the interface, the end of the rod
X = (0.0, 1.0, 2.0)
#: where the strong shock starts; its width there over -fsi_shock times the spacing of the grid:
#: with this number the waves that follow are least in all orders of the operators together
X_SHOCK, WIDTH = 0.7, 0.66


@dataclass(frozen=True)
class Solution:
    """Exact solution of gas behind a piston and a rod at rest.

    ahead: the gas before the rod; mach: of a shock in it that has not hit the rod yet, None if
    there is none. InputError where gas and rod part.
    """

    gas: Fluid
    solid: Solid
    ahead: GasState
    mach: float | None = None

    @cached_property
    def shock(self) -> tuple[GasState, float]:
        """The gas behind the shock, and how fast it is; as if it had gone through without one."""
        if self.mach is None:
            return self.ahead, np.inf
        return behind_shock(self.gas, self.ahead, self.mach)

    @property
    def hit(self) -> float:
        """The time when the gas behind the shock meets the rod [s]."""
        return (X[1] - X_SHOCK) / self.shock[1]

    @cached_property
    def waves(self) -> tuple[GasWave, SolidWave, float]:
        """What begins then: a wave into either side, and the pressure [Pa] at the interface."""
        at_rest = SolidState(0.0, -LOW.p, T_ROD, 1.0)
        gas, solid = GasWave(self.gas, self.shock[0]), SolidWave(self.solid, at_rest)
        return gas, solid, riemann.pressure_between(gas.velocity, solid.velocity)

    @property
    def valid(self) -> float:
        """When a wave comes to the end of the rod or to the piston, and the solution ends."""
        *waves, p = self.waves
        back, on = (wave.speeds(p)[0] for wave in waves)
        piston = self.shock[0].u
        gap = X[1] - X[0] - piston * self.hit
        return self.hit + min((X[2] - X[1]) / on, gap / (piston - back))

    def at_start(self, X_g: Array, width: float) -> Fields:
        """(rho, u, T): as exact, but for a shock of this width (shock_structure)."""
        if self.mach is None:
            return self.in_gas(X_g, 0.0)
        grid = self.shock[0].u * (X[1] - X_SHOCK) / (X[1] - X[0])
        spread = riemann.shock_structure(self.gas, self.ahead, self.mach, width, grid)
        rho, u, p = spread(X_g - X_SHOCK)
        return [rho, u, p / (self.gas.R * rho)]

    def in_gas(self, X_g: Array, t: float) -> Fields:
        """(rho, u, T) at the points of the grid, which goes from the piston to the rod."""
        (behind, speed), (wave, _, p) = self.shock, self.waves
        piston = X[0] + behind.u * t
        interface = X[1] + wave.velocity(p) * max(t - self.hit, 0.0)
        x = piston + (X_g - X[0]) / (X[1] - X[0]) * (interface - piston)
        if t < self.hit:
            both = zip(behind, self.ahead, strict=True)
            state = GasState(*(np.where(x < X_SHOCK + speed * t, a, b) for a, b in both))
        else:
            state = wave.at(p, x - X[1], t - self.hit)
        return [state.rho, state.u, state.p / (self.gas.R * state.rho)]

    def in_solid(self, X_s: Array, t: float = 0.0) -> Fields:
        """Return (u, sigma, T, x) at the material points."""
        _, wave, p = self.waves
        state = wave.at(p, X_s - X[1], t - self.hit)
        # x/t = u + F X/t, as all depends on X/t
        place = X[1] + state.u * (t - self.hit) + state.F * (X_s - X[1])
        return [state.u, state.sigma, state.T, place]

    def notes(self) -> tuple[str, ...]:
        """Return what a result says of the solution. InputError where there is none."""
        _, wave, p = self.waves
        u, F = wave.velocity(p), wave.strain(p)
        return (
            f"interface: p = {p:.10g}, u = {u:.10g}, x_X = {F:.10g} from t = {self.hit:.6g} on",
            "the exact solution is that without viscosity and conduction, and holds until "
            f"t = {self.valid:.6g}",
        )


def build(opt: Opt) -> Problem:
    """The gas between X = 0 and 1, the rod between 1 and 2."""
    gas, solid = gas_of(opt, GAMMA, R), solid_of(opt)
    strong = opt["shock_problem"] == "strong"
    high = GasState(DENSE, 0.0, opt["shock_ratio"] * LOW.p)
    exact = Solution(gas, solid, *((LOW, opt["shock_mach"]) if strong else (high,)))
    notes, speed = exact.notes(), exact.shock[0].u
    width = WIDTH * max(opt["fsi_shock"], 1.0) * opt["fsi_h"]
    begin = lambda x: exact.at_start(x, width)  # noqa: E731
    piston = Wall(lambda t: X[0] + speed * t, velocity=lambda t: speed)
    left, right = (piston, free(-LOW.p)) if strong else (Wall(X[0]), clamped())
    layers = (
        FluidLayer("gas", gas, X[:2], begin, exact=exact.in_gas),
        SolidLayer("rod", solid, X[1:], exact.in_solid, exact=exact.in_solid),
    )
    return Problem(layers, left, right, notes=notes, units="none")
