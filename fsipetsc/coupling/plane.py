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
COLUMNS = 11
#: what may hold a point
HELD, HELD_X = 1, 2


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
