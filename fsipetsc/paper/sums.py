"""What is monitored after a step: bounds on the next one, and integrals.

Bounds are the largest numbers of all points, whoever owns them; sums over ranks may differ by
round-off, and nothing that is computed on depends on them. Quadrature with the norm of the
operator, per cross-section; the strip between an embedded boundary and its ghost point does not
count.

    layer.rates     1/dt [1/s] at Courant number 1, by convection and diffusion
    sums            this rank's share of the masses of the gases [kg/m2], then of energy [J/m2] and
                    momentum [N s/m2] of all layers
"""

import numpy as np

from fsipetsc.kernels.loops import each, variable, when
from fsipetsc.paper.embedded import beyond_boundary
from fsipetsc.paper.outer_ends import outer_side
from fsipetsc.paper.rates import own_range
from fsipetsc.paper.stencils import near_ends
from fsipetsc.scheme.plan import BAD

#: of the points 0 to 3: coefficients of delta, delta^2 ... in the integral from the ghost point (0)
#: to the boundary (delta) of the cubic through them
STRIP = np.array([[24, -22, 8, -1], [0, 36, -20, 3], [0, -18, 16, -3], [0, 4, -4, 1]]) / 24.0


def larger(found, x):
    """Let a variable be x if this is larger; what is not a number is never."""
    found.value = np.where(x > found.value, x, found.value)


def smaller(found, x):
    """Let a variable be x if this is smaller."""
    found.value = np.where(x < found.value, x, found.value)


def monitor_gas(part, steps):
    """Fill rates, by the largest |u-s| + c and max(mu', kappa/cv)/rho, and add to sums; note if a
    point is not physical."""
    op, gas, layer, q, sums = part.op, part.law, part.layers[0], part.local, steps.sums
    a, b, A, B = own_range(layer)
    speeds, diffusivities, temperatures, s = *(part.scratch[c] for c in range(3)), layer.s
    for i in each(a, b, vector=True):
        rho = q[i, 0]
        u, T = gas.velocity_and_temperature(rho, q[i, 1], q[i, 2])
        sound = np.sqrt(gas.law.sound_speed_squared(rho, T))
        heat = gas.conductivity(T) / gas.law.heat_capacity(rho, T)
        diffusivity = np.maximum(gas.viscosity(T), heat) / rho
        speeds[i], diffusivities[i] = np.absolute(u - s) + sound, diffusivity
        temperatures[i] = T
    fastest, diffusivity, least, finite = (variable(v) for v in (0.0, 0.0, np.inf, 0.0))
    totals = mass, momentum, energy = [variable() for _ in range(3)]
    for i in each(a, b):
        rho, m, e = (q[i, c] for c in range(3))
        speed, other, T = speeds[i], diffusivities[i], temperatures[i]
        larger(fastest, speed)
        larger(diffusivity, other)
        smaller(least, np.where(T < rho, T, rho))
        finite.value += rho + m + e + T + speed
        add(totals, 1.0, (rho, m, e))
    for r, i, _, _ in near_ends(op, a, b, A, B):
        add(totals, op.norm[r] - 1.0, [q[i, c] for c in range(3)])
    side = outer_side(part.ends)
    strip, ghost, step = beyond_boundary(layer, side), (A, B)[side], 1 - 2 * side
    for k in range(4):
        i, weight = ghost + step * k, 0.0
        for coefficient in STRIP[k, ::-1]:
            weight = (weight + float(coefficient)) * strip
        with when((a <= i) & (i < b)):
            add(totals, -weight, [q[i, c] for c in range(3)])
    h = layer.h
    sums[layer.number // 2] += h * mass.value  # every other layer is a gas
    sums[-2] += h * energy.value
    sums[-1] += h * momentum.value
    layer.rates[0] = fastest.value / h
    layer.rates[1] = op.diffusion * diffusivity.value / (h * h)
    note_bad(steps, (least.value > 0.0) & (np.absolute(finite.value) < np.inf))


def add(totals, weight, values):
    """Add numbers to sums."""
    for total, value in zip(totals, values, strict=True):
        total.value += weight * value


def note_bad(steps, good):
    """Note where a state is not good."""
    with when(~good):
        steps.results[BAD] = 1.0


def monitor_solid(part, steps):
    """The same, by the largest speed of waves and kappa_e/(alpha m0 x_X), in Lagrangian
    coordinates."""
    op, solid, layer, q, sums = part.op, part.law, part.layers[0], part.local, steps.sums
    a, b, A, B = own_range(layer)
    moduli, stretches, per_h = part.scratch[0], part.scratch[1], 1.0 / layer.h

    def measure(i, j):
        sigma, T, x_X = q[i, 1], q[i, 2], (q[j, 3] - q[j - 1, 3]) * per_h
        p = solid.pressure(T, x_X)
        modulus = solid.wave_modulus(T, p, np.minimum(sigma, p), x_X)
        moduli[i], stretches[i] = modulus, x_X

    for i in each(np.maximum(a, A + 1), b, vector=True):
        measure(i, i)
    with when((a == A) & (a < b)):
        measure(A, A + 1)
    stiffest, softest, shortest, coldest = (variable(v) for v in (0.0, np.inf, np.inf, np.inf))
    finite, totals = variable(), [variable() for _ in range(3)]
    for i in each(a, b):
        (u, sigma, T), modulus, x_X = (q[i, c] for c in range(3)), moduli[i], stretches[i]
        larger(stiffest, modulus)
        smaller(softest, modulus)
        smaller(shortest, x_X)
        smaller(coldest, T)
        finite.value += x_X + u * u + sigma + T + modulus
        add(totals, 1.0, (u, 0.5 * u * u, T))
    for r, i, _, _ in near_ends(op, a, b, A, B):
        u, T = q[i, 0], q[i, 2]
        add(totals, op.norm[r] - 1.0, (u, 0.5 * u * u, T))
    h, (momentum, kinetic, heat) = layer.h, totals
    m0_h = solid.m0 * h
    sums[-2] += m0_h * (kinetic.value + solid.alpha * heat.value)
    sums[-1] += m0_h * momentum.value
    diffusivity = solid.kappa_e / (shortest.value * solid.alpha * solid.m0)
    layer.rates[0] = np.sqrt(stiffest.value / solid.m0) / h
    layer.rates[1] = op.diffusion * diffusivity / (h * h)
    physical = (shortest.value > 0.0) & (coldest.value > 0.0) & (softest.value >= 0.0)
    note_bad(steps, physical & (np.absolute(finite.value) < np.inf))
