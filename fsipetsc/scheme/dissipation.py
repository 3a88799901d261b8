"""Dissipation along each axis k, of order q everywhere and of order 1 at shocks, with undivided
differences Delta_q (docs/entropy.md). In a gas mass, momentum, energy and a uniform flow stay, and
entropy does not fall:

    (J U)_t  -=  H_k^-1 Delta_q^T  sigma/4^q (1 - alpha) lambda/(1 + eta) U_z Delta_q z
    eta       =  T/K Delta_q z . U_z Delta_q z,    K = rho dp/drho at constant T

lambda = |a^k . u - g^k| + c |a^k|, z the entropy variables, U_z = dU/dz at the mean rho, u/T and
1/T of the nodes in the middle, which is positive definite. At shocks the flux of a pair of nodes
i < l goes in part from node to node:

    S_il F(i, l)  becomes  (1 - alpha_il) S_il F(i, l)
                  and      alpha_il S_il F(m, m + 1; a_il, g_il)  between m and m + 1,  i <= m < l,

with F(m, m + 1; a, g) the two-point flux of neighbours through the area a and volume flux g of the
pair: such links change the entropy as the pair does, by a . (psi_l - psi_i) - g (phi_l - phi_i). F
is linear in a and g, so neighbours have one flux, through

    A_m = sum alpha_il S_il a_il,   G_m = sum alpha_il S_il g_il   over all pairs with i <= m < l.

To it comes the flux of Lax and Friedrichs, beta/2 max(|A . u - G| + c |A|) (U_m - U_m+1), which
makes entropy grow. alpha of a pair is the largest of its nodes and of those between. At a node j

    alpha = min(1, max(0, 2.5 (s - 0.03))),   d_+ = f_j+1 - f_j,   d_- = f_j - f_j-1,
    s = |d_+ - d_-| / (|d_+| + |d_-| + size),

the largest s of f = rho, p and a_j . u, with the sizes 0.05 (rho_j+1 + 2 rho_j + rho_j-1), the same
of K, and 2 c_j |a_j|; 0 at an end. Of a_j . u the d_+ and d_- below 0 count, which compress. After
R. C. Swanson and E. Turkel, J. Comput. Phys. 101, 1992, for p and with p as the size; links: S.
Hennemann et al., J. Comput. Phys. 426, 2021.

In a solid what motion it takes becomes heat at the same place: with K the wave modulus at rest and
M_q the mean of the nodes in the middle of a difference, where A^k is taken, too,

    F = (a + b alpha) sqrt(K m0) |A^k| Delta_q v
    J0 m0 v_t  -=  H_k^-1 Delta_q^T F
    J0 m0 e_t  -=  v . H_k^-1 Delta_q^T F  -  H_k^-1 M_q^T (F . Delta_q v)
    s = |d_+ - d_-| / (|d_+| + |d_-| + 0.02 sqrt(K/m0)),    f = v, |.| the length of a vector

Everywhere q is half the order of the scheme, a = sigma/4^q. At shocks q = 1, a = 0, b = 0.7 times
the option; then the former has b = -a. alpha of a difference is the largest of its nodes.
"""

from functools import partial, reduce
from types import SimpleNamespace

import numpy as np

from fsipetsc.equations.vectors import add, along, choose, dot, mean, scale, sub
from fsipetsc.kernels.loops import Known, column, each, number, otherwise, pick, row, tally, when
from fsipetsc.operators.sbp import undivided
from fsipetsc.scheme.part import area, gas_at, moving, nodes_of

#: s up to which there is no shock, and how fast alpha rises from there
NO_SHOCK, RISE = 0.03, 2.5
#: in the denominator of s: part of rho and K of a gas, of the speed of sound of a solid
SMALL, SMALL_OF_SOLID = 0.05, 0.02
#: usual strength at shocks of a solid
AT_SHOCKS = 0.7


