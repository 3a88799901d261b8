"""The grid of a gas block: x = X + the displacements of its faces, blended (fsipetsc.blocks.hull):
Gordon and Hall, Int. J. Numer. Meth. Eng. 7 (1973) 461-477. Its velocity is the same blend of the
faces' velocities.

On a plane only the faces are differentiated: D_k of a linear function is exact, so derivatives of a
blend of faces are blends of derivatives along them. With S, N the faces along axis 1 at the low and
high end of axis 2, W, E those along axis 2, and l, h the weights of low and high ends,

    Q_ij     = l_j S_i + h_j N_i
    u_ij     = Q_ij + l_i (W_j - Q_0j) + h_i (E_j - Q_nj)
    D_1 u_ij = l_j D_1 S_i + h_j D_1 N_i + [E_j - W_j - (Q_nj - Q_0j)]
    D_2 u_ij = l_i D_2 W_j + h_i D_2 E_j + [N_i - S_i - l_i (N_0 - S_0) - h_i (N_n - S_n)]

The brackets are 0 to the bit at S and N, or W and E. Along a periodic axis there are no faces
across it; then their values, those at vertices, l and h are 0.

Around an axis (kappa = 1) or a centre (2) it is a flat grid of (z, s), s = |r|^kappa r/(kappa + 1),
as r^kappa dr = ds; r is the last coordinate. With A = |r|^kappa, the velocity v of the grid, and
D_k of summation by parts,

    b^k, J    metrics and Jacobian of (z, s): J = D s in one dimension, D_1 z D_2 s - D_1 s D_2 z
    a^k       = (b^k_1, A b^k_2), the area vectors
    J_t       = sum_k b^k . D_k w,    w = (v_1, A v_2) = d(z, s)/dt,    exactly that of J
    source S  = sum_k D_k a^k_2;  sum_k D_k a^k_1 = 0

A pressure p that is the same everywhere gives p S to the momentum along r; so much is added again
(fsipetsc.scheme.gas_terms). J_t is what two-point fluxes let through a node that moves (radial Gas
of fsipetsc.equations.gas). Beside an axis, where A has a kink, D along r has weights of its own
(AXIS of fsipetsc.operators.bands).
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.blocks.block import Range
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.hull import blend_of, hull_of, put_on_faces
from fsipetsc.blocks.metrics import Wide, cube_of, slopes_across, slopes_along
from fsipetsc.checks import Array
from fsipetsc.equations.tensors import cofactor, determinant
from fsipetsc.equations.vectors import add, scale, sub
from fsipetsc.kernels.arrays import column, row, zeros
from fsipetsc.kernels.loops import each, invoke, pick
from fsipetsc.kernels.symbols import exact


class Grid(SimpleNamespace):
    """The motion of a range of N nodes of gas block k, a record for procedures; the W nodes of
    ``wide`` are those that derivatives reach.

    nodes: (M,) those on faces of the whole block whose displacement and velocity will be given.
    faces: of the range, (axis, index along it), whose turning is wanted in three dimensions.

    Procedures get known: (M, 2d) displacements [m] and velocities [m/s] of the given nodes, and
    metrics: (d d + d, N), a^1 … a^d and the velocity of the grid; around an axis or a centre A is
    one more row. like: d zeros, hoops: kappa zeros. `prepare` makes room, and finds what does not
    move; `edge` finds where the grid's faces are, and a^k on those at constraints, or everywhere if
    that is little work.
    """

    #: of the axes whose faces are blended
    order = "012"

    def __init__(self, problem: BlockProblem, k: int, wide: Wide, nodes: Array, faces: Any) -> None:
        block, centred = problem.blocks[k], problem.centred(k)
        self.like, self.hoops = (0.0,) * problem.dimension, (0.0,) * problem.symmetry
        self.hull = hull_of(block, nodes, centred)
        found = blend_of(block, wide, self.hull.nodes, self.order, centred)
        self.blend, self.wide, self.range = found
        self.prepare(wide, faces)

    def move(self, metrics):
        """Find where the grid is and a^k, as far as `edge` has not."""

    def swing(self, known, metrics):
        """Fill the velocity, after `edge` and `move`."""
        d = len(self.like)
        self.hull.fill(self.hull.moving, known, d)
        self.blend.fill(self.hull.moving, metrics[d * d :], self.range)

    def find_places(self, X, places):
        """Find where nodes are (d, N), after `move`; X: those of the reference map."""
        self.blend.fill(self.hull.moved, places, self.range, X)

    def find_volumes(self):
        """Find what `jacobian` takes."""

    def jacobian(self, metrics, node):
        """det(D x) of a node, after `find_volumes`."""
        return self.volume[node]


class Line(Grid):
    """A grid in one dimension."""

    def prepare(self, wide: Wide, faces: Any) -> None:
        self.slope = np.ascontiguousarray(wide.gradients()[0, 0])

    def edge(self, known, metrics):
        self.hull.fill(self.hull.moved, known, 0)
        metrics[0, :] = 1.0

    def jacobian(self, metrics, node):
        return self.slope[node] + (self.hull.moved[0, -1] - self.hull.moved[0, 0])


class Plane(Grid):
    """A flat grid in two dimensions. slopes: (4, N), D_1 X and D_2 X. along, across: the faces
    along both axes. corners: columns of the four vertices, if there are any, vertices: (4, 2)
    values there; rise: (2, n) the bracket of D_2 u.
    """

    order = "10"

    def prepare(self, wide: Wide, faces: Any) -> None:
        self.slopes = np.ascontiguousarray(wide.gradients().reshape(4, -1))
        self.along, self.across = (self.faces_along(wide, axis) for axis in (0, 1))
        corners = self.blend.axes[1].columns[:, [0, -1]] if len(self.blend.order) == 2 else ()
        self.corners, self.vertices = np.array(corners, int).ravel(), np.zeros((4, 2))
        self.rise = np.zeros((2, self.range.sizes[0]))

    def faces_along(self, wide: Wide, axis: int) -> SimpleNamespace:
        """Faces along an axis: columns (2, n) of the hull, if there are any, the band of the axis,
        the first node of the range, ends: (2, n) weights of the ends of the axis; f, slope: (4, n)
        values and derivatives by side and component.
        """
        own, opposite = self.blend.axes[axis], self.blend.axes[1 - axis]
        n, first, begin = wide.sizes[axis], self.wide.first[axis], self.range.first[axis]
        ends = np.zeros((2, n)) if own is None else own.weights[:, 0, begin:]
        columns = np.zeros((0, n), int) if opposite is None else opposite.columns
        return SimpleNamespace(
            columns=columns[:, first : first + n].copy(),
            S=wide.S[axis],
            weight=wide.weight[axis],
            first=begin - first,
            ends=ends[:, : self.range.sizes[axis]].copy(),
            f=np.zeros((4, n)),
            slope=np.zeros((4, n)),
        )

    def edge(self, known, metrics):
        """Fill a^1 = (D_2 y, -D_2 x) and a^2 = (-D_1 y, D_1 x)."""
        self.hull.fill(self.hull.moved, known, 0)
        self.differentiate_faces(self.hull.moved)
        along, across, like, of_row = self.along, self.across, self.like, self.across.ends
        at_00, at_10, at_01, at_11 = (row(like, self.vertices, k) for k in range(4))
        for j in each(of_row.shape[1]):
            (low, high), at = (of_row[0, j], of_row[1, j]), across.first + j
            (W, E), (D_W, D_E) = pair(across.f, at), pair(across.slope, at)
            start, stop = mixed(low, at_00, high, at_01), mixed(low, at_10, high, at_11)
            rise = sub(sub(E, W), sub(stop, start))
            for i in each(n := along.ends.shape[1], vector=True):
                at, (D_S, D_N) = j * n + i, pair(along.slope, along.first + i)
                x_1, y_1 = add(mixed(low, D_S, high, D_N), rise)
                of_axis_2 = mixed(along.ends[0, i], D_W, along.ends[1, i], D_E)
                x_2, y_2 = add(column(like, self.rise, i), of_axis_2)
                X_1, Y_1, X_2, Y_2 = column((0.0,) * 4, self.slopes, at)
                metrics[:4, at] = Y_2 + y_2, -(X_2 + x_2), -(Y_1 + y_1), X_1 + x_1

    def differentiate_faces(self, values):
        """Find values (2, H) of the hull at faces and vertices, derivatives along faces, and the
        bracket of D_2 u.
        """
        for faces in self.along, self.across:
            for r in each(2 * faces.columns.shape[0]):
                for i in each(faces.f.shape[1], vector=True):
                    faces.f[r, i] = values[r % 2, faces.columns[r // 2, i]]
            slopes_along(faces.slope.reshape(-1), faces.f.reshape(-1), faces.S, faces.weight)
        for corner in each(self.corners.shape[0]):
            self.vertices[corner, :] = column(self.like, values, self.corners[corner])
        along, ends, at = self.along, self.along.ends, self.vertices
        for c in range(2):
            at_low, at_high = at[2, c] - at[0, c], at[3, c] - at[1, c]
            for i in each(ends.shape[1], vector=True):
                between, n = ends[0, i] * at_low + ends[1, i] * at_high, along.first + i
                self.rise[c, i] = exact((along.f[2 + c, n] - along.f[c, n]) - between)

    def jacobian(self, metrics, node):
        x, y, z, t = (metrics[k, node] for k in range(4))
        return exact(x * t - y * z)


def mixed(l, a, h, b):
    """l a + h b."""
    return exact(add(scale(l, a), scale(h, b)))


def pair(f, at):
    """Values at both ends, which opposite faces have of a node."""
    return column((0.0, 0.0), f, at), column((0.0, 0.0), f, at, 2)


class Cube(Grid):
    """A grid in three dimensions. y: (3, W), of a Wide; x, moved: (3, W) places less those of
    linear maps, volume: (N,) det D x. ahead, back: (9, N) a^k on faces at constraints if nodes go
    on with their velocity for 1 s, and where they were 1 s before. address, kept: see `cube_of`.
    """

    def prepare(self, wide: Wide, faces: Any) -> None:
        self.y, (self.x, self.moved) = wide.y, zeros((2, *wide.y.shape))
        self.volume = np.zeros(int(np.prod(self.range.sizes)))
        self.ahead, self.back = np.zeros((2, 9, self.volume.size))
        self.address, self.kept = cube_of(wide, faces)

    def edge(self, known, metrics):
        self.hull.fill(self.hull.moved, known, 0)
        for c in range(3):
            put_on_faces(self.x[c], self.wide.faces, self.hull.moved[c], self.y[c])
        invoke("cube_faces", self.address, self.x, metrics)

    def move(self, metrics):
        self.blend.fill(self.hull.moved, self.x, self.wide, self.y)
        invoke("cube_areas", self.address, self.x, metrics)

    def turn(self):
        """Find ahead and back, after `swing`."""
        for sign, areas in ((1.0, self.ahead), (-1.0, self.back)):
            for c in range(3):
                put_on_faces(self.moved[c], self.wide.faces, self.hull.moving[c], self.x[c], sign)
            invoke("cube_faces", self.address, self.moved, areas)

    def find_volumes(self):
        invoke("cube_volumes", self.address, self.x, self.volume)


class Radial(Grid):
    """A grid around an axis or a centre.

    y, P, S, weight, inner: of a Wide; before: nodes of faster axes between neighbours along each
    axis. x, v: (d, W) places and velocities. area: (W,) A. flat: (d, W) z and
    s, or w, b, slopes: (d d, W), slope: (W,) room. source, volume: (N,) S and J; turning: (d d, N)
    d a^k/dt in two dimensions; bounds: (d d + d + 1, N) metrics by which steps are bounded.
    """

    def prepare(self, wide: Wide, faces: Any) -> None:
        (d, W), self.before = wide.y.shape, (1, *wide.sizes[:-1])
        self.inner = wide.inner(np.arange(W))
        self.y, self.P, self.S, self.weight = wide.y, wide.P, wide.S, wide.weight
        self.area, self.slope = np.zeros((2, W))
        self.x, self.v, self.flat = np.zeros((3, d, W))
        self.b, self.slopes = np.zeros((2, d * d, W))
        self.source, self.volume = np.zeros((2, self.inner.size))
        self.turning = np.zeros((d * d, self.inner.size))
        self.bounds = np.zeros((d * d + d + 1, self.inner.size))

    def edge(self, known, metrics):
        """Complete x, find A and flat, and fill a^k, A, source, volume."""
        self.hull.fill(self.hull.moved, known, 0)
        d, kappa, area, slopes = len(self.like), len(self.hoops), self.area, self.slopes
        last, entries, inner = d - 1, (0.0,) * d * d, self.inner
        self.blend.fill(self.hull.moved, self.x, self.wide, self.y)
        for n in each(area.size, vector=True):
            *z, r = column(self.like, self.x, n)
            area[n] = A = abs(r) if kappa == 1 else r * r
            self.flat[:, n] = (*z, A * r / (kappa + 1.0))
        self.differentiate_flat()
        for n in each(area.size, vector=True):
            for k in range(d):
                for c in range(last):
                    slopes[k * d + c, n] += self.P[k, c]
            self.b[:, n] = cofactor(column(entries, slopes, n))
        for i in each(inner.size, vector=True):
            n = inner[i]
            self.source[i] = 0.0
            self.volume[i] = exact(determinant(column(entries, slopes, n)))
            metrics[d * d + d, i] = area[n]
            for m in range(d * d):
                metrics[m, i] = self.b[m, n] * (area[n] if m % d == last else 1.0)
        for k in range(d):
            through = self.flat[0]
            for n in each(area.size, vector=True):
                through[n] = area[n] * self.b[k * d + last, n]
            self.differentiate(k, self.slope, through)
            for i in each(inner.size, vector=True):
                self.source[i] += self.slope[inner[i]]

    def swing(self, known, metrics):
        """Velocity of the grid, and turning."""
        self.hull.fill(self.hull.moving, known, len(self.like))
        d, kappa, v, area = len(self.like), len(self.hoops), self.v, self.area
        last, entries = d - 1, (0.0,) * d * d
        self.blend.fill(self.hull.moving, v, self.wide)
        for i in each(self.inner.size, vector=True):
            metrics[d * d : d * d + d, i] = column(self.like, v, self.inner[i])
        if d == 1:  # area vectors do not turn
            return
        for n in each(area.size, vector=True):
            *v_z, v_r = column(self.like, v, n)
            self.flat[:, n] = (*v_z, v_r * area[n])
        self.differentiate_flat()
        for i in each(self.inner.size, vector=True):
            n = self.inner[i]
            slopes, b = column(entries, self.slopes, n), column(entries, self.b, n)
            spread = kappa * area[n] / self.x[last, n] * v[last, n]
            for m, turned in enumerate(cofactor(slopes)):
                more = exact(area[n] * turned + spread * b[m])
                self.turning[m, i] = more if m % d == last else turned

    def bound(self, metrics):
        """Fill bounds: metrics, a^k times 1/2 (1 + the largest A of the node and those beside it
        along the axis k, over A).
        """
        d, area, copied, bounds = len(self.like), self.area, metrics.reshape(-1), self.bounds
        for m in each(copied.size, vector=True):
            bounds.reshape(-1)[m] = copied[m]
        for k in range(d):
            step, length = 1 if k == 0 else self.before[k], self.weight[k].shape[0]
            for i in each(self.inner.size, vector=True):
                n = self.inner[i]
                at, here = n // step % length, area[n]
                below = area[pick(at > 0, n - step, n)]
                above = area[pick(at < length - 1, n + step, n)]
                largest = np.maximum(np.maximum(here, below), above)
                for c in range(d):
                    bounds[k * d + c, i] *= 0.5 * (1.0 + largest / here)

    def differentiate(self, k, out, f):
        """out = D_k f, both (W,)."""
        if k == 0:
            slopes_along(out, f, self.S[k], self.weight[k])
        else:
            slopes_across(out, f, self.S[k], self.weight[k], self.before[k])

    def differentiate_flat(self):
        """slopes: D_k of both components of flat."""
        d = len(self.like)
        for k in range(d):
            for c in range(d):
                self.differentiate(k, self.slopes[k * d + c], self.flat[c])


def grid_of(
    problem: BlockProblem, k: int, order: int, where: Range, nodes: Array, faces: Any
) -> tuple[Grid, Array]:
    """The `Grid` of a range of nodes of gas block k (of a rank: the ghosted), and its metrics."""
    d, around = problem.dimension, problem.symmetry > 0
    wide, kind = Wide(problem, k, order, where), Radial if around else (Line, Plane, Cube)[d - 1]
    size = int(np.prod([end - begin for begin, end in where]))
    return kind(problem, k, wide, nodes, faces), zeros((d * d + d + around, size))
