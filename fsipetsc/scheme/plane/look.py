"""One look at each point of a layer after a step: what bounds the next one, whether the state is physical, integrals. Compiled.

Words, of this rank's points:

    CONVECTION  largest rate of convection, sum_k (|Ja^k.(u - w)| + c |Ja^k|) / (J h_k); of waves in a solid, sum_k c_k / h_k
    DIFFUSION   largest rate of diffusion, z max(4/3 mu/rho, kappa/(rho cv)) sum_k |Ja^k|^2 / (J h_k)^2 (z: stiffness of D
    twice)
    BAD         1 if a state is not physical
    LEAST_J     least J
    MASS, MOMENTUM_X, MOMENTUM_Y, ENERGY, ENTROPY    integrals with the norm of the operators; the energy is what is conserved

Extremes are exact, whoever owns the points; the last bits of the sums depend on that, and nothing that is computed on takes
them.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.rows import across, along, at
from fsipetsc.physics.plane.gas import LINE_ROWS
from fsipetsc.physics.plane.layer import DOF, NOWHERE
from fsipetsc.scheme.plane.sweep import last_needed, lines_of, prepare_row

CONVECTION, DIFFUSION, BAD, LEAST_J, MASS, MOMENTUM_X, MOMENTUM_Y, ENERGY, ENTROPY = range(9)
#: number of words; those from MASS on are sums
WORDS = 9


@njit(**OPTIONS)
def begin(words):
    """Nothing has been seen."""
    words[:] = 0.0
    words[LEAST_J] = np.inf


@njit(**OPTIONS)
def weight(op, n, first, last):
    """Of the norm at point n between the ends first and last, without h."""
    r = min(n - first, last - n)
    return op.norm[r] if r < op.rows else 1.0


@njit(**OPTIONS)
def area(layer, op, j, i):
    """Weight of a point in an integral over the reference coordinates."""
    across_y = weight(op, j, layer.end_y[0], layer.end_y[1])
    along_x = weight(op, i, layer.end_x[0], layer.end_x[1]) if layer.end_x[1] < NOWHERE else 1.0
    return along_x * across_y * layer.h_x * layer.h_y


@njit(**OPTIONS)
def look_at_gas(law, layer, op, s, place, y, words):
    """Words of a gas layer; its lines must stand in scratch."""
    begin(words)
    gas, transport = law.gas.constants(layer), law.transport.constants(layer)
    low, stride = lines_of(place), place.stride
    high, per_length = low + LINE_ROWS * stride, 1.0 / ((layer.ny - 1) * layer.h_y)
    for j in range(layer.own_y[0], layer.own_y[1]):
        zeta = (layer.first_y + j) / (layer.ny - 1)
        for i in range(layer.own_x[0], layer.own_x[1]):
            n = (j * layer.width + i) * DOF
            J, r, m, k, e = y[U64(n)], y[U64(n + 1)], y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            u, v, rho = m / r, k / r, r / J
            T = law.gas.temperature(gas, rho, e / r - 0.5 * (u * u + v * v))
            a1x = (s[U64(high + stride + i)] - s[U64(low + stride + i)]) * per_length
            a1y = (s[U64(low + i)] - s[U64(high + i)]) * per_length
            a2x = -blended(s, low, high, 5 * stride + i, zeta)
            a2y = 1.0 + blended(s, low, high, 4 * stride + i, zeta)
            u = u - blended(s, low, high, 2 * stride + i, zeta)
            v = v - blended(s, low, high, 3 * stride + i, zeta)
            n1, n2 = a1x * a1x + a1y * a1y, a2x * a2x + a2y * a2y
            c = np.sqrt(law.gas.sound_speed_squared(gas, rho, T))
            x, z = J * layer.h_x, J * layer.h_y
            fastest = (abs(a1x * u + a1y * v) + c * np.sqrt(n1)) / x + (abs(a2x * u + a2y * v) + c * np.sqrt(n2)) / z
            of_mu, of_kappa = law.transport.relative(transport, T)
            spread = max(4.0 / 3.0 * layer.mu * of_mu, layer.kappa * of_kappa / law.gas.heat_capacity(gas, rho, T)) / rho
            words[CONVECTION] = max(words[CONVECTION], fastest)
            words[DIFFUSION] = max(words[DIFFUSION], op.stiffness * spread * (n1 / (x * x) + n2 / (z * z)))
            if not (rho > 0.0 and T > 0.0 and J > 0.0 and fastest < np.inf):
                words[BAD] = 1.0
            words[LEAST_J] = min(words[LEAST_J], J)
            part = area(layer, op, j, i)
            words[MASS] += part * r
            words[MOMENTUM_X] += part * m
            words[MOMENTUM_Y] += part * k
            words[ENERGY] += part * e
            words[ENTROPY] += part * r * law.gas.entropy(gas, rho, T)


@njit(**OPTIONS)
def blended(s, low, high, row, zeta):
    """Of a quantity of the lines, between them."""
    return s[U64(low + row)] + zeta * (s[U64(high + row)] - s[U64(low + row)])


@njit(**OPTIONS)
def look_at_solid(law, layer, op, s, place, y, words):
    """Words of a solid layer. The energy: kinetic and m0 alpha T, and the elastic one W where the heat is without its work."""
    begin(words)
    c, lo, hi = law.elastic.constants(layer), layer.end_y[0], layer.end_y[1]
    a, b, prepared, stride = layer.own_x[0], layer.own_x[1], 0, place.stride
    for j in range(layer.own_y[0], layer.own_y[1]):
        while prepared <= min(last_needed(op, j, lo, hi), layer.height - 1):
            prepare_row(law, layer, s, place, y, prepared)
            prepared += 1
        for k in range(2):
            to = place.slopes + 2 * k * stride
            along(op, s, at(place.v, k, j), to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
            across(op, s, place.v, k, j, to + stride, a, b, lo, hi, 1.0 / layer.h_y)
        for i in range(a, b):
            n, d = (j * layer.width + i) * DOF, place.slopes + i
            F = (1.0 + s[U64(d)], s[U64(d + stride)], s[U64(d + 2 * stride)], 1.0 + s[U64(d + 3 * stride)])
            u, v, T = y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            J = F[0] * F[3] - F[1] * F[2]
            x, z = F[3] * F[3] + F[1] * F[1], F[2] * F[2] + F[0] * F[0]
            along_x, across_y = law.elastic.modulus(c, F, x, z)
            fastest = np.sqrt(along_x / layer.m0) / layer.h_x + np.sqrt(across_y / layer.m0) / layer.h_y
            spread = layer.kappa_e / (layer.alpha * layer.m0 * J)
            words[CONVECTION] = max(words[CONVECTION], fastest)
            words[DIFFUSION] = max(words[DIFFUSION], op.stiffness * spread * (x / layer.h_x**2 + z / layer.h_y**2))
            if not (J > 0.0 and T > 0.0 and fastest + abs(u) + abs(v) < np.inf):
                words[BAD] = 1.0
            words[LEAST_J] = min(words[LEAST_J], J)
            part = area(layer, op, j, i)
            words[MASS] += part * layer.m0
            words[MOMENTUM_X] += part * layer.m0 * u
            words[MOMENTUM_Y] += part * layer.m0 * v
            energy = layer.m0 * (0.5 * (u * u + v * v) + layer.alpha * T)
            if layer.heat == 1:
                energy += law.elastic.energy(c, F)
            words[ENERGY] += part * energy
            words[ENTROPY] += part * layer.m0 * layer.alpha * np.log(T)
