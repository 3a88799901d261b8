"""Dissipation of a gas block: of order q everywhere, of order 1 at shocks.

Mass, momentum, energy and a uniform flow stay, and entropy does not fall. Along each axis k, with
undivided differences (fsipetsc.operators.bands),

    (J U)_t  -=  H_k^-1 Delta_q^T  sigma/4^q (1 - alpha) lambda/(1 + eta) U_z Delta_q z,

lambda = |a^k . u - g^k| + c |a^k|, z the entropy variables, U_z = dU/dz at the mean rho, u/T and
1/T of the nodes in the middle, which is positive definite. U_z Delta_q z is Delta_q U if that is
small, but z has |u|^2/T: in cold gas a jump of u is a much larger one of z. So with

    eta = T/K Delta_q z . U_z Delta_q z,    K = rho dp/drho at constant T,

the square of this change over the state itself, the flux is never more than the state bears. eta
falls with h^2q in smooth flow.

At shocks the flux of a pair of nodes i < l goes in part from node to node:

    S_il F(i, l)  becomes  (1 - alpha_il) S_il F(i, l)
                  and      alpha_il S_il F(m, m + 1; a_il, g_il)  between m and m + 1,  i <= m < l,

with F(m, m + 1; a, g) the two-point flux of neighbours through the area a and volume flux g of the
pair. What leaves i arrives at l. With the potentials psi, phi of the entropy, (z_l - z_i) .
F(i, l; a, g) = a . (psi_l - psi_i) - g (phi_l - phi_i): the links change the entropy as the pair
does, whatever alpha is. F is linear in a and g, so neighbours have one flux, through

    A_m = sum alpha_il S_il a_il,   G_m = sum alpha_il S_il g_il   over all pairs with i <= m < l.

To it comes the flux of Lax and Friedrichs, beta/2 max(|A . u - G| + c |A|) (U_m - U_m+1), which
makes entropy grow. With alpha = 1 everywhere this is a scheme of finite volumes of first order.

alpha of a pair is the largest of its nodes and of those between. At a node j

    alpha = min(1, max(0, 2.5 (s - 0.03))),   d_+ = f_j+1 - f_j,   d_- = f_j - f_j-1,
    s = |d_+ - d_-| / (|d_+| + |d_-| + size),

the largest s of f = rho, p and a_j . u, with the sizes 0.05 (rho_j+1 + 2 rho_j + rho_j-1), the same
of K (beside which small pressures are no shock), and 2 c_j |a_j|; 0 at an end. Of a_j . u, which
jumps first where gas collides, the d_+ and d_- below 0 count, which compress. In smooth flow s
falls with h^2 and alpha is 0. After R. C. Swanson and E. Turkel, J. Comput. Phys. 101, 1992, for p
and with p as the size. Finite volumes between the nodes of a summation-by-parts scheme: S.
Hennemann et al., J. Comput. Phys. 426, 2021. That alpha may vary from pair to pair was derived for
this program.
"""

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import add, along, choose, dot, mean, scale, sub
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, variable, when
from fsipetsc.operators.bands import difference
from fsipetsc.scheme.gas_force import collect_force, with_force
from fsipetsc.scheme.part import area, clear, gas_at, moving, rows_of

#: s up to which there is no shock, and how fast alpha rises from there
NO_SHOCK, RISE = 0.03, 2.5
#: part of rho and K in the denominator of s
SMALL = 0.05


class GasDamping(SimpleNamespace):
    """Both terms for the nodes of a patch. sigma, shock: their sizes, None: none; raises: of the
    form of convection; found: fsipetsc.operators.bands.Differences.

    Memory, (numbers, nodes): states, entropy variables, fluxes of differences after zeros, alpha,
    areas and volume fluxes of links, sums. In a constant force there are more of these: see
    fsipetsc.scheme.gas_force.
    """

    def __init__(self, d: int, raises: bool, found: Any, sigma: float, shock: float) -> None:
        N = found.norm.shape[1]
        self.sigma, self.shock, self.differences = sigma or None, shock or None, found
        self.state, self.z, self.alpha = np.zeros((d + 5, N)), np.zeros((d + 2, N)), np.zeros(N)
        self.F, self.link = np.zeros((d + 2 + raises, found.room(d))), np.zeros((d + 1, N))
        self.sums = np.zeros((d + 2 + raises * (d + 1), N))

    def add(self, part, q, rates, gain):
        """Add both terms to the rates (M, d + 3) of the owned nodes; q: with a halo of q + 1."""
        prepare(part, self, q)
        for k in range(len(part.like)):
            stride = self.differences.strides[k]
            if self.shock is not None:
                clear(self.sums.reshape(-1))
                steep = partial(steepness, part, self.state, k)
                sense(steep, self.alpha, stride, part.patch.ghosted[k])
                shocks = variable(0.0)
                for i in each(self.alpha.size):
                    shocks.value = np.where(self.alpha[i] > 0.0, 1.0, shocks.value)
                with when(shocks.value > 0.0):
                    clear(self.link.reshape(-1))
                    split_pairs(part, self, k, stride)
                    flow_on(part, self, stride)
            if self.sigma is not None:
                fluxes(part, self, k, stride)
            for first, own, n in rows_of(part):
                collect(part, self, k, stride, first, own, n, rates)


