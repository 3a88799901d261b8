"""Area vectors of grids that move, and det D x, from places: what procedures find by derivatives.

On a line and on a plane the area vectors are the cofactors of D x. In three dimensions they have
the curl form, with sum_k D_k a^k = 0:

    a^i = D_j q_k - D_k q_j + P_j cross P_k,    q_k = 1/2 x cross D_k x + x cross P_k

with (i, j, k) cyclic, x the places less those of linear maps, and P_k the period of axis k, or 0
(Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). They are exact sums (fsipetsc.operators.slopes):
blocks that share a face get the same bits for what lies within it, whichever way their axes run.
"""

from collections.abc import Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.metrics import Wide
from fsipetsc.equations.tensors import cofactor, determinant
from fsipetsc.equations.vectors import add, along, cross, sub, total
from fsipetsc.kernels.arrays import aligned
from fsipetsc.kernels.kernel import PLANES, SHARED, Kernel
from fsipetsc.kernels.loops import each, pick, when
from fsipetsc.kernels.symbols import exact
from fsipetsc.operators.slopes import Near, axis_of, kinds, slope

#: planes of places, and of q in the layers that are kept
WIDE, RING = "{c} * W + {i}", "{c} * Q + {i}"
#: instead of the number of an axis: all of them
ALL = 3


@cache
def grid_kernels(d: int, near: Near) -> SimpleNamespace:
    """The kernels of grids in d dimensions: of any nodes, then of nodes inside."""
    both = (0, near[1]), near
    volumes, axes = tuple(_volume(d, of) for of in both), range(3)
    if d < 3:
        return SimpleNamespace(
            volumes=volumes,
            metrics=tuple(_metrics(d, of) for of in both),
            divergences=tuple(_divergence(d, of) for of in both),
        )
    return SimpleNamespace(
        volumes=volumes,
        potentials=tuple(_potential(k, of) for k in axes for of in both),
        curls=tuple(_curl(k, of) for k in axes for of in both),
    )


def _kernel(name: str, near: Near, says: str) -> Kernel:
    return Kernel(name + "_inside" * (near[0] > 0), f"{says} of nodes of a row.")


def _gradients(kernel: Kernel, d: int, near: Near) -> Any:
    """D_k x and the periods, axis by axis."""
    P = (kernel.read("P", SHARED, d, d * k) for k in range(d))
    return total(add(slope(kernel, "x", WIDE, k, near, d), of) for k, of in enumerate(P))


def _volume(d: int, near: Near) -> Kernel:
    kernel = _kernel("volume", near, "det D x")
    kernel.store("out", PLANES, (exact(determinant(_gradients(kernel, d, near))),))
    return kernel


def _metrics(d: int, near: Near) -> Kernel:
    kernel = _kernel("metrics", near, "Cofactors of D x")
    kernel.store("out", PLANES, exact(cofactor(_gradients(kernel, d, near))))
    return kernel


def _divergence(d: int, near: Near) -> Kernel:
    kernel = _kernel("divergence", near, "sum_k D_k x_k")
    every = total(slope(kernel, "x", WIDE, k, near, 1, k) for k in range(d))
    kernel.store("out", PLANES, (exact(total(every)),))
    return kernel


def _potential(k: int, near: Near) -> Kernel:
    kernel = _kernel(f"potential_{k}", near, "q_k")
    x, D = kernel.read("x", WIDE, 3), slope(kernel, "x", WIDE, k, near, 3)
    of_period = cross(x, kernel.read("P", SHARED, 3, 3 * k))
    kernel.store("q", RING, exact(along(of_period, 0.5, cross(x, D))), 3 * k)
    return kernel


def _curl(i: int, near: Near) -> Kernel:
    kernel = _kernel(f"curl_{i}", near, "a^i")
    j, k = (i + 1) % 3, (i + 2) % 3
    ahead, behind = (slope(kernel, "q", RING, m, near, 3, 3 * n) for m, n in ((j, k), (k, j)))
    found = add(sub(ahead, behind), kernel.read("of_periods", SHARED, 3, 3 * i))
    kernel.store("a", PLANES, exact(found), 3 * i)
    return kernel


