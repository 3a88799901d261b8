"""What passes faces of blocks that are open, loaded or heated: added to the rates of the nodes
there, and, times the weights of these, to ``gain``: mass, momentum, energy. Compiled.

The volume terms let nothing pass a face. With the outward area vector n of a face per unit of its
reference coordinates, and the velocity v of the grid, a node at it gets -f / weight, weight that of
its axis, where f is

    open       F(U*), F(U) = n . (f(U) - v U), by characteristics: U* = U_in where gas leaves faster
               than sound, U_out where it comes so; else p + Z N . u is that inside, p - Z N . u
               that outside, with Z = rho c of the gas inside at the mean pressure of both (so a
               simple wave leaves but for its third order), and rho - p/c^2 and velocities
               along the face those of the side that the gas comes from; c^2 of that side
               If no such gas can be, 1/2 (F(U_in) + F(U_out)) - 1/2 lambda (U_out - U_in),
               lambda = max over both of |n . (u - v)| + c |n| (local Lax-Friedrichs)
    outflow    F(U_in); with a pressure p_b beyond and a Mach number m < 1 through the face that of
               Lax and Friedrichs, with U_out of density and velocity of U_in and of pressure p + (1 - m^2)(p_b - p);
               m = 0 where gas flows in
    free       p_b n(x) on a solid, n(x) the area vector of the face where it is now: a pressure
               that follows it
    absorbing  (Z N . v - stress) N |A| on a solid, N the unit normal and |A| the area at rest

All are equal to n . f for a uniform state, so that uniform flow stays uniform.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import CALL, INNER_CALL, column
from fsipetsc.scheme.rows import U64

Array = NDArray[Any]


class Face(NamedTuple):
    """Nodes of a face of a block on a rank.

    ghosted, owned: (n,) numbers of its nodes in the ghosted array and among the owned ones. axis,
    sign: of its outward normal. per_weight: 1 / weight of the axis at the face. across: (n,)
    product of the weights of the other axes.
    """

    ghosted: Array
    owned: Array
    axis: int
    sign: float
    per_weight: float
    across: Array


@njit(**INNER_CALL)
def _energy_density(law, rho, u, T):
    square = 0.0
    for c in range(u.size):
        square += u[c] * u[c]
    return rho * (law.internal_energy(rho, T) + 0.5 * square)


@njit(**INNER_CALL)
def _flux(law, rho, u, T, n, g, out):
    """out = n . (f - v U) of (rho, rho u, E); returns |n . u - g| + c |n|."""
    d = u.size
    through, area = 0.0, 0.0
    for c in range(d):
        through += n[c] * u[c]
        area += n[c] * n[c]
    p = law.pressure(rho, T)
    out[0] = rho * (through - g)
    for c in range(d):
        out[1 + c] = rho * u[c] * (through - g) + n[c] * p
    out[d + 1] = _energy_density(law, rho, u, T) * (through - g) + p * through
    return abs(through - g) + np.sqrt(law.sound_speed_squared(rho, T) * area)


@njit(**CALL)
def inside(law, q, u):
    """(rho, T) of a node, u is filled; q: (J, J rho, J rho u, J E)."""
    d = u.size
    rho, square = q[1] / q[0], 0.0
    for c in range(d):
        u[c] = q[2 + c] / q[1]
        square += u[c] * u[c]
    return rho, law.temperature(rho, q[2 + d] / q[1] - 0.5 * square)


@njit(**CALL)
def open_face(law, face, q, metrics, outside, pressure, rates, gain):
    """Add what passes an open face to ``rates`` (owned, d + 3).

    q: (ghosted, d + 3); metrics: (d d + d + 1, ghosted). outside: (n, d + 2), (rho, u, T) beyond.
    pressure: (n,) that beyond an outflow, 0 for one that is supersonic; below 0: the face is open,
    not an outflow.
    """
    d = q.shape[1] - 3
    n, u, u_out = np.zeros(d), np.zeros(d), np.zeros(d)
    f, f_out = np.zeros(d + 2), np.zeros(d + 2)
    for i in range(face.ghosted.size):
        at = face.ghosted[i]
        g, area = 0.0, 0.0
        for c in range(d):
            n[c] = face.sign * metrics[face.axis * d + c, at]
            g += n[c] * metrics[d * d + c, at]
            area += n[c] * n[c]
        rho, T = inside(law, q[at], u)
        fastest = _flux(law, rho, u, T, n, g, f)
        if pressure[i] != 0.0:
            rho_out, T_out = outside[i, 0], outside[i, d + 1]
            for c in range(d):
                u_out[c] = outside[i, 1 + c]
            if pressure[i] > 0.0:
                through = -g
                for c in range(d):
                    through += n[c] * u[c]
                    u_out[c] = u[c]
                m = max(through, 0.0) / np.sqrt(area * law.sound_speed_squared(rho, T))
                p = law.pressure(rho, T)
                beyond = p + max(1.0 - m * m, 0.0) * (pressure[i] - p)
                rho_out, T_out = rho, law.temperature_of(rho, beyond)
            arguments = rho, u, T, rho_out, u_out, T_out, n, g, area, f
            if pressure[i] < 0.0 and _by_characteristics(law, *arguments):
                _pass(face, i, f, rates, gain)
                continue
            fastest = max(fastest, _flux(law, rho_out, u_out, T_out, n, g, f_out))
            f[:] = 0.5 * (f + f_out)
            f[0] -= 0.5 * fastest * (rho_out - rho)
            for c in range(d):
                f[1 + c] -= 0.5 * fastest * (rho_out * u_out[c] - rho * u[c])
            jump = _energy_density(law, rho_out, u_out, T_out) - _energy_density(law, rho, u, T)
            f[d + 1] -= 0.5 * fastest * jump
        _pass(face, i, f, rates, gain)


@njit(**INNER_CALL)
def _pass(face, i, f, rates, gain):
    """Let f leave at a node of a face."""
    for c in range(f.size):
        rates[face.owned[i], 1 + c] -= face.per_weight * f[c]
        gain[c] -= face.across[i] * f[c]


@njit(**INNER_CALL)
def _by_characteristics(law, rho, u, T, rho_out, u_out, T_out, n, g, area, out):
    """out = F(U*); False if there is no such gas. area: |n|^2."""
    size = np.sqrt(area)
    c2, c2_out = law.sound_speed_squared(rho, T), law.sound_speed_squared(rho_out, T_out)
    a, a_out = -g / size, -g / size
    for c in range(u.size):
        a += n[c] * u[c] / size
        a_out += n[c] * u_out[c] / size
    p, p_out = law.pressure(rho, T), law.pressure(rho_out, T_out)
    rho_mean = rho + 0.5 * (p_out - p) / c2
    T_mean = law.temperature_of(rho_mean, 0.5 * (p + p_out)) if rho_mean > 0.0 else 0.0
    if not T_mean > 0.0:
        return False
    Z = rho_mean * np.sqrt(law.sound_speed_squared(rho_mean, T_mean))
    speed = 0.5 * (a + a_out) + 0.5 * (p - p_out) / Z
    between = 0.5 * (p + p_out) + 0.5 * Z * (a - a_out)
    rho_face, leaves = rho + (between - p) / c2, speed >= 0.0
    if not leaves:
        rho_face = rho_out + (between - p_out) / c2_out
    if a >= np.sqrt(c2):
        leaves, speed, rho_face, between = True, a, rho, p
    elif a_out <= -np.sqrt(c2_out):
        leaves, speed, rho_face, between = False, a_out, rho_out, p_out
    if not rho_face > 0.0:
        return False
    T_face, known = law.temperature_of(rho_face, between), a if leaves else a_out
    if not T_face > 0.0:
        return False
    u_face = np.empty(u.size)
    for c in range(u.size):
        u_face[c] = (u[c] if leaves else u_out[c]) + n[c] / size * (speed - known)
    _flux(law, rho_face, u_face, T_face, n, g, out)
    return True


def area_vectors(face: Face, tangents: list[Array]) -> Array:
    """(n, d) outward area vectors of a solid's face where it is now, from D_k x (n, d) along the
    axes of the face, in one or two dimensions.
    """
    if not tangents:
        return np.full((face.ghosted.size, 1), face.sign)
    (tx, ty), sign = tangents[0].T, face.sign if face.axis == 0 else -face.sign
    return np.stack([sign * ty, -sign * tx], axis=-1)


@njit(**CALL)
def tangent(nodes, S, weight, stride, size, X, q):
    """(n, d) derivative of the place x = X + D along an axis, at nodes of the ghosted array.

    size: nodes of the ghosted array along the axis, stride apart. X: (d, ghosted), q: (ghosted, …),
    whose first numbers are the displacement.
    """
    d = X.shape[0]
    out = np.zeros((nodes.size, d))
    for i in range(nodes.size):
        at = nodes[i]
        place = at // stride % size
        for k in range(1, S.shape[0]):
            for c in range(d):
                if place + k < size and S[k, place] != 0.0:
                    to = at + k * stride
                    out[i, c] += S[k, place] * (X[c, to] + q[to, c] - X[c, at] - q[at, c])
                if place - k >= 0 and S[k, place - k] != 0.0:
                    to = at - k * stride
                    out[i, c] -= S[k, place - k] * (X[c, to] + q[to, c] - X[c, at] - q[at, c])
        for c in range(d):
            out[i, c] *= 0.5 / weight[place]
    return out


@njit(**CALL)
def push_face(face, forces, q, inertia, rates, gain):
    """Add forces (n, d) on a solid's face, over ``across``, to ``rates`` (owned, 2d + 1) of
    velocity and energy.

    q: (ghosted, 2d + 1). inertia: (ghosted,), J0 m0.
    """
    d = forces.shape[1]
    for i in range(face.ghosted.size):
        at, power = face.ghosted[i], 0.0
        scale = face.per_weight / inertia[at]
        for c in range(d):
            rates[face.owned[i], d + c] += scale * forces[i, c]
            gain[1 + c] += face.across[i] * forces[i, c]
            power += forces[i, c] * q[at, d + c]
        rates[face.owned[i], 2 * d] += scale * power
        gain[1 + d] += face.across[i] * power


@njit(**CALL)
def absorb(solid, like, face, F, stress, q, metrics, forces):
    """Add (stress - Z N . v) N |A| to forces (n, d); F: (d d, n), Z = sqrt(m0 wave modulus)."""
    d = len(like)
    for i in range(face.ghosted.size):
        at = face.ghosted[i]
        here = column((*like, *like, 0.0), q.T, U64(at))
        here_F = column(outer(like, like), F, U64(i))
        T = solid.temperature(here[d:-1], here[-1], here_F)
        impedance = np.sqrt(solid.m0 * solid.wave_modulus_at(here_F, T))
        area, through = 0.0, 0.0
        for c in range(d):
            A = face.sign * metrics[face.axis * d + c, at]
            area += A * A
            through += A * here[d + c]
        push = stress[i] - impedance * through / np.sqrt(area)
        for c in range(d):
            forces[i, c] += push * face.sign * metrics[face.axis * d + c, at]


@njit(**CALL)
def heat_face(face, heat, inertia, rates, column, gain):
    """Add heat (n,) [W] that comes into a gas (inertia 1) or a solid, over ``across``, to column
    ``column`` of ``rates``.
    """
    for i in range(face.ghosted.size):
        scale = face.per_weight / inertia[face.ghosted[i]]
        rates[face.owned[i], column] += scale * heat[i]
        gain[gain.size - 1] += face.across[i] * heat[i]
