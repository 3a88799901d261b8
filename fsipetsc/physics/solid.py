"""Elastic (elastic-plastic) solid in Lagrangian coordinates, (3.1) and (4.19).

    u_t         = (sigma - p)_X / m0 + force
    sigma_t     = K / x_X u_X,                                   K = 2 mu_e + lambda_e
    alpha m0 T_t = (sigma - p) u_X + (kappa_e / x_X T_X)_X
    x_t         = u

with p(epsilon, rho) an equation of state in epsilon = alpha T and rho = m0 / x_X; p = 0 is the elastic solid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc.checks import ANY, NONNEGATIVE, POSITIVE, numbers
from fsipetsc.operators.kernels import (
    BLOCK,
    OPTIONS,
    ROW,
    U64,
    closure,
    derivative,
    end_of,
    end_rows,
    grid_start,
    interior_stencil,
    row,
    store_lanes,
    weights_of,
    whole_vectors,
)
from fsipetsc.operators.vectors import WIDTH, fma, load, masked, maximum, minimum, mirrored, spread, store
from fsipetsc.scheme.extremes_and_sums import (
    GREATEST_T,
    LEAST_SIGMA,
    LEAST_STRAIN,
    LEAST_T,
    SUMS,
    note_largest,
    note_smallest,
    note_sum,
)
from fsipetsc.scheme.stage_update import update_stage, update_stage_lanes


def modulus(K, gruneisen, p, sigma, x_X):
    """m0 times the squared speed of elastic waves in Lagrangian coordinates [Pa].

    With p = G alpha m0 T / x_X it is what (3.1b-d) make of (sigma - p)_t over u_X: (K + p + G (p - sigma)) / x_X; in
    the letters after (3.9), where x_X = 1, K + (p - sigma) p_eps / rho + rho p_rho.
    """
    return (K + p + gruneisen * (p - sigma)) / x_X


wave_modulus = njit(**OPTIONS)(modulus)


@dataclass(frozen=True)
class Solid:
    """Linear elastic material, with the pressure p = gruneisen * rho * epsilon where gruneisen > 0.

    K: 2 mu_e + lambda_e [Pa]; kappa_e: heat conductivity [W/(m K)]; m0: density in the reference configuration
    [kg/m3]; alpha: specific heat [J/(kg K)]; force: body force per mass [m/s2]; gruneisen: [-]. InputError for what is no
    number or out of range.
    """

    K: float
    kappa_e: float
    m0: float
    alpha: float
    force: float = 0.0
    gruneisen: float = 0.0

    def __post_init__(self) -> None:
        ranges = {"K": POSITIVE, "kappa_e": NONNEGATIVE, "m0": POSITIVE, "alpha": POSITIVE}
        numbers(self, "Solid", {**ranges, "force": ANY, "gruneisen": NONNEGATIVE})

    def sound_speed(self, x_X: float = 1.0, T: float = 0.0, sigma: float = 0.0) -> float:
        """Speed of the elastic waves in Lagrangian coordinates [m/s]; T and sigma matter where gruneisen > 0."""
        return float(modulus(self.K, self.gruneisen, self.pressure(T, x_X), sigma, x_X) / self.m0) ** 0.5

    def pressure(self, T: np.ndarray, x_X: np.ndarray) -> np.ndarray:
        """p(epsilon, rho) [Pa] with epsilon = alpha T, rho = m0 / x_X."""
        return self.gruneisen * self.m0 * self.alpha * T / x_X


@njit(**OPTIONS)
def solid_rhs(layer, op, s, w, scratch, target, begin, end):
    """Time derivative of (u, sigma, T, x) at the points begin .. end-1, equation (4.19), to where ``target`` says.

    s: the memory, in which the points of each unknown stand from w on, counted from the layer's first, and
    ``layer.stride`` apart; scratch rows from ``scratch`` on. The values must reach 2 op.reach points beyond the range,
    or to lo, hi.
    """
    for i0 in range(begin, end, BLOCK):
        i1 = min(i0 + BLOCK, end)
        a, b = max(i0, layer.lo + op.rows), min(i1, layer.hi + 1 - op.rows)
        # all rows of scratch lie on one grid of vectors, so that what has just been stored is loaded as a whole
        origin = a if a < b else i0
        f = scratch + row(0) - origin
        solid_fluxes(layer, op, s, w, f, origin, i0, i1)
        solid_rates(layer, op, s, w, f, target, (i0, a, b, i1))


@njit(**OPTIONS)
def solid_flux(constants, s, at, x_X, conduction):
    """(1/x_X, sigma - p, heat flux) at the points from s[at] on; conduction: kappa_e T_X there.

    constants: p x_X / T, stride; numbers, because a record would be read anew at each point.
    """
    heated, stride = constants
    stretch = 1.0 / x_X
    p = heated * load(s, at + 2 * stride) * stretch
    return stretch, load(s, at + stride) - p, conduction * stretch


@njit(**OPTIONS)
def solid_fluxes(layer, op, s, w, f, origin, i0, i1):
    """1/x_X, sigma - p, heat flux (to the rows f and the next two) where one derivative reaches from i0 .. i1-1."""
    lo, hi, p, reach = layer.lo, layer.hi, op.p, op.reach
    net, heat = f + ROW, f + 2 * ROW
    T, x = w + 2 * layer.stride, w + 3 * layer.stride
    d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
    constants = layer.gruneisen * layer.m0 * layer.alpha, layer.stride
    strain, conduction = weights_of(op, 1.0 / layer.h), weights_of(op, layer.kappa_e / layer.h)
    first = grid_start(origin, min(origin, max(d0, lo + op.rows)))
    x0, x1, T0, T1 = load(s, x + first - WIDTH), load(s, x + first), load(s, T + first - WIDTH), load(s, T + first)
    for i in range(first, min(d1, hi + 1 - op.rows), WIDTH):
        x2, T2 = load(s, x + i + WIDTH), load(s, T + i + WIDTH)
        g1, g2, g3 = solid_flux(constants, s, w + i, interior_stencil(p, strain, x0, x1, x2), interior_stencil(p, conduction, T0, T1, T2))
        store(s, f + i, g1)
        store(s, net + i, g2)
        store(s, heat + i, g3)
        x0, x1, T0, T1 = x1, x2, T1, T2
    for side in range(2):
        end, known = end_of(lo, hi, side, layer.own_lo - layer.halo_lo, layer.own_hi + layer.halo_hi)
        for r in range(0, op.rows, WIDTH):
            i, a, b = end_rows(op, lo, hi, side, r, d0, d1)
            if a < b:
                x_X, T_X = closure(op, s, x + end, side, known, r), closure(op, s, T + end, side, known, r)
                g1, g2, g3 = solid_flux(constants, s, w + i, x_X * (1.0 / layer.h), layer.kappa_e / layer.h * T_X)
                store_lanes(s, f + i, g1, a, b)
                store_lanes(s, net + i, g2, a, b)
                store_lanes(s, heat + i, g3, a, b)


@njit(**OPTIONS)
def solid_rate(constants, s, f, acceleration, u_X, heating):
    """Rates of u, sigma, T from the slopes of sigma - p over m0, of u, of the heat flux; f: 1/x_X there, see above.

    constants: force, K, 1/(alpha m0).
    """
    force, K, per_heat = constants
    stretch, net = load(s, f), load(s, f + ROW)
    return acceleration + force, K * u_X * stretch, fma(net, u_X, heating) * per_heat


@njit(**OPTIONS)
def solid_rates(layer, op, s, w, f, target, points):
    """Send on the rates of all unknowns; points: (i0, a, b, i1), of them a .. b-1 away from the closures."""
    lo, hi, p, reach = layer.lo, layer.hi, op.p, op.reach
    i0, a, b, i1 = points
    net, heat = f + ROW, f + 2 * ROW
    constants = layer.force, layer.K, 1.0 / (layer.alpha * layer.m0)
    per_mass, per_length = 1.0 / (layer.h * layer.m0), 1.0 / layer.h
    by_mass, by_length = weights_of(op, per_mass), weights_of(op, per_length)
    n0, n1, u0, u1 = load(s, net + a - WIDTH), load(s, net + a), load(s, w + a - WIDTH), load(s, w + a)
    q0, q1 = load(s, heat + a - WIDTH), load(s, heat + a)
    whole = whole_vectors(a, b)
    for i in range(a, b, WIDTH):
        n2, u2, q2 = load(s, net + i + WIDTH), load(s, w + i + WIDTH), load(s, heat + i + WIDTH)
        rates = solid_rate(
            constants, s, f + i, interior_stencil(p, by_mass, n0, n1, n2), interior_stencil(p, by_length, u0, u1, u2), interior_stencil(p, by_length, q0, q1, q2)
        )
        if i == whole:
            for unknown in range(4):
                update_stage_lanes(s, target, unknown, i, u1 if unknown == 3 else rates[unknown], 0, b - i)
        else:
            update_stage(s, target, 0, i, rates[0])
            update_stage(s, target, 1, i, rates[1])
            update_stage(s, target, 2, i, rates[2])
            update_stage(s, target, 3, i, u1)
        n0, n1, u0, u1, q0, q1 = n1, n2, u1, u2, q1, q2
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - reach, i1 + reach)
        for r in range(0, op.rows, WIDTH):
            i, first, last = end_rows(op, lo, hi, side, r, i0, i1)
            if first < last:
                rates = solid_rate(
                    constants,
                    s,
                    f + i,
                    per_mass * closure(op, s, net + end, side, known, r),
                    per_length * closure(op, s, w + end, side, known, r),
                    per_length * closure(op, s, heat + end, side, known, r),
                )
                for unknown in range(4):
                    update_stage_lanes(s, target, unknown, i, load(s, w + i) if unknown == 3 else rates[unknown], first, last)


@njit(**OPTIONS)
def solid_fields(layer, op, s, w, scratch, out, at, stride):
    """u, sigma, T, x and p of the owned points; out, at, stride: as in ``fluid_fields``, the rest as in ``solid_rhs``."""
    heated, strain = layer.gruneisen * layer.m0 * layer.alpha, scratch + row(0)
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        if heated != 0.0:
            derivative(op, s, w + 3 * layer.stride + i0, i0, strain, i0, i0, i1, layer.lo, layer.hi, 1.0 / layer.h)
        for i in range(i0, i1):
            o, p = U64(at + (i - layer.own_lo) * stride), 0.0
            for c in range(4):
                out[o + U64(c)] = s[U64(w + c * layer.stride + i)]
            if heated != 0.0:
                p = heated * out[o + U64(2)] / s[U64(strain + i - i0)]
            out[o + U64(4)] = p


@njit(**OPTIONS)
def solid_survey(layer, s, w, at, begin, end):
    """Add the points begin .. end-1 to the survey at s[at:]: see fsipetsc.scheme.extremes_and_sums."""
    sigma, T, x, inv_h = w + layer.stride, w + 2 * layer.stride, w + 3 * layer.stride, 1.0 / layer.h
    strain, pulled, cold, hot = spread(np.inf), spread(np.inf), spread(np.inf), spread(-np.inf)
    momentum, kinetic, heat = spread(0.0), spread(0.0), spread(0.0)
    for i in range(begin, end, WIDTH):
        n, u, stress, t = end - i, load(s, w + i), load(s, sigma + i), load(s, T + i)
        momentum, kinetic, heat = momentum + masked(u, n, 0.0), kinetic + masked(u * u, n, 0.0), heat + masked(t, n, 0.0)
        # what is beyond the end has no say, and the first point of the layer has no neighbour on the left
        dx = masked((load(s, x + i) - load(s, x + i - 1)) * inv_h, n, np.inf)
        if i == layer.lo:
            dx = mirrored(masked(mirrored(dx), WIDTH - 1, np.inf))
        strain = minimum(strain, dx)
        pulled, cold = minimum(pulled, masked(stress, n, np.inf)), minimum(cold, masked(t, n, np.inf))
        hot = maximum(hot, masked(t, n, -np.inf))
    note_smallest(s, at + LEAST_STRAIN, strain)
    note_smallest(s, at + LEAST_SIGMA, pulled)
    note_smallest(s, at + LEAST_T, cold)
    note_largest(s, at + GREATEST_T, hot)
    note_sum(s, at + SUMS, momentum)
    note_sum(s, at + SUMS + 1, kinetic)
    note_sum(s, at + SUMS + 2, heat)


@njit(**OPTIONS)
def solid_bounds(layer, s, at):
    """(largest squared wave speed, largest 1/x_X, smallest x_X, smallest T) from a survey.

    Not numbers where the state is none; speeds are in Lagrangian coordinates, x_X is the difference between neighbours.
    The state is unphysical where x_X > 0 and T > 0 do not hold.
    """
    shortest, coldest = s[U64(at + LEAST_STRAIN)], s[U64(at + LEAST_T)]
    hottest, pulled, stretch = s[U64(at + GREATEST_T)], s[U64(at + LEAST_SIGMA)], 1.0 / shortest
    p = layer.gruneisen * layer.m0 * layer.alpha * hottest * stretch
    # a velocity or stress that is not a number shows in the speed
    c2 = wave_modulus(layer.K, layer.gruneisen, p, min(pulled, p), shortest) / layer.m0
    c2 += 0.0 * (s[U64(at + SUMS)] + pulled)
    return c2, stretch, shortest, coldest
