"""What passes faces of blocks that are open, loaded or heated: added to the rates of the nodes
there, and, times the weights of these, to what comes in.

The volume terms let nothing pass a face. With the outward area vector n of a face per unit of its
reference coordinates, and the velocity v of the grid, a node at it gets -f / weight, weight that of
its axis, where f is

    open       F(U*), F(U) = n . (f(U) - v U), by characteristics: U* = U_in where gas leaves faster
               than sound, U_out where it comes so; else p + Z N . u is that inside, p - Z N . u
               that outside, Z = rho c of the gas inside at the mean pressure of both, and
               rho - p/c^2, c^2 and velocities along the face those of the side that gas comes from
               If no such gas can be, 1/2 (F(U_in) + F(U_out)) - 1/2 lambda (U_out - U_in),
               lambda = max over both of |n . (u - v)| + c |n| (local Lax-Friedrichs)
               To first order in viscosity and conduction see `first_order`
    outflow    F(U_in); with a pressure p_b beyond and a Mach number m < 1 through the face that of
               Lax and Friedrichs, with U_out of density and velocity of U_in and of pressure
               p + (1 - m^2)(p_b - p); m = 0 where gas flows in
    drags      (0, t, t . w), t = mu/l (u - w) |n| without its part along n: the gas slips along a
               wall of velocity w with the length l of Navier
    free       p_b n(x) on a solid, n(x) the area vector of the face where it is now: a pressure
               that follows it
    absorbing  (stress N - Z v) |A| on a solid, N the unit normal and |A| the area at rest, Z the
               tensor sqrt(m0 Q) of the acoustic tensor Q along N (fsipetsc.equations.solid)

All are equal to n . f for a uniform state, so that uniform flow stays uniform.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.equations.tensors import add_unit, outer
from fsipetsc.equations.vectors import add, along, choose, dot, last_times, mean, per, scale, sub
from fsipetsc.kernels.arrays import column_of, node, part_of
from fsipetsc.kernels.procedure import each, invoke, variable, when
from fsipetsc.scheme.normals import slope_at, turned

Array = NDArray[Any]
#: first order of an open face fades out where viscosity is this fraction of L times the speed at
#: which sound leaves, L the length of the gas
LONGEST = 0.25
#: what stands in ``opens`` where gas may pass a face, and where it slips along it
OPENS, DRAGS = 1, 2


class GasFaces(NamedTuple):
    """Nodes of faces of a part of a gas block through which something passes; a node at an edge
    stands there once for each of its faces.

    at, own: (n,) numbers of the nodes in the ghosted array and among the owned ones. axis, sign: of
    the outward normal. per_weight: 1 / weight of the axis at the face, across: product of those of
    the other axes. column: of the face in what comes in. opens: OPENS, DRAGS or 0; outside:
    (n, d + 2), (rho, u, T) beyond; goes: (n,) 1 where a wall that drags moves with the grid, 0
    where it rests. pressure: (n,) that beyond an outflow, 0 for one that is supersonic, below 0
    where the face is open and no outflow. heat: (n,) what comes in per area [W/m2]. width: (n,)
    length [m] of the gas behind an open face of first order, or the slip length of a wall, else 0.
    """

    at: Array
    own: Array
    axis: Array
    sign: Array
    per_weight: Array
    across: Array
    column: Array
    opens: Array
    outside: Array
    goes: Array
    pressure: Array
    heat: Array
    width: Array

    def add(self, part, q, rates, gain):
        """Add all that passes."""
        pass_faces(part, self, q, rates, gain)


class Turned(NamedTuple):
    """A solid's face in three dimensions, whose area vectors where it is now have the curl form,
    with derivatives within the face only, and the bits that a gas there has.

    address: of its fsipetsc.blocks.cube.Cube, with x: (3, W) places less those of linear maps, y:
    (3, W) these at rest, at: (W,) the nodes, and areas: (9, n), of which rows from ``row`` on are
    wanted. sign: of the outward normal. begin, nodes: which nodes of the faces it has, perhaps none
    on this rank.
    """

    address: int
    x: Array
    y: Array
    at: Array
    areas: Array
    row: int
    sign: float
    begin: int
    nodes: int


def turn_face(face, q, normal):
    """Find the outward area vectors of the nodes of a face."""
    with when(face.nodes > 0):
        for i in each(face.at.shape[0]):
            for c in range(3):
                face.x[c, i] = face.y[c, i] + q[face.at[i], c]
        invoke("cube_faces", face.address)
        for i in each(face.nodes):
            for c in range(3):
                normal[face.begin + i, c] = face.sign * face.areas[face.row + c, i]


class SolidFaces(NamedTuple):
    """The same of a solid block.

    traction: (n, d) per area at rest, pressure: (n,) that follows the face. absorbs: 1 where waves
    leave, stress: (n,) pulls there. normal: (n, d) area vectors of the face as it is, in three
    dimensions, which `turned` find. X: (d, ghosted) places in the reference map.
    """

    at: Array
    own: Array
    axis: Array
    sign: Array
    per_weight: Array
    across: Array
    column: Array
    absorbs: Array
    traction: Array
    pressure: Array
    stress: Array
    heat: Array
    normal: Array
    X: Array
    turned: tuple[Turned, ...]

    def add(self, part, q, rates, gain):
        """Add all that loads a solid; returns its work."""
        for face in self.turned:
            turn_face(face, q, self.normal)
        return load_faces(part, self, q, rates, gain)


def pass_faces(part, faces, q, rates, gain):
    """Add what passes the faces of a gas to ``rates`` (owned, d + 3) and ``gain``; q: (ghosted,
    d + 3).
    """
    d, metrics = len(part.like), part.metrics
    like, energy = (0.0,) * d, gain.energy
    for i in each(faces.at.shape[0]):
        at, own, axis, column = faces.at[i], faces.own[i], faces.axis[i], faces.column[i]
        per_weight, across = faces.per_weight[i], faces.across[i]
        n = scale(faces.sign[i], column_of(like, metrics, axis * d, at))
        size = np.sqrt(dot(n, n))
        with when(faces.opens[i] == OPENS):
            f = let_pass(part, faces, i, q, n, size)
            for c in range(d + 2):
                rates[own, 1 + c] -= per_weight * f[c]
            gain.mass[part.column] -= across * f[0]
            for c in range(d):
                gain.impulse[c] -= across * f[1 + c]
            energy[column] -= across * f[d + 1]
        with when(faces.opens[i] == DRAGS):
            wall = scale(faces.goes[i], column_of(like, metrics, d * d, at))
            w = part.laws.primitive(node((*like, 0.0, 0.0, 0.0), q, at))
            t = drag(part.laws, w, wall, n, size, faces.width[i])
            for c in range(d):
                rates[own, 2 + c] += per_weight * t[c]
                gain.impulse[c] += across * t[c]
            rates[own, d + 2] += per_weight * dot(t, wall)
            energy[column] += across * dot(t, wall)
        heat = faces.heat[i] * size
        rates[own, d + 2] += per_weight * heat
        energy[column] += across * heat
        gain.heat[column] += across * heat


def let_pass(part, faces, i, q, n, size):
    """f of the i-th node, of an open face or an outflow; n: area vector, size: |n|."""
    gas, d, at, of_axes = part.laws, len(part.like), faces.at[i], (part.S, part.weight, part.patch)
    like, out, width, v_n = (0.0,) * d, faces.outside, faces.width[i], variable(0.0)
    g = dot(n, column_of(like, part.metrics, d * d, at))
    w = gas.primitive(node((*like, 0.0, 0.0, 0.0), q, at))
    beyond = gas.state(out[i, 0], part_of(like, out, i, 1), out[i, d + 1])
    with when(width > 0.0):
        slope = slope_at(like, at, faces.axis[i], *of_axes, Velocity(gas, q))
        v_n.value = faces.sign[i] / q[at, 0] * dot(n, slope)
    return open_flux(gas, w, beyond, faces.pressure[i], width, n, g, size, v_n.value)


def drag(gas, w, wall, n, size, length):
    """-mu/l (u - w) |n| without its part along n: what a wall does to a gas that slips along it."""
    past = sub(gas.velocity(w), wall)
    past = along(past, -dot(past, n) / (size * size), n)
    return scale(-gas.mu * gas.transport.viscosity(w[2]) * size / length, past)


def surface_flux(gas, w, n, g):
    """F(U) = n . (f(U) - v U)."""
    return along(gas.flux(w, n), -g, gas.densities(w))


def open_flux(gas, w, beyond, pressure, width, n, g, size, v_n):
    """f of an open face or an outflow, w: state inside, size: |n|, v_n: see `first_order`. All
    kinds are computed, and one is taken.
    """
    f, a = surface_flux(gas, w, n, g), (dot(n, gas.velocity(w)) - g) / size
    m = np.maximum(a, 0.0) / gas.speed_of_sound(w)
    p = w[1] + np.maximum(1.0 - m * m, 0.0) * (pressure - w[1])
    held = gas.state(w[0], gas.velocity(w), gas.law.temperature_of(w[0], p))
    viscous, of_sound = first_order(gas, w, a, beyond, width, v_n)
    viscous = choose(width > 0.0, viscous, (0.0, 0.0, 0.0))
    beyond = choose(width > 0.0, of_sound, beyond)
    found, there_is = by_characteristics(gas, w, beyond, n, g, size, viscous)
    beyond = choose(pressure > 0.0, held, beyond)
    fastest = np.maximum(gas.fastest(w, n, g), gas.fastest(beyond, n, g))
    jump = sub(gas.densities(beyond), gas.densities(w))
    mixed = along(mean(f, surface_flux(gas, beyond, n, g)), -0.5 * fastest, jump)
    mixed = choose((pressure < 0.0) & there_is, found, mixed)
    return choose(pressure == 0.0, f, mixed)


def first_order(gas, w, a, beyond, width, v_n):
    """Of a node of an open face: the incoming sound, the viscous stress, the incoming heat, and
    the gas beyond with the temperature that leaving sound gives it.

    To first order in viscosity and conduction, as docs/open-end.md derives it for small
    disturbances of the gas beyond. a: velocity through the face; v_n: outward derivative
    of the outward velocity [1/s].
    """
    law, rho0, T0 = gas.law, beyond[0], beyond[2]
    c2, cv = law.sound_speed_squared(rho0, T0), law.heat_capacity(rho0, T0)
    c, by_heat = np.sqrt(c2), law.pressure_by_temperature(rho0, T0) / cv
    tau = T0 * by_heat / (rho0 * rho0 * c2)
    mu = 4.0 / 3.0 * gas.mu * gas.transport.viscosity(T0)
    kappa = gas.kappa * gas.transport.conductivity(T0)
    longest = LONGEST * (c + np.minimum(a, 0.0)) * width
    part = np.maximum(0.0, 1.0 - np.maximum(mu, kappa / cv) / (rho0 * longest))
    part = np.where(longest > 0.0, part, 0.0)
    capacity = cv * rho0 * rho0 * c2 / law.bulk_modulus(rho0, T0)
    alpha = kappa / capacity
    lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) * (alpha / width)) - a)
    warmer = np.where(a < 0.0, -part * alpha * tau * rho0 * v_n, 0.0)
    warmer = np.minimum(np.maximum(warmer, -0.5 * T0), 0.5 * T0)
    heat = part * kappa * tau * rho0 * c * v_n
    let_out = capacity * lost * (w[2] - T0 - warmer - tau * (w[1] - beyond[1]))
    heat = heat - np.where(kappa > 0.0, let_out, 0.0)
    sound, T = part * 0.5 * (mu - tau * by_heat * kappa) * v_n, T0 + warmer
    beyond = gas.state(law.density(beyond[1], T), gas.velocity(beyond), T)
    return (sound, part * mu * v_n, heat), beyond


def by_characteristics(gas, w, beyond, n, g, size, viscous):
    """F(U*) and whether there is such a gas; viscous: see `first_order`."""
    law, (sound, stress, heat), N = gas.law, viscous, scale(1.0 / size, n)
    rho, p, u = w[0], w[1], gas.velocity(w)
    rho_out, p_out, u_out = beyond[0], beyond[1], gas.velocity(beyond)
    c, c_out = gas.speed_of_sound(w), gas.speed_of_sound(beyond)
    a, a_out = dot(N, u) - g / size, dot(N, u_out) - g / size
    rho_mean = rho + 0.5 * (p_out - p) / (c * c)
    T_mean = law.temperature_of(rho_mean, 0.5 * (p + p_out))
    Z = rho_mean * np.sqrt(law.sound_speed_squared(rho_mean, T_mean))
    speed = 0.5 * (a + a_out) + 0.5 * (p - p_out - sound) / Z
    between = 0.5 * (p + p_out + sound) + 0.5 * Z * (a - a_out)
    fast_out, fast_in = a >= c, a_out <= -c_out
    leaves = fast_out | ((speed >= 0.0) & ~fast_in)
    of_side = np.where(leaves, rho, rho_out), np.where(leaves, p, p_out), np.where(leaves, c, c_out)
    rho_face = of_side[0] + (between - of_side[1]) / (of_side[2] * of_side[2])
    speed, rho_face, between = choose(
        fast_out, (a, rho, p), choose(fast_in, (a_out, rho_out, p_out), (speed, rho_face, between))
    )
    T_face = law.temperature_of(rho_face, between)
    there_is = (rho_mean > 0.0) & (T_mean > 0.0) & (rho_face > 0.0) & (T_face > 0.0)
    known = choose(leaves, along(u, speed - a, N), along(u_out, speed - a_out, N))
    F = surface_flux(gas, gas.state(rho_face, known, T_face), n, g)
    lost = (0.0, *scale(stress, n), size * (stress * (speed + g / size) + heat))
    return sub(F, lost), there_is


def load_faces(part, faces, q, rates, gain):
    """Add forces and heat at the faces of a solid to ``rates`` (owned, 2d + 1) and ``gain``;
    returns the work; q: (ghosted, 2d + 1).
    """
    d, total, energy = len(part.like), variable(0.0), gain.energy
    like = (0.0,) * d
    for i in each(faces.at.shape[0]):
        at, own, column, across = faces.at[i], faces.own[i], faces.column[i], faces.across[i]
        A = scale(faces.sign[i], column_of(like, part.metrics, faces.axis[i] * d, at))
        area, v = np.sqrt(dot(A, A)), part_of(like, q, at, d)
        forces = [variable(area * faces.traction[i, c]) for c in range(d)]
        with when(faces.absorbs[i] == 1):
            add_to(forces, area, absorbed(part, faces, i, q, per(A, area), v))
        with when(faces.pressure[i] != 0.0):
            add_to(forces, -faces.pressure[i], normal_at(part, faces, i, q))
        force = tuple(one.value for one in forces)
        scaled, heat = faces.per_weight[i] / part.inertia[at], faces.heat[i] * area
        work = dot(force, v)
        for c in range(d):
            rates[own, d + c] += scaled * force[c]
            gain.impulse[c] += across * force[c]
        rates[own, 2 * d] += scaled * (work + heat)
        energy[column] += across * (work + heat)
        gain.heat[column] += across * heat
        total.value += across * work
    return total.value


def add_to(sums, c, a):
    """Add c times a vector to variables."""
    for total, number in zip(sums, a, strict=True):
        total.value += c * number


def absorbed(part, faces, i, q, N, v):
    """stress N - Z v at the i-th node of a solid's faces."""
    solid, at, d = part.laws, faces.at[i], len(part.like)
    F = strain_at(part, q, at)
    T = solid.temperature(v, q[at, 2 * d], F)
    return along(scale(faces.stress[i], N), -1.0, solid.resistance(F, T, N, v))


