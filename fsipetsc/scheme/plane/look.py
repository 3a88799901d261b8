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

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import Formulas, each
from fsipetsc.operators.kernels import FORMULA, OPTIONS, U64
from fsipetsc.operators.lanes import half, lane, masked, where_above
from fsipetsc.operators.memory import load_twice, load_twice_interlaced, store
from fsipetsc.operators.rows import STRIDE, along, at
from fsipetsc.operators.vectors import TWICE, fma, magnitude, maximum, minimum, on_aligned_stack, root, spread_twice
from fsipetsc.physics.plane.gas import JA1, JA2_X, JA2_Y, LINE_ROWS, between, line_of
from fsipetsc.physics.plane.layer import DOF, ELASTIC, NOWHERE
from fsipetsc.scheme.plane.geometry import lay
from fsipetsc.scheme.plane.kinetic import mended
from fsipetsc.scheme.plane.slopes import slopes_across, weigh_across
from fsipetsc.scheme.plane.sums import norm_at
from fsipetsc.scheme.plane.sweep import block_width, last_needed, place_of, prepare_row
from fsipetsc.scheme.plane.targets import at_interface

CONVECTION, DIFFUSION, BAD, LEAST_J, MASS, MOMENTUM_X, MOMENTUM_Y, ENERGY, ENTROPY = range(9)
#: the largest number below 0, about: a modulus may be 0, not less
_BELOW = -1e-300
#: number of words; those from MASS on are sums
WORDS = 9


class Seen(NamedTuple):
    """What has been seen so far, in vectors: what bounds steps, the least J, the least of what must be above 0, integrals."""

    convection: float
    diffusion: float
    least_J: float
    least: float
    mass: float
    x: float
    y: float
    e: float
    s: float


@njit(**FORMULA)
def nothing_seen():
    """To begin with."""
    zero, most = spread_twice(0.0), spread_twice(np.inf)
    return Seen(zero, zero, most, most, zero, zero, zero, zero, zero)


@njit(**FORMULA)
def _times(v, part):
    return part * v


@njit(**FORMULA)
def _first(v, count, other):
    return masked(v, count, other)


of_vectors = Formulas(times=_times, first=_first)


@njit(**FORMULA)
def with_more(seen, count, part, convection, diffusion, J, least, integrals):
    """And so many of a vector of points; part: their weights in integrals."""
    mass, x, y, energy, entropy = each(of_vectors.times, integrals, part)
    if count < TWICE:
        mass, x, y, energy, entropy = each(of_vectors.first, (mass, x, y, energy, entropy), count, 0.0)
        convection, diffusion = each(of_vectors.first, (convection, diffusion), count, 0.0)
        J, least = each(of_vectors.first, (J, least), count, np.inf)
    return Seen(
        maximum(seen.convection, convection),
        maximum(seen.diffusion, diffusion),
        minimum(seen.least_J, J),
        minimum(seen.least, least),
        seen.mass + mass,
        seen.x + x,
        seen.y + y,
        seen.e + energy,
        seen.s + entropy,
    )


@njit(**FORMULA)
def largest(v):
    """Of the lanes; not a number if one of them is not."""
    v = maximum(half(v, 0), half(v, 1))
    below, above = maximum(lane(v, 0), lane(v, 1)), maximum(lane(v, 2), lane(v, 3))
    return maximum(maximum(below, above), maximum(maximum(lane(v, 4), lane(v, 5)), maximum(lane(v, 6), lane(v, 7))))


@njit(**FORMULA)
def total(v):
    """Of the lanes."""
    v = half(v, 0) + half(v, 1)
    below, above = (lane(v, 0) + lane(v, 1)) + (lane(v, 2) + lane(v, 3)), (lane(v, 4) + lane(v, 5)) + (lane(v, 6) + lane(v, 7))
    return below + above


@njit(**OPTIONS)
def note(seen, words):
    """Put it into words."""
    words[CONVECTION], words[DIFFUSION] = largest(seen.convection), largest(seen.diffusion)
    words[LEAST_J] = -largest(-1.0 * seen.least_J)
    sound = -largest(-1.0 * seen.least) > 0.0 and words[CONVECTION] < np.inf
    words[BAD] = 0.0 if sound else 1.0
    words[MASS], words[MOMENTUM_X], words[MOMENTUM_Y] = total(seen.mass), total(seen.x), total(seen.y)
    words[ENERGY], words[ENTROPY] = total(seen.e), total(seen.s)


