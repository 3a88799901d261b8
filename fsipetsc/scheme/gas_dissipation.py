"""Dissipation of a gas block: of order q everywhere, of order 1 at shocks.

Both terms keep mass, momentum, energy and a uniform flow, and entropy does not fall. Along each
axis k, with undivided differences (fsipetsc.operators.undivided),

    (J U)_t  -=  H_k^-1 Delta_q^T  sigma/4^q (1 - alpha) lambda/(1 + eta) U_z Delta_q z,

lambda = |a^k . u - g^k| + c |a^k|, z the entropy variables, U_z = dU/dz at the mean rho, u/T and
1/T of the nodes in the middle, which is positive definite. U_z Delta_q z stands for Delta_q U,
which it is if that is small: z has |u|^2/T, and in cold gas a jump of u is a much larger one of z.

    eta = T/K Delta_q z . U_z Delta_q z,    K = rho dp/drho at constant T,

is the square of this change over the state itself (for a perfect gas that of drho/rho, and
|du|^2/(R T), and (dT/T)^2/(gamma - 1)). With 1 + eta below it the flux is never more than the state
bears, however far neighbours are apart. eta falls with h^2q in smooth flow.

At shocks the flux of a pair of nodes i < l goes in part from node to node:

    S_il F(i, l)  becomes  (1 - alpha_il) S_il F(i, l)
                  and      alpha_il S_il F(m, m + 1; a_il, g_il)  between m and m + 1,  i <= m < l,

with F(m, m + 1; a, g) the two-point flux of neighbours through the area a and volume flux g of the
pair. What leaves i arrives at l, and in a uniform flow each link has the flux F(i, l). With the
potentials psi, phi of the entropy, (z_l - z_i) . F(i, l; a, g) = a . (psi_l - psi_i) -
g (phi_l - phi_i): the links change the entropy as the pair does, whatever alpha is. F is linear in
a and g, so neighbours have one flux, through

    A_m = sum alpha_il S_il a_il,   G_m = sum alpha_il S_il g_il   over all pairs with i <= m < l.

To it comes the flux of Lax and Friedrichs, S/2 max(|A . u - G| + c |A|) (U_m - U_m+1), which makes
entropy grow. With alpha = 1 everywhere this is a scheme of finite volumes of first order.

alpha of a pair is the largest of its nodes and of those between. At a node j

    alpha = min(1, max(0, 2.5 (s - 0.03))),   d_+ = f_j+1 - f_j,   d_- = f_j - f_j-1,
    s = |d_+ - d_-| / (|d_+| + |d_-| + size),

the largest s of f = rho, p and a_j . u, with the sizes 0.05 (rho_j+1 + 2 rho_j + rho_j-1), the same
of K, and 2 c_j |a_j|; 0 at an end, whose pairs have its neighbour's. After R. C. Swanson and E.
Turkel, J. Comput. Phys. 101, 1992, for p and with p as the size. K is p in a perfect gas and p +
p_inf in a stiffened one: what is small beside it is no shock. Where gas collides, or is set in
motion at once, only u jumps at first. Of a_j . u the d_+ and d_- below 0 count, which compress. In
smooth flow s falls with h^2 and alpha is 0.

Finite volumes between the nodes of a summation-by-parts scheme: S. Hennemann et al., J. Comput.
Phys. 426, 2021. That alpha may vary from pair to pair was derived for this program.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.operators.loops import njit, register_jitable
from fsipetsc.operators.loops import (
    CALL,
    EXACT_LOOP,
    INNER_CALL,
    add,
    along,
    choose,
    dot,
    mean,
    scale,
    sub,
    zeros,
)
from fsipetsc.operators.undivided import Differences
from fsipetsc.scheme.gas_forms import state_like
from fsipetsc.scheme.rows import ONE, U64, Array, at, put

#: s up to which there is no shock, and how fast alpha rises from there
NO_SHOCK, RISE = 0.03, 2.5
#: part of rho and K in the denominator of s
SMALL = 0.05


class GasDamping(NamedTuple):
    """Sizes of both terms, 0: none. Memory, by components of N nodes: states, entropy variables,
    fluxes of differences (each component after zeros), alpha, areas and volume fluxes of links,
    sums. In a constant force there are more of these: see fsipetsc.scheme.gas_force.
    """

    sigma: float
    shock: float
    differences: Differences
    state: Array
    z: Array
    F: Array
    alpha: Array
    link: Array
    sums: Array

    def add(self, part, q, rates, gain):
        """Both terms."""
        gas_dissipation(part, self, q, rates)


def gas_damping(like: Any, force: Any, found: Differences, *sizes: float) -> GasDamping:
    """For the nodes of a patch. force: fsipetsc.scheme.gas_force. sizes: sigma, shock."""
    d, N, F = len(like), found.norm.shape[1], len(force.diffused(like)) * found.room(len(like))
    memory = (d + 5) * N, (d + 2) * N, F, N, (d + 1) * N, len(force.linked(like)) * N
    return GasDamping(*sizes, found, *map(np.zeros, memory))


@njit(**CALL)
def gas_dissipation(part, damp, q, rates):
    """Add both terms to the rates (M, d + 3) of the owned nodes; q: with a halo of q + 1 nodes."""
    gas, like, form, S, patch = part.laws, part.like, part.form, part.S, part.patch
    sigma, shock, difference, metrics = damp.sigma, damp.shock, damp.differences, part.metrics
    q, metrics, rates, N = q.reshape(-1), metrics.reshape(-1), rates.reshape(-1), damp.alpha.size
    own, ghosted, first, weights = patch.own, patch.ghosted, patch.first, difference.weights
    potential, supplied = part.potential, part.supplied
    prepare(gas, like, form.force, q, potential, damp.state, damp.z, U64(N))
    for k in range(len(like)):
        stride, damp.sums[:] = int(difference.strides[k]), 0.0
        if shock > 0.0:
            waves = GasWaves(gas, like, damp.state, metrics, U64(k * len(like) * N), U64(N))
            sense(waves, damp.alpha, stride, ghosted[k])
            if damp.alpha.max() > 0.0:
                damp.link[:] = 0.0
                of_axis = metrics, potential, k, stride, ghosted[k]
                split_pairs(gas, like, form, S[k], *of_axis, damp)
                flow_on(gas, like, form, potential, shock, stride, damp)
        if sigma > 0.0:
            strength, norm = sigma / 4.0 ** (len(weights) - 1), difference.norm[k]
            of_axis = weights, norm, metrics, potential, k, U64(stride)
            fluxes(gas, like, form.force, strength, *of_axis, damp, U64(N))
        per_weight = difference.per_weight[k]
        for y in range(own[1]):
            for z in range(own[2]):
                node = U64(first[0] + ghosted[0] * (first[1] + y + ghosted[1] * (first[2] + z)))
                to, n = U64(own[0] * (y + own[1] * z)), U64(own[0])
                found = damp, potential, supplied, rates, to, n
                of_axis = weights, per_weight, sigma > 0.0, node, U64(stride)
                collect(like, form.force, *of_axis, *found)


@njit(**EXACT_LOOP)
def prepare(gas, like, force, q, potential, state, z, n):
    """Primitive and entropy variables of interlaced nodes."""
    like_q = (*like, 0.0, 0.0, 0.0)
    for i in range(n):
        w = gas.primitive(at(like_q, q, U64(0), ONE, i * U64(len(like_q))))
        put(state, U64(0), n, i, w)
        first = force.level(potential, i, gas.first_entropy_variable(w), w)
        put(z, U64(0), n, i, (first, *gas.entropy_variables(w)))


class GasWaves(NamedTuple):
    """What is sensed in a gas along an axis. state, metrics: by components of n nodes; area: where
    those of a^k begin.
    """

    gas: Any
    like: Any
    state: Array
    metrics: Array
    area: Any
    n: Any

    def steepness(self, i, stride):
        """s of a node."""
        like_w, none, n, gas = (*self.like, 0.0, 0.0, 0.0), U64(0), self.n, self.gas
        a = at(self.like, self.metrics, self.area, n, i)
        below = at(like_w, self.state, none, n, i - stride)
        here = at(like_w, self.state, none, n, i)
        above = at(like_w, self.state, none, n, i + stride)
        rise, fall = sub(above, here), sub(here, below)
        size_of_rho = SMALL * (above[0] + 2.0 * here[0] + below[0])
        size_of_p = SMALL * (self.modulus(above) + 2.0 * self.modulus(here) + self.modulus(below))
        s = max(bend(rise[0], fall[0], size_of_rho), bend(rise[1], fall[1], size_of_p))
        c2 = gas.law.sound_speed_squared(here[0], here[2])
        before, behind = min(0.0, dot(a, rise[3:])), min(0.0, dot(a, fall[3:]))
        return max(s, bend(before, behind, 2.0 * np.sqrt(c2 * dot(a, a))))

    def modulus(self, w):
        """K of a state."""
        return self.gas.law.bulk_modulus(w[0], w[2])


@register_jitable
def bend(rise, fall, size):
    """s of d_+ and d_-; 0 where there is nothing."""
    return abs(rise - fall) / (abs(rise) + abs(fall) + size + 1e-300)


@njit(**EXACT_LOOP)
def sense(waves, alpha, stride, length):
    """alpha of all nodes along an axis of so many. waves: with s of a node as ``steepness``."""
    next_one = U64(stride)
    for line in range(0, alpha.size, stride * length):
        begin, end, beyond = line + stride, line + stride * (length - 1), line + stride * length
        for i in range(line, begin):
            alpha[i] = 0.0
        for i in range(U64(begin), U64(max(begin, end))):
            alpha[i] = min(1.0, max(0.0, RISE * (waves.steepness(i, next_one) - NO_SHOCK)))
        for i in range(max(begin, end), beyond):
            alpha[i] = 0.0


# of order q


@register_jitable
def shifted_sum(like, array, start, step, i, stride, weights):
    """sum_m weights_m f_(i + m stride) of the numbers f of a node."""
    found = scale(weights[0], at(like, array, start, step, i))
    for m in range(1, len(weights)):
        found = along(found, weights[m], at(like, array, start, step, i + U64(m) * stride))
    return found


@register_jitable
def largest(alpha, i, stride, weights):
    """The largest alpha of the nodes of a difference."""
    found = alpha[i]
    for m in range(1, len(weights)):
        found = max(found, alpha[i + U64(m) * stride])
    return found


@njit(**EXACT_LOOP)
def fluxes(gas, like, force, strength, weights, norm, metrics, potential, k, stride, damp, n):
    """sigma/4^q lambda/(1 + eta) U_z Delta z of differences by their first nodes, 0 if one does not
    fit.
    """
    like_z, nothing = (*like, 0.0, 0.0), zeros(force.diffused(like))
    d, order, none = len(like), len(weights) - 1, U64(0)
    low, high = U64(order // 2) * stride, U64((order + 1) // 2) * stride
    area, grid = U64(k * d) * n, U64(d * d) * n
    apart = U64(damp.F.size // len(nothing))
    for i in range(n - U64(order) * stride):
        change = shifted_sum(like_z, damp.z, none, n, i, stride, weights)
        l, r = i + low, i + high
        change = force.at_middle(change, potential, l, r)
        middle = mean(at(like_z, damp.z, none, n, l), at(like_z, damp.z, none, n, r))
        T = -1.0 / middle[-1]
        w = gas.state(0.5 * (damp.state[l] + damp.state[r]), scale(T, middle[1:-1]), T)
        a_l, a_r = at(like, metrics, area, n, l), at(like, metrics, area, n, r)
        g = dot(a_l, at(like, metrics, grid, n, l)) + dot(a_r, at(like, metrics, grid, n, r))
        speed = gas.fastest(w, mean(a_l, a_r), 0.5 * g)
        wide = 1.0 - largest(damp.alpha, i, stride, weights)
        dU = gas.densities_of_change(w, change)
        eta = gas.size_of_change(w, change, dU)
        F = scale(strength * norm[i] * wide * speed / (1.0 + eta), dU)
        F = force.with_level(F, potential, l, r)
        put(damp.F, apart - n, apart, i, choose(norm[i] > 0.0, F, nothing))
    for i in range(n - U64(order) * stride, n):
        put(damp.F, apart - n, apart, i, nothing)


@njit(**EXACT_LOOP)
def collect(
    like, force, weights, per_weight, differs, node, stride, damp, potential, supplied, rates, to, n
):
    """Add sums and H^-1 Delta^T F to the rates of a row of owned nodes; all is interlaced there."""
    like_f, N, count = (*like, 0.0, 0.0), U64(per_weight.size), U64(len(like) + 3)
    like_F = force.diffused(like)
    order, apart = len(weights) - 1, U64(damp.F.size // len(like_F))
    back, sign = apart - N + node - U64(order) * stride, 1.0 - 2.0 * (order % 2)
    for i in range(n):
        more, place = at(like_f, damp.sums, node, N, i), (to + i) * count + ONE
        power = 0.0
        if differs:  # weights of Delta^T: those of Delta in reverse order, perhaps with sign -1
            sums_of_F = shifted_sum(like_F, damp.F, back, apart, i, stride, weights)
            sum_of_F, level = force.parted(sums_of_F)
            more = along(more, -sign, sum_of_F)
            power = sign * force.lifted(potential, node + i, sum_of_F, level)
        force.collect(like, damp.sums, N, node + i, per_weight[node + i], power, supplied, to + i)
        found = at(like_f, rates, place, ONE, U64(0))
        put(rates, place, ONE, U64(0), along(found, per_weight[node + i], more))


# at shocks


@njit(**INNER_CALL)
def split_pairs(gas, like, form, S, metrics, potential, k, stride, length, damp):
    """Take alpha of its flux from each pair; add to areas and volume fluxes of its links."""
    for i in range(damp.alpha.size):
        place, alpha = i // stride % length, damp.alpha[i]
        for m in range(1, min(S.shape[0], length - place)):
            alpha = max(alpha, damp.alpha[i + m * stride])
            if alpha > 0.0 and S[m, place] != 0.0:
                weight, ends = alpha * S[m, place], (U64(i), U64(m), U64(stride))
                split(gas, like, form, weight, metrics, potential, k, *ends, damp)


@njit(**INNER_CALL)
def split(gas, like, form, weight, metrics, potential, k, i, m, stride, damp):
    """One pair, of the node i and that m farther on; weight: alpha S."""
    like_w, like_f, d = state_like(like), form.force.sums(like), len(like)
    N, none, like_v = U64(damp.alpha.size), U64(0), gas.of_grid(like)
    j, area, grid = i + m * stride, U64(k * d) * N, U64(d * d) * N
    l, r = at(like_w, damp.state, none, N, i), at(like_w, damp.state, none, N, j)
    a_l, v_l = at(like, metrics, area, N, i), at(like_v, metrics, grid, N, i)
    a_r, v_r = at(like, metrics, area, N, j), at(like_v, metrics, grid, N, j)
    g = gas.volume_flux(a_l, v_l, a_r, v_r)
    F, rise = form.any(gas, l, r, a_l, a_r, g), form.force.rise(potential, i, j)
    below, above = form.force.any(gas, F, l, r, a_l, a_r, rise)
    put(damp.sums, none, N, i, along(at(like_f, damp.sums, none, N, i), weight, below))
    put(damp.sums, none, N, j, along(at(like_f, damp.sums, none, N, j), -weight, above))
    more = (*mean(a_l, a_r), g)
    for n in range(m):
        link = i + U64(n) * stride
        before = at((*like, 0.0), damp.link, none, N, link)
        put(damp.link, none, N, link, along(before, weight, more))


@njit(**INNER_CALL)
def flow_on(gas, like, form, potential, shock, stride, damp):
    """Fluxes through the links, with those of Lax and Friedrichs."""
    like_w, N, none, force = state_like(like), U64(damp.alpha.size), U64(0), form.force
    like_f = force.linked(like)
    for i in range(N - U64(stride)):
        link, j = at((*like, 0.0), damp.link, none, N, i), i + U64(stride)
        a, g = link[:-1], link[-1]
        if dot(link, link) > 0.0:
            l, r = at(like_w, damp.state, none, N, i), at(like_w, damp.state, none, N, j)
            speed = 0.5 * shock * max(gas.fastest(l, a, g), gas.fastest(r, a, g))
            rise = force.rise(potential, i, j)
            jump, F = force.jump(gas, l, r, rise), form.any(gas, l, r, a, a, g)
            below, above = force.link(gas, F, speed, jump, l, r, a, rise)
            put(damp.sums, none, N, i, sub(at(like_f, damp.sums, none, N, i), below))
            put(damp.sums, none, N, j, add(at(like_f, damp.sums, none, N, j), above))
