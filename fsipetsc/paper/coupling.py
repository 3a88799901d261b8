"""What holds at an interface: three treatments, each of the rows of both sides that a condition can
reach. Compiled.

Rows are counted from the interface into each material: f[j] = (rho, rho u, e)_j of the gas, s[j] =
(u, sigma, T, x)_j of the solid. A treatment changes both in place so that (2.6)-(2.8b) hold up to
the prescribed jumps,

    g_u = u_s - u_f                          g_T = T_s - T_f
    g_stress = sigma - p_s + p - mu' u_X     g_flux = kappa_e/x_X T_s,X - kappa T_f,X

d_j is the row of D in the gas, -d_j in the solid: beta_j/h if the gas lies right of the solid, n =
1, else -beta_j/h. a_j are the weights of the norm, K, m0, ... the numbers of the solid, hats the
state one point into the gas.

*Energy*, Theorem 4.1: all four conditions at once, the temperatures among the unknowns,
orthogonally in

    E = h sum_j a_j (W q^2)_j,    gas: W = p_rho/rho^ (rho), rho^ (u), rho^ cv/T^ (T)
                                  solid: W = m0 (u), 1/K^ (sigma), alpha m0/T^ (T)

with K^ = (K - x_X dp_s/dx_X)/x_X. The q with C(q) = 0 nearest to q~ are q~ - W^-1 grad C . l/a_j,
where S l = C(q~) with the Gram matrix S of grad C. c = dp_s/dT, k_s = kappa_e/x_X, tau_f = T^/(rho^
cv), tau_s = T^/(alpha m0):

    a_0 S11 = 1/m0 + 1/rho^       a_0 S12 = mu' d_0/rho^       S13 = S14 = 0
    a_0 S22 = K^ + rho^ p_rho + c^2 tau_s + p_T^2 tau_f + mu'^2 sum_j (a_0/a_j) d_j^2/rho^
    a_0 S23 = -c tau_s - p_T tau_f             a_0 S24 = d_0 (c k_s tau_s - p_T kappa tau_f)
    a_0 S33 = tau_s + tau_f                    a_0 S34 = d_0 (kappa tau_f - k_s tau_s)
    a_0 S44 = (k_s^2 tau_s + kappa^2 tau_f) sum_j (a_0/a_j) d_j^2

and rho_0 from p_0 = mu' (D u)_0 - sigma + p_s + g_stress, (4.24). Where a side does not conduct
heat, the energy asks for less: no g_T, and no g_flux either if none does. About the weights in a
solid without pressure, where (3.11) is singular, see docs/paper.md.

*Projection*, what the paper runs (Theorem 4.2, Sec. 4.2): temperatures first, by (4.21); with them
held, (u, sigma, rho) are projected orthogonally on g_u and g_stress. That is the projection above
with tau_f = tau_s = 0 and without the conditions on the temperature, with K in the place of K^:
S l = C are (4.23), with rho p_rho for p^ in a gas that is not perfect, and the changes

    u_s = u~_s - l1/(a_0 m0)    sigma = sigma~ - K l2/a_0                                     (4.9)
    u_j = u~_j + (l1 [j=0] + mu' d_j l2)/(a_j rho^)                                          (4.10)

*Traditional*: the solid moves the gas, u_f = u~_s - g_u, and the gas loads the solid, sigma = p_s -
p + mu' u_X + g_stress, both temperatures from (4.21). The energy may grow without bound, the more
so the lighter the solid: it is here to be compared with.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.paper.stencils import INNER, weight

PROJECTION, ENERGY, TRADITIONAL = 0, 1, 2
KINDS = {"projection": PROJECTION, "energy": ENERGY, "traditional": TRADITIONAL}
#: rows, as no literals
FIRST, SECOND = np.int64(0), np.int64(1)
#: the conductivity at the interface has the temperature that it leads to, but for this fraction, or
#: after so many attempts
AGREED, REFINEMENTS = 1e-15, 20


class Face(NamedTuple):
    """An interface. n: 1 if the gas lies right of the solid, else -1; h: spacing [m] on both
    sides."""

    kind: int
    gas: Any
    solid: Any
    n: float
    h: float


@njit(**INNER)
def couple(op, face, jump, f, s):
    """Apply the treatment that the interface has."""
    if face.kind == TRADITIONAL:
        traditional(op, face, jump, f, s)
        return
    if face.kind == PROJECTION:
        T_f, T_s = temperatures(op, face, jump, f, s)
        put_gas(face, f, FIRST, f[0, 0], f[0, 1] / f[0, 0], T_f)
        s[0, 2] = T_s
    for _ in range(REFINEMENTS):
        used = face.gas.conductivity(gas_at(face, f, FIRST)[1])
        T_f = project(op, face, jump, f, s)
        if not abs(face.gas.conductivity(T_f) - used) > AGREED * used:
            return


@njit(**INNER)
def gas_at(face, f, j):
    """(u, T) in row j."""
    return face.gas.velocity_and_temperature(f[j, 0], f[j, 1], f[j, 2])


@njit(**INNER)
def put_gas(face, f, j, rho, u, T):
    """Let the gas in row j be of this density, velocity and temperature."""
    f[j, 0], f[j, 1], f[j, 2] = rho, rho * u, face.gas.total_energy(rho, u, T)


@njit(**INNER)
def gradients(op, face, f, s):
    """(u_X, T_X) of the gas and (T_X, x_X) of the solid, and sum_j a_0/a_j d_j^2."""
    d, u_X, Tf_X, Ts_X, x_X, squares = face.n / face.h, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(op.n):
        d_j, (u, T) = d * op.closure[0, j], gas_at(face, f, j)
        u_X += d_j * u
        Tf_X += d_j * T
        Ts_X -= d_j * s[j, 2]
        x_X -= d_j * s[j, 3]
        squares += d_j * d_j * (op.norm[0] / weight(op, j))
    return u_X, Tf_X, Ts_X, x_X, squares


@njit(**INNER)
def temperatures(op, face, jump, f, s):
    """(T_f, T_s) at the interface by continuity of temperature and heat flux, (4.21).

    Without heat conduction on either side the temperatures do not couple. With conduction on one
    side only, continuity of T cannot be imposed: that side gets its heat flux, the other keeps its
    temperature. The gas conducts with the kappa of its new temperature: where that depends on T,
    the temperatures are found again with it.
    """
    beta, rest_f, rest_s, d = op.closure[0], 0.0, 0.0, face.n / face.h
    T_f, T_s = gas_at(face, f, FIRST)[1], s[0, 2]
    for j in range(1, op.n):
        rest_f += beta[j] * gas_at(face, f, j)[1]
        rest_s += beta[j] * s[j, 2]
    rest_f, rest_s, d_f, d_s = d * rest_f, -d * rest_s, d * beta[0], -d * beta[0]
    k_s, k_f = face.solid.kappa_e / gradients(op, face, f, s)[3], face.gas.conductivity(T_f)
    for _ in range(REFINEMENTS):
        if k_s > 0.0 and k_f > 0.0:
            T_f = (jump[3] - k_s * (rest_s + d_s * jump[2]) + k_f * rest_f) / (
                k_s * d_s - k_f * d_f
            )
            T_s = T_f + jump[2]
        elif k_s > 0.0:
            T_s = (jump[3] / k_s - rest_s) / d_s
        elif k_f > 0.0:
            T_f = (-jump[3] / k_f - rest_f) / d_f
        used, k_f = k_f, face.gas.conductivity(T_f)
        if not abs(k_f - used) > AGREED * used:
            break
    return T_f, T_s


@njit(**INNER)
def residuals(op, face, jump, f, s):
    """What the four conditions are off by, as a tuple."""
    u_X, Tf_X, Ts_X, x_X, _ = gradients(op, face, f, s)
    u, T = gas_at(face, f, FIRST)
    p_s, p_f = face.solid.pressure(s[0, 2], x_X), face.gas.law.pressure(f[0, 0], T)
    stress = s[0, 1] - p_s + p_f - face.gas.viscosity(T) * u_X
    flux = face.solid.kappa_e / x_X * Ts_X - face.gas.conductivity(T) * Tf_X
    return s[0, 0] - u - jump[0], stress - jump[1], s[0, 2] - T - jump[2], flux - jump[3]


@njit(**INNER)
def multipliers(S11, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4):
    """(l1, l2, l3, l4) with S l = r; S symmetric and positive definite, S13 = S14 = 0. Cholesky
    without roots."""
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


@njit(**INNER)
def project(op, face, jump, f, s):
    """Project orthogonally, with the conductivity of the gas as it is: all unknowns in *energy*,
    else all but the temperatures, which are as they should be. Returns the gas's new temperature
    at the interface."""
    gas, solid, beta, d, a_0 = face.gas, face.solid, op.closure[0], face.n / face.h, op.norm[0]
    _, _, _, x_X, squares = gradients(op, face, f, s)
    # the state that the weights belong to
    rho, (u, T), T_s = f[1, 0], gas_at(face, f, SECOND), s[0, 2]
    bulk, p_T = gas.law.bulk_modulus(rho, T), gas.law.pressure_by_temperature(rho, T)
    K, c, tau_f, tau_s = solid.K, solid.pressure_by_temperature(T_s, x_X), 0.0, 0.0
    if face.kind == ENERGY:
        K = (solid.K + solid.stiffness(T_s, x_X)) / x_X
        tau_f, tau_s = T / (rho * gas.law.heat_capacity(rho, T)), T / (solid.alpha * solid.m0)
    T_f = gas_at(face, f, FIRST)[1]
    mu, kappa, k_s = gas.viscosity(T_f), gas.conductivity(T_f), solid.kappa_e / x_X
    r1, r2, r3, r4 = residuals(op, face, jump, f, s)
    # S without the factor 1/a_0: the multipliers come out as l/a_0
    d_0 = d * beta[0]
    S11, S12 = 1.0 / solid.m0 + 1.0 / rho, mu * d_0 / rho
    S22 = K + bulk + c * c * tau_s + p_T * p_T * tau_f + mu * mu * squares / rho
    S23, S24 = -c * tau_s - p_T * tau_f, d_0 * (c * k_s * tau_s - p_T * kappa * tau_f)
    S33, S34 = tau_s + tau_f, d_0 * (kappa * tau_f - k_s * tau_s)
    S44 = (k_s * k_s * tau_s + kappa * kappa * tau_f) * squares
    held = face.kind == PROJECTION
    if held or kappa <= 0.0 or k_s <= 0.0:  # T may jump
        S23, S33, S34, r3 = 0.0, 1.0, 0.0, 0.0
    if held or (kappa <= 0.0 and k_s <= 0.0):
        S24, S44, r4 = 0.0, 1.0, 0.0
    l1, l2, l3, l4 = multipliers(S11, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4)
    s[0, 0] -= l1 / solid.m0
    s[0, 1] -= K * l2
    here = 1.0
    for j in range(op.n):
        d_j, w = d * beta[j], a_0 / weight(op, j)
        rho_j, (u, T) = f[j, 0], gas_at(face, f, j)
        u += w * (here * l1 + mu * d_j * l2) / rho
        T += w * tau_f * (here * (l3 - p_T * l2) + kappa * d_j * l4)
        s[j, 2] += w * tau_s * (here * (c * l2 - l3) + k_s * d_j * l4)
        here = 0.0
        put_gas(face, f, j, rho_j, u, T)
    u, T_f = gas_at(face, f, FIRST)
    u_X = gradients(op, face, f, s)[0]
    p_0 = gas.viscosity(T_f) * u_X - s[0, 1] + solid.pressure(s[0, 2], x_X) + jump[1]  # (4.24)
    put_gas(face, f, FIRST, gas.law.density(p_0, T_f), u, T_f)
    return T_f


@njit(**INNER)
def traditional(op, face, jump, f, s):
    """The solid moves the gas, the gas loads the solid."""
    T_f, T_s = temperatures(op, face, jump, f, s)
    put_gas(face, f, FIRST, f[0, 0], s[0, 0] - jump[0], T_f)
    u_X, _, _, x_X, _ = gradients(op, face, f, s)
    stress = face.gas.viscosity(T_f) * u_X - face.gas.law.pressure(f[0, 0], T_f)
    s[0, 1] = face.solid.pressure(T_s, x_X) + stress + jump[1]
    s[0, 2] = T_s
