"""Metric terms of blocks from derivatives D_k of places: cofactors of D x on lines and planes and
of solids. Those of gases in three dimensions have the curl form, with sum_k D_k a^k = 0:

    a^i = D_j q_k - D_k q_j + P_j cross P_k,    q_k = 1/2 x cross D_k x + x cross P_k

with (i, j, k) cyclic (Thomas and Lombard, AIAA J. 17 (1979) 1030-1037). Along periodic axes only
periodic functions are differentiated: X = x + sum_k xi_k P_k, with P_k the period of axis k, or 0.

All are exact sums (fsipetsc.operators.slopes): blocks that share a face get the same bits there.
"""

from collections.abc import Sequence
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range, determinant, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.checks import Array, place_text
from fsipetsc.equations import tensors
from fsipetsc.equations.vectors import add, along, cross, sub, total
from fsipetsc.errors import InputError
from fsipetsc.kernels.kernel import PLANES, SHARED, Kernel
from fsipetsc.kernels.loops import each, pick, when, zeros
from fsipetsc.kernels.symbols import exact
from fsipetsc.operators.slopes import Stencil, axis_of, kinds, slope

#: planes from which kernels take numbers
WIDE = "{c} * W + {i}"
#: instead of the number of an axis: all of them
ALL = 3


@cache
def grid_kernel(d: int, stencil: Stencil, of: str, i: int = 0) -> Kernel:
    """The kernel that makes planes of what ``of`` names, of axis i, from places x, periods P."""
    kernel = stencil.kernel(f"{of}_{i}", f"{of.capitalize()} of nodes of a row.")
    j, k = (i + 1) % 3, (i + 2) % 3

    def D(axis: int, count: int = d, first: int = 0) -> Any:
        return slope(kernel, "x", WIDE, axis, stencil, count, first)

    def P(axis: int) -> Any:
        return kernel.read("P", SHARED, d, d * axis)

    if of == "divergence":
        found = (total(D(axis, 1, axis)[0] for axis in range(d)),)
    elif of == "potential":
        x = kernel.read("x", WIDE, 3)
        found = along(cross(x, P(i)), 0.5, cross(x, D(i)))
    elif of == "curl":
        found = add(sub(D(j, 3, 3 * k), D(k, 3, 3 * j)), P(0))
    else:
        G = total(add(D(axis), P(axis)) for axis in range(d))
        found = tensors.cofactor(G) if of == "metrics" else (tensors.determinant(G),)
    kernel.store("out", PLANES, exact(tuple(found)))
    return kernel


