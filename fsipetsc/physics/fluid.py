"""Compressible Navier–Stokes equations in the rigid frame that moves with the interface, (3.2) and (4.20).

    rho_t     + (rho (u-s))_X                                        = 0
    (rho u)_t + (rho u (u-s) + p - mu' u_X)_X                        = 0,      mu' = 4/3 mu
    e_t       + (e (u-s) + u (p - mu' u_X) - kappa T_X)_X            = 0

with p = (gamma-1)(e - rho u^2/2) = rho R T (R stands for R/M) and s(t) the velocity of the fluid's own interface
point. The viscous and heat fluxes stand inside the outer derivative, so that D is applied twice to u and T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsipetsc.checks import NONNEGATIVE, POSITIVE, numbers
from fsipetsc.operators.kernels import (
    BLOCK,
    OPTIONS,
    ROW,
    U64,
    closure,
    end_of,
    end_rows,
    grid_start,
    interior_stencil,
    row,
    store_lanes,
    weights_of,
    whole_vectors,
)
from fsipetsc.operators.vectors import WIDTH, fma, lane, load, magnitude, masked, maximum, minimum, root, spread, store
from fsipetsc.scheme.extremes_and_sums import LEAST_RHO, LEAST_T, SPEED, SUMS, note_largest, note_smallest, note_sum
from fsipetsc.scheme.stage_update import update_stage, update_stage_lanes


@dataclass(frozen=True)
class Fluid:
    """A perfect gas.

    mu: shear viscosity [Pa s]; kappa: heat conductivity [W/(m K)]; gamma: ratio of the specific heats, above 1;
    R: gas constant over molar mass [J/(kg K)]. InputError for what is no number or out of range.
    """

    mu: float
    kappa: float
    gamma: float
    R: float

    def __post_init__(self) -> None:
        numbers(self, "Fluid", {"mu": NONNEGATIVE, "kappa": NONNEGATIVE, "gamma": "above 1", "R": POSITIVE})

    @property
    def cv(self) -> float:
        """Specific heat at constant volume [J/(kg K)]."""
        return self.R / (self.gamma - 1)

    def sound_speed(self, T: float | np.ndarray) -> float | np.ndarray:
        """Speed of sound [m/s] at temperature T [K]."""
        return np.sqrt(self.gamma * self.R * T)

    def conserved(self, rho: np.ndarray, u: np.ndarray, T: np.ndarray) -> np.ndarray:
        """(rho, rho u, e) of shape (..., 3) from density, velocity and temperature."""
        return np.stack([rho, rho * u, rho * (self.cv * T + 0.5 * u * u)], axis=-1)

    def primitive(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """rho, u, T, p from the conserved variables q of shape (..., 3)."""
        rho = q[..., 0]
        u = q[..., 1] / rho
        T = (q[..., 2] / rho - 0.5 * u * u) / self.cv
        return rho, u, T, self.R * rho * T


@njit(**OPTIONS)
def fluid_rhs(layer, op, s, w, scratch, target, begin, end):
    """Time derivative of (rho, rho u, e) at the active points begin .. end-1, equation (4.20), to where ``target`` says.

    s: the memory, in which the points of each unknown stand from w on, counted from the layer's first, and
    ``layer.stride`` apart; scratch rows from ``scratch`` on. The values must reach 2 op.reach points beyond the range,
    or to lo, hi. Other points do not change.
    """
    lo, hi, rows = layer.lo, layer.hi, op.rows
    for i0 in range(max(begin, lo), min(end, hi + 1), BLOCK):
        i1 = min(i0 + BLOCK, min(end, hi + 1))
        a, b = max(i0, lo + rows), min(i1, hi + 1 - rows)
        # all rows of scratch lie on one grid of vectors, so that what has just been stored is loaded as a whole
        origin = a if a < b else i0
        u, f = scratch + row(0) - origin, scratch + row(2) - origin
        fluid_primitives(layer, op, s, w, u, origin, i0, i1)
        fluid_fluxes(layer, op, s, w, u, f, origin, i0, i1)
        for unknown in range(3):
            fluid_rates(layer, op, s, f + unknown * ROW, target, unknown, (i0, a, b, i1))


@njit(**OPTIONS)
def fluid_primitives(layer, op, s, w, u, origin, i0, i1):
    """Velocity (to the row u) and temperature (to the next) where the double derivative reaches from i0 .. i1-1.

    At a ghost point they are those of the gradients, which a boundary may want to be others.
    """
    T = u + ROW
    first = grid_start(origin, max(layer.lo, i0 - 2 * op.reach))
    for i in range(first, min(layer.hi + 1, i1 + 2 * op.reach), WIDTH):
        v, warmth = velocity_and_temperature(layer, s, w + i)
        store(s, u + i, v)
        store(s, T + i, warmth)
    for side in range(2):
        ghost = layer.lo if side == 0 else layer.hi
        if layer.end_apart[side] != 0 and first <= ghost < i1 + 2 * op.reach:
            s[U64(u + ghost)], s[U64(T + ghost)] = layer.end_gradient[side]


@njit(**OPTIONS)
def velocity_and_temperature(layer, s, at):
    """Velocity and temperature at the points from s[at] on."""
    r = 1.0 / load(s, at)
    v = load(s, at + layer.stride) * r
    return v, (load(s, at + 2 * layer.stride) * r - 0.5 * v * v) * (1.0 / layer.cv)


@njit(**OPTIONS)
def fluid_flux(constants, s, at, u, T, friction, conduction):
    """The three fluxes at the points from s[at] on; friction: mu' u_X, conduction: kappa T_X there.

    constants: gas constant, velocity of the frame, stride; numbers, because a record would be read anew at each point.
    """
    R, velocity, stride = constants
    rho, v = load(s, at), u - velocity
    tau = R * rho * T - friction  # pressure less viscous stress
    return rho * v, fma(load(s, at + stride), v, tau), fma(load(s, at + 2 * stride), v, fma(u, tau, -1.0 * conduction))


@njit(**OPTIONS)
def fluid_fluxes(layer, op, s, w, u, f, origin, i0, i1):
    """Fluxes (to the rows f and the next two) where one derivative reaches from i0 .. i1-1."""
    lo, hi, p, reach = layer.lo, layer.hi, op.p, op.reach
    T, f2, f3 = u + ROW, f + ROW, f + 2 * ROW
    d0, d1 = max(lo, i0 - reach), min(hi + 1, i1 + reach)
    friction, conduction = weights_of(op, layer.mu / layer.h), weights_of(op, layer.kappa / layer.h)
    constants = (layer.gamma - 1.0) * layer.cv, layer.s, layer.stride
    first = grid_start(origin, min(origin, max(d0, lo + op.rows)))
    u0, u1, T0, T1 = load(s, u + first - WIDTH), load(s, u + first), load(s, T + first - WIDTH), load(s, T + first)
    for i in range(first, min(d1, hi + 1 - op.rows), WIDTH):
        u2, T2 = load(s, u + i + WIDTH), load(s, T + i + WIDTH)
        g1, g2, g3 = fluid_flux(
            constants, s, w + i, u1, T1, interior_stencil(p, friction, u0, u1, u2), interior_stencil(p, conduction, T0, T1, T2)
        )
        store(s, f + i, g1)
        store(s, f2 + i, g2)
        store(s, f3 + i, g3)
        u0, u1, T0, T1 = u1, u2, T1, T2
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - 2 * reach, i1 + 2 * reach)
        for r in range(0, op.rows, WIDTH):
            i, first, last = end_rows(op, lo, hi, side, r, d0, d1)
            if first < last:
                u_X, T_X = closure(op, s, u + end, side, known, r), closure(op, s, T + end, side, known, r)
                # not from the rows: at a ghost point they may hold something else
                v, warmth = velocity_and_temperature(layer, s, w + i)
                friction, conduction = layer.mu / layer.h * u_X, layer.kappa / layer.h * T_X
                g1, g2, g3 = fluid_flux(constants, s, w + i, v, warmth, friction, conduction)
                store_lanes(s, f + i, g1, first, last)
                store_lanes(s, f2 + i, g2, first, last)
                store_lanes(s, f3 + i, g3, first, last)


@njit(**OPTIONS)
def fluid_rates(layer, op, s, f, target, unknown, points):
    """Send on -f_X of one unknown; points: (i0, a, b, i1), of them a .. b-1 away from the closures."""
    lo, hi, scale = layer.lo, layer.hi, -1.0 / layer.h
    i0, a, b, i1 = points
    weights, f0, f1 = weights_of(op, scale), load(s, f + a - WIDTH), load(s, f + a)
    p, whole = op.p, whole_vectors(a, b)
    for i in range(a, whole, WIDTH):
        f2 = load(s, f + i + WIDTH)
        update_stage(s, target, unknown, i, interior_stencil(p, weights, f0, f1, f2))
        f0, f1 = f1, f2
    if whole < b:
        k = interior_stencil(p, weights, f0, f1, load(s, f + whole + WIDTH))
        update_stage_lanes(s, target, unknown, whole, k, 0, b - whole)
    for side in range(2):
        end, known = end_of(lo, hi, side, i0 - op.reach, i1 + op.reach)
        for r in range(0, op.rows, WIDTH):
            i, first, last = end_rows(op, lo, hi, side, r, i0, i1)
            if first < last:
                update_stage_lanes(s, target, unknown, i, scale * closure(op, s, f + end, side, known, r), first, last)


@njit(**OPTIONS)
def fluid_fields(layer, s, w, interface, out, at, stride):
    """rho, u, T, p and the Eulerian position x of the owned points; NaN where inactive.

    s, w: as in ``fluid_rhs``; interface: the interface point. What belongs to the first owned point goes to
    out[at:], to the next one to out[at + stride:], ...
    """
    for i in range(layer.own_lo, layer.own_hi):
        inside = layer.lo <= i <= layer.hi
        rho = s[U64(w + i)] if inside else np.nan
        u = s[U64(w + layer.stride + i)] / rho
        T = (s[U64(w + 2 * layer.stride + i)] / rho - 0.5 * u * u) / layer.cv
        x = (i - interface) * layer.h + layer.x_interface if inside else np.nan
        o = U64(at + (i - layer.own_lo) * stride)
        out[o], out[o + U64(1)], out[o + U64(2)], out[o + U64(3)], out[o + U64(4)] = rho, u, T, layer.R * rho * T, x


@njit(**OPTIONS)
def fluid_survey(layer, s, w, at, begin, end):
    """Add the active points begin .. end-1 to the survey at s[at:]: see fsipetsc.scheme.extremes_and_sums."""
    begin, end, velocity = max(begin, layer.lo), min(end, layer.hi + 1), layer.s
    q, e, cc = w + layer.stride, w + 2 * layer.stride, layer.gamma * (layer.gamma - 1.0)
    speed, light, cold = spread(-np.inf), spread(np.inf), spread(np.inf)
    mass, momentum, energy = spread(0.0), spread(0.0), spread(0.0)
    for i in range(begin, end, WIDTH):
        n, rho, m, E = end - i, load(s, w + i), load(s, q + i), load(s, e + i)
        mass, momentum, energy = mass + masked(rho, n, 0.0), momentum + masked(m, n, 0.0), energy + masked(E, n, 0.0)
        if n < WIDTH:
            rho, m, E = masked(rho, n, lane(rho, 0)), masked(m, n, lane(m, 0)), masked(E, n, lane(E, 0))
        r = 1.0 / rho
        v = m * r
        c2 = cc * (E * r - 0.5 * v * v)
        speed = maximum(speed, magnitude(v - velocity) + root(c2))
        light, cold = minimum(light, rho), minimum(cold, c2)
    note_largest(s, at + SPEED, speed)
    note_smallest(s, at + LEAST_RHO, light)
    note_smallest(s, at + LEAST_T, cold * (1.0 / (cc * layer.cv)))
    note_sum(s, at + SUMS, mass)
    note_sum(s, at + SUMS + 1, momentum)
    note_sum(s, at + SUMS + 2, energy)
