"""An elastic rod falls into a compressible gas and bounces (Sec. 5.2): fluid | solid | fluid.

A wall stands at the lower end of the domain, the upper end is open. The paper does not give the
initial state of the gas: at rest at 1e5 Pa and 300 K is inferred from its figures (one cycle ends
at t = 0.90-0.91), and the rod starts under the stress -p0, so that only gravity disturbs the rest.
-fsi_coupling projection computes it as the paper does.
"""

from fsipetsc import FluidLayer, Open, Option, Problem, SolidLayer, Wall
from fsipetsc.cases.common import Opt, constant, gas_of, line_at_rest, materials, solid_of

OPTIONS = (
    *materials(fluid_mu=0.5, fluid_kappa=0.7, fluid_gamma=1.4, fluid_R=8.3145 / 0.029),
    *materials(solid_modulus=1e5, solid_kappa=0.5, solid_density=2700.0, solid_alpha=1.0),
    *materials(solid_gruneisen=0.0),
    Option("rod_gravity", float, -10.0, "m/s2", "body force per mass on the rod"),
    Option("rod_p0", float, 1e5, "Pa", "initial pressure of the gas", check="positive"),
    Option("rod_T0", float, 300.0, "K", "initial temperature", check="positive"),
    Option("rod_wall", float, 0.0, "m", "position of the lower wall",
        check=lambda x: None if x < 1 else "a number below 1"),
    Option("rod_top", float, 6.0, "m", "position of the open upper end",
        check=lambda x: None if x > 2 else "a number above 2"),
)  # fmt: skip
DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 3.0, "fsi_output_dt": 0.05}


def build(opt: Opt) -> Problem:
    """The rod between X = 1 and X = 2."""
    gas, rod = gas_of(opt), solid_of(opt, force=opt["rod_gravity"])
    p0, T0, wall, top = (opt[f"rod_{name}"] for name in ("p0", "T0", "wall", "top"))
    still = constant(p0 / (gas.R * T0), 0.0, T0)
    balanced = line_at_rest(rod.pressure(T0, 1.0) - p0, T0)
    layers = (
        FluidLayer("below", gas, (wall, 1.0), still),
        SolidLayer("rod", rod, (1.0, 2.0), balanced),
        FluidLayer("above", gas, (2.0, top), still),
    )
    return Problem(layers, left=Wall(wall), right=Open(top, p0, T0))