@njit(**OPTIONS)
def weigh(layer, op, s, place):
    """Weights of the columns of a block in integrals over the reference coordinates, to a row of scratch."""
    for i in range(place.first, place.end):
        inside = layer.end_x[1] >= NOWHERE
        s[U64(place.rates + i)] = layer.h_x * layer.h_y * (1.0 if inside else norm_at(op, i, layer.end_x[0], layer.end_x[1]))


@njit(**OPTIONS)
def look_at_gas(law, layer, op, s, y, lines, words):
    """Words of a gas layer."""
    seen = nothing_seen()
    for first in range(layer.own_x[0], layer.own_x[1], block_width(layer)):
        place = place_of(layer, first)
        lay(layer, op, s, place, lines)
        seen = look_at_block_of_gas(law, layer, op, s, place, y, seen)
    note(seen, words)


@njit(**OPTIONS)
def look_at_block_of_gas(law, layer, op, s, place, y, seen):
    """What has been seen, and the points of a block, whose lines stand in scratch."""
    on_aligned_stack()
    weigh(layer, op, s, place)
    c, low, high = law.constants(law, layer), place.lines, place.lines + LINE_ROWS * STRIDE
    per_h_x, per_h_y = 1.0 / layer.h_x, 1.0 / layer.h_y
    for j in range(layer.own_y[0], layer.own_y[1]):
        zeta, first = (layer.first_y + j) / (layer.ny - 1), j * layer.width * DOF
        across_y = norm_at(op, j, layer.end_y[0], layer.end_y[1])
        for i in range(place.first, place.end, TWICE):
            J, r, m, n, e = load_twice_interlaced(y, first + i * DOF, 5)
            per_both = 1.0 / (J * r)  # divisions take as long as twenty products
            per_J, per_r = r * per_both, J * per_both
            u, v, rho = m * per_r, n * per_r, r * per_J
            T = law.gas.temperature_in_loops(c[0], rho, e * per_r - 0.5 * fma(u, u, v * v))
            a1x, a1y = line_of(s, place.lines, JA1, i), line_of(s, place.lines, JA1 + 1, i)
            a2x, a2y = between(s, place.lines, JA2_X, zeta, i), between(s, place.lines, JA2_Y, zeta, i)
            u = u - blend(s, low + 2 * STRIDE + i, high + 2 * STRIDE + i, zeta)
            v = v - blend(s, low + 3 * STRIDE + i, high + 3 * STRIDE + i, zeta)
            n1, n2 = fma(a1x, a1x, a1y * a1y), fma(a2x, a2x, a2y * a2y)
            squared, x, z = law.gas.sound_speed_squared(c[0], rho, T), per_J * per_h_x, per_J * per_h_y
            fastest = (magnitude(fma(a1x, u, a1y * v)) + root(squared * n1)) * x
            fastest = fastest + (magnitude(fma(a2x, u, a2y * v)) + root(squared * n2)) * z
            of_mu, of_kappa = law.transport.relative(c[1], T)
            spreading = maximum(4.0 / 3.0 * layer.mu * of_mu, layer.kappa * of_kappa / law.gas.heat_capacity(c[0], rho, T))
            diffusion = (op.stiffness * spreading) * (J * per_r) * fma(n1, x * x, n2 * (z * z))
            integrals = r, m, n, e, r * law.gas.entropy(c[0], rho, T)
            part, least = across_y * load_twice(s, place.rates + i), minimum(minimum(rho, T), J)
            seen = with_more(seen, place.end - i, part, fastest, diffusion, J, least, integrals)
    return seen


@njit(**FORMULA)
def blend(s, low, high, zeta):
    """Of a quantity of the lines, between them."""
    below = load_twice(s, low)
    return fma(zeta, load_twice(s, high) - below, below)