def prepare(part, damp, q):
    """Primitive and, for differences, entropy variables of the nodes."""
    gas = part.laws
    for i in each(damp.alpha.size, vector=True):
        w = gas_at(part, q, i)
        damp.state[:, i] = w
        if damp.sigma is not None:
            first, more = gas.first_entropy_variable(w), gas.entropy_variables(w)
            if part.form.raises:
                first = first + part.volume.potential[i] * w[-1]
            damp.z[:, i] = first, *more


def steepness(part, state, k, i, stride):
    """The steepness s of a node along axis k. state: (3 + d and more, N)."""
    law, like_w = part.laws.law, (*part.like, 0.0, 0.0, 0.0)
    a = area(part, k, i)
    below, above = (column(like_w, state, n) for n in (i - stride, i + stride))
    here = column(like_w, state, i)
    rise, fall = sub(above, here), sub(here, below)
    size_of_rho = SMALL * (above[0] + 2.0 * here[0] + below[0])
    K_above, K, K_below = (law.bulk_modulus(w[0], w[2]) for w in (above, here, below))
    size_of_p = SMALL * (K_above + 2.0 * K + K_below)
    s = np.maximum(bend(rise[0], fall[0], size_of_rho), bend(rise[1], fall[1], size_of_p))
    size = 2.0 * np.sqrt(law.sound_speed_squared(here[0], here[2]) * dot(a, a))
    before, behind = (np.minimum(0.0, dot(a, change[3:])) for change in (rise, fall))
    return np.maximum(s, bend(before, behind, size))


def bend(rise, fall, size):
    """Return s from d_+ and d_-; 0 where both are 0."""
    return abs(rise - fall) / (abs(rise) + abs(fall) + size + 1e-300)


