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
from fsipetsc.blocks.metrics import Wide, curl_metrics
from fsipetsc.blocks.problem import Meeting
from fsipetsc.blocks.values import checked
from fsipetsc.parallel.block_layout import Part
from fsipetsc.scheme import faces
from fsipetsc.scheme.faces import Face
from fsipetsc.scheme.line_parts import AbsorbingEnd, Closed, HeatedEnd, LoadedEnd, OpenEnd

Array = NDArray[Any]


class FaceTerms:
    """Terms of the faces of one part of a block that have a condition, or interfaces with jumps.

    equations: of the block. inertia: (ghosted nodes,), J0 m0 of a solid, 1 of a gas. reference: (d,
    ghosted nodes) places X in the reference map. asked: has the data of the case.

    In three dimensions the pressure p_ref under which a solid is free of strain is no part of its
    stress: -p_ref cof F would not be at rest with a gas. Faces to gas, and those with a traction of
    their own, get p_ref n(x) instead, n in the curl form that the gas has.
    """

    def __init__(
        self,
        problem: Any,
        part: Part,
        order: int,
        equations: Any,
        inertia: Array,
        reference: Array,
        asked: Asked,
    ) -> None:
        self._part, self._equations, self._inertia = part, equations, inertia
        self._reference, self._asked, self._jumps = reference, asked, problem.jumps
        self._d, self._gas = problem.dimension, problem.blocks[part.k].kind == "fluid"
        self.p_ref = _left_out(problem.blocks[part.k])
        self._turned: dict[int, TurnedFace] = {}
        self._faces: list[tuple[Any, Face, Array]] = []
        self._acting: list[tuple[Any, Face]] = []  # with faces that have no node here
        for (axis, side), condition in problem.faces_of(part.k).items():
            interface = isinstance(condition, Meeting) and problem.is_interface(part.k, axis, side)
            supplied = interface and not self._gas and self._jumps is not None
            loaded = _unheld(condition) and self.p_ref not in (0.0, _beyond(problem, condition))
            if supplied or loaded or _acts(condition):
                face = face_of(problem, part, axis, side)
                self._acting.append((condition, face))
                if face.owned.size:
                    places = problem.places(part.k, part.numbers[face.owned])
                    self._faces.append((condition, face, places))
                    if self._d == 3 and not self._gas:
                        turned = TurnedFace(problem, part, order, axis, side)
                        self._turned[len(self._faces) - 1] = turned
        meets = [isinstance(condition, Meeting) for condition, _, _ in self._faces]
        still = all(meeting or steady(c) for (c, _, _), meeting in zip(self._faces, meets))
        self.timed = not still or (any(meets) and self._jumps is not None)

    def ask(self, t: float) -> list[dict[str, Array]]:
        """Data of all faces at time t [s]. InputError the first time."""
        key, instant = ("faces", self._part.k), t if self.timed else None
        return self._asked(key, instant, lambda: [self._data(c, X, t) for c, _, X in self._faces])

    def add(self, t: float, q: Array, metrics: Array, rates: Array, gain: Array) -> None:
        """Add all terms at time t [s] to ``rates`` (owned, dof) and ``gain`` (d + 2,); q: (ghosted,
        dof).
        """
        pairs = zip(self._faces, self.ask(t), strict=True)
        for number, ((_, face, _), found) in enumerate(pairs):
            if "outside" in found:
                arguments = found["outside"], found["pressure"], rates, gain
                faces.open_face(self._equations.law, face, q, metrics, *arguments)
            if not self._gas:
                forces = self._forces(number, found, q, metrics)
                faces.push_face(face, forces, q, self._inertia, rates, gain)
            if "heat" in found:
                heat = found["heat"] * self._areas(face, metrics)
                column = rates.shape[1] - 1
                faces.heat_face(face, heat, self._inertia, rates, column, gain)

    def line(self, nodes: int) -> list[Any]:
        """What is at both ends in one dimension, for fsipetsc.scheme.line_parts, once `refresh`
        has filled it; the same records on all ranks of the block, for numba compiles for them.
        nodes: of the ghosted array.
        """
        self._ends: list[Any] = [Closed(), Closed()]
        for condition, face in self._acting:
            heat = np.zeros(face.owned.size)
            forces, stress, outside = heat[:, None].copy(), heat.copy(), np.zeros((heat.size, 3))
            if not self._gas and isinstance(condition, Absorbing):
                band = self._part.bands[0]
                of_band = band.S, band.weight, np.zeros((1, nodes))
                end: Any = AbsorbingEnd(face, forces, heat, stress, *of_band)
            elif not self._gas:
                end = LoadedEnd(face, forces, heat)
            elif isinstance(condition, (Open, Outflow)):
                end = OpenEnd(face, outside, stress)
            else:
                end = HeatedEnd(face, heat)
            self._ends[int(face.sign > 0.0)] = end
        return self._ends

    def refresh(self, t: float, metrics: Array) -> None:
        """Fill the arrays of the ends with data at time t [s]."""
        for (_, face, _), found in zip(self._faces, self.ask(t), strict=True):
            end, area = self._ends[int(face.sign > 0.0)], self._areas(face, metrics)
            if "outside" in found:
                end.outside[:], end.pressure[:] = found["outside"], found["pressure"]
            if "stress" in found:
                end.stress[:] = found["stress"]
            if not self._gas:
                forces = found.get("traction", 0.0 * end.forces) * area[:, None]
                pressure = np.broadcast_to(found.get("pressure", 0.0), area.shape)
                end.forces[:] = forces - face.sign * pressure[:, None]
            if "heat" in found:
                end.heat[:] = found["heat"] * area

    def _data(self, condition: Any, X: Array, t: float) -> dict[str, Array]:
        """What a face is given."""
        d, found = self._d, {}
        if isinstance(condition, Meeting):
            names = *(f"traction along {x}" for x in "xyz"[:d]), "heat"
            if self._jumps is None:
                return {}
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
        self, number: int, found: dict[str, Array], q: Array, metrics: Array
    ) -> Array:
        """(n, d) on a face of a solid."""
        condition, face, _ = self._faces[number]
        forces = np.zeros((face.ghosted.size, self._d))
        if "traction" in found:
            forces += found["traction"] * self._areas(face, metrics)[:, None]
        if "stress" in found:
            F = strain(self._part, face.ghosted, metrics, q)
            arguments = F, found["stress"], q, metrics, forces
            faces.absorb(self._equations, (0.0,) * self._d, face, *arguments)
        pressure = found.get("pressure", 0.0) - self.p_ref * _unheld(condition)
        if np.any(pressure):
            if self._d == 3:
                normals = self._turned[number](q)
            else:
                axes = [axis for axis in range(self._d) if axis != face.axis]
                nodes, X = face.ghosted, self._reference
                tangents = [slope(self._part, axis, nodes, q, X) for axis in axes]
                normals = faces.area_vectors(face, tangents)
            forces -= np.broadcast_to(pressure, len(normals))[:, None] * normals
        return forces