@njit(**OPTIONS)
def look_at_solid(law, layer, op, s, y, words, kept, mend):
    """Words of a solid layer. The energy: kinetic and m0 alpha T, and the elastic one W where the heat is without its work.

    kept, mend: see fsipetsc.scheme.plane.kinetic.
    """
    seen = nothing_seen()
    for first in range(layer.own_x[0], layer.own_x[1], block_width(layer)):
        seen = look_at_block_of_solid(law, layer, op, s, place_of(layer, first), y, kept, mend, seen)
    note(seen, words)
    words[CONVECTION] = np.sqrt(words[CONVECTION])


@njit(**FORMULA)
def squared_sum(x, y):
    """(sqrt x + sqrt y)^2; not a number where one of them is below 0."""
    return where_above(minimum(x, y), _BELOW, x + y + 2.0 * root(x * y), spread_twice(np.nan))


@njit(**OPTIONS)
def strain_row(law, layer, op, s, place, y, j, prepared):
    """Derivatives of the displacement at row j of a block of a solid, to slopes; how many rows are prepared, and were."""
    a, b = place.first, place.end
    while prepared <= min(last_needed(op, j, layer.end_y[0], layer.end_y[1]), layer.height - 1):
        prepare_row(law, layer, op, s, place, y, prepared)
        prepared += 1
    for k in range(2):
        to = place.slopes + 2 * k * STRIDE
        along(op, s, at(place.v, k, j), to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
    terms = weigh_across(layer, op, s, place, j, False)
    for i in range(a, b, TWICE):
        x, y = slopes_across((0, 1), s, place.v, j, i, terms)
        store(s, place.slopes + STRIDE + i, x)
        store(s, place.slopes + 3 * STRIDE + i, y)
    return prepared


@njit(**OPTIONS)
def look_at_block_of_solid(law, layer, op, s, place, y, kept, mend, seen):
    """What has been seen, and the points of a block; of the rate of convection its square, which takes one root of a point."""
    on_aligned_stack()
    per_x, per_y = 1.0 / (layer.m0 * layer.h_x**2), 1.0 / (layer.m0 * layer.h_y**2)
    c, a, b, prepared, slopes = law.elastic.constants(layer), place.first, place.end, 0, place.slopes
    weigh(layer, op, s, place)
    for j in range(layer.own_y[0], layer.own_y[1]):
        prepared = strain_row(law, layer, op, s, place, y, j, prepared)
        across_y = norm_at(op, j, layer.end_y[0], layer.end_y[1])
        u_row, v_row, T_row = at(place.v, 2, j), at(place.v, 3, j), at(place.v, 4, j)
        moving = 0.0 if at_interface(layer, j) else 1.0
        for i in range(a, b, TWICE):
            d = slopes + i
            f12, f21 = load_twice(s, d + STRIDE), load_twice(s, d + 2 * STRIDE)
            F = load_twice(s, d) + 1.0, f12, f21, load_twice(s, d + 3 * STRIDE) + 1.0
            u, v, T = load_twice(s, u_row + i), load_twice(s, v_row + i), load_twice(s, T_row + i)
            J, x, z = F[0] * F[3] - F[1] * F[2], fma(F[3], F[3], F[1] * F[1]), fma(F[2], F[2], F[0] * F[0])
            along_x, along_y = law.elastic.modulus(c, F, x, z)
            fastest = squared_sum(along_x * per_x, along_y * per_y)
            diffusion = spread_twice(0.0)
            if layer.kappa_e > 0.0:
                spreading = (op.stiffness * layer.kappa_e / (layer.alpha * layer.m0)) / J
                diffusion = spreading * layer.m0 * fma(x, per_x, z * per_y)
            kinetic, elastic = (0.5 * layer.m0) * fma(u, u, v * v), spread_twice(0.0)
            if layer.heat == ELASTIC:
                elastic = law.elastic.energy(c, F)
            T = mended(layer, s, place.rates + STRIDE + i, y, kept, mend, j, i, b - i, fma(moving, kinetic, elastic), T)
            energy = kinetic + elastic + (layer.m0 * layer.alpha) * T
            fastest = fastest + 0.0 * (u + v)  # which must be numbers, too
            integrals = spread_twice(layer.m0), layer.m0 * u, layer.m0 * v, energy, layer.m0 * layer.alpha * np.log(T)
            part = across_y * load_twice(s, place.rates + i)
            seen = with_more(seen, b - i, part, fastest, diffusion, J, minimum(J, T), integrals)
    return seen
