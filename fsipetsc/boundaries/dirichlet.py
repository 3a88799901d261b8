"""Exact data (rho, u, T) at an embedded boundary: as many of them as the equations need, at every viscosity and speed.

Seen from the boundary, with n the outward normal and c the speed of sound,

    | | without viscosity | what viscosity (u) and conduction (T) add |
    |---|---|---|
    | inflow faster than sound | rho, u, T | nothing new |
    | inflow | p - n Z u, entropy | u, T: three in all |
    | outflow | p - n Z u | u, T |
    | outflow faster than sound | nothing | u, T |

The two columns are imposed at two places. *The ghost point itself* takes what comes in along characteristics from the
formulas (4.26) of degree q; the outgoing characteristic p + n Z u and on outflow the entropy rho - p/c^2 keep their values.
Z = rho c and c are taken one point inside, as at an interface: then a ghost point that is filled already does not change.
*The gradients* of u and T in friction and heat conduction see at the ghost point the values of the formulas instead. What
viscosity and conduction ask for is so imposed where they act: with mu = 0 nothing is asked of u, with kappa = 0 nothing of
T, and no number of cells or viscosity decides between two rules. Inflow is what the data say; that nothing comes in on
outflow is what the first point inside says.

(Imposed at the ghost point, three conditions at inflow and two at outflow grow at all cell Peclet numbers
nu/(c h) < 10: by up to 1.6 c/h a second. Two and one alone leave viscous problems without a unique solution: no convergence
once nu/(c h) is about 1.) Around a uniform flow, Mach -2 to 1.5, nu/(c h) 0 to 10, no mode grows and the classical Runge-Kutta
method is stable at Courant number 0.8: tests/test_ends.py. The exception is a boundary that stays within 0.15 h of the first
point inside with degree 4 or 5 (6/3, 8/4): incoming waves then grow, by less than a factor of e in the time L/c, L the width
of the layer. (A least weight of the ghost point in the formulas that falls from 1/4 to 1/10 there ends it, but makes the errors
of ``mms`` up to four times as large.)
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, bounded_ghost, dirichlet_ghost

NEW_POINT = 3


@njit(**OPTIONS)
def note_gradient(layer, side, nodes, weights):
    """Put u and T of the formulas where the gradients find them; from the points inside alone."""
    q, data = layer.end_degree[side], layer.end_data[side]
    least = 0.25 if q < 4 else 0.3  # else the friction of the ghost point takes more than the time step gives
    layer.end_gradient[side, 0] = bounded_ghost(data[1], nodes[1], weights, q, least)
    layer.end_gradient[side, 1] = bounded_ghost(data[2], nodes[2], weights, q, least)


@njit(**OPTIONS)
def dirichlet(law, layer, side, normal, nodes, weights):
    """Fill the ghost values nodes[:, 0] of (rho, u, T); end_data = (rho, u, T) at the boundary."""
    gas, c = law.gas, law.gas.constants(layer)
    q, data = layer.end_degree[side], layer.end_data[side]
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    note_gradient(layer, side, nodes, weights)
    rho_d = dirichlet_ghost(data[0], nodes[0], weights, q)
    u_d = dirichlet_ghost(data[1], nodes[1], weights, q)
    T_d = dirichlet_ghost(data[2], nodes[2], weights, q)
    c2 = gas.sound_speed_squared(c, nodes[0, 1], nodes[2, 1])
    speed = np.sqrt(c2)
    if normal * data[1] <= -np.sqrt(gas.sound_speed_squared(c, data[0], data[2])):
        nodes[0, 0], nodes[1, 0], nodes[2, 0] = rho_d, u_d, T_d
        return
    if normal * data[1] >= 0.0 and normal * nodes[1, 1] >= speed:
        return
    impedance = nodes[0, 1] * speed
    p, p_d = gas.pressure(c, rho, T), gas.pressure(c, rho_d, T_d)
    outgoing = p + normal * impedance * u
    incoming = p_d - normal * impedance * u_d
    entropy = rho - p / c2 if normal * data[1] >= 0.0 else rho_d - p_d / c2
    p = 0.5 * (incoming + outgoing)
    rho = entropy + p / c2
    nodes[0, 0] = rho
    nodes[1, 0] = normal * (outgoing - incoming) / (2.0 * impedance)
    nodes[2, 0] = gas.temperature_of_pressure(c, rho, p)
