"""What passes the faces of this rank's parts of blocks: lists of nodes and data for fsipetsc.scheme.faces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blockrun.prescribed import timed, value
from fsipetsc.blocks.conditions import Free, Open, Outflow
from fsipetsc.parallel.block_layout import Part
from fsipetsc.scheme import faces
from fsipetsc.scheme.faces import Face

Array = NDArray[Any]


class FaceTerms:
    """Terms of the faces with a condition of one part of a block.

    inertia: (ghosted nodes,), J0 m0 of a solid, 1 of a gas. Functions of the case are asked at each time.
    """

    def __init__(self, problem: Any, part: Part, inertia: Array, reference: Array | None = None) -> None:
        """reference: (d, ghosted nodes) places X in the reference map; of a solid."""
        self._part, self._inertia, self._reference = part, inertia, reference
        self._block = problem.blocks[part.k]
        self._faces: list[tuple[Any, Face, Array]] = []
        for (axis, side), condition in problem.faces_of(part.k).items():
            if isinstance(condition, (Open, Outflow)) or _loads(condition) or _heats(condition):
                face = face_of(problem, part, axis, side)
                places = problem.places(part.k, part.numbers[face.owned]) if face.owned.size else np.empty((0, 1))
                self._faces.append((condition, face, places))
        self.timed = any(timed(condition) for condition, _, _ in self._faces)

    def add(self, t: float, gas_law: Any, q: Array, metrics: Array, rates: Array) -> None:
        """Add all terms at time t [s] to ``rates`` (owned, dof); q: (ghosted, dof)."""
        d = self._block.dimension
        for condition, face, X in self._faces:
            if not face.owned.size:
                continue
            if isinstance(condition, (Open, Outflow)):
                outside, pressure = _beyond(condition, X, t)
                faces.open_face(gas_law, face, q, metrics, outside, pressure, rates)
            if _loads(condition):
                pressure = value(condition.pressure, X, t)
                normals = self._area_vectors(face, q)
                faces.load_face(face, normals, pressure, q, self._inertia, rates)
            if _heats(condition):
                areas = np.sqrt(sum(metrics[face.axis * d + c, face.ghosted] ** 2 for c in range(d)))
                column = d + 2 if self._block.kind == "fluid" else 2 * d
                flux = value(condition.heat_flux, X, t)
                faces.heat_face(face, areas, flux, self._inertia, rates, column)

    def _area_vectors(self, face: Face, q: Array) -> Array:
        """(n, d) area vectors of a solid's face where it is now, outward."""
        return faces.area_vectors(face, self._part.patch.ghosted, self._part.bands, self._reference, q)


def ranges_of(part: Part, shape: Sequence[int]) -> list[tuple[int, int]]:
    """First node and first beyond of the ghosted array along each axis of a block of this shape; they go on beyond the ends
    of periodic axes.
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
    return Face(ghosted, owned, axis, 1.0 if side else -1.0, 1.0 / weight)


def _loads(condition: Any) -> bool:
    pressure = getattr(condition, "pressure", 0.0)
    return isinstance(condition, Free) and (callable(pressure) or pressure != 0.0)


def _heats(condition: Any) -> bool:
    return getattr(condition, "heat_flux", None) is not None


def _beyond(condition: Any, X: Array, t: float) -> tuple[Array, float]:
    """(n, d + 2) density, velocity and temperature beyond an open face, and the pressure beyond an outflow."""
    if isinstance(condition, Outflow):
        pressure = condition.pressure
        return np.empty((len(X), X.shape[1] + 2)), float(pressure(*X.T, t) if callable(pressure) else pressure)
    u: Sequence[Any] = condition.u(*X.T, t) if callable(condition.u) else condition.u
    velocity = [value(c, X, t) for c in u]
    return np.stack([value(condition.rho, X, t), *velocity, value(condition.T, X, t)], axis=-1), -1.0

