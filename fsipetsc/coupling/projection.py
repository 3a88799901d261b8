"""The paper's projection: temperatures first, then velocity, stress and pressure (Theorem 4.2, Sec. 4.2).

The two temperatures at the interface follow from (4.21). With them held, (u, sigma, rho) are projected
orthogonally, in the norm of the symmetric variables, on the conditions u_s = u_f and (4.24): multipliers l1, l2
from (4.23), then (4.9), (4.10). The fluid velocity changes on the whole closure row, because its derivative
stands in the stress condition; density and temperature change at the interface only.

Corrections to the printed formulas: beta_j in the second formula of (4.10) and 1/rho_f in (4.23a), K + p in the
bracket of (4.23b).
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.interface import (
    JUMP_FLUX,
    JUMP_STRESS,
    JUMP_T,
    JUMP_U,
    closure_derivative,
    conductivity,
    gas_energy,
    gas_pressure,
    gas_velocity_and_temperature,
    norm_weight,
    solid_pressure,
    solid_strain,
    viscosity,
)
from fsipetsc.operators.kernels import OPTIONS, row_length

#: the conductivity at the interface has the temperature that it leads to, but for this fraction, or after so many attempts
AGREED, REFINEMENTS = 1e-15, 20


@njit(**OPTIONS)
def interface_temperatures(pair, face, op, trace_f, trace_s, x_X):
    """(T_f, T_s) at the interface from continuity of temperature and heat flux, (4.21).

    Without heat conduction on either side the temperatures do not couple. With conduction on one side only,
    continuity of T cannot be imposed: that side gets its heat flux, the other keeps its temperature. The gas conducts
    with the kappa of its new temperature: where that depends on T, the temperatures are found again with it.
    """
    beta, n = op.closure[0], row_length(op)
    rest_f, T_f0 = 0.0, 0.0
    for j in range(n):
        _, T = gas_velocity_and_temperature(pair, face, trace_f, j)
        if j == 0:
            T_f0 = T
        else:
            rest_f += beta[j] * T
    d, d_solid = face.normal / face.spacing, face.normal / face.h
    rest_f *= d
    rest_s = closure_derivative(op, trace_s, 2, -d_solid) + d_solid * beta[0] * trace_s[0, 2]
    T_s0 = trace_s[0, 2]
    k_s, k_f = face.kappa_e / x_X, conductivity(pair, face, T_f0)
    d_f, d_s = d * beta[0], -d_solid * beta[0]
    for _ in range(REFINEMENTS):
        if k_s > 0.0 and k_f > 0.0:
            g_T = face.jump[JUMP_T]
            T_f0 = (face.jump[JUMP_FLUX] - k_s * (rest_s + d_s * g_T) + k_f * rest_f) / (k_s * d_s - k_f * d_f)
            T_s0 = T_f0 + g_T
        elif k_s > 0.0:
            T_s0 = (face.jump[JUMP_FLUX] / k_s - rest_s) / d_s
        elif k_f > 0.0:
            T_f0 = (-face.jump[JUMP_FLUX] / k_f - rest_f) / d_f
        used, k_f = k_f, conductivity(pair, face, T_f0)
        if not abs(k_f - used) > AGREED * used:
            break
    return T_f0, T_s0


@njit(**OPTIONS)
def projection(pair, face, op, trace_f, trace_s):
    """Project the traces in place on the interface conditions; see the module and fsipetsc.coupling.interface."""
    n, beta = row_length(op), op.closure[0]
    x_X = solid_strain(face, op, trace_s)
    T_f0, T_s0 = interface_temperatures(pair, face, op, trace_f, trace_s, x_X)
    ps = solid_pressure(pair, face, T_s0, x_X)

    # linearisation state: one point into the fluid; rho p_rho takes the place of p in a gas that is not perfect
    rho_hat = trace_f[1, 0]
    u1 = trace_f[1, 1] / rho_hat
    bulk = pair.gas.bulk_modulus_of_energy(pair.gas.constants(face), rho_hat, trace_f[1, 2] - 0.5 * rho_hat * u1 * u1)

    # the weights of the gas are as many times as large as its points are further apart
    inertia, bulk = rho_hat * face.ratio, bulk / face.ratio
    d, mu, a0 = face.normal / face.spacing, viscosity(pair, face, T_f0), op.norm[0]
    u_X, row_norm = 0.0, 0.0
    for j in range(n):
        u_X += d * beta[j] * (trace_f[j, 1] / trace_f[j, 0])
        row_norm += d * beta[j] * (d * beta[j]) / norm_weight(op, j)
    uf0, us0 = trace_f[0, 1] / trace_f[0, 0], trace_s[0, 0]
    p_tilde = gas_pressure(pair, face, trace_f[0, 0], T_f0)

    # (4.23)
    a11 = (1.0 / face.m0 + 1.0 / inertia) / a0
    a12 = mu * d * beta[0] / (a0 * inertia)
    a22 = (face.K + bulk) / a0 + mu * mu * row_norm / inertia
    r1 = us0 - uf0 - face.jump[JUMP_U]
    r2 = trace_s[0, 1] - ps + p_tilde - mu * u_X - face.jump[JUMP_STRESS]
    det = a11 * a22 - a12 * a12
    l1 = (a22 * r1 - a12 * r2) / det
    l2 = (a11 * r2 - a12 * r1) / det

    # (4.9)
    trace_s[0, 0] = us0 - l1 / (a0 * face.m0)
    trace_s[0, 1] -= face.K * l2 / a0
    trace_s[0, 2] = T_s0
    # (4.10); density and temperature stay for j >= 1
    u_X = 0.0
    for j in range(n):
        rho, m = trace_f[j, 0], trace_f[j, 1]
        internal = trace_f[j, 2] - 0.5 * m * m / rho
        change = mu * d * beta[j] * l2
        if j == 0:
            change += l1
        u = m / rho + change / (norm_weight(op, j) * inertia)
        u_X += d * beta[j] * u
        trace_f[j, 1] = rho * u
        trace_f[j, 2] = internal + 0.5 * rho * u * u
    # (4.24)
    u = trace_f[0, 1] / trace_f[0, 0]
    p0 = mu * u_X - trace_s[0, 1] + ps + face.jump[JUMP_STRESS]
    rho = pair.gas.density(pair.gas.constants(face), p0, T_f0)
    trace_f[0, 0] = rho
    trace_f[0, 1] = rho * u
    trace_f[0, 2] = gas_energy(pair, face, rho, u, T_f0)
