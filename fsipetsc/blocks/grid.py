"""The grid of a gas block: x = X + the displacements of its faces, blended: Gordon and Hall, Int.
J. Numer. Meth. Eng. 7 (1973) 461-477. Its velocity is the same blend of the faces' velocities.

Nodes on faces whose displacement is known, at solids and at walls that move, have it. Any other
face is blended from its edges, edges are linear between their vertices, and vertices that are not
known do not move. Along periodic axes there are no faces. A face at r = 0 is none, either: what
lies between it and the opposite one follows this alone.

Inside is the Boolean sum of the faces: axis after axis, what is missing at the two faces is added,
with the weights of the ends between them. On faces their values, to the bit.

Around an axis (m = 1) or a centre (2) it is a flat grid of (z, s), s = |r|^m r/(m + 1), as ds =
r^m dr; r is the last coordinate. With A = |r|^m, the velocity v of the grid, and SBP D_k,

    b^k, J    metrics and Jacobian of (z, s): J = D s in one dimension, D_1 z D_2 s - D_1 s D_2 z
    a^k       = (b^k_1, A b^k_2), the area vectors
    J_t       = sum_k b^k . D_k w,    w = (v_1, A v_2) = d(z, s)/dt,    exactly that of J
    source S  = sum_k D_k a^k_2;  sum_k D_k a^k_1 = 0

A pressure p that is the same everywhere gives p S to the momentum along r; so much is added again
(fsipetsc.scheme.gas_sweep). J_t is what two-point fluxes let through a node that moves (radial Gas
of fsipetsc.equations.gas). Beside an axis, where A has a kink, D along r has weights of its own
(AXIS of fsipetsc.operators.sbp).
"""

from itertools import combinations, product
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Block, Range, mesh
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.metrics import Curls, Wide
from fsipetsc.checks import Array
from fsipetsc.kernels.loops import Known, column, each, number, pick, zeros
from fsipetsc.kernels.symbols import exact


class Grid(SimpleNamespace):
    """The motion of a range of N nodes of gas block k, on a line or a plane; a record for
    procedures. The W nodes of ``wide`` are those that derivatives reach.

    nodes: (M,) those on faces of the whole block whose displacement and velocity will be given.
    faces: of the range, (axis, index along it), those at constraints.

    metrics: (d d + d, N), a^1 … a^d and the velocity of the grid; around an axis or a centre A is
    one more row. Procedures get known: (M, 2d) displacements [m] and velocities [m/s] of the given
    nodes. x: (d, W) places less those of linear maps, flat: what is differentiated; volume: (N,)
    det D x, by `find_volumes`.
    """

    def __init__(
        self, problem: BlockProblem, k: int, order: int, where: Range, nodes: Array, faces: Any
    ) -> None:
        block, centred, d = problem.blocks[k], problem.centred(k), problem.dimension
        self.d, self.hoops = Known(d), Known(problem.symmetry)
        self.wide: Any = (Curls if d == 3 else Wide)(problem, k, order, where, faces)
        self.blend = Blend(block, self.wide, nodes, centred)
        self.x = self.flat = zeros(self.wide.y.shape)
        self.volume = np.zeros(self.wide.N)
        self.metrics = zeros((d * d + d + (problem.symmetry > 0), self.wide.N))

    def edge(self, known):
        """Find where the grid's faces are, and a^k on those at constraints."""
        self.blend.complete(self.blend.moved, known, 0)
        self.find_faces(self.x, self.blend.moved, self.wide.y, self.metrics)

    def find_faces(self, x, values, base, areas, sign=1.0):
        """Put values of the hull, added to a base, on faces of x, and find a^k there."""
        for c in range(self.d):
            put_on_faces(x[c], self.blend.every.faces, values[c], base[c], sign)
        self.wide.find(x, areas, 1, self.wide.only.size)

    def place(self):
        self.blend.fill(self.blend.moved, self.x, self.blend.every, self.wide.y)

    def move(self):
        """Find where the grid is and a^k, after `edge`."""
        self.place()
        self.wide.find(self.x, self.metrics, 0, 1)

    def swing(self, known):
        """Fill the velocity, after `edge` and `move`."""
        self.blend.complete(self.blend.moving, known, self.d)
        self.blend.fill(self.blend.moving, self.metrics[self.d * self.d :], self.blend.inner)

    def find_places(self, X, places):
        """Find where nodes are (d, N), after `move`; X: those of the reference map."""
        self.blend.fill(self.blend.moved, places, self.blend.inner, X)

    def find_volumes(self):
        """Find det D x, after `move`."""
        self.wide.run("volume", self.flat, self.volume, self.wide.P)


