"""A column of materials that are not the built-in pair under gravity, held or in free fall.

gas | solid | gas | solid | gas: Sutherland's law, the pressure of Mie and Grüneisen, Sutherland's
law with other numbers, that of a stiffened gas, powers of T, written by hand as a user would; a
body force acts on all. Pressures are written as the literature has them: p of rho and epsilon.
"""

from __future__ import annotations

import numpy as np

from fsipetsc.boundaries import Wall
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.own import transport_law
from fsipetsc.materials.power_law import power_law
from fsipetsc.materials.solid_pressure import mie_gruneisen, stiffened_pressure
from fsipetsc.materials.sutherland import sutherland
from fsipetsc.options import Option
from fsipetsc.problem import FluidLayer, Problem, SolidLayer

NAME = "materials"
SUMMARY = "other materials under gravity"
OPTIONS = (
    Option("materials_state", str, "column", "", "held or falling", choices=("column", "fall")),
)
DEFAULTS = {"fsi_h": 0.025, "ts_max_time": 0.45, "fsi_output_dt": 1.0}

FORCE = -1.5
MU, KAPPA, GAMMA, R = 0.015, 0.045, 1.4, 1.0
K, KAPPA_E, M0, ALPHA, T_0 = 10.0, 0.03, 2.0, 1.0, 3.0
#: temperature of the column
REST = 5.0

# pressures as the literature has them, and transport by hand


def mu_by_hand(T):
    """The same as a law of a case file."""
    return (T / 10) ** 0.7


def kappa_by_hand(T):
    """The same as a law of a case file."""
    return (T / 10) ** 0.9


def of_mie(rho, epsilon, c_0=2.0, s=1.3, G=1.5):
    """p about the Hugoniot."""
    eta = 1 - M0 / rho
    p_H = M0 * c_0**2 * eta / (1 - s * eta) ** 2
    epsilon_H = ALPHA * T_0 + p_H * eta / (2 * M0)
    return p_H + G * M0 * (epsilon - epsilon_H)


def of_stiffened(rho, epsilon, gamma=1.5, p_inf=4.0, p_0=1.0):
    """p of a stiffened gas that has p_0 at T_0."""
    q = ALPHA * T_0 - (p_0 + gamma * p_inf) / ((gamma - 1) * M0)
    return (gamma - 1) * rho * (epsilon - q) - gamma * p_inf


#: of the layers from left to right: the pressure above of solids, and the built-in laws
LAWS = (
    (None, sutherland(10.0, 4.0, 7.0)),
    (of_mie, mie_gruneisen(2.0, 1.3, 1.5, T_0)),
    (None, sutherland(8.0, 2.0)),
    (of_stiffened, stiffened_pressure(1.5, 4.0, T_0, 1.0)),
    (None, power_law(10.0, 0.7, 0.9)),
)
OWN = transport_law(mu_by_hand, kappa_by_hand)


def layer(k, X, exact):
    """Layer k with its material and an exact solution, with which it starts; the last gas has the
    law written by hand.
    """
    if k % 2:
        kind, material = SolidLayer, Solid(K, KAPPA_E, M0, ALPHA, FORCE, pressing=LAWS[k][1])
    else:
        transport = OWN if k == 4 else LAWS[k][1]
        kind, material = FluidLayer, Fluid(MU, KAPPA, GAMMA, R, transport=transport, force=FORCE)
    return kind(f"layer {k}", material, X, initial=lambda X: exact(X, 0.0), exact=exact)


def column():
    """At rest between two walls at one temperature: each layer carries those above it."""
    layers, p = [], 16.0
    for k in range(5):
        X0, X1 = float(k), float(k + 1)
        if k % 2:

            def exact(X, t, k=k, p=p, X0=X0):
                stress = LAWS[k][0](M0, ALPHA * REST) - p - M0 * FORCE * (X - X0)
                return 0.0 * X, stress, REST + 0.0 * X, X

            p += M0 * FORCE
        else:

            def exact(X, t, p=p, X0=X0):
                rho = p / (R * REST) * np.exp(FORCE / (R * REST) * (X - X0))
                return rho, 0.0 * X, REST + 0.0 * X

            p *= np.exp(FORCE / (R * REST))
        layers.append(layer(k, (X0, X1), exact))
    return Problem(tuple(layers), Wall(0.0), Wall(5.0), units="none")


def fall():
    """Under one pressure between two walls: all fall alike, and nothing else changes."""

    def gas_falls(X, t):
        return 10.0 / (R * REST) + 0.0 * X, FORCE * t + 0.0 * X, REST + 0.0 * X

    def solid_falls(k):
        stress = LAWS[k][0](M0, ALPHA * REST) - 10.0

        def falls(X, t):
            zero = 0.0 * X
            return FORCE * t + zero, stress + zero, REST + zero, X + 0.5 * FORCE * t * t

        return falls

    exact = [solid_falls(k) if k % 2 else gas_falls for k in range(5)]
    layers = [layer(k, (float(k), float(k + 1)), f) for k, f in enumerate(exact)]
    ends = [(lambda t, x=x: x + 0.5 * FORCE * t * t) for x in (0.0, 5.0)]
    walls = [Wall(x, velocity=lambda t: FORCE * t) for x in ends]
    return Problem(tuple(layers), *walls, units="none")


def build(opt):
    return {"column": column, "fall": fall}[opt["materials_state"]]()
