"""What holds at an interface: three treatments, of the rows of both sides that conditions reach.

Rows are counted from the interface into each material. A treatment changes both in place so that
(2.6)-(2.8b) hold up to the prescribed jumps,

    g_u = u_s - u_f                          g_T = T_s - T_f
    g_stress = sigma - p_s + p - mu' u_X     g_flux = kappa_e/x_X T_s,X - kappa T_f,X

d_j is the row of D in the gas, -d_j in the solid: beta_j/h if the gas lies right of the solid, n =
1, else -beta_j/h. a_j are the weights of the norm, K, m0, ... the numbers of the solid, hats the
state one point into the gas.

*Energy*, Theorem 4.1: all four conditions at once, with the temperatures, orthogonally in

    E = h sum_j a_j (W q^2)_j,    gas: W = p_rho/rho^ (rho), rho^ (u), rho^ cv/T^ (T)
                                  solid: W = m0 (u), 1/K^ (sigma), alpha m0/T^ (T)

with K^ = (K - x_X dp_s/dx_X)/x_X. The q with C(q) = 0 nearest to q~ are q~ - W^-1 grad C . l/a_j,
where S l = C(q~) with the Gram matrix S of grad C; then rho_0 follows from p_0, (4.24). Where a
side does not conduct heat, the energy asks for less: no g_T, and no g_flux either if none does.
About the weights in a solid without pressure, where (3.11) is singular, see docs/paper.md.

*Projection*, what the paper runs (Theorem 4.2, Sec. 4.2): temperatures first, by (4.21); with them
held, (u, sigma, rho) are projected orthogonally on g_u and g_stress. That is the projection above
with T^ = 0 and without the conditions on the temperature, with K in the place of K^: S l = C are
(4.23), with rho p_rho for p^ in a gas that is not perfect, and the changes are (4.9), (4.10).

*Traditional*: the solid moves the gas, u_f = u~_s - g_u, and the gas loads the solid, sigma = p_s -
p + mu' u_X + g_stress, both temperatures from (4.21). The energy may grow without bound.
"""

from types import SimpleNamespace

import numpy as np

from fsipetsc.equations.vectors import choose
from fsipetsc.kernels.loops import each, stop, variable
from fsipetsc.operators.sbp import row_length
from fsipetsc.problem import SolidLayer

#: the conductivity at the interface has the temperature that it leads to, but for this fraction, or
#: after so many attempts
AGREED, REFINEMENTS = 1e-15, 20


class Interface(SimpleNamespace):
    """An interface of a pair of layers, the left one first, in the treatment of a ``kind``, a value
    of -fsi_coupling. first: their points at the interface; ranks: the owners of these, who have all
    rows, at ``places`` in memory, and both solve the same small system; here: whether each is this
    one, ``me``. jump: what is prescribed; notes: of all, (8, interfaces), here column ``number``.
    """

    def __init__(self, pair, number, me, kind, notes):
        gas, solid = sorted(pair, key=lambda layer: not layer.is_gas)
        super().__init__(kind=kind, gas=gas, solid=solid, notes=notes, number=number)
        self.first = int(gas.active[gas.side - 1]), int(solid.active[gas.side])
        rows = self.n * np.arange(row_length(gas.op))
        self.ranks = gas.share.ranks[gas.side - 1], solid.share.ranks[-gas.side]
        places = gas.places(self.first[0] + rows), solid.places(self.first[1] - rows)
        self.places, self.jump = np.concatenate(places), np.zeros(4)
        self.here = [rank == me for rank in self.ranks]

    @property
    def n(self):
        """1 if the gas lies right of the solid, else -1."""
        return 2 * self.gas.side - 1

    @property
    def stencil(self):
        """beta_j; n/h, of which and beta_j d_j are the products; a_0/a_j."""
        op, per_h = self.gas.op, float(self.n) / self.gas.h
        beta = [float(v) for v in op.closure[0][: row_length(op)]]
        return beta, per_h, [float(op.norm[0]) / float(a) for a in (*op.norm, 1)]

    def gas_at(self, j):
        """(rho, u, T) in row j."""
        rho, m, e = (self.gas.local[c, self.first[0] + self.n * j] for c in range(3))
        return (rho, *self.gas.material.velocity_and_temperature(rho, m, e))

    def put_gas(self, j, rho, u, T):
        energy = self.gas.material.total_energy(rho, u, T)
        self.gas.local[:, self.first[0] + self.n * j] = rho, rho * u, energy

    def solid_at(self, j):
        """(u, sigma, T, x) in row j."""
        return tuple(self.solid.local[c, self.first[1] - self.n * j] for c in range(4))

    def put_solid(self, j, **values):
        for name, value in values.items():
            self.solid.local[SolidLayer.unknowns.index(name), self.first[1] - self.n * j] = value


