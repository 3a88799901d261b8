"""The conservative coupling: the end points of gas and solid are one particle, with one velocity and one temperature.

Both end points are unloaded (fsipetsc.scheme.end_rates): in their rates no traction, heat or mass goes through the interface.
What does is equal and opposite on the two sides, so it does not enter the rates of the sums: with M_f = J rho h_f a_0 and
M_s = m0 h_s a_0 the masses of the two end points, and r = h_f/h_s,

    momentum   P = r J rho u_f + m0 u_s
    energy     E = r J e + (m0 u_s^2/2) + m0 alpha T_s

(each over h_s a_0). These are what is integrated in time; velocity and temperature follow from them,

    u_f = (P - m0 g_u) / (r J rho + m0),    u_s = u_f + g_u
    r J rho (u_f^2/2 + eps(rho, T_f)) + m0 u_s^2/2 + m0 alpha (T_f + g_T) = E,    T_s = T_f + g_T,

so that mass, momentum and energy are linear in what a Runge-Kutta method integrates: kept to round-off, and without an error
in the order. That is the scheme whose Lagrange multiplier is the interface traction (index 1: one acceleration), written in
coordinates of its constraint. The kinetic energy of the solid's end point is not linear in its velocity: it has a rate of its
own, m0 u_s times the unloaded acceleration, and a place of its own beside the unknowns; here it is trace_s[0, 4].

Where one side does not conduct heat, its temperature stays apart: E is then without m0 alpha T_s. Prescribed jumps are in the
rates (fsipetsc.scheme.end_rates). No other point changes, and no derivative is taken here.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.interface import JUMP_T, JUMP_U
from fsipetsc.operators.kernels import OPTIONS

#: Newton's method for T ends at a change of this fraction, or after so many steps (one is enough for a perfect gas)
AGREED, STEPS = 1e-15, 20


@njit(**OPTIONS)
def conservative(pair, face, op, trace_f, trace_s):
    """Velocity and temperature of the two end points from what they have together; see the module.

    trace_f: J (rho, rho u, e). trace_s has five columns, the last one m0 u^2/2 in its first row.
    """
    r, m0 = face.h_gas / face.h, face.m0
    mass = r * trace_f[0, 0]
    u = (r * trace_f[0, 1] + m0 * (trace_s[0, 0] - face.jump[JUMP_U])) / (mass + m0)
    u_s = u + face.jump[JUMP_U]
    kinetic = 0.5 * m0 * u_s * u_s
    energy = r * trace_f[0, 2] + (trace_s[0, 4] - kinetic)
    if face.kappa > 0.0 and face.kappa_e > 0.0:
        heat, g_T = m0 * face.alpha, face.jump[JUMP_T]
        T = shared_temperature(
            *(pair, face, trace_f[0, 0] / face.J, mass, heat),
            *(energy - 0.5 * mass * u * u + heat * (trace_s[0, 2] - g_T), trace_s[0, 2] - g_T),
        )
        energy += heat * (trace_s[0, 2] - (T + g_T))
        trace_s[0, 2] = T + g_T
    trace_f[0, 1], trace_f[0, 2] = trace_f[0, 0] * u, energy / r
    trace_s[0, 0], trace_s[0, 4] = u_s, kinetic


@njit(**OPTIONS)
def shared_temperature(pair, face, rho, mass, heat, energy, T):
    """T with mass eps(rho, T) + heat T = energy, by Newton's method from T."""
    gas, c = pair.gas, pair.gas.constants(face)
    for _ in range(STEPS):
        missing = energy - mass * gas.energy(c, rho, T) - heat * T
        change = missing / (mass * gas.heat_capacity(c, rho, T) + heat)
        T += change
        if not abs(change) > AGREED * abs(T):
            break
    return T
