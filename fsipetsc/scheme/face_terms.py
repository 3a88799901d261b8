"""Faces of blocks: what passes those that are open, loaded or heated; area vectors where particles
have constraints, and how they turn; derivatives at single nodes.

The volume terms let nothing pass a face. With the outward area vector n of a face per unit of its
reference coordinates a node gets -f / weight of the axis; conditions know f, which is n . f of a
uniform state, so uniform flow stays uniform.

The area vector of a face of axis k is +-a^k times the weights of the other axes. With x' the
velocity of the grid it turns, not in 1-D, by

    2-D      (D_2 y', -D_2 x') on faces of axis 1,   (-D_1 y', D_1 x') on those of axis 2
    3-D      1/2 (a^k(x + x') - a^k(x - x')),   as a^k is bilinear in places
"""

from types import SimpleNamespace

import numpy as np

from fsipetsc.blocks.face_formulas import FaceNode
from fsipetsc.equations.tensors import add_unit, outer
from fsipetsc.equations.vectors import add, along, dot, last_times, per, scale
from fsipetsc.kernels.loops import column, each, row, variable, when
from fsipetsc.kernels.symbols import exact
from fsipetsc.scheme.part import area, gas_at, moving


def turned(c, a):
    """c times a vector of two numbers turned to the right; a vector of another length as it is."""
    return (c * a[1], -c * a[0]) if len(a) == 2 else a


def add_areas(part, table, areas, less=None):
    """Add areas (d d + …, ghosted nodes), by axis and component, of faces at members to the rows of
    a table; or half of what they are more than others.
    """
    faces, d = part.at_particles, part.d
    for i in each(faces.row.shape[0]):
        for c in range(d):
            at = faces.axis[i] * d + c, faces.node[i]
            number = areas[at] if less is None else exact(0.5 * (areas[at] - less[at]))
            table[faces.row[i], faces.column[i] + c] += faces.weight[i] * number


def normals(part, record):
    """Add area vectors of faces to the table of members at constraints."""
    add_areas(part, record.of_normals, part.metrics)


def turn_plane(part, table):
    """Add to a table how area vectors turn on a flat plane."""
    faces = part.at_particles
    for i in each(faces.row.shape[0]):
        slope = slope_at(part, faces.node[i], 1 - faces.axis[i], lambda n: moving(part, n))
        sign = np.where(faces.axis[i] == 0, 1.0, -1.0)
        for c, turning in enumerate(turned(sign * faces.weight[i], slope)):
            table[faces.row[i], faces.column[i] + c] += turning


def slope_at(part, at, axis, of):
    """Return D_axis of a vector at a node of the ghosted array; axis: known, or read from an array,
    of: a function that returns the vector at a node, a tuple.
    """
    reach, nodes, stride = (part.axes[axis, c] for c in range(3))
    place, here = at // stride % nodes, of(at)
    total = [variable() for _ in here]
    for k in each(1, reach + 1):
        for sign in (1, -1):
            first = place if sign > 0 else place - k
            with when((first >= 0) & (first + k < nodes)):
                band = part.S[axis, k, first]
                with when(band != 0.0):
                    change = along(of(at + sign * k * stride), -1.0, here)
                    for sum_, number in zip(total, change, strict=True):
                        sum_.value += sign * band * number
    return per(scale(0.5, tuple(sum_.value for sum_ in total)), part.weight[axis, place])


class Faces(SimpleNamespace):
    """Nodes of faces of a part of a block through which something passes, or which are loaded or
    heated; a node at an edge stands there once for each of its faces.

    at, own: (n,) numbers of the nodes in the ghosted array and among the owned ones. axis, sign: of
    the outward normal. per_weight: 1 / weight of the axis at the face, across: product of those of
    the other axes. column: of the face in what comes in. heat: (n,) what comes in per area [W/m2].
    effect: that of their conditions. add_node: `pass_face` of a gas, `load_face` of a solid.

    Of a gas: outside: (n, d + 2), (rho, u, T) beyond. pressure: (n,) beyond an outflow, 0 for one
    that is supersonic. width: (n,) length [m] of the gas behind an open face of first order. slip:
    (n,) slip length [m] of a wall. Of a solid: traction: (n, d) per area at rest, pressure: (n,)
    that follows the face, stress: (n,) pulls where waves leave. normal: (n, d) area vectors of the
    face as it is, in three dimensions, which `turned` find.
    """

    def add(self, part, own, q, rates, gain):
        """Add all this to ``rates`` of the owned nodes and to ``gain``; q: of ghosted nodes."""
        for face in self.turned:
            turn_face(face, q, self.normal)
        for i in each(self.own.size):
            self.add_node(part, self, i, q, rates, gain)