def note(of):
    """Note x, u, sigma, T and the residuals of the four conditions of an interface."""
    u, sigma, T, x = of.solid_at(0)
    for row, value in enumerate((x, u, sigma, T, *residuals(of))):
        of.notes[row, of.number] = value


def couple(of):
    """Couple the rows of both sides; the frame of the gas follows."""
    if of.kind == "traditional":
        traditional(of)
    else:
        if of.kind == "projection":
            (T_f, T_s), (rho, u, _) = temperatures(of), of.gas_at(0)
            of.put_gas(0, rho, u, T_f)
            of.put_solid(0, T=T_s)
        for _ in each(REFINEMENTS):
            used = of.gas.material.conductivity(of.gas_at(0)[2])
            T_f = project(of)
            stop(~(np.absolute(of.gas.material.conductivity(T_f) - used) > AGREED * used))
    of.gas.frame[:] = of.gas_at(0)[1], of.solid_at(0)[3]


def gradients(of):
    """(u_X, T_X) of the gas and (T_X, x_X) of the solid, and sum_j a_0/a_j d_j^2."""
    (beta, d, weights), u_X, Tf_X, Ts_X, x_X, squares = of.stencil, 0.0, 0.0, 0.0, 0.0, 0.0
    for j, (beta_j, weight) in enumerate(zip(beta, weights)):
        d_j, (_, u, T_f), (_, _, T_s, x) = d * beta_j, of.gas_at(j), of.solid_at(j)
        u_X += d_j * u
        Tf_X += d_j * T_f
        Ts_X -= d_j * T_s
        x_X -= d_j * x
        squares += d_j * d_j * weight
    return u_X, Tf_X, Ts_X, x_X, squares


def temperatures(of):
    """(T_f, T_s) at the interface by continuity of temperature and heat flux, (4.21).

    Without heat conduction on either side the temperatures do not couple. With conduction on one
    side only, continuity of T cannot be imposed: that side gets its heat flux, the other keeps its
    temperature. The gas conducts with the kappa of its new temperature: where that depends on T,
    the temperatures are found again with it.
    """
    (_, _, jump_T, jump_flux), (beta, d, _) = (of.jump[c] for c in range(4)), of.stencil
    gas, solid = of.gas.material, of.solid.material
    T_f, T_s = variable(of.gas_at(0)[2]), variable(of.solid_at(0)[2])
    rest_f = d * sum(beta[j] * of.gas_at(j)[2] for j in range(1, len(beta)))
    rest_s = -d * sum(beta[j] * of.solid_at(j)[2] for j in range(1, len(beta)))
    d_f, d_s = d * beta[0], -d * beta[0]
    k_s = solid.kappa_e / gradients(of)[3]
    for _ in each(REFINEMENTS):
        k_f = gas.conductivity(T_f.value)
        both = (jump_flux - k_s * (rest_s + d_s * jump_T) + k_f * rest_f) / (k_s * d_s - k_f * d_f)
        in_gas, in_solid = (-jump_flux / k_f - rest_f) / d_f, (jump_flux / k_s - rest_s) / d_s
        in_gas = np.where(k_f > 0.0, np.where(k_s > 0.0, both, in_gas), T_f.value)  # it conducts
        in_solid = np.where(k_s > 0.0, np.where(k_f > 0.0, both + jump_T, in_solid), T_s.value)
        T_f.value, T_s.value = in_gas, in_solid
        stop(~(np.absolute(gas.conductivity(in_gas) - k_f) > AGREED * k_f))
    return T_f.value, T_s.value


def residuals(of):
    """What the four conditions are off by, as a tuple."""
    jump, (u_X, Tf_X, Ts_X, x_X, _) = of.jump, gradients(of)
    gas, (rho, u_f, T_f) = of.gas.material, of.gas_at(0)
    solid, (u_s, sigma, T_s, _) = of.solid.material, of.solid_at(0)
    stress = sigma - solid.pressure(T_s, x_X) + gas.law.pressure(rho, T_f)
    stress -= gas.viscosity(T_f) * u_X
    flux = solid.kappa_e / x_X * Ts_X - gas.conductivity(T_f) * Tf_X
    return u_s - u_f - jump[0], stress - jump[1], T_s - T_f - jump[2], flux - jump[3]


