"""What is monitored after a step: bounds on the next one, and integrals.

Bounds are the largest numbers of all points, whoever owns them; sums over ranks may differ by
round-off, and nothing that is computed on depends on them. Quadrature with the norm of the
operator, per cross-section; the strip between an embedded boundary and its ghost point does not
count.

    rates           1/dt [1/s] at Courant number 1, by convection and diffusion
    sums            this rank's share of the masses of the gases [kg/m2], then of energy [J/m2] and
                    momentum [N s/m2] of all layers
"""

import numpy as np

from fsipetsc.kernels.loops import when
from fsipetsc.paper.ends import beyond_boundary, outer_side
from fsipetsc.paper.rates import own_range
from fsipetsc.paper.stencils import near_ends
from fsipetsc.scheme.columns import COLUMNS, clear, collected, count, tiled
from fsipetsc.scheme.plan import BAD

#: of the points 0 to 3: coefficients of delta, delta^2 ... in the integral from the ghost point (0)
#: to the boundary (delta) of the cubic through them
STRIP = np.array([[24, -22, 8, -1], [0, 36, -20, 3], [0, -18, 16, -3], [0, 4, -4, 1]]) / 24.0


def monitor_gas(part, steps):
    """Fill rates, by the largest |u-s| + c and max(mu', kappa/cv)/rho, and add to sums; note if a
    point is not physical."""
    op, gas, layer, sums = part.op, part.law, part.layers[0], steps.sums
    q, (a, b, A, B), s = part.local, own_range(layer), layer.s
    clear(part.scratch, 3, 4, COLUMNS)
    for i, column in tiled(a, b):
        rho, m, e = (q[c, i] for c in range(3))
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = np.absolute(u - s) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        heat = gas.conductivity(T) / gas.law.heat_capacity(rho, T)
        diffusivity = np.maximum(gas.viscosity(T), heat) / rho
        least = np.where(T < rho, T, rho)
        count(part.scratch, column, (speed, diffusivity, -least), (rho, m, e, T + speed))
    extremes, (*totals, other) = collected(part.scratch, (0.0, 0.0, -np.inf), 4, COLUMNS)
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
    clear(part.scratch, 4, 4, COLUMNS)
    for i, column in tiled(a, b):
        u, sigma, T = (q[c, i] for c in range(3))
        j = np.maximum(i, A + 1)  # the first point has the stretch of the second one
        x_X = (q[3, j] - q[3, j - 1]) * per_h
        p = solid.pressure(T, x_X)
        modulus = solid.wave_modulus(T, p, np.minimum(sigma, p), x_X)
        sums_of = u, 0.5 * u * u, T, x_X + sigma + modulus
        count(part.scratch, column, (modulus, -modulus, -x_X, -T), sums_of)
    extremes, (*totals, other) = collected(part.scratch, (0.0, *(-np.inf,) * 3), 4, COLUMNS)
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
