"""Edges of two dimensions that move: a piston that recedes, the simple wave of receding.py, and a floor that waves."""

from __future__ import annotations

import numpy as np
from receding import GAMMA, RHO, T, gas, piston

from fsipetsc.boundaries.plane import Given, NoSlip, Open, Slip
from fsipetsc.options import Option
from fsipetsc.physics.fluid import Fluid
from fsipetsc.plane import PlaneFluidLayer, PlaneProblem

NAME = "moving_edges"
SUMMARY = "edges that move in two dimensions"
OPTIONS = (
    Option("wall", str, "NoSlip", "", "what the lower edge is", ("NoSlip", "Slip", "Given", "waves")),
    Option("known", bool, False, "", "the velocity of the piston is given, too"),
)
DEFAULTS = {"fsi_h": 0.05, "ts_max_time": 0.9, "fsi_output_dt": 1.0}


def exact(X, Y, t):
    rho, v, temperature = gas(Y / 1.5 * (1.5 - piston(t)), t)
    return rho, 0 * X, v, temperature


def place(X, t):
    return X, piston(t)


def floor(X, t):
    return X, 0.1 * np.sin(np.pi * X) ** 2 * np.sin(2 * t)


def waves():
    """A floor that waves, beside walls that stand still."""
    layer = PlaneFluidLayer(
        "gas", Fluid(0.01, 0.02, 1.4, 1.0), (0.0, 1.0), lambda X, Y: (1.0, 0.0, 0.0, 1.0), left=Slip(), right=NoSlip()
    )
    return PlaneProblem((layer,), (0.0, 1.0), NoSlip(T=1.0, x=floor), NoSlip(), units="none")


def build(opt):
    if opt["wall"] == "waves":
        return waves()
    motion = {"x": place, **({"velocity": lambda X, t: (0.0, -(t**3))} if opt["known"] else {})}
    walls = {"NoSlip": NoSlip, "Slip": Slip, "Given": lambda **moved: Given(exact, **moved)}
    layer = PlaneFluidLayer("gas", Fluid(0.0, 0.0, GAMMA, 1.0), (0.0, 1.5), lambda X, Y: exact(X, Y, 0.0), exact=exact)
    return PlaneProblem((layer,), (0.0, 8 * opt["fsi_h"]), walls[opt["wall"]](**motion), Open(RHO, 0.0, 0.0, T), units="none")
