"""The conservative coupling in two dimensions: at each point of an interface the gas and the solid are one particle.

As in fsipetsc.coupling.conservative, of whose masses and energies these are the same per length of the interface: the rates of
both end points are unloaded, traction and heat through the interface do not enter those of the sums

    momentum   r J rho (u, v) + m0 (u, v)_s,                       r = h_gas / h_solid across the layers
    energy     r J e + (m0 |u_s|^2 / 2) + m0 alpha T_s,

and velocity and temperature follow from these. Nothing couples the points along the interface: each is solved on its own, by
every rank that needs it, from the same ten numbers.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.conservative import shared_temperature
from fsipetsc.operators.kernels import OPTIONS

#: what is known of a point: J (1, rho, rho u, rho v, e) of the gas, (x, y, u, v, T) of the solid (displacements), and the
#: kinetic energy m0 |u|^2 / 2 of its end point
COLUMNS, KINETIC = 11, 10
#: what may hold a point
HELD, HELD_X = 1, 2
#: rates of J (rho, rho u, rho v) of the gas, and of the velocity of the solid
RATES = 5


@njit(**OPTIONS)
def meet(pair, face, points, held):
    """One velocity and, where both conduct, one temperature at each of the points (n, COLUMNS), in place.

    face: an INTERFACE record, of which h, h_gas, the gas, m0, alpha, kappa and kappa_e are needed. held: (n,), 0, or HELD
    where the end of a solid or a wall holds the point, or HELD_X where it does so against X alone.
    """
    r, m0, heat = face.h_gas / face.h, face.m0, face.m0 * face.alpha
    shared = face.kappa > 0.0 and face.kappa_e > 0.0
    for n in range(points.shape[0]):
        q = points[n]
        mass = r * q[1]
        u, v = (r * q[2] + m0 * q[7]) / (mass + m0), (r * q[3] + m0 * q[8]) / (mass + m0)
        u, v = (0.0 if held[n] != 0 else u), (0.0 if held[n] == HELD else v)
        kinetic = 0.5 * m0 * (u * u + v * v)
        energy = r * q[4] + (q[10] - kinetic)
        if shared:
            rest = energy - 0.5 * mass * (u * u + v * v) + heat * q[9]
            T = shared_temperature(pair, face, q[1] / q[0], mass, heat, rest, q[9])
            energy += heat * (q[9] - T)
            q[9] = T
        q[2], q[3], q[4] = q[1] * u, q[1] * v, energy / r
        q[7], q[8], q[10] = u, v, kinetic


@njit(**OPTIONS)
def meet_sliding(pair, face, points, held, normals):
    """One normal velocity at each point where the gas slips along the solid, in place; arguments as of ``meet``.

    normals: (n, 4), N = (-y_xi, x_xi) and its rate. Momentum is kept, and energy: the gas gets what the solid's kinetic energy
    has changed by. The temperature is shared where both conduct.
    """
    r, m0, heat = face.h_gas / face.h, face.m0, face.m0 * face.alpha
    shared = face.kappa > 0.0 and face.kappa_e > 0.0
    for n in range(points.shape[0]):
        q = points[n]
        mass, nx, ny = r * q[1], normals[n, 0], normals[n, 1]
        u, v, u_s, v_s = q[2] / q[1], q[3] / q[1], q[7], q[8]
        if held[n] != 0:
            u_s, v_s = 0.0, (0.0 if held[n] == HELD else v_s)
        gap = (nx * (u_s - u) + ny * (v_s - v)) / (nx * nx + ny * ny)
        part = 1.0 if held[n] == HELD else m0 / (mass + m0)
        u, v = u + part * gap * nx, v + part * gap * ny
        if held[n] != HELD:
            u_s, v_s = u_s - (1.0 - part) * gap * nx * (held[n] == 0), v_s - (1.0 - part) * gap * ny
        kinetic = 0.5 * m0 * (u_s * u_s + v_s * v_s)
        energy = r * q[4] + (q[10] - kinetic)
        if shared:
            rest = energy - 0.5 * mass * (u * u + v * v) + heat * q[9]
            T = shared_temperature(pair, face, q[1] / q[0], mass, heat, rest, q[9])
            energy += heat * (q[9] - T)
            q[9] = T
        q[2], q[3], q[4] = q[1] * u, q[1] * v, energy / r
        q[7], q[8], q[10] = u_s, v_s, kinetic


@njit(**OPTIONS)
def slide(face, weight, q, f, held, normal):
    """What the pressure pi between gas and solid, a traction pi N, adds to the rates at a point q where the gas slips.

    pi |N|^2 (1/M_f + 1/M_s) = N.(a_s - a_f) - N_t.(u - u_s), with the unloaded accelerations a and the masses M_f = h_gas
    a_0 J rho, M_s = h a_0 m0: both sides go on with one normal velocity. f: (RATES,); in place, what is to be added: to
    those of J (rho u, rho v, e) of the gas, and of the velocity of the solid. weight: a_0.
    """
    nx, ny = normal[0], normal[1]
    u, v = q[2] / q[1], q[3] / q[1]
    a_x, a_y = (f[1] - u * f[0]) / q[1], (f[2] - v * f[0]) / q[1]
    s_x, s_y = (0.0 if held != 0 else f[3]), (0.0 if held == HELD else f[4])
    of_gas = 1.0 / (face.h_gas * weight * q[1])
    of_solid = 0.0 if held == HELD else 1.0 / (face.h * weight * face.m0)
    turned = normal[2] * (u - q[7]) + normal[3] * (v - q[8])
    pi = (nx * (s_x - a_x) + ny * (s_y - a_y) - turned) / ((nx * nx + ny * ny) * (of_gas + of_solid))
    per_length = pi / (face.h_gas * weight)
    f[0], f[1], f[2] = per_length * nx, per_length * ny, per_length * (nx * q[7] + ny * q[8])
    f[3], f[4] = -pi * of_solid * nx, -pi * of_solid * ny
