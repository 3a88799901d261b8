"""What is monitored after a step: bounds on the next one, and integrals. Compiled.

Bounds are the largest numbers of all points, whoever owns them; sums over ranks may differ by
round-off, and nothing that is computed on depends on them. Quadrature with the norm of the
operator, per cross-section; the strip between an embedded boundary and its ghost point does not
count.

    layer.rates     1/dt [1/s] at Courant number 1, by convection and diffusion
    sums            this rank's share of the masses of the gases [kg/m2], then of energy [J/m2] and
                    momentum [N s/m2] of all layers
"""

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.paper.ends import beyond_boundary
from fsipetsc.paper.rates import outer_side, own_range
from fsipetsc.paper.stencils import INNER, weight

#: of the points 0 to 3: coefficients of delta, delta^2 ... in the integral from the ghost point (0)
#: to the boundary (delta) of the cubic through them
STRIP = np.array([[24, -22, 8, -1], [0, 36, -20, 3], [0, -18, 16, -3], [0, 4, -4, 1]]) / 24.0


@njit(**INNER)
def monitor_gas(op, gas, layer, q, sums):
    """Fill rates, by the largest |u-s| + c and max(mu', kappa/cv)/rho, and add to sums; whether all
    points are physical. q: (points with halos, 3)."""
    a, b, A, B = own_range(layer)
    side = outer_side(layer)
    strip, ghost = beyond_boundary(layer, side), (A if side == 0 else B)
    fastest, diffusivity, least, finite = 0.0, 0.0, np.inf, 0.0
    mass, momentum, energy = 0.0, 0.0, 0.0
    for i in range(a, b):
        rho, m, e = q[i, 0], q[i, 1], q[i, 2]
        u, T = gas.velocity_and_temperature(rho, m, e)
        speed = abs(u - layer.s) + np.sqrt(gas.law.sound_speed_squared(rho, T))
        heat = gas.conductivity(T) / gas.law.heat_capacity(rho, T)
        fastest = max(fastest, speed)
        diffusivity = max(diffusivity, max(gas.viscosity(T), heat) / rho)
        least = min(least, min(rho, T))
        finite += rho + m + e + T + speed
        w = weight(op, min(i - A, B - i))
        k = abs(i - ghost)
        if k < 4:
            for power in range(4):
                w -= STRIP[k, power] * strip ** (power + 1)
        mass += w * rho
        momentum += w * m
        energy += w * e
    sums[layer.number // 2] += layer.h * mass  # every other layer is a gas
    sums[-2] += layer.h * energy
    sums[-1] += layer.h * momentum
    layer.rates[0] = fastest / layer.h
    layer.rates[1] = op.diffusion * diffusivity / (layer.h * layer.h)
    return least > 0.0 and np.isfinite(finite)


@njit(**INNER)
def monitor_solid(op, solid, layer, q, sums):
    """The same, by the largest speed of waves and kappa_e/(alpha m0 x_X), in Lagrangian
    coordinates. q: (points with halos, 4)."""
    a, b, A, B = own_range(layer)
    stiffest, softest, shortest, coldest = 0.0, np.inf, np.inf, np.inf
    per_h, finite = 1.0 / layer.h, 0.0
    momentum, kinetic, heat = 0.0, 0.0, 0.0
    for i in range(a, b):
        u, sigma, T, w = q[i, 0], q[i, 1], q[i, 2], weight(op, min(i - A, B - i))
        j = max(i, A + 1)
        x_X = (q[j, 3] - q[j - 1, 3]) * per_h
        p = solid.pressure(T, x_X)
        modulus = solid.wave_modulus(T, p, min(sigma, p), x_X)
        stiffest, softest = max(stiffest, modulus), min(softest, modulus)
        shortest, coldest = min(shortest, x_X), min(coldest, T)
        finite += x_X + u * u + sigma + T + modulus
        momentum += w * u
        kinetic += 0.5 * w * u * u
        heat += w * T
    m0_h = solid.m0 * layer.h
    sums[-2] += m0_h * (kinetic + solid.alpha * heat)
    sums[-1] += m0_h * momentum
    diffusivity = solid.kappa_e / (shortest * solid.alpha * solid.m0)
    layer.rates[0] = np.sqrt(stiffest / solid.m0) / layer.h
    layer.rates[1] = op.diffusion * diffusivity / (layer.h * layer.h)
    return min(shortest, coldest) > 0.0 and softest >= 0.0 and np.isfinite(finite)
