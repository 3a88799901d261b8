"""A column of five layers, solid | gas | solid | gas | solid: a pulse runs through all of them.

The outer solids are clamped, so nothing leaves: the mass of both gases, the total energy and, with
the impulse of the two ends, the momentum stay what they are, to round-off.
"""

from fsipetsc import FluidLayer, Option, Problem, SolidLayer, clamped
from fsipetsc.cases.common import Opt, constant, gas_of, line_at_rest, materials, solid_of
from fsipetsc.equations.elementary import exp, power

OPTIONS = (
    *materials(fluid_mu=0.01, fluid_kappa=0.03, solid_modulus=20.0, solid_kappa=0.02),
    *materials(solid_density=2.0, solid_alpha=1.0),
    Option("column_pulse", float, 0.5, "", "overpressure / p0", check="nonnegative"),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 4.0, "fsi_output_dt": 0.05}


def build(opt: Opt) -> Problem:
    """All at rest under p0 = 1 but for the pulse; the plate in the middle is thin."""
    gas, solid = gas_of(opt), solid_of(opt)

    def pulse(X):
        p = 1 + opt["column_pulse"] * exp(-(((X - 1.5) / 0.12) ** 2))
        rho = power(p, 1 / gas.gamma)
        return [rho, 0 * X, power(rho, gas.gamma - 1)]

    still, rest = constant(1.0, 0.0, 1.0), line_at_rest(-1.0, 1.0)
    layers = (
        SolidLayer("bottom", solid, (0.0, 1.0), rest),
        FluidLayer("lower gas", gas, (1.0, 2.0), pulse),
        SolidLayer("plate", solid, (2.0, 2.5), rest),
        FluidLayer("upper gas", gas, (2.5, 3.5), still),
        SolidLayer("top", solid, (3.5, 4.5), rest),
    )
    return Problem(layers, clamped(), clamped(), units="none")
