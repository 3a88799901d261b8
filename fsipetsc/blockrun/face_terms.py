"""What passes the faces of this rank's parts of blocks: lists of nodes and data for
fsipetsc.scheme.faces.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.asked import Asked, data, datum
from fsipetsc.blocks.conditions import Absorbing, Free, Open, Outflow, steady
from fsipetsc.blocks.problem import Meeting
from fsipetsc.blocks.values import checked
from fsipetsc.parallel.block_layout import Part
from fsipetsc.scheme import faces
from fsipetsc.scheme.faces import Face

Array = NDArray[Any]


class FaceTerms:
    """Terms of the faces of one part of a block that have a condition, or interfaces with jumps.

    equations: of the block. inertia: (ghosted nodes,), J0 m0 of a solid, 1 of a gas. reference: (d,
    ghosted nodes) places X in the reference map. asked: has the data of the case.
    """

    def __init__(
        self,
        problem: Any,
        part: Part,
        equations: Any,
        inertia: Array,
        reference: Array,
        asked: Asked,
    ) -> None:
        self._part, self._equations, self._inertia = part, equations, inertia
        self._reference, self._asked, self._jumps = reference, asked, problem.jumps
        self._d, self._gas = problem.dimension, problem.blocks[part.k].kind == "fluid"
        self._faces: list[tuple[Any, Face, Array]] = []
        for (axis, side), condition in problem.faces_of(part.k).items():
            interface = isinstance(condition, Meeting) and problem.is_interface(part.k, axis, side)
            supplied = interface and not self._gas and self._jumps is not None
            if supplied or _acts(condition):
                face = face_of(problem, part, axis, side)
                if face.owned.size:
                    places = problem.places(part.k, part.numbers[face.owned])
                    self._faces.append((condition, face, places))
        conditions = [c for c, _, _ in self._faces if not isinstance(c, Meeting)]
        self.timed = len(conditions) < len(self._faces) or not all(map(steady, conditions))

    def ask(self, t: float) -> list[dict[str, Array]]:
        """Data of all faces at time t [s]. InputError the first time."""
        key, instant = ("faces", self._part.k), t if self.timed else None
        return self._asked(key, instant, lambda: [self._data(c, X, t) for c, _, X in self._faces])

    def add(self, t: float, q: Array, metrics: Array, rates: Array, gain: Array) -> None:
        """Add all terms at time t [s] to ``rates`` (owned, dof) and ``gain`` (d + 2,); q: (ghosted,
        dof).
        """
        for (condition, face, _), found in zip(self._faces, self.ask(t), strict=True):
            if "outside" in found:
                arguments = found["outside"], found["pressure"], rates, gain
                faces.open_face(self._equations.law, face, q, metrics, *arguments)
            if not self._gas:
                forces = self._forces(condition, face, found, q, metrics)
                faces.push_face(face, forces, q, self._inertia, rates, gain)
            if "heat" in found:
                heat = found["heat"] * self._areas(face, metrics)
                column = rates.shape[1] - 1
                faces.heat_face(face, heat, self._inertia, rates, column, gain)

    def _data(self, condition: Any, X: Array, t: float) -> dict[str, Array]:
        """What a face is given."""
        d, found = self._d, {}
        if isinstance(condition, Meeting):
            names = *(f"traction along {x}" for x in "xyz"[:d]), "heat"
            values = checked(self._jumps, (*X.T, t), X.T, names, f"jumps at t = {t:.6g}")
            return {"traction": np.stack(values[:-1], axis=-1), "heat": values[-1]}
        if isinstance(condition, Open):
            found = {"outside": _outside(condition, X, t), "pressure": np.full(len(X), -1.0)}
        elif isinstance(condition, Outflow):
            outside = np.empty((len(X), d + 2))
            found = {"outside": outside, "pressure": datum(condition, "pressure", X, t)}
        elif isinstance(condition, Free):
            found["pressure"] = datum(condition, "pressure", X, t)
        elif isinstance(condition, Absorbing):
            found["stress"] = datum(condition, "stress", X, t)
        if getattr(condition, "heat_flux", None) is not None:
            found["heat"] = datum(condition, "heat_flux", X, t)
        return found

    def _areas(self, face: Face, metrics: Array) -> Array:
        """(n,) of a gas where it is now, of a solid at rest."""
        at = metrics[face.axis * self._d : (face.axis + 1) * self._d, face.ghosted]
        return np.sqrt((at * at).sum(axis=0))

    def _forces(
        self, condition: Any, face: Face, found: dict[str, Array], q: Array, metrics: Array
    ) -> Array:
        """(n, d) on a face of a solid."""
        if "traction" in found:
            return found["traction"] * self._areas(face, metrics)[:, None]
        if isinstance(condition, Free):
            axes = [axis for axis in range(self._d) if axis != face.axis]
            tangents = [self._slope(axis, face, q, self._reference) for axis in axes]
            return -found["pressure"][:, None] * faces.area_vectors(face, tangents)
        forces = np.zeros((face.ghosted.size, self._d))
        if isinstance(condition, Absorbing):
            F = strain(self._part, face.ghosted, metrics, q)
            arguments = F, found["stress"], q, metrics, forces
            faces.absorb(self._equations, (0.0,) * self._d, face, *arguments)
        return forces

    def _slope(self, axis: int, face: Face, q: Array, X: Array) -> Array:
        return slope(self._part, axis, face.ghosted, q, X)


def slope(part: Part, axis: int, nodes: Array, q: Array, X: Array) -> Array:
    """(n, d) D_k of X (d, ghosted) + displacement along an axis, at nodes of the ghosted array."""
    sizes, band = part.patch.ghosted, part.bands[axis]
    stride = int(np.prod(sizes[:axis], dtype=int))
    return faces.tangent(nodes, band.S, band.weight, stride, sizes[axis], X, q)


def strain(part: Part, nodes: Array, metrics: Array, q: Array) -> Array:
    """F = 1 + sum_k D_k D A^k / J0 (d d, n) of a solid at nodes of the ghosted array."""
    d, n = (q.shape[1] - 1) // 2, nodes.size
    F = np.tile(np.eye(d)[..., None], (1, 1, n))
    nothing = np.zeros((d, q.shape[0]))
    for k in range(d):
        A = metrics[k * d : (k + 1) * d, nodes] / metrics[d * d, nodes]
        F += slope(part, k, nodes, q, nothing).T[:, None] * A
    return F.reshape(d * d, n)


def ranges_of(part: Part, shape: Sequence[int]) -> list[tuple[int, int]]:
    """First node and first beyond of the ghosted array along each axis of a block of this shape;
    they go on beyond the ends of periodic axes.
    """
    begins = np.unravel_index(int(part.numbers[0]), shape, order="F")
    return [
        (int(begin) - first, int(begin) - first + size)
        for begin, first, size in zip(begins, part.patch.first, part.patch.ghosted, strict=False)
    ]


def face_of(problem: Any, part: Part, axis: int, side: int) -> Face:
    """This rank's nodes of a face."""
    nodes = problem.face_nodes(part.k, axis, side)
    mine = nodes[np.isin(nodes, part.numbers, assume_unique=True)]
    owned = part.rows(mine) if mine.size else np.empty(0, np.int64)
    ghosted = part.ghosted_rows(owned)
    last = part.patch.first[axis] + (part.patch.own[axis] - 1 if side else 0)
    weight = float(part.bands[axis].weight[last])
    across = weights_of(part, ghosted) / weight
    return Face(ghosted, owned, axis, 1.0 if side else -1.0, 1.0 / weight, across)