class Wide(SimpleNamespace):
    """A range of N nodes of a block, and the W nodes that derivatives there need; a record.

    where: the range, beyond the ends on periodic axes only, or to images before a centre. wide: it
    and, as far as there are nodes, as many more on each side as pairs reach; sizes: how many along
    three axes; axes: neighbours along the axes. range, every: (3, 2) first node and first beyond of
    both, among the wide ones. P: (d, d), the periods. y: (d, W), the periodic part of X.
    boxes: (1 + count, 3, 2) as range, of that and of its ``faces``, (axis, index along it). only:
    ALL, or the axis i of a face, whose a^i is wanted.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, faces: Sequence[Any] = ()
    ) -> None:
        block, centred, d = problem.blocks[k], problem.centred(k), problem.dimension
        self.where, self.wide, bands = [tuple(ends) for ends in where], list[Any](), []
        for axis, (begin, end) in enumerate(where):
            band, n = problem.band(k, order, axis), block.shape[axis]
            begin, end = begin - band.reach, end + band.reach
            if not block.periodic[axis]:
                begin, end = max(begin, -n if centred and axis == d - 1 else 0), min(end, n)
            self.wide.append((begin, end))
            bands.append(band.part(begin, end))
        stencil = Stencil(order // 2, max(band.reach for band in bands))
        self.kernels = [partial(grid_kernel, d, of) for of in stencil.both]
        self.every, self.range = np.tile(np.array([0, 1]), (2, 3, 1))
        for box, ends in (self.every, self.wide), (self.range, where):
            box[:d] = np.array(ends) - np.array(self.wide)[:, :1]
        self.sizes = tuple(self.every[:, 1].tolist())
        self.W, self.N = (int(np.prod(box[:, 1] - box[:, 0])) for box in (self.every, self.range))
        steps = np.cumprod(self.sizes)
        places = None, *(np.arange(n) * step for n, step in zip(self.sizes[1:], steps))
        self.axes = tuple(axis_of(band, stencil, at) for band, at in zip(bands, places))
        index = mesh([np.arange(*ends) for ends in self.wide])
        index = [i % n if closed else i for i, n, closed in zip(index, block.shape, block.periodic)]
        self.P, y = block.periods, problem.places_at(k, index).reshape(d, -1)
        for P, i, cells in zip(self.P, index, block.cells):
            y = y - np.multiply.outer(P, i.ravel() / cells)
        self.y = np.ascontiguousarray(y)
        self.only = np.array([ALL, *(axis for axis, _ in faces)])
        self.boxes = np.array([self.range] * self.only.size)
        for box, (axis, at) in zip(self.boxes[1:], faces):
            box[axis] = box[axis, 0] + at + np.array([0, 1])

    def inner(self, f: Array) -> Array:
        """The part of f (…, W) on the range, (…, N)."""
        (x0, x1), (y0, y1), (z0, z1) = self.range
        seen = f.reshape(*f.shape[:-1], *self.sizes[::-1])[..., z0:z1, y0:y1, x0:x1]
        return seen.reshape(*f.shape[:-1], -1)

    def gradients(self) -> Array:
        """D_k X (d, d, N): axis, component."""
        G, before = [], 1
        for axis, n in zip(self.axes, self.sizes):
            reach, i = axis.weights.shape[1] // 2, np.arange(n)
            u, found = self.y.reshape(len(self.P), -1, n, before), 0.0
            for m in range(reach):
                ahead, behind = (u[..., np.clip(i + k, 0, n - 1), :] - u for k in (m + 1, -1 - m))
                w = axis.weights[:, [m, reach + m], None]
                found = found + (w[:, 0] * ahead - w[:, 1] * behind)
            G.append(np.reshape(found, self.y.shape))
            before *= n
        return self.inner(np.array(G)) + self.P[..., None]

    # in procedures

    def find(self, x, a, first, end):
        """Fill planes a (d d, N) with area vectors of the boxes first … end - 1, x: (d, W)."""
        for b in each(first, end):
            self.run("metrics", x, a, self.P, box=self.boxes[b])

    def run(self, of, x, out, P, everywhere=False, box=None):
        """Run a kernel on the range, a box in it, or everywhere; x: planes of all nodes."""
        source, out = (x.reshape(-1), self.W, self.axes, self.at), out.reshape(-1)
        target = (out, self.W, self.at) if everywhere else (out, self.N, self.place)
        box = self.every if everywhere else self.range if box is None else box
        for z in each(box[2, 0], box[2, 1]):
            self.run_layer(of, 0, box, z, range(len(self.axes)), source, target, P)

    def run_layer(self, of, i, box, z, along, source, target, P):
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
                given = {"x": x[at(*node) :], "W": W, "out": out[place(*node) :], "N": N, "P": P[0]}
                for k in along:
                    given |= axes[k].given(k, node[k])
                self.kernels[kind](of, i)(n, **given)

    def at(self, x, y, z):
        """The number of a node among all."""
        return (z * self.sizes[1] + y) * self.sizes[0] + x

    def place(self, x, y, z):
        """Its number in the range."""
        (x0, x1), (y0, y1), (z0, _) = ((self.range[k, 0], self.range[k, 1]) for k in range(3))
        return ((z - z0) * (y1 - y0) + (y - y0)) * (x1 - x0) + (x - x0)


class Curls(Wide):
    """The same in three dimensions. Layers of q are found when needed; a ring of few is kept.

    of_q: (1 + count, 3, 2) boxes of the nodes whose q those of ``boxes`` need. far: layers between
    neighbours. ring: of q, the neighbours along the last axis. products: of periods, P_j cross P_k.
    """

    def __init__(self, *of_wide: Any) -> None:
        super().__init__(*of_wide)
        reach = self.axes[0].weights.shape[1] // 2 * np.array([-1, 1])
        across = np.arange(3)[:, None] != self.only[:, None, None]
        self.of_q = np.clip(self.boxes + reach * across, 0, self.every[:, 1:])
        layer, z = self.sizes[0] * self.sizes[1], np.arange(self.sizes[2])[:, None]
        steps = self.axes[2].far // layer
        self.far = int(np.abs(steps).max())
        self.slots = 2 * self.far + 1
        self.ring = self.axes[2]._replace(far=((z + steps) % self.slots - z % self.slots) * layer)
        self.q = zeros((9, self.slots * layer))
        self.products = np.array([np.cross(self.P[i - 2], self.P[i - 1]) for i in range(3)])

    def find(self, x, a, first, end):
        for b in each(first, end):
            only, box, of_q = self.only[b], self.boxes[b], self.of_q[b]
            for z in each(box[2, 0], box[2, 1]):
                next_one = pick(z == box[2, 0], z - self.far, z + self.far)
                ends = np.maximum(next_one, of_q[2, 0]), np.minimum(z + self.far + 1, of_q[2, 1])
                for layer in each(*ends):
                    for k in range(3):
                        with when(only != k):
                            self.find_potential(x, k, of_q, layer)
                for i in range(3):
                    with when((only == i) | (only == ALL)):
                        self.find_area(i, a, box, z)

    def find_potential(self, x, k, box, z):
        """Fill q_k of the rows of a layer of a box."""
        source = x[0], self.W, self.axes, self.at
        target = self.q[3 * k], self.q.shape[1], self.at_q
        self.run_layer("potential", k, box, z, (k,), source, target, self.P)

    def find_area(self, i, a, box, z):
        """Fill a^i of the rows of a layer of a box."""
        source = self.q[0], self.q.shape[1], (*self.axes[:2], self.ring), self.at_q
        along, target = ((i + 1) % 3, (i + 2) % 3), (a[3 * i], self.N, self.place)
        self.run_layer("curl", i, box, z, along, source, target, self.products[i:])

    def at_q(self, x, y, z):
        """Where a node is in the ring."""
        return self.at(x, y, z % self.slots)


def solid_metrics(problem: BlockProblem, k: int, order: int, where: Range) -> Array:
    """A^1, …, A^d and J0 of a range of nodes, (d d + 1, N). InputError if J0 <= 0,
    perhaps on this rank alone.

    J0 = det G, A^k = J0 G^-T e_k from G = D X, node by node; both times R^m around an axis (m =
    1) or a centre (2), and then R is another row, below 0 of images, which are at a centre alone.
    """
    G, X = Wide(problem, k, order, where).gradients(), problem.positions(k, where)
    J = determinant(G)
    if not J.min() > 0.0:
        i = int(np.argmin(J))
        found = f"{problem.blocks[k]}: J = {J[i]:.3g} at {place_text(X[:, i])}: expected J > 0"
        raise InputError(f"{found}: more cells, or another map", collective=False)
    metrics = np.array([*tensors.cofactor(tuple(G.reshape(-1, J.size))), J])
    if problem.symmetry:
        metrics = np.concatenate([metrics * X[-1] ** problem.symmetry, X[-1:]])
    return metrics
