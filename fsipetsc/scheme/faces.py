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
               To first order in viscosity and conduction `first_order` says what p - Z N . u
               outside is besides, and viscous stress and heat pass
    outflow    F(U_in); with a pressure p_b beyond and a Mach number m < 1 through the face that of
               Lax and Friedrichs, with U_out of density and velocity of U_in and of pressure
               p + (1 - m^2)(p_b - p); m = 0 where gas flows in
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

from fsipetsc.operators.loops import CALL, INNER_CALL, column
from fsipetsc.scheme.rows import U64

Array = NDArray[Any]
#: first order of an open face fades out where viscosity is this fraction of c L, and q_nn = 0 where
#: alpha is this fraction of a L, L the length of the gas
LONGEST = 0.25


class GasFaces(NamedTuple):
    """Nodes of faces of a part of a gas block through which something passes; a node at an edge
    stands there once for each of its faces.

    at, own: (n,) numbers of the nodes in the ghosted array and among the owned ones. axis, sign: of
    the outward normal. per_weight: 1 / weight of the axis at the face, across: product of those of
    the other axes. opens: 1 where gas may pass; outside: (n, d + 2), (rho, u, T) beyond; pressure:
    (n,) that beyond an outflow, 0 for one that is supersonic, below 0 where the face is open and no
    outflow. heat: (n,) what comes in per area [W/m2]. width: (n,) length [m] of the gas behind an
    open face of first order, else 0.
    """

    at: Array
    own: Array
    axis: Array
    sign: Array
    per_weight: Array
    across: Array
    opens: Array
    outside: Array
    pressure: Array
    heat: Array
    width: Array

    def add(self, part, q, rates, gain):
        """Add all that passes, see ``pass_faces``."""
        of_axes = part.S, part.weight, part.patch
        pass_faces(part.laws, self, *of_axes, q, part.metrics, rates, gain)


class SolidFaces(NamedTuple):
    """The same of a solid block.

    traction: (n, d) per area at rest, pressure: (n,) that follows the face. absorbs: 1 where waves
    leave, stress: (n,) pulls there. normal: (n, d) area vectors of the face as it is, in three
    dimensions. X: (d, ghosted) places in the reference map.
    """

    at: Array
    own: Array
    axis: Array
    sign: Array
    per_weight: Array
    across: Array
    absorbs: Array
    traction: Array
    pressure: Array
    stress: Array
    heat: Array
    normal: Array
    X: Array

    def add(self, part, q, rates, gain):
        """Add all that loads a solid, see ``load_faces``."""
        laws, of_axes = part.laws, (part.S, part.weight, part.patch)
        load_faces(laws, part.like, self, *of_axes, q, part.metrics, part.inertia, rates, gain)


class Closed(NamedTuple):
    """Faces through which nothing passes."""

    kind: int = 0

    def add(self, part, q, rates, gain):
        """Nothing."""
        return None


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


@njit(**INNER_CALL)
def inside(law, q, u):
    """(rho, T) of a node, u is filled; q: (J, J rho, J rho u, J E)."""
    d = u.size
    rho, square = q[1] / q[0], 0.0
    for c in range(d):
        u[c] = q[2 + c] / q[1]
        square += u[c] * u[c]
    return rho, law.temperature(rho, q[2 + d] / q[1] - 0.5 * square)


@njit(**CALL)
def pass_faces(gas, faces, S, weight, patch, q, metrics, rates, gain):
    """Add what passes the faces of a gas to ``rates`` (owned, d + 3) and ``gain`` (d + 2,).

    q: (ghosted, d + 3); metrics: (d d + d + 1, ghosted). S, weight: of the three axes.
    """
    d, law = q.shape[1] - 3, gas.law
    n, u, u_out, slopes = np.zeros(d), np.zeros(d), np.zeros(d), np.zeros(3)
    f, f_out = np.zeros(d + 2), np.zeros(d + 2)
    for i in range(faces.at.size):
        at = faces.at[i]
        g, area = 0.0, 0.0
        for c in range(d):
            n[c] = faces.sign[i] * metrics[faces.axis[i] * d + c, at]
            g += n[c] * metrics[d * d + c, at]
            area += n[c] * n[c]
        if faces.opens[i] == 1:
            rho, T = inside(law, q[at], u)
            if faces.width[i] > 0.0:
                slopes_outward(law, faces, i, S, weight, patch, q, n, np.sqrt(area), slopes)
            open_node(gas, faces, i, rho, T, u, n, g, area, slopes, u_out, f, f_out)
            for c in range(d + 2):
                rates[faces.own[i], 1 + c] -= faces.per_weight[i] * f[c]
                gain[c] -= faces.across[i] * f[c]
        heat = faces.heat[i] * np.sqrt(area)
        rates[faces.own[i], d + 2] += faces.per_weight[i] * heat
        gain[d + 1] += faces.across[i] * heat