class Cube(Grid):
    """A grid in three dimensions. moved: (3, W), ahead, back: (9, N) a^k on faces at constraints if
    nodes go on with their velocity for 1 s, and where they were 1 s before.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.moved = zeros(self.x.shape)
        self.ahead, self.back = self.both = np.zeros((2, 9, self.wide.N))

    def turn(self):
        """Find ahead and back, after `swing`."""
        for s in each(2):
            self.find_faces(self.moved, self.blend.moving, self.x, self.both[s], number(1 - 2 * s))


class Radial(Grid):
    """A grid around an axis or a centre.

    inner: numbers of the range among the wide nodes. v: (d, W) velocities. area: (W,) A. flat:
    (d, W) z and s, w: their rates, through: A b^k_2 of each axis. b: (d d, W). source: (N,) S;
    turning: (d d, N) d a^k/dt in two dimensions; bounds: (d d + d + 1, N) metrics that bound steps.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        (d, W), N = self.x.shape, self.wide.N
        self.inner, self.area = self.wide.inner(np.arange(W)), np.zeros(W)
        self.flat, self.w, self.through = (zeros((d, W)) for _ in range(3))
        self.v, self.b, self.still = np.zeros((d, W)), np.zeros((d * d, W)), np.zeros((d, d))
        self.source, self.turning, self.bounds = np.zeros(N), np.zeros((d * d, N)), 1 * self.metrics

    def edge(self, known):
        """Complete x, find A and flat, and fill a^k, A, source."""
        self.blend.complete(self.blend.moved, known, 0)
        d, hoops, area = self.d, self.hoops, self.area
        self.place()
        for n in each(area.size, vector=True):
            *z, r = column(d, self.x, n)
            area[n] = A = abs(r) if hoops == 1 else r * r
            self.flat[:, n] = (*z, A * r / (hoops + 1.0))
        self.wide.run("metrics", self.flat, self.b, self.wide.P, everywhere=True)
        for n in each(area.size, vector=True):
            for k in range(d):
                self.through[k, n] = area[n] * self.b[k * d + d - 1, n]
        self.wide.run("divergence", self.through, self.source, self.still)
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            self.metrics[d * d + d, i] = area[n]
            for m in range(d * d):
                self.metrics[m, i] = self.b[m, n] * (area[n] if m % d == d - 1 else 1.0)

    def move(self):
        """There is nothing left to find after `edge`."""

    def swing(self, known):
        """Velocity of the grid, and turning."""
        self.blend.complete(self.blend.moving, known, self.d)
        d, hoops, v, area = self.d, self.hoops, self.v, self.area
        self.blend.fill(self.blend.moving, v, self.blend.every)
        for i in each(self.inner.size, vector=True):
            self.metrics[d * d : d * d + d, i] = column(d, v, self.inner[i])
        if d == 1:  # area vectors do not turn
            return
        for n in each(area.size, vector=True):
            *v_z, v_r = column(d, v, n)
            self.w[:, n] = (*v_z, v_r * area[n])
        self.wide.run("metrics", self.w, self.turning, self.still)
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            spread = hoops * area[n] / self.x[d - 1, n] * v[d - 1, n]
            for m in range(d - 1, d * d, d):
                self.turning[m, i] = exact(area[n] * self.turning[m, i] + spread * self.b[m, n])

    def bound(self):
        """Fill bounds: metrics, a^k times 1/2 (1 + the largest A of the node and those beside it
        along the axis k, over A).
        """
        d, area, copied, bounds = self.d, self.area, self.metrics.reshape(-1), self.bounds
        for m in each(copied.size, vector=True):
            bounds.reshape(-1)[m] = copied[m]
        for k in range(d):
            step, length = self.wide.sizes[0] if k else 1, self.wide.sizes[k]
            for i in each(self.inner.size, vector=True):
                n = self.inner[i]
                at, here = n // step % length, area[n]
                below = area[pick(at > 0, n - step, n)]
                above = area[pick(at < length - 1, n + step, n)]
                largest = np.maximum(np.maximum(here, below), above)
                for c in range(d):
                    bounds[k * d + c, i] *= 0.5 * (1.0 + largest / here)


def grid_of(problem: BlockProblem, *given: Any) -> Grid:
    """The `Grid` of a range of nodes of a gas block (of a rank: the ghosted)."""
    kind = Radial if problem.symmetry else Cube if problem.dimension == 3 else Grid
    return kind(problem, *given)