class Rows(SimpleNamespace):
    """A range of N nodes of a Wide, of which a kernel is run row by row. sizes: W nodes of the Wide
    along three axes; range: of each axis first node and first beyond among these; axes: the
    neighbours along the axes. P: the periods.
    """

    def __init__(self, wide: Wide, where: Range) -> None:
        self.sizes, more = (*wide.sizes, 1, 1)[:3], 3 - len(where)
        begins, last = [begin for begin, _ in wide.wide], np.cumprod(self.sizes)
        places = [None, *(np.arange(n) * step for n, step in zip(self.sizes[1:], last))]
        every = zip(wide.bands, places, strict=False)
        self.axes = tuple(axis_of(band, wide.near, at) for band, at in every)
        ends = [(a - begin, b - begin) for (a, b), begin in zip(where, begins)]
        self.range, self.P = np.array(ends + [(0, 1)] * more), np.ascontiguousarray(wide.P)
        self.nodes = int(np.prod(self.range[:, 1] - self.range[:, 0]))
        self.kernels = grid_kernels(len(where), wide.near)

    def run(self, kernels, x, out, P):
        """Run a kernel on the range. x: planes of the Wide, out: of the range."""
        x, out = x.reshape(-1), out.reshape(-1)
        for z in each(self.range[2, 0], self.range[2, 1]):
            for at, n, kind, given in self.parts(self.range, z, self.axes, range(len(self.axes))):
                given |= {"x": x[self.at(*at) :], "out": out[self.place(*at) :], "P": P[0]}
                kernels[kind](n, **given)

    def parts(self, box, z, axes, along):
        """Yield parts of the rows of a layer of a box: first node, how many, 1 where they are
        inside along some axes, else 0, and what kernels take of these.
        """
        inside = [axes[k].inside if k in along else None for k in range(3)]
        inside[0] = inside[0] or (0, self.sizes[0])
        W = self.sizes[0] * self.sizes[1] * self.sizes[2]
        for y in each(box[1, 0], box[1, 1]):
            x = box[0, 0]
            for begin, n, kind in kinds(x, box[0, 1] - x, y, z, inside):
                at, given = (begin, y, z), {"W": W, "N": self.nodes}
                for k in along:
                    given |= axes[k].given(k, at[k])
                yield at, n, kind, given

    def at(self, x, y, z):
        """The number of a node of the Wide."""
        return (z * self.sizes[1] + y) * self.sizes[0] + x

    def place(self, x, y, z):
        """Its number in the range."""
        (x0, x1), (y0, y1), (z0, _) = ((self.range[k, 0], self.range[k, 1]) for k in range(3))
        return ((z - z0) * (y1 - y0) + (y - y0)) * (x1 - x0) + (x - x0)


class Curls(Rows):
    """The same in three dimensions. Layers of q are found when they are needed, and few are kept,
    in a ring.

    boxes: (1 + count, 2, 3, 2) first node and first beyond, among the wide ones, of nodes whose
    area vectors are wanted, and of those whose q these need: first of the range, then of its
    ``faces``, (axis, index along it). only: ALL, or the axis i of a face, whose a^i is wanted.
    layers: (2, n) of each layer, the first one whose q is found before it, and the first beyond.
    ring: of q, the neighbours along the last axis.
    """

    def __init__(self, wide: Wide, faces: Sequence[Any] = ()) -> None:
        super().__init__(wide, wide.where)
        n, layers, in_layer = self.sizes, np.arange(self.sizes[2]), self.sizes[0] * self.sizes[1]
        reach = np.array([band.reach for band in wide.bands])[:, None] * [-1, 1]
        boxes, self.only = [], np.array([ALL, *(axis for axis, _ in faces)])
        for axis, at in ((ALL, 0), *faces):
            box, but = self.range.copy(), np.arange(3)[:, None] != axis
            if axis != ALL:
                box[axis] = box[axis, 0] + at + np.array([0, 1])
            boxes.append((box, np.clip(box + reach * but, 0, np.array(n)[:, None])))
        self.boxes = np.array(boxes)
        begin, end = self.range[2]
        to = layers[:, None] + self.axes[2].far // in_layer
        last, first = np.maximum.accumulate(to.max(axis=1)[begin:end]), to.min(axis=1)[begin:end]
        first = np.minimum.accumulate(first[::-1])[::-1]
        self.layers = np.zeros((2, n[2]), np.int64)
        self.layers[:, begin:end] = [first[0], *(last[:-1] + 1)], last + 1
        self.slots = int((last - first).max()) + 1
        self.ring = axis_of(wide.bands[2], wide.near, layers % self.slots * in_layer)
        self.q = aligned(9 * self.slots * in_layer).reshape(9, -1)
        self.of_periods = np.array([np.cross(wide.P[i - 2], wide.P[i - 1]) for i in range(3)])

    def find(self, x, a, first, end):
        """Fill planes a (9, N) with area vectors of the boxes first … end - 1, x: (3, wide)."""
        for b in each(first, end):
            only, box, of_q = self.only[b], self.boxes[b, 0], self.boxes[b, 1]
            for z in each(box[2, 0], box[2, 1]):
                ends = (pick(only == 2, z + m, self.layers[m, z]) for m in range(2))
                for layer in each(*ends):
                    for k in range(2):
                        with when(only != k):
                            self.find_potential(x, k, of_q, layer)
                with when(only != 2):
                    self.find_potential(x, 2, of_q, z)
                for i in range(3):
                    with when((only == i) | (only == ALL)):
                        self.find_area(i, a, box, z)

    def find_potential(self, x, k, box, z):
        """Fill q_k of the rows of a layer of a box."""
        for at, n, kind, given in self.parts(box, z, self.axes, (k,)):
            given |= {"x": x[0, self.at(*at) :], "q": self.q[0, self.at_q(*at) :], "P": self.P[0]}
            self.kernels.potentials[2 * k + kind](n, Q=self.q.shape[1], **given)

    def find_area(self, i, a, box, z):
        """Fill a^i of the rows of a layer of a box."""
        of_q, along = (*self.axes[:2], self.ring), ((i + 1) % 3, (i + 2) % 3)
        for at, n, kind, given in self.parts(box, z, of_q, along):
            given |= {"q": self.q[0, self.at_q(*at) :], "a": a[0, self.place(*at) :]}
            given |= {"Q": self.q.shape[1], "of_periods": self.of_periods[0]}
            self.kernels.curls[2 * i + kind](n, **given)

    def at_q(self, x, y, z):
        """Where a node is in the ring."""
        return self.at(x, y, z % self.slots)
