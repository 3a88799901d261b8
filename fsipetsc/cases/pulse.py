"""A sound pulse meets the interface of the two-domain problem (Fig. 2, Sec. 4): solid | fluid.

Both materials rest under the pressure p0. A Gaussian pulse starts in the fluid (or in the solid)
and travels to the interface at X = 0; a part is reflected, a part goes through. For small
amplitudes and without viscosity and heat conduction, which are the defaults, linear acoustics gives
the exact solution: with the impedances Z = rho c of the gas and m0 c of the solid (sqrt(K m0) if it
is elastic) the reflected pressure is (Z2-Z1)/(Z2+Z1), the transmitted one 2 Z2/(Z1+Z2) of the
incoming one. In the solid p - sigma changes by -m0 c^2 times the strain.
What remains of the error on fine grids is of second order in the amplitude.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from fsipetsc import Fluid, FluidLayer, InputError, Open, Option, Problem, Solid, SolidLayer
from fsipetsc.boundaries import absorbing
from fsipetsc.cases.common import PAPER, Opt, gas_of, materials, solid_of
from fsipetsc.checks import Array
from fsipetsc.equations.elementary import exp

OPTIONS = (
    *materials(fluid_mu=0.0, fluid_kappa=0.0, fluid_gamma=1.4, fluid_R=8.3145 / 0.029),
    *materials(solid_modulus=1e6, solid_kappa=0.0, solid_density=4.0, solid_alpha=1000.0),
    *materials(solid_gruneisen=0.0),
    Option("pulse_amplitude", float, 1.0, "Pa", "pressure of the pulse, small against p0"),
    Option("pulse_width", float, 0.12, "m", "width of exp(-(distance/width)^2)", check="positive"),
    Option("pulse_start", float, 0.75, "m", "where it starts: above 0 in the fluid, or below"),
)
DEFAULTS = {**PAPER, "ts_max_time": 4e-3, "fsi_output_dt": 2e-4}
#: pressure and temperature at rest, thickness of either layer
P0, T0, SIZE = 1e5, 300.0, 1.5


@dataclass(frozen=True)
class Acoustics:
    """Linear solution for a pulse that starts in one medium (impedance Z1, speed c1) and meets
    another (Z2, c2). side: +1 if the first medium lies at X > 0. arrival, duration [s]: of the
    pulse at the interface.
    """

    side: float
    Z1: float
    c1: float
    Z2: float
    c2: float
    amplitude: float
    arrival: float
    duration: float

    @property
    def reflection(self) -> float:
        """Reflected over incoming pressure."""
        return (self.Z2 - self.Z1) / (self.Z2 + self.Z1)

    @property
    def transmission(self) -> float:
        """Transmitted over incoming pressure."""
        return 2 * self.Z2 / (self.Z1 + self.Z2)

    def waves(self, X: Array, t: float, first: bool) -> tuple[Array, Array, Array]:
        """(pressure, velocity, displacement) at X in the first or the second medium."""
        Z, c = (self.Z1, self.c1) if first else (self.Z2, self.c2)
        side = self.side if first else -self.side
        # part of the pressure, way, time at which it was at the interface
        trains = [(self.reflection if first else self.transmission, side, t - np.abs(X) / c)]
        if first:
            trains.append((1.0, -side, t + np.abs(X) / c))
        p, u, moved = np.zeros((3, *np.shape(X)))
        for part, way, time in trains:
            z, size = (time - self.arrival) / self.duration, part * self.amplitude
            p, u = p + size * exp(-z * z), u + way / Z * size * exp(-z * z)
            moved = moved + way / Z * size * 0.5 * np.sqrt(np.pi) * self.duration * (1.0 + erf(z))
        return p, u, moved


def acoustics(opt: Opt, gas: Fluid, solid: Solid) -> Acoustics:
    """Return the linear problem of these options."""
    c_f, c_s = float(gas.sound_speed(T0)), solid.sound_speed(1.0, T0, solid.pressure(T0) - P0)
    of_gas, of_solid = (P0 / (gas.R * T0) * c_f, c_f), (solid.m0 * c_s, c_s)
    in_fluid = opt["pulse_start"] > 0
    first, second = (of_gas, of_solid) if in_fluid else (of_solid, of_gas)
    times = abs(opt["pulse_start"]) / first[1], opt["pulse_width"] / first[1]
    return Acoustics(1.0 if in_fluid else -1.0, *first, *second, opt["pulse_amplitude"], *times)


def build(opt: Opt) -> Problem:
    """Solid in -SIZE < X < 0, fluid in 0 < X < SIZE."""
    gas, solid, start = gas_of(opt), solid_of(opt), opt["pulse_start"]
    if not 0 < abs(start) < SIZE:
        where = f"expected 0 < |start| < {SIZE:g}"
        raise InputError(f"-pulse_start {start:g} is not inside a layer: {where}")
    sigma, linear = solid.pressure(T0) - P0, acoustics(opt, gas, solid)
    in_fluid = linear.side > 0

    def exact_gas(X, t=0.0):
        p, u, _ = linear.waves(X, t, in_fluid)
        T = T0 * (1 + (gas.gamma - 1) / gas.gamma * p / P0)
        return (P0 + p) / (gas.R * T), u, T

    def exact_solid(X, t=0.0):
        p, u, displacement = linear.waves(X, t, not in_fluid)
        strain = -p / (solid.m0 * solid.sound_speed(1.0, T0, sigma) ** 2)
        T = T0 - P0 * strain / (solid.alpha * solid.m0)
        return u, sigma + solid.K * strain, T, X + displacement

    layers = (
        SolidLayer("solid", solid, (-SIZE, 0.0), exact_solid, exact=exact_solid),
        FluidLayer("gas", gas, (0.0, SIZE), exact_gas, exact=exact_gas),
    )
    note = (
        f"exact solution: linear acoustics, reflection {linear.reflection:.6g}, "
        f"transmission {linear.transmission:.6g} of the pressure"
    )
    return Problem(layers, absorbing(-P0), Open(SIZE, P0, T0), notes=(note,))
