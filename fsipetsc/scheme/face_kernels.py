"""What passes faces of blocks that are open, loaded or heated: it is added to the rates of the
nodes there, and, times their weights, to what comes in.

The volume terms let nothing pass a face. With the outward area vector n of a face per unit of its
reference coordinates a node gets -f / weight of the axis; conditions know f, which is n . f of a
uniform state, so uniform flow stays uniform.
"""

from types import SimpleNamespace

import numpy as np

from fsipetsc.blocks.face_formulas import FaceNode
from fsipetsc.equations.tensors import add_unit, outer
from fsipetsc.equations.vectors import add, dot, last_times, per, scale
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, invoke, variable, when
from fsipetsc.scheme.normals import slope_at, turned
from fsipetsc.scheme.part import area, gas_at, moving


class GasFaces(SimpleNamespace):
    """Nodes of faces of a part of a gas block through which something passes; a node at an edge
    stands there once for each of its faces.

    at, own: (n,) numbers of the nodes in the ghosted array and among the owned ones. axis, sign: of
    the outward normal. per_weight: 1 / weight of the axis at the face, across: product of those of
    the other axes. column: of the face in what comes in. outside: (n, d + 2), (rho, u, T) beyond.
    pressure: (n,) that beyond an outflow, 0 for one that is supersonic. heat: (n,) what comes in
    per area [W/m2]. width: (n,) length [m] of the gas behind an open face of first order, or the
    slip length of a wall, else 0. groups: records of nodes from ``begin`` on whose conditions have
    one ``effect``; nodes: how many, perhaps none on this rank.
    """

    def add(self, part, q, rates, gain):
        """Add all that passes to ``rates`` (owned, d + 3) and ``gain``; q: (ghosted, d + 3)."""
        for group in self.groups:
            for i in each(group.nodes):
                pass_face(part, self, group.effect, group.begin + i, q, rates, gain)


def turn_face(face, q, normal):
    """Find the outward area vectors of the nodes of a solid's face in three dimensions, where it is
    now. They have the curl form, with derivatives within the face only, and the bits that a gas
    there has.

    face: address: of its Cube (fsipetsc.blocks.metrics); x: (3, W) places less those of linear
    maps, y: (3, W) these at rest, at: (W,) the nodes; areas: (9, n), of which rows from ``row`` on
    are filled. sign: of the outward normal. begin, nodes: which nodes of the faces it
    has, perhaps none on this rank.
    """
    with when(face.nodes > 0):
        for i in each(face.at.shape[0]):
            for c in range(3):
                face.x[c, i] = face.y[c, i] + q[face.at[i], c]
        invoke("cube_faces", face.address, face.x, face.areas)
        for i in each(face.nodes):
            for c in range(3):
                normal[face.begin + i, c] = face.sign * face.areas[face.row + c, i]


class SolidFaces(SimpleNamespace):
    """The same of a solid block.

    traction: (n, d) per area at rest, pressure: (n,) that follows the face. stress: (n,) pulls
    where waves leave. normal: (n, d) area vectors of the face as it is, in three dimensions, which
    `turned` find. X: (d, ghosted) places in the reference map.
    """

    def add(self, part, q, rates, gain):
        """Add all that loads and heats a solid to ``rates`` (owned, 2d + 1) and ``gain``; returns
        its work; q: (ghosted, 2d + 1).
        """
        for face in self.turned:
            turn_face(face, q, self.normal)
        total = variable(0.0)
        for group in self.groups:
            for i in each(group.nodes):
                total.value += load_face(part, self, group.effect, group.begin + i, q, rates, gain)
        return total.value


def pass_face(part, faces, effect, i, q, rates, gain):
    """Add what passes the face at its i-th node."""
    d, own, column, energy = len(part.like), faces.own[i], faces.column[i], gain.energy
    per_weight, across = faces.per_weight[i], faces.across[i]
    w, face = seen_at(part, faces, effect, i, q)
    if effect.by.leaving:
        f = effect.by.leaving(part.laws, w, face)
        for c in range(d + 2):
            rates[own, 1 + c] -= per_weight * f[c]
        gain.mass[part.column] -= across * f[0]
        for c in range(d):
            gain.impulse[c] -= across * f[1 + c]
        energy[column] -= across * f[d + 1]
    if effect.by.traction:
        t = effect.by.traction(part.laws, w, face)
        for c in range(d):
            rates[own, 2 + c] += per_weight * t[c]
            gain.impulse[c] += across * t[c]
        rates[own, d + 2] += per_weight * dot(t, face.wall)
        energy[column] += across * dot(t, face.wall)
    if effect.heated:
        heat = faces.heat[i] * face.size
        rates[own, d + 2] += per_weight * heat
        energy[column] += across * heat
        gain.heat[column] += across * heat