@njit(**INNER_CALL)
def open_node(gas, faces, i, rho, T, u, n, g, area, slopes, u_out, f, f_out):
    """f of an open face or an outflow; area: |n|^2, slopes: see `slopes_outward`."""
    law, d, pressure, viscous = gas.law, u.size, faces.pressure[i], (0.0, 0.0, 0.0)
    fastest = _flux(law, rho, u, T, n, g, f)
    if pressure == 0.0:
        return
    rho_out, T_out = faces.outside[i, 0], faces.outside[i, d + 1]
    for c in range(d):
        u_out[c] = faces.outside[i, 1 + c]
    if pressure > 0.0:
        through = -g
        for c in range(d):
            through += n[c] * u[c]
            u_out[c] = u[c]
        m = max(through, 0.0) / np.sqrt(area * law.sound_speed_squared(rho, T))
        p = law.pressure(rho, T)
        beyond = p + max(1.0 - m * m, 0.0) * (pressure - p)
        rho_out, T_out = rho, law.temperature_of(rho, beyond)
    else:
        if faces.width[i] > 0.0:
            a = -g / np.sqrt(area)
            for c in range(d):
                a += n[c] * u[c] / np.sqrt(area)
            viscous = first_order(gas, rho, T, a, rho_out, T_out, faces.width[i], slopes)
        if _by_characteristics(law, rho, u, T, rho_out, u_out, T_out, n, g, area, viscous, f):
            return
    fastest = max(fastest, _flux(law, rho_out, u_out, T_out, n, g, f_out))
    for c in range(d + 2):
        f[c] = 0.5 * (f[c] + f_out[c])
    f[0] -= 0.5 * fastest * (rho_out - rho)
    for c in range(d):
        f[1 + c] -= 0.5 * fastest * (rho_out * u_out[c] - rho * u[c])
    jump = _energy_density(law, rho_out, u_out, T_out) - _energy_density(law, rho, u, T)
    f[d + 1] -= 0.5 * fastest * jump


@njit(**INNER_CALL)
def slopes_outward(law, faces, i, S, weight, patch, q, n, size, out):
    """out = outward derivatives of N . u, p and T at a node of a face, along its axis."""
    axis, at, (nx, ny, nz) = faces.axis[i], faces.at[i], patch.ghosted
    stride, nodes = (1, nx) if axis == 0 else (nx, ny) if axis == 1 else (nx * ny, nz)
    place, band, u = at // stride % nodes, S[axis], np.zeros(n.size)
    for k in range(3):
        out[k] = 0.0
    for k in range(1, band.shape[0]):
        for sign in (1, -1):
            to, first = at + sign * k * stride, place if sign > 0 else place - k
            if first >= 0 and first + k < nodes and band[k, first] != 0.0:
                part = sign * 0.5 * band[k, first] / weight[axis][place]
                for node, share in ((to, part), (at, -part)):
                    rho, T = inside(law, q[node], u)
                    for c in range(n.size):
                        out[0] += share * n[c] * u[c] / size
                    out[1] += share * law.pressure(rho, T)
                    out[2] += share * T
    for k in range(3):
        out[k] *= faces.sign[i] * size / q[at, 0]


@njit(**INNER_CALL)
def first_order(gas, rho, T, a, rho0, T0, width, slopes):
    """What comes in with sound, viscous stress, and heat that comes in, of a node of an open face.

    To first order in viscosity and conduction, as docs/open-end.md derives it for small
    disturbances of the gas beyond, rho0, T0. a: velocity through the face; slopes: outward.
    """
    law, v_n, p_n = gas.law, slopes[0], slopes[1]
    c2, cv = law.sound_speed_squared(rho0, T0), law.heat_capacity(rho0, T0)
    c, by_heat = np.sqrt(c2), law.pressure_by_temperature(rho0, T0) / cv
    tau = T0 * by_heat / (rho0 * rho0 * c2)
    mu = 4.0 / 3.0 * gas.mu * gas.transport.viscosity(T0)
    kappa = gas.kappa * gas.transport.conductivity(T0)
    part = max(0.0, 1.0 - max(mu, kappa / cv) / (rho0 * LONGEST * c * width))
    sound, heat = 0.5 * (mu - tau * by_heat * kappa) * v_n, 0.0
    if kappa > 0.0:
        capacity = cv * rho0 * rho0 * c2 / law.bulk_modulus(rho0, T0)
        alpha, carrying = kappa / capacity, max(a, 0.0) * LONGEST * width
        q_n = carrying / (carrying + alpha) * (slopes[2] - tau * p_n)
        slow = max(1.0 + min(a, 0.0) / c, 0.0)
        lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
        warmer = T - T0 - tau * (law.pressure(rho, T) - law.pressure(rho0, T0))
        sound -= by_heat * kappa / (rho0 * c) * q_n
        heat = part * kappa * (slow * slow * tau * p_n + q_n) - capacity * lost * warmer
    return part * sound, part * mu * v_n, heat


@njit(**INNER_CALL)
def _by_characteristics(law, rho, u, T, rho_out, u_out, T_out, n, g, area, viscous, out):
    """out = F(U*); False if there is no such gas. area: |n|^2, viscous: see `first_order`."""
    size, (sound, stress, heat) = np.sqrt(area), viscous
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
    speed = 0.5 * (a + a_out) + 0.5 * (p - p_out - sound) / Z
    between = 0.5 * (p + p_out + sound) + 0.5 * Z * (a - a_out)
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
    for c in range(u.size):
        out[1 + c] -= n[c] * stress
    out[u.size + 1] -= size * (stress * (speed + g / size) + heat)
    return True


