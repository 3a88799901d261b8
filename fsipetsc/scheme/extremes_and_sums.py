"""Extremes of a layer that bound the time step and sums for its integrals, from one look at each point. Compiled.

Words, gathered from as many parts of a layer as one likes. Extremes are exact and let through what is not a
number; the last bits of sums depend on the parts.

    fluid   SPEED largest |u-w| + c; LEAST_RHO, LEAST_T, GREATEST_T;      SUMS of J rho, J rho u, J e
    solid   LEAST_STRAIN x_X, LEAST_SIGMA, LEAST_T, GREATEST_T;           SUMS of u, u^2, T
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.lanes import lane, masked, mirrored
from fsipetsc.operators.memory import load
from fsipetsc.operators.vectors import LANES, fma, magnitude, maximum, minimum, numbers_from, root, spread
from fsipetsc.physics.layer import FLUID

SPEED, LEAST_RHO, LEAST_T = 0, 1, 2
LEAST_STRAIN, LEAST_SIGMA, GREATEST_T = 0, 1, 3
SUMS = 4
#: number of words
SIZE = 8


@njit(**OPTIONS)
def begin_extremes_and_sums(layer, s, at):
    """Nothing has been seen yet."""
    for k in range(SUMS):
        s[U64(at + k)] = np.inf
    s[U64(at + GREATEST_T)] = -np.inf
    if layer.kind == FLUID:
        s[U64(at + SPEED)] = -np.inf
    for k in range(SUMS, SIZE):
        s[U64(at + k)] = 0.0


@njit(**OPTIONS)
def note_largest(s, at, v):
    """The lanes of v count for the maximum at s[at]."""
    v = maximum(maximum(lane(v, 0), lane(v, 1)), maximum(lane(v, 2), lane(v, 3)))
    s[U64(at)] = maximum(s[U64(at)], v)


@njit(**OPTIONS)
def note_smallest(s, at, v):
    """The lanes of v count for the minimum at s[at]."""
    v = minimum(minimum(lane(v, 0), lane(v, 1)), minimum(lane(v, 2), lane(v, 3)))
    s[U64(at)] = minimum(s[U64(at)], v)


@njit(**OPTIONS)
def note_sum(s, at, v):
    """The lanes of v count for the sum at s[at]."""
    s[U64(at)] += (lane(v, 0) + lane(v, 1)) + (lane(v, 2) + lane(v, 3))


@njit(**OPTIONS)
def fluid_extremes_and_sums(law, layer, s, w, at, begin, end):
    """Add the active points begin .. end-1 to the words at s[at:]."""
    begin, end, per_J = max(begin, layer.lo), min(end, layer.hi + 1), 1.0 / layer.J
    q, e, gas = w + layer.stride, w + 2 * layer.stride, law.gas.constants(layer)
    speed, light, cold, hot = spread(-np.inf), spread(np.inf), spread(np.inf), spread(-np.inf)
    mass, momentum, energy = spread(0.0), spread(0.0), spread(0.0)
    for i in range(begin, end, LANES):
        n, number, rho, m, E = end - i, numbers_from(i), load(s, w + i), load(s, q + i), load(s, e + i)
        mass, momentum, energy = mass + masked(rho, n, 0.0), momentum + masked(m, n, 0.0), energy + masked(E, n, 0.0)
        if n < LANES:  # what is beyond the end has no say: the first of these points stands for it
            rho, m, E = masked(rho, n, lane(rho, 0)), masked(m, n, lane(m, 0)), masked(E, n, lane(E, 0))
            number = masked(number, n, lane(number, 0))
        r = 1.0 / rho
        v = m * r
        internal = E * r - 0.5 * v * v
        rho = rho * per_J
        relative = v - fma(layer.spread, number, layer.s)
        speed = maximum(speed, magnitude(relative) + root(law.gas.sound_speed_squared_of_energy(gas, rho, internal)))
        T = law.gas.temperature_in_loops(gas, rho, internal)
        light, cold, hot = minimum(light, rho), minimum(cold, T), maximum(hot, T)
    note_largest(s, at + SPEED, speed)
    note_smallest(s, at + LEAST_RHO, light)
    note_smallest(s, at + LEAST_T, cold)
    note_largest(s, at + GREATEST_T, hot)
    note_sum(s, at + SUMS, mass)
    note_sum(s, at + SUMS + 1, momentum)
    note_sum(s, at + SUMS + 2, energy)


@njit(**OPTIONS)
def solid_extremes_and_sums(law, layer, s, w, at, begin, end):
    """Add the points begin .. end-1 to the words at s[at:]."""
    sigma, T, x, inv_h = w + layer.stride, w + 2 * layer.stride, w + 3 * layer.stride, 1.0 / layer.h
    strain, pulled, cold, hot = spread(np.inf), spread(np.inf), spread(np.inf), spread(-np.inf)
    momentum, kinetic, heat = spread(0.0), spread(0.0), spread(0.0)
    for i in range(begin, end, LANES):
        n, u, stress, t = end - i, load(s, w + i), load(s, sigma + i), load(s, T + i)
        momentum, kinetic, heat = momentum + masked(u, n, 0.0), kinetic + masked(u * u, n, 0.0), heat + masked(t, n, 0.0)
        # what is beyond the end has no say, and the first point of the layer has no neighbour on the left
        dx = masked((load(s, x + i) - load(s, x + i - 1)) * inv_h, n, np.inf)
        if i == layer.lo:
            dx = mirrored(masked(mirrored(dx), LANES - 1, np.inf))
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
