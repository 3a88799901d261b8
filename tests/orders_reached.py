"""Problems whose orders docs/convergence.md states, with exact solutions.

slab: heat in a solid at rest, T = 1 + 1e-6 cos(2 pi X + phase) exp(-a t), the phase 0 between
insulated ends, pi/2 between ends of the temperature 1, and 0.7 between ends with heat flux(t).
gas: a wave of density is carried along at p = 1 and u = 0.4, between ends where all is given.
shock: a viscous shock of Mach number 1.3 (R. Becker, Z. Phys. 8 (1922) 321-362) goes out through
the right end, where all is given; shock_open, shock_first: where it is open to the gas at rest
before it, to order 0 and 1.
"""

import numpy as np

from fsipetsc.boundaries import Dirichlet, Open, clamped
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import Solid
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

PROBLEMS = "insulated", "warm", "heated", "gas", "shock", "shock_open", "shock_first"
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

    def end(X, outward):
        if which == "heated":
            return clamped(heat_flux=lambda t: -outward * SLAB.kappa_e * K * warmth(X, t).imag)
        return clamped(T=1.0) if which == "warm" else clamped()

    layer = SolidLayer("slab", SLAB, (0.0, 1.0), lambda X: exact(X, 0.0), exact=exact)
    return Problem((layer,), end(0.0, -1), end(1.0, 1), units="none")


def wave(X, t):
    rho = 1 + 0.2 * np.sin(2 * np.pi * (X - 0.4 * t) + 0.3)
    return rho, 0.4 + 0 * rho, 1 / rho


#: of the shock: velocities of the gas before it (p = rho = 1) and behind it, seen from the shock,
#: which starts at X = 0.75
GAMMA, MU, MACH = 1.4, 0.02, 1.3
CP = GAMMA / (GAMMA - 1)
BEFORE = MACH * GAMMA**0.5
BEHIND = BEFORE * (GAMMA - 1 + 2 / MACH**2) / (GAMMA + 1)


def shock(X, t):
    """With w = u seen from the shock, 4/3 mu c_p = kappa: c_p T + w^2/2 is constant, and
    4/3 mu w w_x = (gamma + 1)/(2 gamma) m (w - w_1)(w - w_2), solved by bisection in z where
    w = w_2 + (w_1 - w_2)/(1 + exp(-z))."""
    place = 0.75 + BEFORE * t - np.asarray(X, float)
    length = 8 / 3 * MU * GAMMA / ((GAMMA + 1) * BEFORE) / (BEFORE - BEHIND)
    low, high = np.full(place.shape, -300.0), np.full(place.shape, 300.0)
    for _ in range(70):
        z = 0.5 * (low + high)
        x = length * (BEHIND * np.logaddexp(0, -z) - BEFORE * np.logaddexp(0, z))
        low, high = np.where(x > place, z, low), np.where(x > place, high, z)
    w = BEHIND + (BEFORE - BEHIND) / (1 + np.exp(-z))
    return BEFORE / w, BEFORE - w, 1 + 0.5 * (BEFORE**2 - w**2) / CP


def build(opt):
    which = opt["orders_problem"]
    if which in PHASE:
        return slab(which)
    exact, mu = (wave, 0.0) if which == "gas" else (shock, MU)
    gas = Fluid(mu, 4 / 3 * mu * CP, GAMMA, 1.0)
    layer = FluidLayer("gas", gas, (0.0, 1.0), lambda X: exact(X, 0.0), exact=exact)
    left, right = (Dirichlet(x, lambda t, x=x: tuple(map(float, exact(x, t)))) for x in (0.0, 1.0))
    if which in ("shock_open", "shock_first"):
        right = Open(1.0, 1.0, 1.0, order=int(which == "shock_first"))
    return Problem((layer,), left, right, units="none")
