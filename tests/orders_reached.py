"""Problems whose orders docs/convergence.md states, with exact solutions.

slab: heat in a solid at rest, T = 1 + 1e-6 cos(2 pi X + phase) exp(-a t), the phase 0 between
insulated ends, pi/2 between ends of the temperature 1, and 0.7 between ends with heat flux(t).
gas: a wave of density is carried along at p = 1 and u = 0.4, between ends where all is given.
"""

from __future__ import annotations

import numpy as np

from fsipetsc.boundaries import Dirichlet, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "orders_reached"
SUMMARY = "heat in a slab, or a wave of density in a gas"
PROBLEMS = "insulated", "warm", "heated", "gas"
OPTIONS = (Option("orders_problem", str, "insulated", "", "which problem", PROBLEMS),)
DEFAULTS = {"fsi_h": 0.05, "ts_max_time": 0.5, "fsi_output_dt": 1.0}

SLAB, K = Solid(20.0, 0.1, 2.0, 1.0), 2 * np.pi
PHASE = {"insulated": 0.0, "warm": 0.5 * np.pi, "heated": 0.7}


def slab(which):
    decay = SLAB.kappa_e / (SLAB.alpha * SLAB.m0) * K**2

    def warmth(X, t):
        return 1e-6 * np.exp(1j * (K * X + PHASE[which]) - decay * t)

    def exact(X, t):
        return 0 * X, 0 * X, 1 + warmth(X, t).real, X

    def into(X, outward):
        return lambda t: -outward * SLAB.kappa_e * K * warmth(X, t).imag

    heat = [{"heat_flux": into(X, outward)} for X, outward in ((0.0, -1), (1.0, 1))]
    if which != "heated":
        heat = [{"T": 1.0} if which == "warm" else {}] * 2
    layer = SolidLayer("slab", SLAB, (0.0, 1.0), lambda X: exact(X, 0.0), exact=exact)
    return Problem((layer,), clamped(**heat[0]), clamped(**heat[1]), units="none")


def wave(X, t):
    rho = 1 + 0.2 * np.sin(2 * np.pi * (X - 0.4 * t) + 0.3)
    return rho, 0.4 + 0 * rho, 1 / rho


def build(opt):
    if opt["orders_problem"] != "gas":
        return slab(opt["orders_problem"])
    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    layer = FluidLayer("gas", gas, (0.0, 1.0), lambda X: wave(X, 0.0), exact=wave)
    ends = (Dirichlet(x, lambda t, x=x: tuple(map(float, wave(x, t)))) for x in (0.0, 1.0))
    return Problem((layer,), *ends, units="none")