class TurnedFace:
    """Area vectors of a rank's nodes of a solid's face in three dimensions, where it is now: in the
    curl form, with derivatives within the face only, and the bits that a gas there has.
    """

    def __init__(self, problem: Any, part: Part, order: int, axis: int, side: int) -> None:
        shape = problem.blocks[part.k].shape
        ghosted = ranges_of(part, shape)
        sizes = zip(ghosted, part.patch.first, part.patch.own, strict=True)
        where = [(begin + first, begin + first + own) for (begin, _), first, own in sizes]
        where[axis] = (shape[axis] - 1, shape[axis]) if side else (0, 1)
        self._axis, self._sign = axis, 1.0 if side else -1.0
        self._wide = wide = Wide(problem, part.k, order, where)
        index = [
            np.clip(np.arange(*ends) - begin, 0, end - begin - 1)
            for ends, (begin, end) in zip(wide.wide, ghosted, strict=True)
        ]
        nx, ny, _ = part.patch.ghosted
        x, y, z = np.meshgrid(*index, indexing="ij")
        self._at = (x + nx * (y + ny * z)).ravel(order="F")
        n = self._at.size
        self._a, self._slopes, self._scratch = (np.empty((3, 3, n)) for _ in range(3))

    def __call__(self, q: Array) -> Array:
        """(n, 3) outward; q: (ghosted, 7)."""
        wide = self._wide
        y = wide.y + q[self._at, :3].T
        scratch = self._scratch.reshape(9, -1)[:4]
        curl_metrics(self._a, y, wide.P, wide.S, wide.weight, self._slopes, scratch)
        return self._sign * wide.inner(self._a[self._axis]).T


def _left_out(block: Any) -> float:
    """p_ref where it is no part of the stress."""
    solid = block.kind == "solid" and isinstance(block.material.law, str)
    return block.material.p_ref if solid and block.dimension == 3 else 0.0


def _unheld(condition: Any) -> bool:
    """Whether the traction on a face is not that of a clamp or a roller."""
    return isinstance(condition, (Meeting, Free, Absorbing))


def _beyond(problem: Any, condition: Any) -> float:
    """p_ref of what a face meets."""
    if isinstance(condition, Meeting):
        return _left_out(problem.blocks[condition.block])
    return 0.0


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