def seen_at(part, faces, effect, i, q):
    """Return the state of the gas at the i-th node of the faces, and the face there."""
    gas, d, at, axis, sign = part.laws, len(part.like), faces.at[i], faces.axis[i], faces.sign[i]
    like, out, rise = (0.0,) * d, faces.outside, None
    n, v = scale(sign, area(part, axis, at)), moving(part, at)
    w = gas_at(part, q, at)
    beyond = gas.state(out[i, 0], row(like, out, i, 1), out[i, d + 1])
    if effect.first_order:
        slope = slope_at(part, at, axis, lambda n: gas.velocity(gas_at(part, q, n)))
        rise = sign / q[at, 0] * dot(n, slope)
    wall = v if effect.moves else like
    data = wall, beyond, faces.pressure[i], faces.width[i], rise
    return w, FaceNode(n, np.sqrt(dot(n, n)), dot(n, v), *data)


def load_face(part, faces, effect, i, q, rates, gain):
    """Add forces and heat at the i-th node; returns their work."""
    d, at, own, energy = len(part.like), faces.at[i], faces.own[i], gain.energy
    like, column, across = (0.0,) * d, faces.column[i], faces.across[i]
    A = scale(faces.sign[i], area(part, faces.axis[i], at))
    size, v = np.sqrt(dot(A, A)), row(like, q, at, d)
    forces = [variable(size * faces.traction[i, c]) for c in range(d)]
    if effect.by.pull:
        F = strain_at(part, q, at)
        T = part.laws.temperature(v, q[at, 2 * d], F)
        pull = effect.by.pull(part.laws, F, T, per(A, size), v, faces.stress[i])
        add_to(forces, size, pull)
    with when(faces.pressure[i] != 0.0):
        add_to(forces, -faces.pressure[i], normal_at(part, faces, i, q))
    force = tuple(one.value for one in forces)
    scaled, heat = faces.per_weight[i] / part.inertia[at], faces.heat[i] * size
    work = dot(force, v)
    for c in range(d):
        rates[own, d + c] += scaled * force[c]
        gain.impulse[c] += across * force[c]
    rates[own, 2 * d] += scaled * (work + heat)
    energy[column] += across * (work + heat)
    gain.heat[column] += across * heat
    return across * work


def add_to(sums, c, a):
    """Add c times a vector to variables."""
    for total, number in zip(sums, a, strict=True):
        total.value += c * number


def normal_at(part, faces, i, q):
    """Return the outward area vector of a solid's face where it is now. For an axis see
    fsipetsc.blocks.grid.
    """
    solid, at, axis, sign = part.laws, faces.at[i], faces.axis[i], faces.sign[i]
    like = part.like
    if len(like) == 3:
        return row(like, faces.normal, i)

    def place(n):
        return add(column(like, faces.X, n), row(like, q, n))

    normal = (sign,)
    if len(like) == 2:
        slope = slope_at(part, at, 1 - axis, lambda n: solid.flat(place(n)))
        normal = turned(np.where(axis == 0, sign, -sign), slope)
    return last_times(solid.weight(place(at)), normal)


def strain_at(part, q, at):
    """Return F = 1 + sum_k D_k D A^k / J0 at a solid's node of the ghosted array, with hoop
    stretches.
    """
    metrics, like, d = part.metrics, part.like, len(part.like)
    F = add_unit(1.0, outer(like, like))
    for k in range(d):
        A = per(area(part, k, at), metrics[d * d, at])
        F = add(F, outer(slope_at(part, at, k, lambda n: row(like, q, n)), A))
    return part.laws.with_hoops(F, row(like, q, at), metrics[-1, at])
