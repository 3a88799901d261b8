"""What passes the faces of this rank's parts of blocks: lists of nodes and their data, for
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
from fsipetsc.scheme.faces import Closed, GasFaces, SolidFaces

Array = NDArray[Any]


class FaceTerms:
    """Terms of the faces of one part of a block that have a condition, or interfaces with jumps.

    X: (d, ghosted nodes) places in the reference map. asked: has the data of the case. record: for
    compiled code, once `refresh` has filled it. timed: data depend on time.

    In three dimensions, and around an axis or a centre, the pressure p_ref under which a solid is
    free of strain is no part of its stress: -p_ref cof F would not be at rest with a gas. Faces to
    gas, and those with a traction of their own, get p_ref n(x) instead; in three dimensions n is in
    the curl form that the gas has, which `turn` finds.
    """

    def __init__(self, problem: Any, part: Part, order: int, X: Array, asked: Asked) -> None:
        self._part, self._asked, self._jumps = part, asked, problem.jumps
        self._d, self._gas = problem.dimension, problem.blocks[part.k].kind == "fluid"
        self.p_ref = _left_out(problem, part.k)
        self._turned: list[tuple[slice, TurnedFace]] = []
        self._faces: list[tuple[Any, Array, slice]] = []
        lengths: list[float] = []
        acts, listed, count = False, [_nodes_of(part, np.empty(0, np.int64), 0, 0)], 0
        for (axis, side), condition in problem.faces_of(part.k).items():
            interface = isinstance(condition, Meeting) and problem.is_interface(part.k, axis, side)
            supplied = interface and not self._gas and self._jumps is not None
            loaded = _unheld(condition) and self.p_ref not in (0.0, _beyond(problem, condition))
            if not (supplied or loaded or _acts(condition)):
                continue
            acts = True  # on all ranks of the block, for these compile the same
            listed.append(_nodes_of(part, problem.face_nodes(part.k, axis, side), axis, side))
            own = listed[-1][1]
            where, count = slice(count, count + own.size), count + own.size
            if own.size:
                self._faces.append((condition, problem.places(part.k, part.numbers[own]), where))
                lengths.append(_length(problem.blocks[part.k], axis))
            if own.size and self._d == 3 and not self._gas:
                self._turned.append((where, TurnedFace(problem, part, order, axis, side)))
        nodes = [np.concatenate(values) for values in zip(*listed, strict=True)]
        self.record = self._record(nodes, X) if acts else Closed()
        for k, (condition, _, where) in enumerate(self._faces):
            if isinstance(condition, Open) and condition.order == 1:
                self.record.width[where] = lengths[k]
        meets = [isinstance(condition, Meeting) for condition, _, _ in self._faces]
        still = all(meeting or steady(c) for (c, _, _), meeting in zip(self._faces, meets))
        self.timed = not still or (any(meets) and self._jumps is not None)

    def _record(self, nodes: list[Array], X: Array) -> Any:
        """Memory for the data of the nodes."""
        n, d = nodes[0].size, self._d
        flags, (a, b, c) = np.zeros(n, np.int64), np.zeros((3, n))
        if self._gas:
            return GasFaces(*nodes, flags, np.zeros((n, d + 2)), a, b, c)
        return SolidFaces(*nodes, flags, np.zeros((n, d)), a, b, c, np.zeros((n, d)), X)

    def ask(self, t: float) -> list[dict[str, Array]]:
        """Data of all faces at time t [s]. InputError the first time."""
        key, instant = ("faces", self._part.k), t if self.timed else None
        return self._asked(key, instant, lambda: [self._data(c, X, t) for c, X, _ in self._faces])

    def refresh(self, t: float) -> None:
        """Fill the record with data at time t [s]."""
        record = self.record
        for (condition, _, at), found in zip(self._faces, self.ask(t), strict=True):
            record.heat[at] = found.get("heat", 0.0)
            record.pressure[at] = found.get("pressure", 0.0)
            if self._gas:
                record.opens[at] = "outside" in found
                record.outside[at] = found.get("outside", 0.0)
                continue
            record.pressure[at] -= self.p_ref * _unheld(condition)
            record.traction[at] = found.get("traction", 0.0)
            record.absorbs[at] = "stress" in found
            record.stress[at] = found.get("stress", 0.0)

    def turn(self, q: Array) -> None:
        """Area vectors of a solid's faces where it is now, in three dimensions; q: (ghosted, 7)."""
        for at, face in self._turned:
            self.record.normal[at] = face(q)

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


def _length(block: Any, axis: int) -> float:
    """Mean length of a block along an axis [m]."""
    low, high = (block.face_positions(axis, side) for side in (0, 1))
    return float(np.linalg.norm(high - low, axis=0).mean())


def _left_out(problem: Any, k: int) -> float:
    """p_ref of a block where it is no part of the stress."""
    block = problem.blocks[k]
    solid = block.kind == "solid" and isinstance(block.material.law, str)
    return block.material.p_ref if solid and (block.dimension == 3 or problem.symmetry) else 0.0


def _unheld(condition: Any) -> bool:
    """Whether the traction on a face is not that of a clamp or a roller."""
    return isinstance(condition, (Meeting, Free, Absorbing))


def _beyond(problem: Any, condition: Any) -> float:
    """p_ref of what a face meets."""
    if isinstance(condition, Meeting):
        return _left_out(problem, condition.block)
    return 0.0


def ranges_of(part: Part, shape: Sequence[int]) -> list[tuple[int, int]]:
    """First node and first beyond of the ghosted array along each axis of a block of this shape;
    they go on beyond the ends of periodic axes.
    """
    begins = np.unravel_index(int(part.numbers[0]), shape, order="F")
    return [
        (int(begin) - first, int(begin) - first + size)
        for begin, first, size in zip(begins, part.patch.first, part.patch.ghosted, strict=False)
    ]


def _nodes_of(part: Part, nodes: Array, axis: int, side: int) -> tuple[Array, ...]:
    """This rank's nodes of those of a face: numbers in the ghosted array and among the owned ones,
    axis, sign, 1 / weight of the axis, product of the other weights.
    """
    mine = nodes[np.isin(nodes, part.numbers, assume_unique=True)]
    own = part.rows(mine) if mine.size else np.empty(0, np.int64)
    at = part.ghosted_rows(own)
    last = part.patch.first[axis] + (part.patch.own[axis] - 1 if side else 0)
    weight, ones = float(part.bands[axis].weight[last]), np.ones(own.size)
    signs = ones if side else -ones
    return at, own, np.full(own.size, axis), signs, ones / weight, weights_of(part, at) / weight


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
