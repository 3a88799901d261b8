"""Water hammer: water flows towards the closed end of an elastic tube and stops there.

    mpiexec -n 2 python -m fsipetsc FILE.py -tube_poisson 0    # with an option
    python -m fsipetsc plot NAME.h5 -o pictures                # draw the result

X is the place along the axis, Y the distance from it. A front of pressure runs from the closed end
at X = 0 into the tube, which widens behind it. What to expect: in a thin tube its speed is that of
Korteweg, c = c0/sqrt(1 + (K/E) (D/e)) = 375 m/s, K = rho c0^2; here it is 356 m/s. The pressure
rises by rho c water_speed (Joukowsky), 0.18 MPa. docs/water.md has the theory.
"""

from fsipetsc import Block, BlockProblem, ElasticSolid, Fluid, Option
from fsipetsc.blocks.conditions import Absorbing, Centre, Free, Open, Roller, Slip
from fsipetsc.blocks.maps import off_axis, rectangle
from fsipetsc.equations.elementary import tanh
from fsipetsc.materials.stiffened_gas import stiffened_gas

OPTIONS = (
    Option("tube_young", float, 3e9, "Pa", "Young's modulus E of the wall", check="positive"),
    Option("tube_poisson", float, 0.4, "", "Poisson's number, below 0.5", check="nonnegative"),
    Option("tube_density", float, 1400.0, "kg/m3", "density of the wall", check="positive"),
    Option("tube_thickness", float, 0.005, "m", "thickness e of the wall", check="positive"),
    Option("tube_length", float, 1.5, "m", "length of the tube", check="positive"),
    Option("water_speed", float, 0.5, "m/s", "speed of the water at the start"),
    Option("water_ramp", float, 0.15, "m", "length over which it stops at the start"),
)
DEFAULTS = {"fsi_h": 0.02, "fsi_cfl": 1.2, "ts_max_time": 3.6e-3, "fsi_output_dt": 6e-5}
RHO, C0, P0, T0 = 998.0, 1482.0, 1e6, 293.0  # of water: density, speed of sound, p, T; SI units
GAMMA, RADIUS = 4.4, 0.05  # of its law (docs/water.md); inner radius D/2 of the tube [m]


def build(opt):
    """The problem, for the options in force."""
    p_inf = RHO * C0**2 / GAMMA - P0
    law = stiffened_gas(GAMMA, cv=(P0 + p_inf) / ((GAMMA - 1.0) * RHO * T0), p_inf=p_inf)
    water = Fluid(mu=0.0, kappa=0.0, gamma=GAMMA, R=462.0, law=law)  # it slips along the wall
    E, nu, e = opt["tube_young"], opt["tube_poisson"], opt["tube_thickness"]
    mu = 0.5 * E / (1.0 + nu)
    lame, density = (mu, 2 * mu * nu / (1 - 2 * nu)), opt["tube_density"]
    wall = ElasticSolid(*lame, 0.0, density, 1000.0, p_ref=P0, law="neo-hookean", heat="elastic")
    # Where the water slows down the tube widens, by as much as the water needs.
    speed, ramp, length = opt["water_speed"], opt["water_ramp"], opt["tube_length"]
    part = 1.0 - 1.0 / (1.0 + RHO * C0**2 / E * 2.0 * RADIUS / e)

    def flow(X, Y):
        s = tanh(X / ramp)  # density, velocity along X and Y, temperature
        return RHO, -speed * s, 0.5 * part * speed * (1.0 - s * s) / ramp * Y, T0

    def widening(X, Y):
        return 0.0, flow(X, RADIUS**2 / Y)[2], T0, X, Y  # velocity, temperature, place

    along, inside = round(length / opt["fsi_h"]), 2 * opt["fsi_order"]  # cells, less 1 in the wall
    core = off_axis(rectangle((0.0, 0.0), (length, RADIUS)), inside)
    tube = rectangle((0.0, RADIUS), (length, RADIUS + e))
    blocks = (
        Block("water", water, core, (along, inside), flow),
        Block("tube", wall, tube, (along, inside - 1), widening),
    )
    faces = {("water", 1, 0): Centre(), ("tube", 1, 1): Free(P0)}
    faces |= {("water", 0, 0): Slip(), ("tube", 0, 0): Roller()}  # the closed end
    faces |= {("water", 0, 1): Open(RHO, (-speed, 0.0), T0), ("tube", 0, 1): Absorbing(-P0)}
    return BlockProblem(blocks, faces, symmetry=1)
