"""Compressible Navier–Stokes equations on a curvilinear grid that moves, for d = 1, 2, 3.

With the metrics a^k of the logical directions k, the velocity v of the grid and g^k = a^k . v,

    J_t    = sum_k (a^k . D_k v + v . D_k a^k)
    (JU)_t = - sum_k D_k (a^k . f - g^k U - a^k . f_v) + J s

    U   = (rho, rho u, E),        E = rho (e(rho, T) + |u|^2/2)
    f   = (rho u, rho u u + p, (E + p) u)
    f_v = (0, tau, tau u + kappa grad T),   tau = mu (grad u + grad u^T - 2/3 div u)
    s   = (0, rho b, rho b . u)             b: constant body force per mass, as gravity

a . f is the flux through the area a. Two-point fluxes of the nodes l and r, {q} = (q_l + q_r)/2:

    F = {a} . f# - g U#,    g = (a_l . v_r + a_r . v_l)/2
    U# = rho^ (1, {u}, u_l . u_r/2 + e(rho^, T^))
    {a} . f# = V U# + (0, {a} {p}, (p_l V_r + p_r V_l)/2),    V_l = {a} . u_l,  V = (V_l + V_r)/2

with rho^ the logarithmic mean of rho, T^ one over that of 1/T. They conserve entropy for a perfect
gas (H. Ranocha, Generalised summation-by-parts operators and entropy stability, 2018; moving grids:
G. Schnücke et al., J. Sci. Comput. 82, 2020) and for a stiffened gas, where p_inf adds constants to
f and U. Any other gas law wants the mean flux {a . f} - g {U}.

The body force has the potential Phi = - b . x. With F it enters pair by pair, so that gas at rest
stays so (M. Waruszewski et al., J. Comput. Phys. 468, 2022): J s of a node i is

    Q_i = - sum_l S_il {a} rho^ (Phi_l - Phi_i)/2 / weight_i,    and its power Q_i . u_i

Gradients are those of the entropy variables (u, -1)/T, because then viscosity and conduction
produce entropy at each node: grad u = T (grad (u/T) + u grad (-1/T)), grad T = T^2 grad (-1/T).

The unknowns of a node are q = (J, J rho, J rho u, J E), its primitive variables with reciprocals
w = (rho, p, T, u_1 … u_d, 1/rho, 1/T).

Logarithmic means are (a - b)/(ln a - ln b). With x = ln(a/b) and the distance z = a/b + b/a - 2 =
4 sinh(x/2)^2,

    mean of a and b                  (a + b)/2 A(z),    A = tanh(x/2) / (x/2)
    1 / (mean of 1/a and 1/b)        (a + b)/2 B(z),    B = x / sinh(x)

Near numbers so need neither a division nor a logarithm. With
arcsinh(y) / (y sqrt(1 + y^2)) = sum_n (-4 y^2)^n n!^2 / (2n + 1)! and y^2 = z/4,

    B = sum_n (-z)^n n!^2 / (2n + 1)!,    A = 1 / ((1 + z/4) B).

These series, cut in terms of Chebyshev polynomials (C. Lanczos, Applied Analysis, 1956,
'economization'), are polynomials for z <= NEAR whose errors are below 4e-17.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.tensors import add_unit, apply, outer, trace, transpose
from fsipetsc.equations.vectors import add, along, dot, last_times, mean, scale

#: distance up to which two numbers are near: within 18 % of each other
NEAR = 0.03
#: polynomials of degree 5 in z that are A and B for z <= NEAR
_A = (1.0, -0.0833333333333038, 0.015277777766281236)
_A += (-0.003158067145849683, 0.0006880007798053454, -0.00015131755901776796)
_B = (1.0, -0.1666666666665971, 0.03333333330625483)
_B += (-0.007142853286583752, 0.00158705313550121, -0.00035335621566035354)


def distance(a, b, per_a, per_b):
    """z of a and b; per_a, per_b: 1 over each."""
    return a * per_b + (b * per_a - 2.0)


def logarithmic_mean(a, b, z, near):
    """The logarithmic mean of two positive numbers of distance z; near: z <= NEAR is known."""
    close = 0.5 * (a + b) * _quintic(z, *_A)
    return close if near else np.where(z > NEAR, (a - b) / _logarithm_of_ratio(a, b, z), close)


def harmonic_mean(a, b, z, near):
    """1 / (the logarithmic mean of 1/a and 1/b)."""
    close = 0.5 * (a + b) * _quintic(z, *_B)
    if near:
        return close
    far = a * b * (_logarithm_of_ratio(a, b, z) / np.where(z > NEAR, a - b, 1.0))
    return np.where(z > NEAR, far, close)


def _logarithm_of_ratio(a, b, z):
    """ln(a/b) if z > NEAR, else 1."""
    return np.log(np.where(z > NEAR, a / b, np.e))


def _quintic(z, c0, c1, c2, c3, c4, c5):
    """c0 + c1 z + … + c5 z^5, whose pairs of terms do not wait for one another."""
    square = z * z
    return (c0 + z * c1) + square * ((c2 + z * c3) + square * (c4 + z * c5))


def of_sound(law, rho, T):
    """Numbers of sound in gas of rho and T: its speed c, cv, p_T/cv, dT/dp in it, and rho cp."""
    c2, cv = law.sound_speed_squared(rho, T), law.heat_capacity(rho, T)
    by_heat = law.pressure_by_temperature(rho, T) / cv
    capacity = cv * rho * rho * c2 / law.bulk_modulus(rho, T)
    return np.sqrt(c2), cv, by_heat, T * by_heat / (rho * rho * c2), capacity


class Primitive(NamedTuple):
    """What w has, by names."""

    rho: Any
    p: Any
    T: Any
    u: Any
    per_rho: Any
    per_T: Any


def named(w):
    rho, p, T, *u, per_rho, per_T = w
    return Primitive(rho, p, T, tuple(u), per_rho, per_T)


class Gas(NamedTuple):
    """The equations for a gas law, a transport law and numbers.

    law, transport: as in fsipetsc.materials. mu: viscosity [Pa s], kappa: conductivity [W/(m K)];
    the transport law multiplies both. force: (d,) body force per mass [m/s2].

    around: a zero for each of the m hoops around an axis or a centre; r is the last coordinate.
    With A = |r|^m, a^k = (b^k_1, A b^k_2), w = (v_1, A v_2), in one dimension their last numbers,

        g = (b_l . w_r + b_r . w_l)/2,    J_t = sum_k (b^k . D_k w + w . D_k b^k)

    belong to each other exactly: see fsipetsc.blocks.grid. Here v is (v_1, v_2, A).
    """

    law: Any
    transport: Any
    mu: float
    kappa: float
    force: tuple[float, ...]
    around: Any = ()

    def primitive(self, q):
        """w of q = (J, J rho, J rho u, J E)."""
        J, mass, *momentum, energy = q
        both = 1.0 / (J * mass)  # one division, not two
        rho, per_rho = mass * (mass * both), J * (J * both)
        per_mass = J * both
        u = scale(per_mass, momentum)
        T = self.law.temperature(rho, energy * per_mass - 0.5 * dot(u, u))
        return (rho, self.law.pressure(rho, T), T, *u, per_rho, 1.0 / T)

    def state(self, rho, u, T):
        return (rho, self.law.pressure(rho, T), T, *u, 1.0 / rho, 1.0 / T)

    def velocity(self, w):
        return named(w).u

    def densities(self, w):
        """U, per volume."""
        rho, _, T, u, *_ = named(w)
        energy = self.law.energy_density(rho, T) + 0.5 * rho * dot(u, u)
        return (rho, *scale(rho, u), energy)

    def flux(self, w, a):
        """a . f, the inviscid flux through the area a at rest."""
        (rho, p, _, u, *_), (*_, energy) = named(w), self.densities(w)
        through = dot(a, u)
        mass = rho * through
        return (mass, *along(scale(mass, u), p, a), (energy + p) * through)

    def of_grid(self, d):
        """How many numbers v has: what is known of the grid at a node beside its area vectors."""
        return d + bool(self.around)

    def volume_flux(self, a_l, v_l, a_r, v_r):
        """g of two nodes, from their area vectors and velocities of the grid."""
        if self.around:
            A_l, A_r = v_l[-1] + 1e-300, v_r[-1] + 1e-300  # A is 0 beyond the ends of rows
            v_l, v_r = last_times(A_l / A_r, v_l[:-1]), last_times(A_r / A_l, v_r[:-1])
        return 0.5 * (dot(a_l, v_r) + dot(a_r, v_l))

    def mean_flux(self, l, r, a_l, a_r, g):
        """{a . f} - g {U} of two nodes: the divergence form, for any gas law."""
        f = mean(self.flux(l, a_l), self.flux(r, a_r))
        return along(f, -g, mean(self.densities(l), self.densities(r)))

    def mean_density(self, l, r, near):
        """rho^ of two nodes; near: pair_distance is at most NEAR, and no logarithm is needed."""
        l, r = named(l), named(r)
        return logarithmic_mean(l.rho, r.rho, distance(l.rho, r.rho, l.per_rho, r.per_rho), near)

    def pair_flux(self, l, r, a_l, a_r, g, near):
        """F of two nodes, near ones in a third of the time; linear in a_l, a_r and g."""
        rho, law, l, r = self.mean_density(l, r, near), self.law, named(l), named(r)
        T = harmonic_mean(l.T, r.T, distance(l.T, r.T, l.per_T, r.per_T), near)
        a = mean(a_l, a_r)
        through_l, through_r = dot(a, l.u), dot(a, r.u)
        relative = 0.5 * (through_l + through_r) - g
        mass = rho * relative
        momentum = along(scale(mass, mean(l.u, r.u)), 0.5 * (l.p + r.p), a)
        # rho e = rho cv T + what it is where rho = 0
        energy = mass * (law.heat_capacity(rho, T) * T + 0.5 * dot(l.u, r.u))
        energy = energy + relative * law.energy_density(0.0, T)
        return (mass, *momentum, energy + 0.5 * (l.p * through_r + r.p * through_l))

    def pair_force(self, l, r, a_l, a_r, rise, near):
        """{a} rho^ rise/2 of two nodes, for both; rise: Phi_r - Phi_l."""
        return scale(0.5 * self.mean_density(l, r, near) * rise, mean(a_l, a_r))

    def pair_distance(self, l, r):
        """How far two states are apart: the larger distance of density, temperature."""
        l, r = named(l), named(r)
        of_rho = distance(l.rho, r.rho, l.per_rho, r.per_rho)
        return np.maximum(of_rho, distance(l.T, r.T, l.per_T, r.per_T))

    def speed_of_sound(self, w):
        w = named(w)
        return np.sqrt(self.law.sound_speed_squared(w.rho, w.T))

    def entropy_density(self, w):
        """rho s [J/(m3 K)]."""
        w = named(w)
        return w.rho * self.law.entropy(w.rho, w.T)

    def entropy_variables(self, w):
        """(u_1 … u_d, -1)/T: those whose gradients are taken."""
        w = named(w)
        return (*scale(w.per_T, w.u), -w.per_T)

    def first_entropy_variable(self, w):
        """(e + p/rho - |u|^2/2)/T - s."""
        rho, p, T, u, per_rho, per_T = named(w)
        h = (self.law.energy_density(rho, T) + p) * per_rho
        return (h - 0.5 * dot(u, u)) * per_T - self.law.entropy(rho, T)

    def fastest(self, w, a, g):
        """|a . u - g| + c |a|: the fastest wave through the area a whose volume flux is g."""
        w = named(w)
        c_squared = self.law.sound_speed_squared(w.rho, w.T)
        return abs(dot(a, w.u) - g) + np.sqrt(c_squared * dot(a, a))

    def densities_of_change(self, w, change):
        """U_z dz, U by the d + 2 entropy variables z = ((h - |u|^2/2)/T - s, u/T, -1/T), at w.

        A sum of squares where rho, T, cv and rho dp/drho are positive: dz . U_z dz > 0.
        """
        (rho, p, T, u, per_rho, _), (first, *of_u, of_T), law = named(w), change, self.law
        H = (law.energy_density(rho, T) + p - T * law.pressure_by_temperature(rho, T)) * per_rho
        H = H + 0.5 * dot(u, u)
        mass = rho * rho * T / law.bulk_modulus(rho, T) * (first + dot(u, of_u) + H * of_T)
        push = scale(rho * T, along(of_u, of_T, u))
        heat = rho * law.heat_capacity(rho, T) * T * T * of_T
        return (mass, *along(push, mass, u), H * mass + dot(u, push) + heat)

    def size_of_change(self, w, change, dU):
        """T/K dz . U_z dz [-], dU: U_z dz: for a perfect gas the sum of (drho/rho)^2, |du|^2/(R T)
        and (dT/T)^2/(gamma - 1)."""
        w = named(w)
        return abs(dot(change, dU) * w.T / self.law.bulk_modulus(w.rho, w.T))

    def viscous_stress(self, w, scaled, inverse, e=0.0):
        """The tensor tau [Pa], and tau of a hoop; scaled: the tensor grad (u/T), inverse: grad
        (-1/T), e: the rates of all hoops together [1/s].
        """
        w = named(w)
        G = scale(w.T, add(scaled, outer(w.u, inverse)))
        mu = self.mu * self.transport.viscosity(w.T)
        spread = -2.0 / 3.0 * mu * (trace(G) + e if self.around else trace(G))
        tau = add_unit(spread, scale(mu, add(G, transpose(G))))
        return tau, spread + 2.0 * mu * e / len(self.around) if self.around else 0.0

    def conduction(self, w, inverse):
        """kappa grad T [W/m2], from grad (-1/T)."""
        T = named(w).T
        return scale(self.kappa * self.transport.conductivity(T) * (T * T), inverse)

    def viscous_flux(self, w, tau, conduction, a):
        """(tau a, a . (tau u + kappa grad T)): a . f_v without its first number, which is 0."""
        traction = apply(tau, a)
        return (*traction, dot(traction, named(w).u) + dot(conduction, a))

    def raised(self, w, rise):
        """w where the potential is more by `rise`, for gas at rest: rho exp(-rise/(R T))."""
        w = named(w)
        factor = np.exp(-rise * w.rho / self.law.bulk_modulus(w.rho, w.T))
        return self.state(w.rho * factor, w.u, w.T)

    def diffusivity(self, w):
        """The larger of those of momentum, 4/3 mu/rho, and heat, kappa/(rho cv) [m2/s]."""
        w = named(w)
        mu, kappa = self.transport.viscosity(w.T), self.transport.conductivity(w.T)
        of_heat = self.kappa * kappa / self.law.heat_capacity(w.rho, w.T)
        return np.maximum(4.0 / 3.0 * self.mu * mu, of_heat) * w.per_rho