def sense(steepness, alpha, stride, length):
    """Fill alpha of all nodes along an axis of so many; steepness: returns the s of a node."""
    for line in each(alpha.size // (stride * length)):
        first = line * (stride * length)
        begin, beyond = first + stride, first + stride * length
        end = np.maximum(begin, beyond - stride)
        for i in each(first, begin, vector=True):
            alpha[i] = 0.0
        for i in each(begin, end, vector=True):
            steep = RISE * (steepness(i, stride) - NO_SHOCK)
            alpha[i] = np.minimum(1.0, np.maximum(0.0, steep))
        for i in each(end, beyond, vector=True):
            alpha[i] = 0.0


def largest(alpha, i, stride, weights):
    """Return the largest alpha at the nodes of a difference."""
    found = alpha[i]
    for m in range(1, len(weights)):
        found = np.maximum(found, alpha[i + m * stride])
    return found


def fluxes(part, damp, k, stride):
    """Fill F of differences, by their first nodes, with zeros where one does not fit."""
    gas, raises, potential = part.laws, part.form.raises, part.volume.potential
    weights, norm = damp.differences.weights, damp.differences.norm[k]
    like_z, nothing = (*part.like, 0.0, 0.0), (0.0,) * (len(part.like) + 2 + raises)
    N, order = damp.alpha.size, len(weights) - 1
    strength, before = damp.sigma / 4.0**order, damp.F.shape[1] - N
    low, high = order // 2 * stride, (order + 1) // 2 * stride
    for i in each(N - order * stride, vector=True):
        l, r = i + low, i + high
        change = difference(lambda m: column(like_z, damp.z, m), i, stride, weights)
        level = 0.5 * (potential[l] + potential[r]) if raises else 0.0
        change = (change[0] + level * change[-1], *change[1:])
        middle = mean(column(like_z, damp.z, l), column(like_z, damp.z, r))
        T = -1.0 / middle[-1]
        w = gas.state(0.5 * (damp.state[0, l] + damp.state[0, r]), scale(T, middle[1:-1]), T)
        (a_l, v_l), (a_r, v_r) = ((area(part, k, n), moving(part, n)) for n in (l, r))
        speed = gas.fastest(w, mean(a_l, a_r), 0.5 * (dot(a_l, v_l) + dot(a_r, v_r)))
        if damp.shock is not None:
            speed = (1.0 - largest(damp.alpha, i, stride, weights)) * speed
        dU = gas.densities_of_change(w, change)
        eta = gas.size_of_change(w, change, dU)
        F = scale(strength * norm[i] * speed / (1.0 + eta), dU)
        F = choose(norm[i] > 0.0, (*F, level * F[0]) if raises else F, nothing)
        damp.F[:, before + i] = F
    for i in each(N - order * stride, N, vector=True):
        damp.F[:, before + i] = nothing


def collect(part, damp, k, stride, first, own, n, rates):
    """Add sums and H^-1 Delta^T F to rates of n owned nodes; first: the number of the first one."""
    raises, weights = part.form.raises, damp.differences.weights
    order, d = len(weights) - 1, len(part.like)
    like_F, of_links = (0.0,) * (d + 2 + raises), (0.0,) * (d + 2 + raises * (d + 1))
    sign, back = 1.0 - 2.0 * (order % 2), damp.F.shape[1] - damp.alpha.size - order * stride
    for i in each(n, vector=True):
        at_node, here, power = first + i, own + i, 0.0
        per_weight = damp.differences.per_weight[k, at_node]
        sums = (0.0,) * len(of_links)
        if damp.shock is not None:
            sums = column(of_links, damp.sums, at_node)
        more = sums[: d + 2]
        if damp.sigma is not None:
            # weights of Delta^T: those of Delta in reverse order, perhaps with sign -1
            found = difference(lambda m: column(like_F, damp.F, m), back + at_node, stride, weights)
            F = found[: d + 2]
            more = along(more, -sign, F)
            if raises:
                power = sign * (part.volume.potential[at_node] * F[0] - found[-1])
        if raises:
            collect_force(part, sums, per_weight, power, here)
        rates[here, 1:] = along(row(more, rates, here, 1), per_weight, more)


def split_pairs(part, damp, k, stride):
    """Take alpha of its flux from each pair; add to areas and volume fluxes of its links."""
    gas, form, potential, S = part.laws, part.form, part.volume.potential, part.S[k]
    like_w, like_v = (0.0,) * (len(part.like) + 5), gas.of_grid(part.like)
    length, grid = part.patch.ghosted[k], len(part.like) ** 2
    for i in each(damp.alpha.size):
        place, alpha = i // stride % length, variable(damp.alpha[i])
        for m in each(1, np.minimum(S.shape[0], length - place)):
            j = i + m * stride
            alpha.value = np.maximum(alpha.value, damp.alpha[j])
            with when((alpha.value > 0.0) & (S[m, place] != 0.0)):
                weight = alpha.value * S[m, place]
                l, r = column(like_w, damp.state, i), column(like_w, damp.state, j)
                a_l, a_r = area(part, k, i), area(part, k, j)
                v_l, v_r = (column(like_v, part.metrics, n, grid) for n in (i, j))
                g = gas.volume_flux(a_l, v_l, a_r, v_r)
                F = form.flux(gas, l, r, a_l, a_r, g)
                rise = potential[j] - potential[i] if form.raises else 0.0
                below, above = with_force(gas, form, False, F, l, r, a_l, a_r, rise)
                damp.sums[:, i] = along(column(below, damp.sums, i), weight, below)
                damp.sums[:, j] = along(column(above, damp.sums, j), -weight, above)
                more = (*mean(a_l, a_r), g)
                for n in each(m):
                    link = i + n * stride
                    damp.link[:, link] = along(column(more, damp.link, link), weight, more)


def flow_on(part, damp, stride):
    """Add the fluxes through links, with those of Lax and Friedrichs."""
    gas, form, potential = part.laws, part.form, part.volume.potential
    like_w, like_link = (0.0,) * (len(part.like) + 5), (*part.like, 0.0)
    for i in each(damp.alpha.size - stride):
        link, j = column(like_link, damp.link, i), i + stride
        a, g = link[:-1], link[-1]
        with when(dot(link, link) > 0.0):
            l, r = column(like_w, damp.state, i), column(like_w, damp.state, j)
            speed = 0.5 * damp.shock * np.maximum(gas.fastest(l, a, g), gas.fastest(r, a, g))
            rise = potential[j] - potential[i] if form.raises else 0.0
            both = l, r
            if form.raises:
                both = gas.raised(l, 0.5 * rise), gas.raised(r, -0.5 * rise)
            change = sub(gas.densities(both[1]), gas.densities(both[0]))
            F = along(form.flux(gas, l, r, a, a, g), -speed, change)
            below, above = with_force(gas, form, False, F, l, r, a, a, rise)
            if form.raises:
                power = -0.5 * speed * change[0] * rise
                below, above = (*below, power), (*above, -power)
            damp.sums[:, i] = sub(column(below, damp.sums, i), below)
            damp.sums[:, j] = add(column(above, damp.sums, j), above)