class Blend(SimpleNamespace):
    """The nodes on the faces of a block, and those of a Wide between them. known: numbers (M,) of
    nodes on faces whose values will be given, in any order. centred: the block goes to r = 0.

    nodes: numbers (H,) of the nodes on faces, ascending. given: columns (M,) of what is known.
    columns, weights: (9, T) and (d, 4, T), of nodes on faces that follow: the node, its edges low
    a, high a, low b, high b, four vertices; weights of the edges. moved, moving: (d, H) values, one
    0 where no node is on a face.

    sizes: how many nodes there are along three axes: those of the Wide and, along an axis that has
    faces, those at both ends. order: of the axes with faces. axes: three, None for those without
    faces; of an axis columns: (2, F) of the values at the low and the high face, weights: (2, d, n)
    of these by component, missing: (2, F) what the axes before it leave to be added. every, inner:
    windows of the Wide and of its own range.
    """

    def __init__(self, block: Block, wide: Wide, known: Array, centred: bool) -> None:
        d, shape, last = block.dimension, block.shape, [n - 1 for n in block.shape]
        faces = [block.face_nodes(*f) for f in block.faces if not (centred and f == (d - 1, 0))]
        self.nodes = nodes = np.unique(np.concatenate([np.zeros(0, int), *faces]))
        self.given = np.searchsorted(nodes, np.asarray(known, int))
        self.moved, self.moving = np.zeros((2, d, max(1, len(nodes))))
        index, is_known = np.array(np.unravel_index(nodes, shape, order="F")), np.isin(nodes, known)
        columns, weights = [np.zeros((9, 0), int)], [np.zeros((d, 4, 0))]
        ended = [k for k in range(d) if not block.periodic[k]]
        for free in (*combinations(ended, 1), *combinations(ended, 2)):  # edges, then faces
            fixed, (a, b) = [k for k in ended if k not in free], (free[0], free[-1])
            for sides in product((0, 1), repeat=len(fixed)) if fixed else ():
                on = np.all([index[k] == side * last[k] for k, side in zip(fixed, sides)], axis=0)
                if is_known[on].all():
                    continue
                for k in free:
                    on &= (index[k] >= (not (centred and k == d - 1))) & (index[k] < last[k])
                at, found = index[:, on], []
                vertices = [{a: i, b: j} for i, j in ((0, 0), (1, 1), (1, 0), (0, 1))]
                for ends in ({}, {a: 0}, {a: 1}, {b: 0}, {b: 1}, *vertices):
                    to = [ends[k] * last[k] + 0 * i if k in ends else i for k, i in enumerate(at)]
                    found.append(np.searchsorted(nodes, np.ravel_multi_index(to, shape, order="F")))
                of_ends = [end_weights(block, k, at[k], centred) for k in (a, b)]
                if a == b:  # the ends of an edge count as its edges a
                    of_ends[1][:] = 0.0
                columns.append(np.array(found))
                weights.append(np.concatenate(of_ends).transpose(1, 0, 2))
        self.columns, self.weights = (np.concatenate(of, axis=-1) for of in (columns, weights))
        self._find_axes(block, wide, centred)

    def _find_axes(self, block: Block, wide: Wide, centred: bool) -> None:
        d, shape, index, nodes = block.dimension, block.shape, [], self.nodes
        for n, (begin, end), closed in zip(shape, wide.wide, block.periodic):
            i = np.arange(begin, end)
            index.append(i if closed else np.unique([0, *i[i >= 0], n - 1]))
        axes: list[Any] = [None] * 3
        self.order = "".join(str(k) for k in range(d) if not block.periodic[k])
        for k in map(int, self.order):
            faces = [[*index[:k], np.array([end]), *index[k + 1 :]] for end in (0, shape[k] - 1)]
            numbers = [np.ravel_multi_index(mesh(at), shape, "wrap", "F").ravel() for at in faces]
            columns = np.searchsorted(nodes, np.array(numbers))
            weights, missing = end_weights(block, k, index[k], centred), np.zeros(columns.shape)
            axes[k] = SimpleNamespace(columns=columns, weights=weights, missing=missing)
        self.axes, self.sizes = tuple(axes), tuple([*map(len, index), 1, 1][:3])
        windows = (window(block, index, of, nodes, centred) for of in (wide.wide, wide.where))
        self.every, self.inner = windows

    def complete(self, values, known, first):
        """Complete values (d, H) from known (M, …), of which the columns from `first` count: edges
        between their ends, then faces. Sums do not depend on the order of ends and axes.
        """
        given, columns, weights = self.given, self.columns, self.weights
        for c in each(values.shape[0]):
            f, w = values[c], weights[c]
            for m in each(given.size):
                f[given[m]] = known[m, first + c]
            for t in each(columns.shape[1]):
                a0, a1, b0, b1, v00, v11, v10, v01 = (f[columns[k, t]] for k in range(1, 9))
                la, ha, lb, hb = (w[k, t] for k in range(4))
                edges = (la * a0 + ha * a1) + (lb * b0 + hb * b1)
                vertices = (la * lb * v00 + ha * hb * v11) + (ha * lb * v10 + la * hb * v01)
                f[columns[0, t]] = exact(edges - vertices)

    def fill(self, values, out, window, base=None):
        """out (d, nodes of a window) from values (d, H) of the hull, added to base (d, …) if there
        is one. Of images the last component, along r, has the other sign.
        """
        images = window.images
        for c in each(values.shape[0]):
            of_base = None if base is None else base[c]
            for n, k in enumerate(self.order):
                self.find_missing(self.order[:n], int(k), c, values[c])
            self.add_between(c, out[c], window, of_base)
            put_on_faces(out[c], window.faces, values[c], of_base)
            for i in each(images.shape[1]):
                out[c, images[0, i]] = out[c, images[1, i]]
        for i in each(images.shape[1]):
            out[values.shape[0] - 1, images[0, i]] *= -1.0

    def between(self, order, c, at):
        """The sum of what these axes add at a node; at: its place along each axis."""
        found = 0.0
        for k in map(int, order):
            axis, i, m = self.axes[k], at[k], self.at_face(k, at)
            low, high = (axis.weights[side, c, i] * axis.missing[side, m] for side in (0, 1))
            found = exact(low + high) + found
        return found

    def at_face(self, k, at):
        """The number of a node among those of a face of axis k."""
        a, b = (m for m in range(3) if m != k)
        return at[a] + self.sizes[a] * at[b]

    def find_missing(self, before, k, c, f):
        """Find what is missing at both faces of axis k, after the axes before it."""
        axis, (a, b) = self.axes[k], (m for m in range(3) if m != k)
        for j in each(self.sizes[b]):
            for i in each(self.sizes[a], vector=True):
                for side, end in enumerate((0, self.sizes[k] - 1)):
                    at = {a: i, b: j, k: end}
                    m = self.at_face(k, at)
                    axis.missing[side, m] = f[axis.columns[side, m]] - self.between(before, c, at)

    def add_between(self, c, out, window, base):
        """Fill a window with the sum of all axes."""
        x0, y0, z0 = window.first
        nx, ny, nz = window.sizes
        for z in each(nz):
            for y in each(ny):
                row = window.images.shape[1] + nx * (y + ny * z)
                for x in each(nx, vector=True):
                    u = self.between(self.order, c, (x0 + x, y0 + y, z0 + z))
                    out[row + x] = u if base is None else base[row + x] + u


