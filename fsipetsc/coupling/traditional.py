"""The traditional coupling: the solid moves the fluid, the fluid loads the solid.

The fluid gets the solid's velocity and temperature, as at a moving wall; the solid gets the fluid's stress and heat
flux, as at a loaded end. At the interface point, from the values ~ of the two layers:

    u_f = u~_s - g_u                      sigma = p_s - p_f + mu' u_X + g_s,     p_f = R rho~ T_f
    T_f = T_s - g_T                       T_s: kappa_e/x_X T_s,X = kappa T_f,X + g_k

where u_X and T_f,X already contain the new values. The last two are two linear equations for the two temperatures,
(4.21), that `projection` solves too; the velocity and the stress are where the two treatments differ. The solid
keeps its velocity, the fluid its density; no other point changes. All conditions hold, up to those on the
temperatures that cannot be imposed without heat conduction (see `interface_temperatures`), but the energy may grow
without bound, the more so the lighter the solid: this treatment is here to be compared with.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.interface import (
    JUMP_STRESS,
    JUMP_U,
    gas_energy,
    gas_pressure,
    solid_pressure,
    solid_strain,
    viscosity,
)
from fsipetsc.coupling.projection import interface_temperatures
from fsipetsc.operators.kernels import OPTIONS, row_length


@njit(**OPTIONS)
def traditional(pair, face, op, trace_f, trace_s):
    """Impose the interface conditions on the traces in place; see the module and fsipetsc.coupling.interface."""
    x_X = solid_strain(face, op, trace_s)
    T_f, T_s = interface_temperatures(pair, face, op, trace_f, trace_s, x_X)
    rho, u = trace_f[0, 0], trace_s[0, 0] - face.jump[JUMP_U]
    trace_f[0, 1] = rho * u
    trace_f[0, 2] = gas_energy(pair, face, rho, u, T_f)
    d, u_X = face.normal / face.spacing, 0.0
    for j in range(row_length(op)):
        u_X += d * op.closure[0, j] * (trace_f[j, 1] / trace_f[j, 0])
    fluid_stress = -gas_pressure(pair, face, rho, T_f) + viscosity(pair, face, T_f) * u_X
    trace_s[0, 1] = solid_pressure(pair, face, T_s, x_X) + fluid_stress + face.jump[JUMP_STRESS]
    trace_s[0, 2] = T_s
