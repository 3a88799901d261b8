"""dy/dt at a rank's points of a layer, from its points with halos, which fulfil all conditions, and
what is monitored of them after a step.

Gas, (4.20): compressible Navier-Stokes in a rigid frame that moves with the velocity s(t) of the
gas's interface point, X = x - x_I(t) + X_I, mu' = 4 mu / 3, e = rho (internal energy + u^2/2):

    rho_t     + (rho (u-s))_X                                            = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                            = rho force
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X                = rho u force

Solid, (4.19): Lagrangian, sigma an unknown beside the pressure p(epsilon, rho), epsilon = alpha T,
rho = m0 / x_X:

    u_t          = (sigma - p)_X / m0 + force         (T: the paper's row is misprinted, see (3.1c))
    sigma_t      = K / x_X u_X
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t          = u

Viscous stress and conduction are inside the outer derivative: D acts twice, mu and kappa may vary;
rates need values within twice the reach of D. The loops work on a row of scratch for each quantity.

Monitored are 1/dt [1/s] at Courant number 1, by convection and diffusion, and this rank's share of
the masses of the gases [kg/m2], then of energy [J/m2] and momentum [N s/m2] of all layers, by the
norm of the operator, without the strip between an embedded boundary and its ghost point. Sums over
ranks may differ by round-off: nothing that is computed on depends on them.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.kernels.loops import each, named, pick, variable, when
from fsipetsc.paper.ends import beyond_boundary, end_of, outer_side
from fsipetsc.paper.stencils import derivative, narrow_gas, narrow_solid, near_ends
from fsipetsc.scheme.monitor import clear, collected, count, tiled
from fsipetsc.scheme.plan import BAD

#: rows of scratch
ROWS = 15
#: points whose rates are found together: their rows stay in the fastest memory
PIECE = 192
#: of the points 0 to 3: coefficients of delta, delta^2 ... in the integral from the ghost point (0)
#: to the boundary (delta) of the cubic through them
STRIP = np.array([[24, -22, 8, -1], [0, 36, -20, 3], [0, -18, 16, -3], [0, 4, -4, 1]]) / 24.0


class Gas(NamedTuple):
    """The material of a gas, as formulas: its laws are those of fsipetsc.materials, and mu is 4/3
    of its shear viscosity [Pa s].
    """

    law: Any
    transport: Any
    mu: float
    kappa: float
    gamma: float
    force: float

    def viscosity(self, T):
        """mu' = 4/3 mu(T)."""
        return self.mu * self.transport.viscosity(T)

    def conductivity(self, T):
        """kappa(T)."""
        return self.kappa * self.transport.conductivity(T)

    def velocity_and_temperature(self, rho, m, E):
        """(u, T) from (rho, rho u, e), the last one per volume."""
        u = m / rho
        return u, self.law.temperature(rho, E / rho - 0.5 * u * u)

    def total_energy(self, rho, u, T):
        """e, per volume."""
        return rho * (self.law.internal_energy(rho, T) + 0.5 * u * u)


def own_range(layer):
    """(a, b, A, B) among a rank's points with halos: it owns the active ones a .. b-1; A and B are
    the first and the last active point of all."""
    first = named(layer.own_lo - layer.halo_lo)
    A, B = named(layer.lo - first), named(layer.hi - first)
    a, b = np.maximum(layer.halo_lo, A), np.minimum(layer.own_hi - first, B + 1)
    return named(a), named(b), A, B


def widened(a, b, A, B, reach):
    """(first, end) of the active points a .. b-1 and those within ``reach`` of them."""
    return named(np.maximum(A, a - reach)), named(np.minimum(B + 1, b + reach))


