"""A charge in the middle of an elastic shell, in one dimension: gas | shell | gas in a vessel.

All depends on the distance r from a centre (kappa = 2), or from the axis of a tube (kappa = 1). The
gas inside goes to r = 0, or ends at a core. Hot gas in the middle, of the density of the rest,
sends a shock to the shell, which swings and drives waves into the gas around it. The shell is free
of stress under the pressure of the gas at rest. Its small motions are known exactly: see the
command `modes`.
"""

from fsipetsc import Block, BlockProblem, Option
from fsipetsc.blocks.conditions import Centre, Free, Slip
from fsipetsc.blocks.maps import off_axis, rectangle
from fsipetsc.cases.common import Opt, at_rest, cells_of, constant, elastic_of, gas_of, materials
from fsipetsc.equations.elementary import tanh

OPTIONS = (
    Option("shell_kappa", int, 2, "", "1: around an axis, 2: around a centre", (1, 2)),
    Option("shell_gas", str, "centre", "", "gas inside to r = 0, around a core, or none",
        ("none", "around", "centre")),
    Option("shell_charge", float, 50.0, "", "temperature of the charge / that at rest, less 1",
        check="nonnegative"),
    *materials(fluid_mu=0.0, fluid_kappa=0.0, solid_density=2.0),
    *materials(solid_mu=1.0, solid_lambda=1.5, solid_law=("neo-hookean", "log", "svk")),
)  # fmt: skip
DEFAULTS = {"fsi_h": 0.0125, "ts_max_time": 2.0, "fsi_output_dt": 0.02, "fsi_shock": 1.0}
#: radii [m] of the core, where there is one, of the shell, of the vessel, and of the charge
CORE, INNER, OUTER, VESSEL, WIDTH = 0.4, 1.0, 1.3, 2.0, 0.2


def build(opt: Opt) -> BlockProblem:
    """The axis of the blocks is the radius."""
    gas, core = gas_of(opt), CORE if opt["shell_gas"] == "around" else 0.0
    pressure = 0.0 if opt["shell_gas"] == "none" else 1.0
    solid = elastic_of(opt, pressure, law=opt["solid_law"])

    def block(name, material, low, high, initial):
        n = cells_of(opt, high - low)
        shape = rectangle(low, high)
        shape = off_axis(shape, n) if low == 0.0 else shape
        return Block(name, material, shape, (n,), initial)

    def charge(r):
        """The density is the same everywhere; the edge of the charge is a fifth of it wide."""
        hot = 0.5 * (1.0 - tanh((r - core - WIDTH) / (0.1 * WIDTH)))
        return 1.0 + 0.0 * r, 0.0 * r, 1.0 + opt["shell_charge"] * hot

    blocks = (block("shell", solid, INNER, OUTER, at_rest()),)
    faces = {("shell", 0, 0): Free(), ("shell", 0, 1): Free()}
    if opt["shell_gas"] != "none":
        inside = block("inside", gas, core, INNER, charge)
        blocks = (inside, *blocks, block("around", gas, OUTER, VESSEL, constant(1.0, 0.0, 1.0)))
        faces = {("inside", 0, 0): Slip() if core else Centre(), ("around", 0, 1): Slip()}
    return BlockProblem(blocks, faces, units="none", symmetry=opt["shell_kappa"])
