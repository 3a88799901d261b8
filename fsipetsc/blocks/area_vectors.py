"""Area vectors of grids that move, and det D x, from places: what procedures find by derivatives.

On a line and on a plane the area vectors are the cofactors of D x. In three dimensions they have
the curl form, with sum_k D_k a^k = 0:

    a^i = D_j q_k - D_k q_j + P_j cross P_k,    q_k = 1/2 x cross D_k x + x cross P_k

with (i, j, k) cyclic, x the places less those of linear maps, and P_k the period of axis k, or 0
(Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). They are exact sums (fsipetsc.operators.slopes):
blocks that share a face get the same bits for what lies within it, whichever way their axes run.
"""

from collections.abc import Sequence
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.metrics import Wide
from fsipetsc.equations.tensors import cofactor, determinant
from fsipetsc.equations.vectors import add, along, cross, sub, total
from fsipetsc.kernels.arrays import zeros
from fsipetsc.kernels.kernel import PLANES, SHARED, Kernel
from fsipetsc.kernels.loops import each, pick, when
from fsipetsc.kernels.symbols import exact
from fsipetsc.operators.slopes import Near, axis_of, kinds, slope

#: planes from which kernels take numbers
WIDE = "{c} * W + {i}"
#: instead of the number of an axis: all of them
ALL = 3


@cache
def grid_kernels(d: int, near: Near) -> dict[str, tuple[Kernel, Kernel]]:
    """The kernels of grids in d dimensions, of any nodes and of nodes inside. Of planes x and of
    periods P they make planes out.
    """

    def gradients(kernel: Kernel, D: Any) -> Any:
        P = (kernel.read("P", SHARED, d, d * k) for k in range(d))
        return total(add(D(k, d), of) for k, of in enumerate(P))

    def potential(k: int, kernel: Kernel, D: Any) -> Any:
        x, P = kernel.read("x", WIDE, 3), kernel.read("P", SHARED, 3, 3 * k)
        return along(cross(x, P), 0.5, cross(x, D(k, 3)))

    def curl(i: int, kernel: Kernel, D: Any) -> Any:
        j, k = (i + 1) % 3, (i + 2) % 3
        return add(sub(D(j, 3, 3 * k), D(k, 3, 3 * j)), kernel.read("P", SHARED, 3))

    made: dict[str, Any] = {"volume": lambda *of: (determinant(gradients(*of)),)}
    if d < 3:
        made["metrics"] = lambda *of: cofactor(gradients(*of))  # of D x
        made["divergence"] = lambda kernel, D: (total(D(k, 1, k)[0] for k in range(d)),)
    for k in range(3) if d == 3 else ():
        made[f"potential_{k}"], made[f"curl_{k}"] = partial(potential, k), partial(curl, k)
    any_node = 0, near[1]
    return {
        name: (_kernel(name, any_node, of), _kernel(f"{name}_inside", near, of))
        for name, of in made.items()
    }


def _kernel(name: str, near: Near, formula: Any) -> Kernel:
    """formula(kernel, D): what is stored, D(axis, count, first) the derivatives of so many x."""
    kernel = Kernel(name, "Of the nodes of a row, see fsipetsc.blocks.area_vectors.")

    def D(axis: int, count: int, first: int = 0) -> Any:
        return slope(kernel, "x", WIDE, axis, near, count, first)

    kernel.store("out", PLANES, exact(tuple(formula(kernel, D))))
    return kernel


class Rows(SimpleNamespace):
    """A range of N nodes of a Wide, of which a kernel is run row by row. sizes: W nodes of the Wide
    along three axes; range: of each axis first node and first beyond among these; axes: the
    neighbours along the axes. P: the periods.
    """

    def __init__(self, wide: Wide, where: Range) -> None:
        self.sizes, more = (*wide.sizes, 1, 1)[:3], 3 - len(where)
        self.W = int(np.prod(self.sizes))
        begins, last = [begin for begin, _ in wide.wide], np.cumprod(self.sizes)
        places = [None, *(np.arange(n) * step for n, step in zip(self.sizes[1:], last))]
        every = zip(wide.bands, places, strict=False)
        self.axes = tuple(axis_of(band, wide.near, at) for band, at in every)
        ends = [(a - begin, b - begin) for (a, b), begin in zip(where, begins)]
        self.range, self.P = np.array(ends + [(0, 1)] * more), np.ascontiguousarray(wide.P)
        self.nodes = int(np.prod(self.range[:, 1] - self.range[:, 0]))
        self.kernels = grid_kernels(len(where), wide.near)

    def run(self, name, x, out, P):
        """Run a kernel on the range. x: planes of the Wide, out: of the range, P: periods."""
        source = x.reshape(-1), self.W, self.axes, self.at
        target = out.reshape(-1), self.nodes, self.place
        for z in each(self.range[2, 0], self.range[2, 1]):
            self.run_layer(name, self.range, z, range(len(self.axes)), source, target, P[0])

    def run_layer(self, name, box, z, along, source, target, P):
        """Run a kernel on the rows of a layer of a box. source: planes, how far they are apart, the
        neighbours there, and at(x, y, z), where a node is; target: the same without neighbours.
        along: the axes along which it takes derivatives.
        """
        (x, W, axes, at), (out, N, place) = source, target
        inside = [axes[k].inside if k in along else None for k in range(3)]
        inside[0] = inside[0] or (0, self.sizes[0])
        for y in each(box[1, 0], box[1, 1]):
            first, last = box[0, 0], box[0, 1]
            for begin, n, kind in kinds(first, last - first, y, z, inside):
                node = begin, y, z
                given = {"x": x[at(*node) :], "W": W, "out": out[place(*node) :], "N": N, "P": P}
                for k in along:
                    given |= axes[k].given(k, node[k])
                self.kernels[name][kind](n, **given)

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
        self.q = zeros((9, self.slots * in_layer))
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
        source = x[0], self.W, self.axes, self.at
        target = self.q[3 * k], self.q.shape[1], self.at_q
        self.run_layer(f"potential_{k}", box, z, (k,), source, target, self.P[0])

    def find_area(self, i, a, box, z):
        """Fill a^i of the rows of a layer of a box."""
        source = self.q[0], self.q.shape[1], (*self.axes[:2], self.ring), self.at_q
        along, target = ((i + 1) % 3, (i + 2) % 3), (a[3 * i], self.nodes, self.place)
        self.run_layer(f"curl_{i}", box, z, along, source, target, self.of_periods[i])

    def at_q(self, x, y, z):
        """Where a node is in the ring."""
        return self.at(x, y, z % self.slots)
