"""The orthogonal projection of Theorem 4.1: all four interface conditions at once, in the norm of the energy.

Energy. With (rho, u, T)_f and (u, sigma, T)_s small disturbances of a constant state (hats) the symmetric variables
(3.11), (3.12) have the norm  E = h sum_j a_j (W q^2)_j  with the weights W (inverse squares of Y_f, Y_s)

    fluid   rho: R T^/rho^     u: rho^     T: rho^ cv/T^           solid   u: m0     sigma: 1/K^     T: alpha m0/T^

Two entries need a word.
- K^ = (K + p_s)/x_X. In (3.8) the strain x_X is an unknown of its own with the weight m0 p_rho, and the projection
  would change it at the interface. But sigma/K - x_X keeps its value for ever (3.1b,d), and the rest of the energy
  contains sigma and x_X only as S = sigma - p_rho rho', with the weight 1/(K + m0 p_rho), m0 p_rho = p_s. So to change
  sigma alone, with that weight, is the same projection for (u, S, T) and the fluid, and the particles' positions x
  stay where they are. About a strained state K/x_X takes the place of K.
- alpha m0/T^. This equals (3.11) wherever Theorem 4.1 holds, namely if alpha p_eps T^ = p_s - sigma^ (an ideal gas
  law and sigma^ = 0), and for p_s = 0, where (3.11) is singular, the estimate holds with it too, but for the heating
  sigma^ u_X/(alpha m0) by a stress sigma^ != 0. For any other weight the heat fluxes of both sides do not cancel.

Projection. The conditions, with c = alpha p_eps, k_s = kappa_e/x_X, d_j the row of D in the fluid, -d_j in the solid,

    C1 = u_s - u_f - g_u                              C3 = T_s - T_f - g_T
    C2 = sigma - c T_s + p - mu' sum_j d_j u_j - g_s   C4 = -k_s sum_j d_j T_sj - kappa sum_j d_j T_fj - g_k

are linear but for p, which changes by R T^ drho + R rho^ dT. The q that satisfy C = 0 nearest to q~ are stationary
points of E(q - q~)/2 + sum_i l_i C_i:  q = q~ - W^-1 grad C . l / a_j, written out

    u_s0   = u~_s0 - l1 / (a_0 m0)                    u_fj = u~_fj + (l1 [j=0] + mu' d_j l2) / (a_j rho^)
    sigma0 = sigma~0 - K^ l2 / a_0                    T_fj = T~_fj + tau_f ((l3 - R rho^ l2) [j=0] + kappa d_j l4) / a_j
    p_0    = p~0 - p^ l2 / a_0 + R rho^ (T_f - T~_f)_0  T_sj = T~_sj + tau_s ((c l2 - l3) [j=0] + k_s d_j l4) / a_j

with tau_f = T^/(rho^ cv), tau_s = T^/(alpha m0); (4.9), (4.10), (4.22) are the first lines. C(q) = 0 gives S l = C(q~),

    a_0 S11 = 1/m0 + 1/rho^       a_0 S12 = mu' d_0/rho^       S13 = S14 = 0
    a_0 S22 = K^ + p^ + c^2 tau_s + (R rho^)^2 tau_f + mu'^2 sum_j (a_0/a_j) d_j^2/rho^
    a_0 S23 = -c tau_s - R rho^ tau_f        a_0 S24 = d_0 (c k_s tau_s - R rho^ kappa tau_f)
    a_0 S33 = tau_s + tau_f       a_0 S34 = d_0 (kappa tau_f - k_s tau_s)
    a_0 S44 = (k_s^2 tau_s + kappa^2 tau_f) sum_j (a_0/a_j) d_j^2,

a Gram matrix, hence positive definite as long as the conditions are independent. Where a side does not conduct heat,
the energy asks for less: no C3, and no C4 either if none does; the other two then still change both temperatures.

The non-linear equations are treated as in Sec. 4.2: rho^, T^, p^ one point into the fluid, x_X and p_s at the
interface, p_0 from the stress condition (4.24), then rho_0 = p_0/(R T_0). rho_j is kept for j >= 1. In a gas that is not
perfect rho p_rho takes the place of p^, p_T that of R rho^ and p_rho/rho^ that of the weight R T^/rho^; in a solid with another
pressure -x_X dp/dx_X that of p_s in K^ and p_T that of c. Where the points of the gas are r times as far apart as those of the
solid, the weights of the gas are r times as large, and d_j is that of the gas, r d_j that of the solid.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.coupling.interface import (
    JUMP_FLUX,
    JUMP_STRESS,
    JUMP_T,
    JUMP_U,
    conductivity,
    gas_energy,
    gas_pressure,
    gas_velocity_and_temperature,
    norm_weight,
    solid_pressure,
    solid_strain,
    viscosity,
)
from fsipetsc.coupling.projection import AGREED, REFINEMENTS
from fsipetsc.operators.kernels import OPTIONS, row_length


@njit(**OPTIONS)
def multipliers(S11, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4):
    """(l1, l2, l3, l4) with S l = r; S symmetric and positive definite, S13 = S14 = 0. Cholesky without roots."""
    v12 = S12 / S11
    D2, y2 = S22 - v12 * S12, r2 - v12 * r1
    v23, v24 = S23 / D2, S24 / D2
    D3, y3 = S33 - v23 * S23, r3 - v23 * y2
    off = S34 - v23 * S24
    v34 = off / D3
    l4 = (r4 - v24 * y2 - v34 * y3) / (S44 - v24 * S24 - v34 * off)
    l3 = y3 / D3 - v34 * l4
    l2 = y2 / D2 - v23 * l3 - v24 * l4
    return r1 / S11 - v12 * l2, l2, l3, l4


@njit(**OPTIONS)
def row_sums(pair, face, op, trace_f, trace_s, d):
    """(u_X, T_f,X, T_s,X, sum_j (a_0/a_j) d_j^2) at the interface."""
    beta = op.closure[0]
    u_X, Tf_X, Ts_X, squares = 0.0, 0.0, 0.0, 0.0
    for j in range(row_length(op)):
        dj, (u, T) = d * beta[j], gas_velocity_and_temperature(pair, face, trace_f, j)
        u_X += dj * u
        Tf_X += dj * T
        Ts_X -= dj * face.ratio * trace_s[j, 2]
        squares += dj * dj * (op.norm[0] / norm_weight(op, j))
    return u_X, Tf_X, Ts_X, squares


@njit(**OPTIONS)
def energy(pair, face, op, trace_f, trace_s):
    """Project the traces in place on the interface conditions; see the module and fsipetsc.coupling.interface.

    The gas conducts with the kappa of its new temperature: where that depends on T, the result is projected again.
    """
    for _ in range(REFINEMENTS):
        used = conductivity(pair, face, gas_velocity_and_temperature(pair, face, trace_f, 0)[1])
        T = projected(pair, face, op, trace_f, trace_s)
        if not abs(conductivity(pair, face, T) - used) > AGREED * used:
            return


@njit(**OPTIONS)
def projected(pair, face, op, trace_f, trace_s):
    """Project with the kappa of the temperature as it is; returns the gas's new temperature at the interface."""
    d, r, beta, a0 = face.normal / face.spacing, face.ratio, op.closure[0], op.norm[0]
    gas, pressing, c_f, c_s = pair.gas, pair.pressing, pair.gas.constants(face), pair.pressing.constants(face)
    x_X = solid_strain(face, op, trace_s)
    # the state that the weights belong to
    rho, (u, T) = trace_f[1, 0], gas_velocity_and_temperature(pair, face, trace_f, 1)
    bulk, cv = gas.bulk_modulus(c_f, rho, T) / r, gas.heat_capacity(c_f, rho, T)
    ps = solid_pressure(pair, face, trace_s[0, 2], x_X)
    K = (face.K + pressing.stiffness(c_s, trace_s[0, 2], x_X)) / x_X
    c = pressing.pressure_by_temperature(c_s, trace_s[0, 2], x_X)
    inertia, tau_f, tau_s = rho * r, T / (rho * cv) / r, T / (face.alpha * face.m0)
    uf0, Tf0 = gas_velocity_and_temperature(pair, face, trace_f, 0)
    mu, kappa, k_s = viscosity(pair, face, Tf0), conductivity(pair, face, Tf0), face.kappa_e / x_X
    conducting = int(kappa > 0.0) + int(k_s > 0.0)

    # S without the factor 1/a_0: the multipliers come out as l/a_0
    u_X, Tf_X, Ts_X, squares = row_sums(pair, face, op, trace_f, trace_s, d)
    p_T, d0 = gas.pressure_by_temperature(c_f, rho, T), d * beta[0]
    S12 = mu * d0 / inertia
    S22 = K + bulk + c * c * tau_s + p_T * p_T * tau_f + mu * mu * squares / inertia
    S23, S24 = -c * tau_s - p_T * tau_f, d0 * (c * k_s * tau_s * r - p_T * kappa * tau_f)
    S33, S34 = tau_s + tau_f, d0 * (kappa * tau_f - k_s * tau_s * r)
    S44 = (k_s * k_s * tau_s * (r * r) + kappa * kappa * tau_f) * squares
    us0 = trace_s[0, 0]
    r1 = us0 - uf0 - face.jump[JUMP_U]
    r2 = trace_s[0, 1] - ps + gas_pressure(pair, face, trace_f[0, 0], Tf0) - mu * u_X - face.jump[JUMP_STRESS]
    r3 = trace_s[0, 2] - Tf0 - face.jump[JUMP_T]
    r4 = k_s * Ts_X - kappa * Tf_X - face.jump[JUMP_FLUX]
    if conducting < 2:  # T may jump
        S23, S33, S34, r3 = 0.0, 1.0, 0.0, 0.0
    if conducting == 0:
        S24, S44, r4 = 0.0, 1.0, 0.0
    l1, l2, l3, l4 = multipliers(1.0 / face.m0 + 1.0 / inertia, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4)

    trace_s[0, 0] = us0 - l1 / face.m0
    trace_s[0, 1] -= K * l2
    at_interface_u, at_interface_f, at_interface_s = l1, l3 - p_T * l2, c * l2 - l3
    u_X = 0.0
    for j in range(row_length(op)):
        dj, w = d * beta[j], a0 / norm_weight(op, j)
        rho_j, (u, T) = trace_f[j, 0], gas_velocity_and_temperature(pair, face, trace_f, j)
        u += w * (at_interface_u + mu * dj * l2) / inertia
        T += w * tau_f * (at_interface_f + kappa * dj * l4)
        trace_s[j, 2] += w * tau_s * (at_interface_s + k_s * (dj * r) * l4)
        at_interface_u, at_interface_f, at_interface_s = 0.0, 0.0, 0.0
        u_X += dj * u
        if j == 0:
            uf0, Tf0 = u, T
        trace_f[j, 1] = rho_j * u
        trace_f[j, 2] = gas_energy(pair, face, rho_j, u, T)
    # (4.24)
    ps, mu = solid_pressure(pair, face, trace_s[0, 2], x_X), viscosity(pair, face, Tf0)
    rho_0 = gas.density(c_f, mu * u_X - trace_s[0, 1] + ps + face.jump[JUMP_STRESS], Tf0)
    trace_f[0, 0] = rho_0
    trace_f[0, 1] = rho_0 * uf0
    trace_f[0, 2] = gas_energy(pair, face, rho_0, uf0, Tf0)
    return Tf0