@njit(**CALL)
def load_faces(solid, like, faces, S, weight, patch, q, metrics, inertia, rates, gain):
    """Add forces and heat at the faces of a solid to ``rates`` (owned, 2d + 1), and to ``gain``
    (d + 2,) work, impulse and energy.

    q: (ghosted, 2d + 1). S, weight: of the three axes. inertia: (ghosted,), J0 m0.
    """
    d = len(like)
    A, n, force = np.zeros(d), np.zeros(d), np.zeros(d)
    F = np.zeros((len(solid.unstrained(like)), 1))
    for i in range(faces.at.size):
        at, own, area = faces.at[i], faces.own[i], 0.0
        for c in range(d):
            A[c] = faces.sign[i] * metrics[faces.axis[i] * d + c, at]
            area += A[c] * A[c]
        area = np.sqrt(area)
        for c in range(d):
            force[c] = faces.traction[i, c] * area
        if faces.absorbs[i] == 1:
            strain_at(solid, at, S, weight, patch, metrics, q, F)
            push = faces.stress[i] - _resistance(solid, like, F, q, at, A, area)
            for c in range(d):
                force[c] += push * A[c]
        if faces.pressure[i] != 0.0:
            _normal(faces, i, solid.hoops(), S, weight, patch, q, n)
            for c in range(d):
                force[c] -= faces.pressure[i] * n[c]
        scale, work, heat = faces.per_weight[i] / inertia[at], 0.0, faces.heat[i] * area
        for c in range(d):
            rates[own, d + c] += scale * force[c]
            gain[1 + c] += faces.across[i] * force[c]
            work += force[c] * q[at, d + c]
        rates[own, 2 * d] += scale * (work + heat)
        gain[0] += faces.across[i] * work
        gain[1 + d] += faces.across[i] * (work + heat)


@njit(**INNER_CALL)
def _resistance(solid, like, F, q, at, A, area):
    """Z N . v of a node, Z = sqrt(m0 wave modulus)."""
    d, through = len(like), 0.0
    here = column((*like, *like, 0.0), q.T, U64(at))
    strain = column(solid.unstrained(like), F, U64(0))
    T = solid.temperature(here[d:-1], here[-1], strain)
    for c in range(d):
        through += A[c] * q[at, d + c]
    return np.sqrt(solid.m0 * solid.wave_modulus_at(strain, T)) * through / area


@njit(**INNER_CALL)
def _normal(faces, i, hoops, S, weight, patch, q, n):
    """n = outward area vector of a solid's face where it is now; hoops: of Solid."""
    axis, sign = faces.axis[i], faces.sign[i]
    if n.size == 1:
        r = faces.X[0, faces.at[i]] + q[faces.at[i], 0] if hoops > 0 else 1.0
        n[0] = sign * (r * r if hoops == 2 else r)
    elif n.size == 2:
        slope_at(faces.at[i], 1 - axis, S, weight, patch, 1.0, faces.X, q, n)
        x, turn = n[0], sign if axis == 0 else -sign
        n[0], n[1] = turn * n[1], -turn * x
    else:
        for c in range(n.size):
            n[c] = faces.normal[i, c]


@njit(**CALL)
def slope_at(at, axis, S, weight, patch, share, X, q, out):
    """out = D_axis of share X + displacement at a node of the ghosted array; X: (d, ghosted), q:
    (ghosted, …), whose first numbers are the displacement.
    """
    band, (nx, ny, nz) = S[axis], patch.ghosted
    stride, size = (1, nx) if axis == 0 else (nx, ny) if axis == 1 else (nx * ny, nz)
    place = at // stride % size
    for c in range(out.size):
        total = 0.0
        for k in range(1, band.shape[0]):
            for sign in (1, -1):
                to, first = at + sign * k * stride, place if sign > 0 else place - k
                if first >= 0 and first + k < size:
                    apart = share * (X[c, to] - X[c, at]) + (q[to, c] - q[at, c])
                    total += sign * band[k, first] * apart
        out[c] = total * 0.5 / weight[axis][place]


@njit(**CALL)
def strain_at(solid, at, S, weight, patch, metrics, q, F):
    """F (d d, 1) = 1 + sum_k D_k D A^k / J0 of a solid's node of the ghosted array; behind it in
    one dimension the stretch of hoops, if there are any.
    """
    d = (q.shape[1] - 1) // 2
    if solid.hoops() > 0:
        F[1, 0] = solid.hoop_stretch(q[at, 0], metrics[0, at])
    slope = np.zeros(d)
    for i in range(d):
        for j in range(d):
            F[i * d + j, 0] = 1.0 if i == j else 0.0
    for k in range(d):
        slope_at(at, k, S, weight, patch, 0.0, metrics, q, slope)
        for i in range(d):
            for j in range(d):
                F[i * d + j, 0] += slope[i] * (metrics[k * d + j, at] / metrics[d * d, at])