def normal_at(part, faces, i, q):
    """Outward area vector of a solid's face where it is now; around an axis see
    fsipetsc.blocks.radial_grid.
    """
    solid, at, axis, sign = part.laws, faces.at[i], faces.axis[i], faces.sign[i]
    like, of_axes = (0.0,) * len(part.like), (part.S, part.weight, part.patch)
    if len(like) == 3:
        return node(like, faces.normal, i)
    x = place_at(like, faces.X, q, at)
    if len(like) == 1:
        return last_times(solid.weight(x), (sign,))
    slope = slope_at(like, at, 1 - axis, *of_axes, Flat(solid, faces.X, q))
    return last_times(solid.weight(x), turned(np.where(axis == 0, sign, -sign), slope))


def place_at(like, X, q, n):
    """Where a solid's node of the ghosted array is."""
    return add(column_of(like, X, 0, n), node(like, q, n))


class Velocity(NamedTuple):
    """Of a node of gas."""

    gas: Any
    q: Array

    def at(self, like, n):
        return self.gas.velocity(self.gas.primitive(node((*like, 0.0, 0.0, 0.0), self.q, n)))


class Flat(NamedTuple):
    """Of a solid's node where it is, see fsipetsc.blocks.radial_grid."""

    solid: Any
    X: Array
    q: Array

    def at(self, like, n):
        return self.solid.flat(place_at(like, self.X, self.q, n))


class Displacement(NamedTuple):
    """Of a solid's node."""

    q: Array

    def at(self, like, n):
        return node(like, self.q, n)


def strain_at(part, q, at):
    """F = 1 + sum_k D_k D A^k / J0 of a solid's node of the ghosted array, with hoops."""
    d, metrics, of_axes = len(part.like), part.metrics, (part.S, part.weight, part.patch)
    like = (0.0,) * d
    F = add_unit(1.0, outer(like, like))
    for k in range(d):
        A = per(column_of(like, metrics, k * d, at), metrics[d * d, at])
        F = add(F, outer(slope_at(like, at, k, *of_axes, Displacement(q)), A))
    return part.laws.with_hoops(F, node(like, q, at), metrics[-1, at])
