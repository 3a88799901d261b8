"""A plate, clamped at both ends, swings under a sudden pressure, with air above it or without.

    mpiexec -n 2 python -m fsipetsc FILE.py -plate_cells 15   # finer through the thickness
    python -m fsipetsc plot NAME.h5 -o pictures               # draw the result

What to expect: it swings between 0 and twice its static deflection with its first frequency. For D
= E d^3/(12 (1 - nu^2)), length L, thickness d and load q, the theory of thin plates has
    delta = q L^4/(384 D) = 10.8 um,    omega = 22.373 sqrt(D/(density d))/L^2, a period of 0.36 ms.
Shear adds 3 % to delta. docs/plates.md says how many cells and which order do.
"""

from fsipetsc import ElasticSolid, Fluid, Layer, Option, layers
from fsipetsc.blocks.conditions import Free, Hinge, Open, Roller, Slip

OPTIONS = (
    Option("plate_thickness", float, 0.005, "m", "thickness d of the plate", check="positive"),
    Option("plate_cells", int, 7, "", "cells through the thickness; order 4 needs 7, 6 needs 11"),
    Option("plate_load", float, 1e5, "Pa", "pressure below, above that of the air"),
    Option("plate_air", bool, True, "", "air above the plate, or nothing but its pressure"),
)
DEFAULTS = {"fsi_h": 0.005, "ts_max_time": 7.5e-4, "fsi_output_dt": 1e-5, "fsi_probes": "0.05,0"}
LENGTH, HEIGHT = 0.1, 0.1  # of the plate and of the air above it [m]
YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0  # of steel: E [Pa], nu, density [kg/m3]
P0, T0 = 1e5, 300.0  # of the air: pressure [Pa], temperature [K]


def build(opt):
    """The problem, for the options in force."""
    air = Fluid(mu=0.0, kappa=0.0, gamma=1.4, R=287.0)  # it slips along the plate
    mu = 0.5 * YOUNG / (1.0 + POISSON)
    lam = 2.0 * mu * POISSON / (1.0 - 2.0 * POISSON)
    # Free of stress under P0; the run tells what time steps lose of its energy: lost_energy.
    steel = ElasticSolid(mu, lam, 0.0, DENSITY, 470.0, p_ref=P0, law="svk", heat="elastic")
    rho, d = P0 / (air.R * T0), opt["plate_thickness"]

    def quiet(X, Y):
        return rho, 0.0, 0.0, T0  # density, velocity in x and y, temperature

    def rest(X, Y):
        return 0.0, 0.0, T0, X, Y  # velocity, temperature, where X, Y is

    # From below: the plate, and the air. The ends of the plate stay in their planes, and a point
    # of each in its place: a clamp as in theories of plates.
    plate = Layer("plate", steel, (0.0, d), rest, opt["plate_cells"], sides=Roller())
    above = Layer("air", air, (d, d + HEIGHT), quiet, sides=Slip())
    both = (plate, above) if opt["plate_air"] else (plate,)
    return layers(
        *both,
        along=((0.0, LENGTH),),
        lower=Free(P0 + opt["plate_load"]),
        points=tuple(("plate", (X, 0.0), Hinge()) for X in (0.0, LENGTH)),
        upper=Open(rho, (0.0, 0.0), T0) if opt["plate_air"] else Free(P0),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
    )
