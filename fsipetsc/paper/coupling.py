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

*Projection*, what the paper runs (Theorem 4.2, Sec. 4.2): temperatures first, by (4.21); with them
held, (u, sigma, rho) are projected orthogonally, in the norm of the symmetric variables, on g_u and
g_stress, with multipliers from

    (1/m0 + 1/rho^) l1/a_0 + mu' d_0/(a_0 rho^) l2 = u~_s - u~_f - g_u                       (4.23)
    mu' d_0/(a_0 rho^) l1 + ((K + p^)/a_0 + mu'^2 sum_j d_j^2/(a_j rho^)) l2
                                                   = sigma~ - p_s + p~ - mu' (D u~)_0 - g_stress

    u_s = u~_s - l1/(a_0 m0)    sigma = sigma~ - K l2/a_0                                     (4.9)
    u_j = u~_j + (l1 [j=0] + mu' d_j l2)/(a_j rho^)                                          (4.10)

and rho_0 from p_0 = mu' (D u)_0 - sigma + p_s + g_stress, (4.24). rho p_rho takes the place of p^
in a gas that is not perfect.

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

Where a side does not conduct heat, the energy asks for less: no g_T, and no g_flux either if none
does. About the weights in a solid without pressure, where (3.11) is singular, see docs/paper.md;
rho_0 follows from (4.24) again.

*Traditional*: the solid moves the gas, u_f = u~_s - g_u, and the gas loads the solid, sigma = p_s -
p + mu' u_X + g_stress, both temperatures from (4.21). The energy may grow without bound, the more
so the lighter the solid: it is here to be compared with.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

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
    if face.kind == PROJECTION:
        projection(op, face, jump, f, s)
    elif face.kind == ENERGY:
        energy(op, face, jump, f, s)
    else:
        traditional(op, face, jump, f, s)


@njit(**INNER)
def strain(op, face, s):
    """x_X of the solid."""
    d, x_X = -face.n / face.h, 0.0
    for j in range(op.n):
        x_X += op.closure[0, j] * s[j, 3]
    return d * x_X


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
    """(u_X, T_X) of the gas and T_X of the solid, and sum_j a_0/a_j d_j^2."""
    d, u_X, Tf_X, Ts_X, squares = face.n / face.h, 0.0, 0.0, 0.0, 0.0
    for j in range(op.n):
        d_j, (u, T) = d * op.closure[0, j], gas_at(face, f, j)
        u_X += d_j * u
        Tf_X += d_j * T
        Ts_X -= d_j * s[j, 2]
        squares += d_j * d_j * (op.norm[0] / weight(op, j))
    return u_X, Tf_X, Ts_X, squares


@njit(**INNER)
def temperatures(op, face, jump, f, s, x_X):
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
    k_s, k_f = face.solid.kappa_e / x_X, face.gas.conductivity(T_f)
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
def weigh(op, face, jump, f, s, x_X, T_f):
    """rho_0 of the gas, which has the temperature T_f, by (4.24)."""
    u_X = gradients(op, face, f, s)[0]
    p_0 = face.gas.viscosity(T_f) * u_X - s[0, 1] + face.solid.pressure(s[0, 2], x_X) + jump[1]
    put_gas(face, f, FIRST, face.gas.law.density(p_0, T_f), f[0, 1] / f[0, 0], T_f)


@njit(**INNER)
def residuals(op, face, jump, f, s, out):
    """What the four conditions are off by."""
    u_X, Tf_X, Ts_X, _ = gradients(op, face, f, s)
    x_X, (u, T) = strain(op, face, s), gas_at(face, f, FIRST)
    p_s, p_f = face.solid.pressure(s[0, 2], x_X), face.gas.law.pressure(f[0, 0], T)
    out[0] = s[0, 0] - u - jump[0]
    out[1] = s[0, 1] - p_s + p_f - face.gas.viscosity(T) * u_X - jump[1]
    out[2] = s[0, 2] - T - jump[2]
    out[3] = face.solid.kappa_e / x_X * Ts_X - face.gas.conductivity(T) * Tf_X - jump[3]


@njit(**INNER)
def projection(op, face, jump, f, s):
    """The paper's projection."""
    gas, solid, beta, d, a_0 = face.gas, face.solid, op.closure[0], face.n / face.h, op.norm[0]
    x_X = strain(op, face, s)
    T_f, T_s = temperatures(op, face, jump, f, s, x_X)
    p_s, mu = solid.pressure(T_s, x_X), gas.viscosity(T_f)
    rho = f[1, 0]
    bulk = gas.law.bulk_modulus(rho, gas_at(face, f, SECOND)[1])
    u_X, _, _, squares = gradients(op, face, f, s)
    u_f, u_s = f[0, 1] / f[0, 0], s[0, 0]
    # (4.23)
    a11 = (1.0 / solid.m0 + 1.0 / rho) / a_0
    a12 = mu * d * beta[0] / (a_0 * rho)
    a22 = (solid.K + bulk + mu * mu * squares / rho) / a_0
    r1 = u_s - u_f - jump[0]
    r2 = s[0, 1] - p_s + gas.law.pressure(f[0, 0], T_f) - mu * u_X - jump[1]
    det = a11 * a22 - a12 * a12
    l1, l2 = (a22 * r1 - a12 * r2) / det, (a11 * r2 - a12 * r1) / det
    # (4.9)
    s[0, 0] = u_s - l1 / (a_0 * solid.m0)
    s[0, 1] -= solid.K * l2 / a_0
    s[0, 2] = T_s
    # (4.10); density and temperature stay for j >= 1
    for j in range(op.n):
        rho_j, m = f[j, 0], f[j, 1]
        internal, change = f[j, 2] - 0.5 * m * m / rho_j, mu * d * beta[j] * l2
        if j == 0:
            change += l1
        u = m / rho_j + change / (weight(op, j) * rho)
        f[j, 1], f[j, 2] = rho_j * u, internal + 0.5 * rho_j * u * u
    weigh(op, face, jump, f, s, x_X, T_f)


@njit(**INNER)
def energy(op, face, jump, f, s):
    """The orthogonal projection of Theorem 4.1; again, where kappa depends on T, until it has its
    new temperature."""
    for _ in range(REFINEMENTS):
        used = face.gas.conductivity(gas_at(face, f, FIRST)[1])
        T = projected(op, face, jump, f, s)
        if not abs(face.gas.conductivity(T) - used) > AGREED * used:
            return


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
def projected(op, face, jump, f, s):
    """Project with the kappa of the temperature as it is; returns the gas's new temperature at the
    interface."""
    gas, solid, beta, d, a_0 = face.gas, face.solid, op.closure[0], face.n / face.h, op.norm[0]
    x_X = strain(op, face, s)
    # the state that the weights belong to
    rho, (u, T) = f[1, 0], gas_at(face, f, SECOND)
    bulk, p_T, T_s = gas.law.bulk_modulus(rho, T), gas.law.pressure_by_temperature(rho, T), s[0, 2]
    K, c = (
        (solid.K + solid.stiffness(T_s, x_X)) / x_X,
        solid.pressure_by_temperature(T_s, x_X),
    )
    tau_f, tau_s = T / (rho * gas.law.heat_capacity(rho, T)), T / (solid.alpha * solid.m0)
    T_f = gas_at(face, f, FIRST)[1]
    mu, kappa, k_s = gas.viscosity(T_f), gas.conductivity(T_f), solid.kappa_e / x_X
    squares, r = gradients(op, face, f, s)[3], np.empty(4)
    residuals(op, face, jump, f, s, r)
    r1, r2, r3, r4 = r[0], r[1], r[2], r[3]
    # S without the factor 1/a_0: the multipliers come out as l/a_0
    d_0 = d * beta[0]
    S12 = mu * d_0 / rho
    S22 = K + bulk + c * c * tau_s + p_T * p_T * tau_f + mu * mu * squares / rho
    S23, S24 = -c * tau_s - p_T * tau_f, d_0 * (c * k_s * tau_s - p_T * kappa * tau_f)
    S33, S34 = tau_s + tau_f, d_0 * (kappa * tau_f - k_s * tau_s)
    S44 = (k_s * k_s * tau_s + kappa * kappa * tau_f) * squares
    if kappa <= 0.0 or k_s <= 0.0:  # T may jump
        S23, S33, S34, r3 = 0.0, 1.0, 0.0, 0.0
    if kappa <= 0.0 and k_s <= 0.0:
        S24, S44, r4 = 0.0, 1.0, 0.0
    S11 = 1.0 / solid.m0 + 1.0 / rho
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
    T_f = gas_at(face, f, FIRST)[1]
    weigh(op, face, jump, f, s, x_X, T_f)
    return T_f


@njit(**INNER)
def traditional(op, face, jump, f, s):
    """The solid moves the gas, the gas loads the solid."""
    x_X = strain(op, face, s)
    T_f, T_s = temperatures(op, face, jump, f, s, x_X)
    put_gas(face, f, FIRST, f[0, 0], s[0, 0] - jump[0], T_f)
    u_X = gradients(op, face, f, s)[0]
    stress = face.gas.viscosity(T_f) * u_X - face.gas.law.pressure(f[0, 0], T_f)
    s[0, 1] = face.solid.pressure(T_s, x_X) + stress + jump[1]
    s[0, 2] = T_s