def sigma_of(option: float, joined: bool) -> float:
    """sigma of -fsi_dissipation: 0 is 1 where blocks are joined, below 0 is none even there."""
    return 0.3 * max(0.0, option if option != 0.0 else float(joined))


class Damping(SimpleNamespace):
    """What terms of gas and solid share: undivided differences

        (Delta_q f)_i = sum_m (-1)^(q - m) C(q, m) f_(i + m),    m = 0 … q,    of nodes in the block

    over the N nodes of a ghosted array. Next to ends a difference counts as much as the least norm
    of its nodes, or it would be stiffer there.

    weights: (q + 1) numbers of a difference. strides: of the axes in memory. norm: (d, N) the least
    norm of the nodes of the difference that begins at a node, 0 where it does not fit. per_weight:
    (d, N) 1 / weight of a node along the axis. alpha: (d, N). F: (numbers, N and more) what
    differences along one axis have, after zeros for those before the first.
    """

    def __init__(self, q, bands, cells, numbers):
        shape, d = [len(band.weight) for band in bands], len(cells)
        least, per_weight = [np.zeros(n) for n in shape], [1.0 / band.weight for band in bands]
        for k in range(d):
            H = bands[k].weight * cells[k]
            for i in range(shape[k] - q):
                least[k][i] = min(1.0, *H[i : i + q + 1])
        self.order, self.weights = Known(q), undivided(q)
        self.strides = np.array([1, shape[0], shape[0] * shape[1]])
        grids = (np.meshgrid(*lines, indexing="ij")[:d] for lines in (least, per_weight))
        self.norm, self.per_weight = (np.stack([one.ravel("F") for one in of]) for of in grids)
        self.alpha, self.nodes = np.zeros_like(self.norm), self.norm.shape[1]
        self.F = np.zeros((numbers, self.nodes + q * self.strides[d - 1]))

    def difference(self, read, i, k, sign=1.0):
        """Return that of the numbers f = read(n) of nodes, from node i on along axis k."""
        first, *others = scale(sign, self.weights)
        found = scale(first, read(i))
        for m, weight in enumerate(others, 1):
            found = along(found, weight, read(i + m * self.strides[k]))
        return found

    def sense(self, steepness, k, length):
        """Fill alpha along axis k of so many nodes, but at its ends, and return at how many it is
        above 0. steepness: the s of a node.
        """
        stride = self.strides[k]
        for line in each(self.nodes // (stride * length)):
            begin = line * (stride * length) + stride
            for i in each(begin, begin + (length - 2) * stride, vector=True):
                steep = RISE * (steepness(i, stride) - NO_SHOCK)
                self.alpha[k, i] = np.minimum(1.0, np.maximum(0.0, steep))
        return tally(0, self.nodes, lambda i: self.alpha[k, i] > 0.0)

    def largest(self, i, k):
        """Return the largest alpha at the nodes of the difference along axis k that begins at i."""
        every = range(self.order + 1)
        return reduce(np.maximum, (self.alpha[k, i + m * self.strides[k]] for m in every))

    def fill(self, k, of):
        """Fill F of differences along axis k, by their first nodes, with zeros where one does not
        fit. of(i, l, r): F of the one that begins at a node, from the nodes in its middle.
        """
        order, stride, N = self.order, self.strides[k], self.nodes
        before, last = self.F.shape[1] - N, N - order * stride
        for i in each(last, vector=True):
            l, r = i + order // 2 * stride, i + (order + 1) // 2 * stride
            self.F[:, before + i] = of(i, l, r)
        self.F[:, before + last :] = 0.0

    def back(self, count, k, node):
        """Return Delta^T F at a node, of the first numbers."""
        first = self.F.shape[1] - self.nodes + node - self.order * self.strides[k]
        # weights of Delta^T: those of Delta in reverse order, perhaps with sign -1
        sign = 1.0 - 2.0 * (self.order % 2)
        return self.difference(lambda n: column(count, self.F, n), first, k, sign)


class GasDamping(Damping):
    """Both terms of a gas. sigma, shock: their sizes, None: none; raises: of the form. What pairs
    keep of their flux at shocks, 1 - alpha, its sweep finds (fsipetsc.scheme.gas_sweep).

    Memory, (numbers, nodes): states, entropy variables; of each axis areas and volume fluxes of
    links; of a row, alpha and weights of its pairs. shocks: (d,) at how many nodes. In a
    constant force F has the forces of links, too: see fsipetsc.scheme.gas_terms.
    """

    def __init__(self, q, bands, cells, sigma, shock, raises):
        d = len(cells)
        super().__init__(q, bands, cells, d + 2 + raises * (d + 1))
        N = self.nodes
        self.sigma, self.shock = sigma or None, shock or None
        self.state, self.z, self.shocks = np.zeros((d + 5, N)), np.zeros((d + 2, N)), np.zeros(d)
        self.link, self.of_pairs = np.zeros((d, d + 1, N)), (np.zeros(N), np.zeros(N))

    def begin(self, part, q):
        """Find states, perhaps entropy variables and alpha; q (N, d + 3): with a halo of q + 1."""
        gas = part.laws
        for i in each(self.nodes, vector=True):
            w = gas_at(part, q, i)
            self.state[:, i] = w
            if self.sigma is not None:
                first, more = gas.first_entropy_variable(w), gas.entropy_variables(w)
                if part.form.raises:
                    first = first + part.volume.potential[i] * w[-1]
                self.z[:, i] = first, *more
        for k in range(part.d if self.shock is not None else 0):
            steep = partial(steepness, part, self.state, k)
            self.shocks[k] = number(self.sense(steep, k, part.patch.ghosted[k]))
            with when(self.shocks[k] > 0.0):
                self.link_pairs(part, k)

    def add(self, part, rates):
        """Add both terms to the rates (M, d + 3) of the owned nodes, after `begin`."""
        for k in range(part.d):
            if self.shock is not None:
                with when(self.shocks[k] > 0.0):
                    self.flow_on(part, k)
                    for node, own in nodes_of(part):
                        self.collect_links(part, k, node, own, rates)
            if self.sigma is not None:
                self.fill(k, partial(self.flux, part, k))
                for node, own in nodes_of(part):
                    self.collect(part, k, node, own, rates)

    def flux(self, part, k, i, l, r):
        """Return F of the difference along axis k that begins at node i."""
        gas, raises, potential = part.laws, part.form.raises, part.volume.potential
        count, norm = part.d + 2, self.norm[k, i]
        change = self.difference(lambda m: column(count, self.z, m), i, k)
        level = 0.5 * (potential[l] + potential[r]) if raises else 0.0
        change = (change[0] + level * change[-1], *change[1:])
        middle = mean(column(count, self.z, l), column(count, self.z, r))
        T = -1.0 / middle[-1]
        w = gas.state(0.5 * (self.state[0, l] + self.state[0, r]), scale(T, middle[1:-1]), T)
        (a_l, v_l), (a_r, v_r) = ((area(part, k, n), moving(part, n)) for n in (l, r))
        speed = gas.fastest(w, mean(a_l, a_r), 0.5 * (dot(a_l, v_l) + dot(a_r, v_r)))
        if self.shock is not None:
            speed = (1.0 - self.largest(i, k)) * speed
        dU = gas.densities_of_change(w, change)
        eta = gas.size_of_change(w, change, dU)
        F = scale(self.sigma / 4.0**self.order * norm * speed / (1.0 + eta), dU)
        F = (*F, level * F[0]) if raises else F
        return choose(norm > 0.0, F, (0.0,) * len(F))

    def collect(self, part, k, node, own, rates):
        """Add - H^-1 Delta^T F to rates of an owned node and, of what diffuses, the power."""
        d, raises, per_weight = part.d, part.form.raises, self.per_weight[k, node]
        F = self.back(d + 2 + raises, k, node)
        rates[own, 1:] = along(row(d + 2, rates, own, 1), -per_weight, F[: d + 2])
        if raises:
            power = part.volume.potential[node] * F[0] - F[-1]
            part.volume.supplied[own, d] += per_weight * power

    def rows(self, part, k):
        """Yield rows of nodes side by side, which are a line along axis 0 or, for other axes k, at
        one place along them: first node, how many, their place.
        """
        length, n = part.patch.ghosted[k], part.patch.ghosted[0] if k == 0 else self.strides[k]
        for row_number in each(self.nodes // n):
            yield row_number * n, n, row_number % length

    def link_pairs(self, part, k):
        """Add up areas and volume fluxes of links along axis k."""
        gas, d, S, stride, link = part.laws, part.d, part.S[k], self.strides[k], self.link[k]
        (alpha, weight), grid = self.of_pairs, (gas.of_grid(d), part.metrics)
        link[:] = 0.0
        for first, n, place in self.rows(part, k):
            alpha[:n] = 0.0
            for m in each(part.axes[k, 0] + 1):
                count = n - m if k == 0 else pick(place + m < part.patch.ghosted[k], n, 0)
                for i in each(count, vector=True):
                    alpha[i] = np.maximum(alpha[i], self.alpha[k, first + m * stride + i])
                    known = np.where(alpha[i] > 0.0, alpha[i], 0.0)  # not of an unphysical state
                    weight[i] = known * S[m, i if k == 0 else place]
                with when(tally(0, count, lambda i: weight[i] != 0.0) > 0):
                    for to in each(m):
                        for i in each(count, vector=True):
                            l, r, at = (first + i + c * stride for c in (0, m, to))
                            a_l, a_r = area(part, k, l), area(part, k, r)
                            v_l, v_r = (column(*grid, c, d * d) for c in (l, r))
                            more = *mean(a_l, a_r), gas.volume_flux(a_l, v_l, a_r, v_r)
                            link[:, at] = along(column(d + 1, link, at), weight[i], more)

    def flow_on(self, part, k):
        """Fill F of links, by their first nodes."""
        last, F = self.nodes - self.strides[k], self.F[:, self.F.shape[1] - self.nodes :]
        link = partial(column, part.d + 1, self.link[k])
        for first, n, _ in self.rows(part, k):
            end = np.minimum(first + n, last)
            with when(tally(first, end, lambda i: dot(link(i), link(i)) > 0.0) > 0):
                for i in each(first, end, vector=True):
                    F[:, i] = self.through(part, k, i, i + self.strides[k])
            with otherwise():
                F[:, first:end] = 0.0
        F[:, last:] = 0.0

    def through(self, part, k, i, j):
        """Return the flux through the link of two nodes, with that of Lax and Friedrichs, and the
        forces in it.
        """
        gas, form, d, potential = part.laws, part.form, part.d, part.volume.potential
        l, r = (column(d + 5, self.state, n) for n in (i, j))
        *a, g = link = column(d + 1, self.link[k], i)
        rise = potential[j] - potential[i] if form.raises else 0.0
        speed = 0.5 * self.shock * np.maximum(gas.fastest(l, a, g), gas.fastest(r, a, g))
        both = l, r
        if form.raises:
            both = gas.raised(l, 0.5 * rise), gas.raised(r, -0.5 * rise)
        change = sub(gas.densities(both[1]), gas.densities(both[0]))
        F, _ = form.pair(gas, l, r, a, a, g, rise)
        F = *along(F[: d + 2], -speed, change), *F[d + 2 :]
        F = (*F, -0.5 * speed * change[0] * rise) if form.raises else F
        return choose(dot(link, link) > 0.0, F, (0.0,) * len(F))

    def collect_links(self, part, k, node, own, rates):
        """Add what flows through links to rates of an owned node, and the forces in both."""
        d, per_weight = part.d, self.per_weight[k, node]
        here = self.F.shape[1] - self.nodes + node
        count = d + 2 + part.form.raises * (d + 1)
        behind, ahead = (column(count, self.F, n) for n in (here - self.strides[k], here))
        more = sub(behind[: d + 2], ahead[: d + 2])
        rates[own, 1:] = along(row(d + 2, rates, own, 1), per_weight, more)
        if part.form.raises:
            supplied, force = part.volume.supplied, add(behind[d + 2 :], ahead[d + 2 :])
            supplied[own] = along(row(d + 1, supplied, own), -per_weight, force)


def steepness(part, state, k, i, stride):
    """The steepness s of a node along axis k. state: (3 + d and more, N)."""
    law, a = part.laws.law, area(part, k, i)
    below, here, above = (column(part.d + 3, state, n) for n in (i - stride, i, i + stride))
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


class SolidDamping(Damping):
    """A term of a solid, a and b of F. impedance: sqrt(K m0) [kg/(m2 s)], small: of s [m/s]."""

    def __init__(self, q, bands, cells, solid, a, b):
        super().__init__(q, bands, cells, len(cells) + 1)
        K = solid.law.wave_modulus(solid.tensor(solid.unstrained(len(cells))))
        self.a, self.b, self.work = a, b, np.zeros(self.nodes)
        self.impedance = float(np.sqrt(K * solid.m0))
        self.small = float(SMALL_OF_SOLID * np.sqrt(K / solid.m0))

    def add(self, part, own, q, rates, gain):
        """Add this term to the rates (M, 2d + 1) of the owned nodes, and its work to what is lost;
        q (N, 2d + 1): with a halo of q + 1 nodes at least.
        """
        d = part.d
        if part.loses:
            self.work[:] = 0.0
        for k in range(d):
            with when(self.b != 0.0):
                self.sense(partial(self.bent, part, q), k, part.patch.ghosted[k])
            self.fill(k, partial(self.drag, part, q, k))
            for node, own in nodes_of(part):
                force, power, heat = self.slowed(part, q, k, node)
                for c, value in enumerate((*force, power + heat), d):
                    rates[own, c] += value
                if part.loses:
                    self.work[node] += part.masses[own] * power
        if part.loses:
            for i in each(self.nodes):
                gain.lost[0] += self.work[i]

    def bent(self, part, q, i, stride):
        """The steepness s of a node."""
        nodes = i - stride, i, i + stride
        below, here, above = (row(part.d, q, n, part.d) for n in nodes)
        rise, fall = sub(above, here), sub(here, below)
        turn, *both = (np.sqrt(dot(a, a)) for a in (sub(rise, fall), rise, fall))
        return turn / (both[0] + both[1] + self.small)

    def drag(self, part, q, k, i, l, r):
        """Return F and F . Delta v of the difference along axis k that begins at node i."""
        A = mean(area(part, k, l), area(part, k, r))
        change = self.difference(lambda n: row(part.d, q, n, part.d), i, k)
        speed = (self.a + self.b * self.largest(i, k)) * self.norm[k, i] * self.impedance
        F = scale(speed * np.sqrt(dot(A, A)), change)
        return *F, dot(F, change)

    def slowed(self, part, q, k, node):
        """What differences along axis k give to a node: rates of v, their power, and heat."""
        d, order, stride = part.d, self.order, self.strides[k]
        per_mass = self.per_weight[k, node] / (part.metrics[d * d, node] * part.laws.m0)
        force, here = scale(-per_mass, self.back(d, k, node)), self.F.shape[1] - self.nodes
        loss = [self.F[d, here + node - j * stride] for j in (order // 2, (order + 1) // 2)]
        heat = 0.5 * per_mass * (loss[0] + loss[1])
        return force, dot(row(d, q, node, d), force), heat