def put_on_faces(out, faces, values, base=None, sign=1.0):
    """Put values of the hull, added to a base if there is one, on faces, to the bit."""
    for i in each(faces.shape[1]):
        n, value = faces[0, i], sign * values[faces[1, i]]
        out[n] = value if base is None else base[n] + value


def window(block: Block, index: Any, ranges: Any, nodes: Array, centred: bool) -> SimpleNamespace:
    """A range of the nodes of a blend: the first one and how many there are along three axes.
    Numbers of nodes, of the range and of the I images before it, are in faces: (2, F), beside those
    in the hull, and in images: (2, I), before a centre, beside those of the nodes that they mirror.
    """
    begins = [b if closed else max(b, 0) for (b, _), closed in zip(ranges, block.periodic)]
    first = [*map(int, map(np.searchsorted, index, begins)), 0, 0][:3]
    sizes = [*(end - begin for begin, (_, end) in zip(begins, ranges)), 1, 1][:3]
    at = mesh([np.arange(b, end) for b, (_, end) in zip(begins, ranges)])
    numbers = np.ravel_multi_index(at, block.shape, "wrap", "F").ravel()
    on = np.flatnonzero(np.isin(numbers, nodes))
    layer, images = int(np.prod(sizes[: len(begins) - 1])), centred * max(-ranges[-1][0], 0)
    rows = np.arange(images * layer).reshape(images, layer)
    pairs = np.stack([rows.ravel(), (images * layer + rows[::-1]).ravel()])
    on_faces = np.stack([images * layer + on, np.searchsorted(nodes, numbers[on])])
    return SimpleNamespace(first=tuple(first), sizes=tuple(sizes), faces=on_faces, images=pairs)


def end_weights(block: Block, axis: int, index: Array, centred: bool) -> Array:
    """1 - xi and xi of nodes (2, d, N), for each component of what is blended; the same bits seen
    from both ends; 0 on a periodic axis. Along one to r = 0 a block is half of one whose other end
    is an image of the first: 0 and 1, or 0 and xi of the component along r, which is odd.
    """
    cells, d = block.cells[axis], block.dimension
    found = np.zeros((2, d, len(index)))
    if centred and axis == d - 1:
        found[1], found[1, -1] = 1.0, (index + 0.5) / (cells + 0.5)
    elif not block.periodic[axis]:
        found[0], found[1] = (cells - index) / cells, index / cells
    return found