def weights_of(part: Part, ghosted: Array) -> Array:
    """(n,) H of nodes of the ghosted array: the product of the weights of the axes."""
    nx, ny, _ = part.patch.ghosted
    places = ghosted % nx, ghosted // nx % ny, ghosted // (nx * ny)
    product = np.ones(ghosted.size)
    for band, place in zip(part.bands, places, strict=True):
        product *= band.weight[place]
    return product


def _acts(condition: Any) -> bool:
    """Whether a condition adds to rates."""
    pressed = isinstance(condition, Free) and condition.pressure != 0.0
    heated = getattr(condition, "heat_flux", None) is not None
    return pressed or heated or isinstance(condition, (Open, Outflow, Absorbing))


def _outside(condition: Open, X: Array, t: float) -> Array:
    """(n, d + 2) density, velocity and temperature beyond an open face."""
    d = X.shape[1]
    if callable(condition.u):
        u = data(condition, "u", X, t, "uvw"[:d])
    else:
        u = np.stack([_component(condition, c, X, t) for c in range(d)], axis=-1)
    rho, T = datum(condition, "rho", X, t), datum(condition, "T", X, t)
    return np.column_stack([rho, u, T])


def _component(condition: Open, c: int, X: Array, t: float) -> Array:
    of = condition.u[c]
    if not callable(of):
        return np.full(len(X), of)
    where = f"u of Open at t = {t:.6g}"
    return checked(lambda *a: (of(*a),), (*X.T, t), X.T, "uvw"[c], where)[0]