def turn_face(face, q, normal):
    """Find the outward area vectors of the nodes of a solid's face in three dimensions, where it is
    now, with the bits that a gas there has.

    face: curls: of it (fsipetsc.blocks.metrics); x: (3, W) places less those of linear maps,
    y: (3, W) these at rest, at: (W,) the nodes; areas: (9, n), of which rows from ``row`` on are
    filled. begin, nodes: which nodes of the faces it has, perhaps none on this rank.
    """
    with when(face.nodes > 0):
        for i in each(face.at.shape[0]):
            face.x[:, i] = add(column(3, face.y, i), row(3, q, face.at[i]))
        face.curls.find(face.x, face.areas, 1, 2)
        for i in each(face.nodes):
            normal[face.begin + i] = scale(face.sign, column(3, face.areas, i, face.row))


def pass_face(part, faces, i, q, rates, gain):
    """Add what passes the face at its i-th node."""
    d, own, account = part.d, faces.own[i], faces.column[i]
    per_weight, across, entering = faces.per_weight[i], faces.across[i], []
    w, face = face_at(part, faces, i, q)
    if faces.effect.by.leaving:
        entering.append(scale(-1.0, faces.effect.by.leaving(part.laws, w, face)))
    if faces.effect.by.traction:
        t = faces.effect.by.traction(part.laws, w, face)
        entering.append((0.0, *t, dot(t, face.wall)))
    if faces.effect.heated:
        heat = faces.heat[i] * face.size
        entering.append((0.0,) * (d + 1) + (heat,))
        gain.heat[account] += across * heat
    for mass, *momentum, energy in entering:
        for c, value in enumerate((mass, *momentum, energy), 1):
            rates[own, c] += per_weight * value
        gain.mass[part.column] += across * mass
        for c, value in enumerate(momentum):
            gain.impulse[c] += across * value
        gain.energy[account] += across * energy


def face_at(part, faces, i, q):
    """Return the state of the gas at the i-th node of the faces, and the face there."""
    gas, d, at, axis, sign = part.laws, part.d, faces.at[i], faces.axis[i], faces.sign[i]
    out, rise = faces.outside, None
    n, v = scale(sign, area(part, axis, at)), moving(part, at)
    w = gas_at(part, q, at)
    beyond = gas.state(out[i, 0], row(d, out, i, 1), out[i, d + 1])
    if faces.effect.first_order:
        slope = slope_at(part, at, axis, lambda n: gas.velocity(gas_at(part, q, n)))
        rise = sign / q[at, 0] * dot(n, slope)
    wall = v if faces.effect.moves else (0.0,) * d
    data = wall, beyond, faces.pressure[i], faces.width[i], faces.slip[i], rise
    return w, FaceNode(n, np.sqrt(dot(n, n)), dot(n, v), *data)


def load_face(part, faces, i, q, rates, gain):
    """Add forces and heat at the i-th node."""
    d, at, own, energy = part.d, faces.at[i], faces.own[i], gain.energy
    account, across = faces.column[i], faces.across[i]
    A = scale(faces.sign[i], area(part, faces.axis[i], at))
    size, v = np.sqrt(dot(A, A)), row(d, q, at, d)
    force = tuple(size * faces.traction[i, c] for c in range(d))
    if faces.effect.by.pull:
        F = strain_at(part, q, at)
        T = part.laws.temperature(v, q[at, 2 * d], F)
        pull = faces.effect.by.pull(part.laws, F, T, per(A, size), v, faces.stress[i])
        force = along(force, size, pull)
    pushed = [variable(number) for number in force]
    with when(faces.pressure[i] != 0.0):
        for total, number in zip(pushed, normal_at(part, faces, i, q), strict=True):
            total.value -= faces.pressure[i] * number
    force = tuple(total.value for total in pushed)
    scaled, heat = faces.per_weight[i] / part.inertia[at], faces.heat[i] * size
    work = dot(force, v)
    for c in range(d):
        rates[own, d + c] += scaled * force[c]
        gain.impulse[c] += across * force[c]
    rates[own, 2 * d] += scaled * (work + heat)
    energy[account] += across * (work + heat)
    gain.heat[account] += across * heat
    if part.loses:
        gain.lost[0] += across * work


def normal_at(part, faces, i, q):
    """The outward area vector of a solid's face as it is. For an axis see fsipetsc.blocks.grid."""
    solid, d, at, axis, sign = part.laws, part.d, faces.at[i], faces.axis[i], faces.sign[i]
    if d == 3:
        return row(d, faces.normal, i)

    def place(n):
        return add(column(d, part.X, n), row(d, q, n))

    normal = (sign,)
    if d == 2:
        slope = slope_at(part, at, 1 - axis, lambda n: solid.flat(place(n)))
        normal = turned(np.where(axis == 0, sign, -sign), slope)
    return last_times(solid.weight(place(at)), normal)


def strain_at(part, q, at):
    """F = 1 + sum_k D_k D A^k / J0 at a solid's node of the ghosted array, with hoop stretches."""
    metrics, d = part.metrics, part.d
    F = add_unit(1.0, (0.0,) * d * d)
    for k in range(d):
        A = per(area(part, k, at), metrics[d * d, at])
        F = add(F, outer(slope_at(part, at, k, lambda n: row(d, q, n)), A))
    return part.laws.with_hoops(F, row(d, q, at), metrics[-1, at])
