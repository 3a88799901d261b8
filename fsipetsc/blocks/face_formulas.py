"""What formulas of conditions are given at a face, and what passes those through which gas goes:
F(U) = n . (f(U) - v U), v the velocity of the grid.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.gas import of_sound
from fsipetsc.equations.vectors import along, choose, dot, mean, scale, sub

#: first order of an open face fades out where viscosity is this fraction of L times the speed at
#: which sound leaves, L the length of the gas
LONGEST = 0.25


class FaceNode(NamedTuple):
    """What a formula is given at a node of a face, as symbols.

    n: outward area vector per unit of the reference coordinates, size: |n|; g: n . v of the grid's
    velocity v; wall: v where the face goes with the grid, else 0. beyond: (rho, p, u, T) outside;
    pressure: as given; width: length of the gas behind the face; slip: the slip length; rise:
    outward derivative of the outward velocity, None where order is 0.
    """

    n: Any
    size: Any
    g: Any
    wall: Any
    beyond: Any
    pressure: Any
    width: Any
    slip: Any
    rise: Any


@dataclass(frozen=True)
class Effect:
    """What a condition adds to rates, without its data: faces of one effect share a loop.

    by: the class with its formula, if it has one. heated: heat comes in. moves: the face goes with
    the grid. first_order: viscosity and conduction matter to what leaves.
    """

    by: Any
    heated: bool = False
    moves: bool = False
    first_order: bool = False


def surface_flux(gas, w, n, g):
    """F(U) of the state w; g: n . v."""
    return along(gas.flux(w, n), -g, gas.densities(w))


def mixed_flux(gas, w, beyond, n, g):
    """1/2 (F(U_in) + F(U_out)) - 1/2 lambda (U_out - U_in), lambda = max over both of
    |n . (u - v)| + c |n| (local Lax-Friedrichs).
    """
    fastest = gas.fastest(w, n, g), gas.fastest(beyond, n, g)
    jump = sub(gas.densities(beyond), gas.densities(w))
    both = mean(surface_flux(gas, w, n, g), surface_flux(gas, beyond, n, g))
    return along(both, -0.5 * np.maximum(*fastest), jump)


def open_flux(gas, w, face: FaceNode):
    """F(U*) of `fsipetsc.blocks.conditions.Open`, or the flux of Lax and Friedrichs."""
    beyond, viscous = face.beyond, (0.0, 0.0, 0.0)
    if face.rise is not None:
        a = (dot(face.n, gas.velocity(w)) - face.g) / face.size
        viscous, beyond = first_order(gas, w, a, beyond, face.width, face.rise)
    found, there_is = by_characteristics(gas, w, beyond, face, viscous)
    return choose(there_is, found, mixed_flux(gas, w, beyond, face.n, face.g))


def first_order(gas, w, a, beyond, width, v_n):
    """Of a node of an open face: the incoming sound, the viscous stress, the incoming heat, and
    the gas beyond with the temperature that leaving sound gives it.

    To first order in viscosity and conduction, as docs/open-end.md derives it for small
    disturbances of the gas beyond. a: velocity through the face; v_n: outward derivative
    of the outward velocity [1/s].
    """
    law, rho0, T0 = gas.law, beyond[0], beyond[2]
    c, cv, by_heat, tau, capacity = of_sound(law, rho0, T0)
    mu = 4.0 / 3.0 * gas.mu * gas.transport.viscosity(T0)
    kappa = gas.kappa * gas.transport.conductivity(T0)
    longest = LONGEST * (c + np.minimum(a, 0.0)) * width
    part = np.maximum(0.0, 1.0 - np.maximum(mu, kappa / cv) / (rho0 * longest))
    part = np.where(longest > 0.0, part, 0.0)
    alpha = kappa / capacity
    lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) * (alpha / width)) - a)
    warmer = np.where(a < 0.0, -part * alpha * tau * rho0 * v_n, 0.0)
    warmer = np.minimum(np.maximum(warmer, -0.5 * T0), 0.5 * T0)
    heat = part * kappa * tau * rho0 * c * v_n
    let_out = capacity * lost * (w[2] - T0 - warmer - tau * (w[1] - beyond[1]))
    heat = heat - np.where(kappa > 0.0, let_out, 0.0)
    sound, T = part * 0.5 * (mu - tau * by_heat * kappa) * v_n, T0 + warmer
    beyond = gas.state(law.density(beyond[1], T), gas.velocity(beyond), T)
    return (sound, part * mu * v_n, heat), beyond


def by_characteristics(gas, w, beyond, face, viscous):
    """F(U*) and whether there is such a gas; viscous: see `first_order`."""
    law, (sound, stress, heat), (n, size, g, *_) = gas.law, viscous, face
    N = scale(1.0 / size, n)
    rho, p, u = w[0], w[1], gas.velocity(w)
    rho_out, p_out, u_out = beyond[0], beyond[1], gas.velocity(beyond)
    c, c_out = gas.speed_of_sound(w), gas.speed_of_sound(beyond)
    a, a_out = dot(N, u) - g / size, dot(N, u_out) - g / size
    rho_mean = rho + 0.5 * (p_out - p) / (c * c)
    T_mean = law.temperature_of(rho_mean, 0.5 * (p + p_out))
    Z = rho_mean * np.sqrt(law.sound_speed_squared(rho_mean, T_mean))
    speed = 0.5 * (a + a_out) + 0.5 * (p - p_out - sound) / Z
    between = 0.5 * (p + p_out + sound) + 0.5 * Z * (a - a_out)
    fast_out, fast_in = a >= c, a_out <= -c_out
    leaves = fast_out | ((speed >= 0.0) & ~fast_in)
    of_side = np.where(leaves, rho, rho_out), np.where(leaves, p, p_out), np.where(leaves, c, c_out)
    rho_face = of_side[0] + (between - of_side[1]) / (of_side[2] * of_side[2])
    slow = choose(fast_in, (a_out, rho_out, p_out), (speed, rho_face, between))
    speed, rho_face, between = choose(fast_out, (a, rho, p), slow)
    T_face = law.temperature_of(rho_face, between)
    there_is = (rho_mean > 0.0) & (T_mean > 0.0) & (rho_face > 0.0) & (T_face > 0.0)
    known = choose(leaves, along(u, speed - a, N), along(u_out, speed - a_out, N))
    F = surface_flux(gas, gas.state(rho_face, known, T_face), n, g)
    lost = (0.0, *scale(stress, n), size * (stress * (speed + g / size) + heat))
    return sub(F, lost), there_is
