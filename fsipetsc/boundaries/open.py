"""Open end: artificial boundary conditions of order 0 or 1 in the viscosity, towards gas of p0, T0 and velocity u0.

After Halpern, SIAM J. Math. Anal. 22 (1991) 1256-1283: of the modes e^(st + lambda n x) of the linearised equations those stay
that decay beyond the end; what they obey is expanded in mu' and kappa. With v = n (u - u0), n the outward normal, Z = rho0 c0,
a = n u, alpha = kappa/(rho0 cp), q = T - tau p, tau = dT/dp at constant entropy, and _n for the outward derivative:

    sound             p - p0 = Z v + b v_n - p_T kappa/(rho0 cv c0) q_n,     b = (mu' - tau p_T kappa/cv)/2
    entropy, a < 0    that of the gas beyond
    heat              alpha q_n = (a - S)/2 q,   but q_nn = 0 for a > 0
    friction, a < 0   u_nn = 0

S^2 = a^2 + 4 (alpha/L)^2, L the width of the layer. Order 0 has Z v alone on the right of the first, alpha T_n on the left of
the third, for a > 0 as well. A gas that does not conduct has no third one, one without friction no fourth: nothing is asked
of the gradient then, and nothing divided by.

*Derivation*: in docs/open-end.md, with what is reflected. Sound that leaves has v_n = p_n/Z = -v_t/(c0 + a) to lowest
order; that form is taken with which a ghost point can be filled for any b/(Z h): v_n where b > 0, p_n where b < 0.

*Finite amplitude.* Instead of p - p0 stands what it makes of Z v in a simple wave of the gas beyond: with m = (gamma-1)/2 gamma
and in units of rho0 c0^2/gamma, ((1 + y)^m - 1)/m = y (1 + (1+m) y/6)/(1 + (2-m) y/3) + O(y^4). So neither is finite sound
reflected, nor does a hot gas make sound that flows out at p0 and u0. A flow out faster than sound is left alone.

*Where.* The ghost point takes sound and entropy; the outgoing characteristic p + n Z1 u, and on outflow the entropy, keep
their values, with Z1 of one point inside. Heat and friction are imposed in the gradients, as in dirichlet.py. Where between
two points the end is does not matter: an artificial end may be anywhere.

*Stability.* Order 1 fades out towards viscosities max(mu'/rho0, kappa/(rho0 cv)) of c0 L/4, where the expansion
means nothing; q_nn = 0, with which heat drifts at rest, fades to q_n = 0 as a L/4 falls below alpha; the share of
sound in the heat flux towards inflow with the speed of sound. Around a uniform flow, Mach -1.5 to 1.5, nu/(c h) 0 to 10, then
no mode grows and the classical Runge-Kutta method is stable at Courant number 0.8: tests/test_open.py.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS

NEW_POINT = 1
#: order 1 ends where viscosity is this fraction of c0 L; q_nn = 0 where alpha is this fraction of a L
LONGEST = 0.25


@njit(**OPTIONS)
def width(layer):
    """Of the gas between its ends."""
    return layer.h * layer.J * (layer.hi - layer.lo)


@njit(**OPTIONS)
def beyond(law, layer, side):
    """(rho0, c0, tau, alpha, p_T/cv, b, kappa) of the gas beyond the end, and how much of order 1 there is, 0 to 1."""
    gas, c = law.gas, law.gas.constants(layer)
    p0, T0 = layer.end_data[side, 0], layer.end_data[side, 1]
    numbers, rho = law.transport.constants(layer), gas.density(c, p0, T0)
    of_mu, of_kappa = law.transport.relative(numbers, T0)
    c2, cv = gas.sound_speed_squared(c, rho, T0), gas.heat_capacity(c, rho, T0)
    speed, by_heat = np.sqrt(c2), gas.pressure_by_temperature(c, rho, T0) / cv
    mu, kappa, tau = layer.mu * of_mu, layer.kappa * of_kappa, T0 * by_heat / (rho * rho * c2)
    alpha = kappa * gas.bulk_modulus(c, rho, T0) / (cv * rho * rho * c2)
    longest = LONGEST * speed * width(layer)
    part = layer.end_data[side, 3] * max(0.0, 1.0 - max(mu, kappa / cv) / (rho * longest))
    return rho, speed, tau, alpha, by_heat, 0.5 * (mu - tau * by_heat * kappa), kappa, part


@njit(**OPTIONS)
def carried(layer, a, alpha, part):
    """How much of q_nn = 0 there is where gas flows out with a, 0 to 1."""
    carrying = max(a, 0.0) * LONGEST * width(layer)
    return part * carrying / (carrying + alpha)


@njit(**OPTIONS)
def open_end(law, layer, beyond, side, normal, nodes):
    """Fill the ghost values nodes[:, 0] of (rho, u, T); end_data = (p0, T0, u0, order), beyond as of the function."""
    gas, c = law.gas, law.gas.constants(layer)
    p0, T0, u0 = layer.end_data[side, 0], layer.end_data[side, 1], layer.end_data[side, 2]
    rho0, c0, tau, alpha, by_heat, b, kappa, part = beyond
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    rho1, T1, v1 = nodes[0, 1], nodes[2, 1], normal * (nodes[1, 1] - u0)
    c2 = gas.sound_speed_squared(c, rho1, T1)
    if normal * nodes[1, 1] >= np.sqrt(c2):
        return
    if normal * u0 <= -c0:
        nodes[0, 0], nodes[1, 0], nodes[2, 0] = rho0, u0, T0
        return
    p, p1 = gas.pressure(c, rho, T), gas.pressure(c, rho1, T1)
    impedance, scale, m = rho1 * np.sqrt(c2), rho0 * c0 * c0 / layer.gamma, 0.5 - 0.5 / layer.gamma
    # Z v (1 + by_v) = simple wave + by_p (p - p0) + known
    spacing = layer.h * layer.J
    by_v, by_p = part * max(b, 0.0) / (rho0 * c0 * spacing), part * max(-b, 0.0) / (rho0 * c0 * spacing)
    known = by_v * rho0 * c0 * v1 - by_p * (p1 - p0)
    if kappa > 0.0:
        q_n = (T1 - nodes[2, 2] - tau * (p1 - gas.pressure(c, nodes[0, 2], nodes[2, 2]))) / spacing
        known += carried(layer, normal * nodes[1, 1], alpha, part) * by_heat * kappa / (rho0 * c0) * q_n
    # with p + Z1 v, a quadratic equation for y
    share, rise, fall = impedance / (rho0 * c0 * (1.0 + by_v)), (1.0 + m) / 6.0, (2.0 - m) / 3.0
    outgoing = p - p0 + impedance * normal * (u - u0)
    free, wave = 1.0 + share * by_p, (outgoing - share * known) / scale
    half = 0.5 * (free + share - fall * wave)
    y = wave / (half + np.sqrt(half * half + (free * fall + share * rise) * wave))
    sound = scale * y
    u = u0 + normal * (outgoing - sound) / impedance
    rho = rho + (p0 + sound - p) / c2 if normal * u >= 0.0 else rho0 * (1.0 + y) ** (1.0 / layer.gamma)
    nodes[0, 0] = rho
    nodes[1, 0] = u
    nodes[2, 0] = gas.temperature_of_pressure(c, rho, p0 + sound)


@njit(**OPTIONS)
def note_gradient(law, layer, beyond, side, normal, nodes):
    """Put u and T where the gradients find them; nodes of a ghost point that is filled."""
    gas, c = law.gas, law.gas.constants(layer)
    u, T, T1 = nodes[1, 0], nodes[2, 0], nodes[2, 1]
    a = normal * u
    layer.end_gradient[side, 0], layer.end_gradient[side, 1] = u, T
    if layer.mu > 0.0 and (a < 0.0 or a * a >= gas.sound_speed_squared(c, nodes[0, 1], T1)):
        layer.end_gradient[side, 0] = 2.0 * nodes[1, 1] - nodes[1, 2]
    if layer.kappa > 0.0:
        _, c0, tau, alpha, _, _, _, part = beyond
        p, p1 = gas.pressure(c, nodes[0, 0], T), gas.pressure(c, nodes[0, 1], T1)
        q_n = T1 - nodes[2, 2] - tau * (p1 - gas.pressure(c, nodes[0, 2], nodes[2, 2]))
        slow, conducted = max(1.0 + min(a, 0.0) / c0, 0.0), alpha / (layer.h * layer.J)
        step = part * slow * slow * tau * (p - p1) + carried(layer, a, alpha, part) * q_n
        lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width(layer)) ** 2) - a)
        at_rest = layer.end_data[side, 1] + tau * (p - layer.end_data[side, 0])
        layer.end_gradient[side, 1] = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