def multipliers(S11, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4):
    """(l1, l2, l3, l4) with S l = r; S positive definite, S13 = S14 = 0. Cholesky without roots."""
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


def project(of):
    """Project orthogonally, with the conductivity of the gas as it is: all unknowns in *energy*,
    else all but the temperatures, which are as they should be. Returns the gas's new T_f.

    c = dp_s/dT, k_s = kappa_e/x_X, tau_f = T^/(rho^ cv), tau_s = T^/(alpha m0).
    """
    gas, solid, (beta, d, weights) = of.gas.material, of.solid.material, of.stencil
    _, _, _, x_X, squares = gradients(of)
    # the state that the weights belong to
    (rho, _, T), (u_s, sigma, T_s, _) = of.gas_at(1), of.solid_at(0)
    bulk, p_T = gas.law.bulk_modulus(rho, T), gas.law.pressure_by_temperature(rho, T)
    (p_x, c), K, tau_f, tau_s = solid.pressure_slopes(T_s, x_X), solid.K, 0.0, 0.0
    if of.kind == "energy":
        K = (solid.K - x_X * p_x) / x_X
        tau_f, tau_s = T / (rho * gas.law.heat_capacity(rho, T)), T / (solid.alpha * solid.m0)
    T_f = of.gas_at(0)[2]
    mu, kappa, k_s = gas.viscosity(T_f), gas.conductivity(T_f), solid.kappa_e / x_X
    r1, r2, r3, r4 = residuals(of)
    # S without the factor 1/a_0: the multipliers come out as l/a_0
    d_0 = d * beta[0]
    S11, S12 = 1.0 / solid.m0 + 1.0 / rho, mu * d_0 / rho
    S22 = K + bulk + c * c * tau_s + p_T * p_T * tau_f + mu * mu * squares / rho
    S23, S24 = -c * tau_s - p_T * tau_f, d_0 * (c * k_s * tau_s - p_T * kappa * tau_f)
    S33, S34 = tau_s + tau_f, d_0 * (kappa * tau_f - k_s * tau_s)
    S44 = (k_s * k_s * tau_s + kappa * kappa * tau_f) * squares
    if of.kind == "projection":
        S23, S33, S34, r3, S24, S44, r4 = 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    else:
        some, none = (kappa <= 0.0) | (k_s <= 0.0), (kappa <= 0.0) & (k_s <= 0.0)
        # where T may jump, and where no heat flows
        S23, S33, S34, r3 = choose(some, (0.0, 1.0, 0.0, 0.0), (S23, S33, S34, r3))
        S24, S44, r4 = choose(none, (0.0, 1.0, 0.0), (S24, S44, r4))
    l1, l2, l3, l4 = multipliers(S11, S12, S22, S23, S24, S33, S34, S44, r1, r2, r3, r4)
    sigma -= K * l2
    of.put_solid(0, u=u_s - l1 / solid.m0, sigma=sigma)
    for j, (beta_j, w) in enumerate(zip(beta, weights)):
        d_j, here = d * beta_j, 1.0 if j == 0 else 0.0
        (rho_j, u, T), T_j = of.gas_at(j), of.solid_at(j)[2]
        u += w * (here * l1 + mu * d_j * l2) / rho
        T += w * tau_f * (here * (l3 - p_T * l2) + kappa * d_j * l4)
        of.put_solid(j, T=T_j + w * tau_s * (here * (c * l2 - l3) + k_s * d_j * l4))
        of.put_gas(j, rho_j, u, T)
    (_, u, T_f), (_, sigma, T_s, _), u_X = of.gas_at(0), of.solid_at(0), gradients(of)[0]
    p_0 = gas.viscosity(T_f) * u_X - sigma + solid.pressure(T_s, x_X) + of.jump[1]  # (4.24)
    of.put_gas(0, gas.law.density(p_0, T_f), u, T_f)
    return T_f


def traditional(of):
    """The solid moves the gas, the gas loads the solid."""
    gas, solid, jump, (T_f, T_s) = of.gas.material, of.solid.material, of.jump, temperatures(of)
    rho = of.gas_at(0)[0]
    of.put_gas(0, rho, of.solid_at(0)[0] - jump[0], T_f)
    u_X, _, _, x_X, _ = gradients(of)
    stress = gas.viscosity(T_f) * u_X - gas.law.pressure(rho, T_f)
    of.put_solid(0, sigma=solid.pressure(T_s, x_X) + stress + jump[1], T=T_s)