def pieces(part):
    """(scratch, a, b, A, B) of pieces a .. b-1 of the points; rows of scratch begin shortly before
    the first point. Rates are forcing, or 0.
    """
    layer, rows, beside = part.layers[0], part.scratch, part.op.halo
    begin, end, A, B = own_range(layer)
    start_with(part, layer.halo_lo, begin, end)
    for piece in each((end - begin + (PIECE - 1)) // PIECE):
        a = named(begin + piece * PIECE)
        scratch = rows.reshape(-1)[beside - a :].reshape(rows.shape[0], rows.shape[1])
        yield scratch, a, named(np.minimum(a + PIECE, end)), A, B


def start_with(part, shift, a, b):
    """Rates are forcing, or 0. Where these are all that stands before the rates of the points
    a .. b-1, they get it with their rates.
    """
    k, n = part.k, part.k.shape[1]
    begin, end = (n, n) if adds(part) else (pick(a < b, one - shift, n) for one in (a, b))
    for first, last in ((0, begin), (end, n)):
        for c in each(k.shape[0]):
            for i in each(first, last, vector=True):
                k[c, i] = 0.0 if part.forcing is None else part.forcing[c, i]


def adds(part):
    """Whether rates are added to what there is: to forcing, or to what narrow terms add."""
    return part.forcing is not None or part.op.narrow


def put(part, k, rates):
    """Store rates of a point, or, where there are some, add them."""
    for c, rate in enumerate(rates):
        part.k[c, k] = part.k[c, k] + rate if adds(part) else rate


def entropy_keeping(gas, rho, m, e, rho_t, m_t, e_t, u_X):
    """What must be added to e_t so that the entropy of a gas's interface point obeys rho T S_t =
    mu' u_X^2.

    Without conduction this point is a particle that no heat reaches, and with h = eps + p/rho

        e_t = u m_t + (h - u^2/2) rho_t + mu' u_X^2.

    The error that the closure makes in the energy, and the entropy that a shock leaves there, would
    stay for ever: nothing carries them away.
    """
    u, T = gas.velocity_and_temperature(rho, m, e)
    h = e / rho - 0.5 * u * u + gas.law.pressure(rho, T) / rho
    return u * m_t + (h - 0.5 * u * u) * rho_t + gas.viscosity(T) * u_X * u_X - e_t


def gas_rates(part):
    """Add the rates of (4.20)."""
    op, gas, layer, kind = part.op, part.law, part.layers[0], end_of(part)
    (rho, m, e), side = (part.local[c] for c in range(3)), outer_side(part.ends)
    for w, a, b, A, B in pieces(part):
        s, per_h, shift = layer.s, 1.0 / layer.h, layer.halo_lo
        (f0, f1), (v0, v1) = (widened(a, b, A, B, reach) for reach in (op.reach, 2 * op.reach))
        u, T, u_X, T_X, f, g, h, f_X, g_X, h_X = (w[c] for c in range(10))
        for i in each(v0, v1, vector=True):
            r = 1.0 / rho[i]
            v = m[i] * r
            u[i], T[i] = v, gas.law.temperature(rho[i], e[i] * r - 0.5 * v * v)
        ghost, end = ((A, B), (B, A))[side]
        if kind.gradient:  # u and T of the ghost point are others for the gradients
            own_u, own_T, seen = variable(), variable(), (v0 <= ghost) & (ghost < v1)
            with when(seen):
                own_u.value, own_T.value = u[ghost], T[ghost]
                u[ghost], T[ghost] = kind(part, ghost).gradient()
        derivative(op, w, 0, w, 2, 2, f0, f1, A, B, per_h)  # u_X, T_X
        if op.narrow:
            narrow_gas(op, gas, layer, w, 0, 10, part.k, a, b, A, B)
        if kind.gradient:
            with when(seen):
                u[ghost], T[ghost] = own_u.value, own_T.value
        for i in each(f0, f1, vector=True):  # rho (u-s), ... of (4.20)
            relative = u[i] - s
            pressing = gas.law.pressure(rho[i], T[i]) - gas.viscosity(T[i]) * u_X[i]
            mass, momentum = rho[i] * relative, m[i] * relative + pressing
            energy = e[i] * relative + u[i] * pressing - gas.conductivity(T[i]) * T_X[i]
            f[i], g[i], h[i] = mass, momentum, energy
        derivative(op, w, 4, w, 7, 3, a, b, A, B, per_h)  # f_X, g_X, h_X
        with when((gas.kappa == 0.0) & (a <= end) & (end < b)):
            rates = -f_X[end], -g_X[end], -h_X[end]
            h_X[end] -= entropy_keeping(gas, rho[end], m[end], e[end], *rates, u_X[end])
        for i in each(a, b, vector=True):
            put(part, i - shift, (-f_X[i], gas.force * rho[i] - g_X[i], gas.force * m[i] - h_X[i]))


def elastic_rates(part):
    """Add the rates of (4.19)."""
    op, solid, layer, q = part.op, part.law, part.layers[0], part.local
    u, sigma, T = (q[c] for c in range(3))
    for w, a, b, A, B in pieces(part):
        per_h, shift = 1.0 / layer.h, layer.halo_lo
        f0, f1 = widened(a, b, A, B, op.reach)
        T_X, x_X, net, conducted, u_X, net_X, conducted_X, stretch = (w[c] for c in range(8))
        derivative(op, q, 2, w, 0, 2, f0, f1, A, B, per_h)  # T_X, x_X
        for i in each(f0, f1, vector=True):  # 1/x_X, sigma - p, kappa_e/x_X T_X
            r = 1.0 / x_X[i]
            stretch[i], net[i] = r, sigma[i] - solid.pressure(T[i], x_X[i])
            conducted[i] = solid.kappa_e * r * T_X[i]
        derivative(op, q, 0, w, 4, 1, a, b, A, B, per_h)  # u_X
        derivative(op, w, 2, w, 5, 2, a, b, A, B, per_h)  # net_X, conducted_X
        if op.narrow:
            scratch = [w[c] for c in (8, 9, 10)]
            narrow_solid(op, solid, layer, T, stretch, scratch, part.k, a, b, A, B)
        for i in each(a, b, vector=True):
            acceleration = net_X[i] / solid.m0 + solid.force
            warming = (net[i] * u_X[i] + conducted_X[i]) / (solid.alpha * solid.m0)
            put(part, i - shift, (acceleration, solid.K * stretch[i] * u_X[i], warming, u[i]))


# after a step


def monitor_gas(part, steps):
    """Fill rates, by the largest |u-s| + c and max(mu', kappa/cv)/rho, and add to sums; note if a
    point is not physical."""
    op, gas, layer, sums = part.op, part.law, part.layers[0], steps.sums
    q, (a, b, A, B), s = part.local, own_range(layer), layer.s
    clear(part.scratch, 3, 4)
    for i, column in tiled(a, b):
        rho, m, e = (q[c, i] for c in range(3))
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = np.absolute(u - s) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        heat = gas.conductivity(T) / gas.law.heat_capacity(rho, T)
        diffusivity = np.maximum(gas.viscosity(T), heat) / rho
        least = np.where(T < rho, T, rho)
        count(part.scratch, column, (speed, diffusivity, -least), (rho, m, e, T + speed))
    extremes, (*totals, other) = collected(part.scratch, (0.0, 0.0, -np.inf), 4)
    fastest, diffusivity, least = extremes
    mass, momentum, energy = totals
    finite = mass.value + momentum.value + energy.value + other.value
    for r, i, _, _ in near_ends(op, a, b, A, B):
        add(totals, op.norm[r] - 1.0, [q[c, i] for c in range(3)])
    side = outer_side(part.ends)
    strip, ghost, step = beyond_boundary(layer, side), (A, B)[side], 1 - 2 * side
    for k in range(4):
        i, weight = ghost + step * k, 0.0
        for coefficient in STRIP[k, ::-1]:
            weight = (weight + float(coefficient)) * strip
        with when((a <= i) & (i < b)):
            add(totals, -weight, [q[c, i] for c in range(3)])
    h = layer.h
    sums[layer.number // 2] += h * mass.value  # every other layer is a gas
    sums[-2] += h * energy.value
    sums[-1] += h * momentum.value
    part.rates[0] = fastest.value / h
    part.rates[1] = op.diffusion * diffusivity.value / (h * h)
    note_bad(steps, (least.value < 0.0) & (np.absolute(finite) < np.inf))


def add(totals, weight, values):
    for total, value in zip(totals, values, strict=True):
        total.value += weight * value


def note_bad(steps, good):
    with when(~good):
        steps.results[BAD] = 1.0


def monitor_solid(part, steps):
    """The same, by the largest speed of waves and kappa_e/(alpha m0 x_X), in Lagrangian
    coordinates."""
    op, solid, layer, sums = part.op, part.law, part.layers[0], steps.sums
    q, (a, b, A, B) = part.local, own_range(layer)
    per_h = 1.0 / layer.h
    clear(part.scratch, 4, 4)
    for i, column in tiled(a, b):
        u, sigma, T = (q[c, i] for c in range(3))
        j = np.maximum(i, A + 1)  # the first point has the stretch of the second one
        x_X = (q[3, j] - q[3, j - 1]) * per_h
        p = solid.pressure(T, x_X)
        modulus = solid.wave_modulus(T, p, np.minimum(sigma, p), x_X)
        sums_of = u, 0.5 * u * u, T, x_X + sigma + modulus
        count(part.scratch, column, (modulus, -modulus, -x_X, -T), sums_of)
    extremes, (*totals, other) = collected(part.scratch, (0.0, *(-np.inf,) * 3), 4)
    stiffest, softest, shortest, coldest = extremes
    finite = totals[0].value + totals[1].value + totals[2].value + other.value
    for r, i, _, _ in near_ends(op, a, b, A, B):
        u, T = q[0, i], q[2, i]
        add(totals, op.norm[r] - 1.0, (u, 0.5 * u * u, T))
    h, (momentum, kinetic, heat) = layer.h, totals
    m0_h = solid.m0 * h
    sums[-2] += m0_h * (kinetic.value + solid.alpha * heat.value)
    sums[-1] += m0_h * momentum.value
    diffusivity = solid.kappa_e / (-shortest.value * solid.alpha * solid.m0)
    part.rates[0] = np.sqrt(stiffest.value / solid.m0) / h
    part.rates[1] = op.diffusion * diffusivity / (h * h)
    physical = (shortest.value < 0.0) & (coldest.value < 0.0) & (softest.value <= 0.0)
    note_bad(steps, physical & (np.absolute(finite) < np.inf))
