"""Grids of the oracle of blocks: places of nodes, metrics, and their rates.

Source: docs/derivation.md. Arrays of a block have the shape (components, n_1, ..., n_d).

Around an axis (kappa = 1) or a centre (kappa = 2) the last coordinate is r. The metrics carry the
weight r^kappa, so that sums are over a sector of unit angle or unit solid angle:
a^k = (b^k_1, r^kappa b^k_2), b^k the metrics of (z, s), s = r^(kappa + 1)/(kappa + 1).

A block that goes from -r to r, with an even number of nodes and mirrored states, is the scheme with
a centre: none of its nodes is there, and the weight is |r|^kappa."""

from collections import namedtuple
from itertools import product

import numpy as np
from oracle_formulas import TINY, along, axis_of, cofactor, det, dot, rate_of, spread

#: of a block at one time: places, velocities (d, ...), metrics a[axis, component, ...], their rates
Grid = namedtuple("Grid", "x v a a_t")


class Grids:
    """Blocks of a problem one by one. ``of_node``: (block, node) -> particle, see Particles."""

    def __init__(self, problem, kappa=0):
        self.problem, self.blocks, self.d = problem, problem.blocks, len(problem.blocks[0].X)
        self.kappa, self.names = kappa, [b.name for b in self.blocks]
        self.axes, self.W, self.periods, self.linear = [], [], [], []
        self.solids, self.of_node = {}, {}
        for k, b in enumerate(self.blocks):
            shape, periods = b.X.shape[1:], b.periods or (None,) * self.d
            around = [False] * (self.d - 1) + [kappa == 1 and b.X[-1].min() < 0.0 < b.X[-1].max()]
            kinds = zip(shape, (p is not None for p in periods), around)
            self.axes.append([axis_of(problem.order, *kind) for kind in kinds])
            weights = np.meshgrid(*(axis.weight for axis in self.axes[k]), indexing="ij")
            self.W.append(np.prod(weights, axis=0))
            vectors = [np.zeros(self.d) if p is None else p for p in periods]
            self.periods.append(np.array(vectors, float))
            xi = np.meshgrid(*(np.arange(n) / n for n in shape), indexing="ij")
            self.linear.append(sum(spread(p, self.d) * x for p, x in zip(self.periods[k], xi)))
            if b.material.kind == "solid":
                G = np.swapaxes(self.slopes(k, b.X), 0, 1)  # G[component, axis] = D_axis X
                A, J0 = np.swapaxes(cofactor(G), 0, 1), det(G)
                self.solids[k] = A * self.weight(b.X), J0 * self.weight(b.X)

    def periodic(self, k, axis):
        return bool(self.blocks[k].periods) and self.blocks[k].periods[axis] is not None

    def derivative(self, k, f, axis):
        return along(self.axes[k][axis].D, f, axis, self.d)

    def boundary_flux_free(self, k, f, axis):
        """H D° f: the derivative without the flux through the ends."""
        return along(self.axes[k][axis].flux_free, f, axis, self.d) * self.W[k]

    def weight(self, x):
        """r^kappa (...); also of complex x, whose real part has the sign."""
        return (np.where(x[-1].real < 0.0, -1.0, 1.0) * x[-1]) ** self.kappa

    def flat(self, x):
        """(z, s) of places."""
        return np.array([*x[:-1], self.weight(x) * x[-1] / (self.kappa + 1.0)])

    def start(self, k):
        """A volume per logical volume."""
        return det(np.swapaxes(self.slopes(k, self.flat(self.blocks[k].X)), 0, 1))

    def slopes(self, k, x):
        """D_axis x for each axis, (d, d, ...), of places x, of which ``linear`` is not periodic."""
        y = x - self.linear[k]
        return np.array(
            [self.derivative(k, y, j) + spread(self.periods[k][j], self.d) for j in range(self.d)]
        )

    def metrics(self, k, x):
        """a[axis, component]: the area vectors of the logical axes."""
        a = self.flat_metrics(k, self.flat(x))
        a[:, -1] *= self.weight(x)
        return a

    def flat_metrics(self, k, x):
        """Those without weight, with sum D_axis a = 0."""
        Dx = self.slopes(k, x)
        if self.d < 3:
            return cofactor(Dx)
        # a = curl(1/2 (y_m D y_l - y_l D y_m) + y_m D c_l - y_l D c_m) + D c_m x D c_l, x = y + c
        y, c, a = x - self.linear[k], self.periods[k], np.zeros_like(Dx)
        Dy = Dx - c.reshape(3, 3, 1, 1, 1)
        for n in range(3):
            m, l = (n + 1) % 3, (n + 2) % 3
            f = [
                0.5 * (y[m] * Dy[b, l] - y[l] * Dy[b, m]) + y[m] * c[b, l] - y[l] * c[b, m]
                for b in range(3)
            ]
            constant = np.cross(c[:, m], c[:, l])
            for i in range(3):
                j, o = (i + 1) % 3, (i + 2) % 3
                a[i, n] = self.derivative(k, f[o], j) - self.derivative(k, f[j], o) + constant[i]
        return a

    def moved(self, q, t, part):
        """By block the displacement (part 0) or the velocity (1) of its nodes."""
        of_solid = slice(part * self.d, (part + 1) * self.d)
        return [
            q[name][of_solid] if k in self.solids else self._blended(k, q, t, part)
            for k, name in enumerate(self.names)
        ]

    def grids(self, q, t):
        found = []
        for k, (D, v) in enumerate(zip(self.moved(q, t, 0), self.moved(q, t, 1))):
            x = self.blocks[k].X + D
            a_t = np.imag(self.metrics(k, x + 1j * TINY * v)) / TINY
            found.append(Grid(x, v, self.metrics(k, x), a_t))
        return found

    def _blended(self, k, q, t, part):
        """Of a gas's grid: vertices, edges, faces, inside; Boolean sums where not all is moved."""
        X, d = self.blocks[k].X, self.d
        f, index = np.zeros(X.shape, q[self.names[k]].dtype), np.indices(X.shape[1:])
        sides = [(None,) if self.periodic(k, j) else (0, -1, None) for j in range(d)]
        for ends in sorted(product(*sides), key=lambda ends: ends.count(None)):
            slices = (slice(None) if e is None else slice(e, e + 1 or None) for e in ends)
            where = (slice(None), *slices)
            nodes = index[where].reshape(d, -1).T.tolist()
            known = [self._source(k, tuple(node), q, t, part) for node in nodes]
            if all(value is not None for value in known):
                f[where] = np.transpose(known).reshape(f[where].shape)
                continue
            rest = f[where]
            for j in range(d):
                if ends[j] is None and not self.periodic(k, j):
                    xi = np.linspace(0.0, 1.0, X.shape[1 + j]).reshape(-1, *[1] * (d - 1 - j))
                    low, high = rest.take([0], j + 1), rest.take([-1], j + 1)
                    rest = rest - (1.0 - xi) * low - xi * high
            f[where] = f[where] - rest
        return f

    def _source(self, k, node, q, t, part):
        """What moves a node of a gas's grid: a solid at its place, or a wall; or None."""
        p = self.of_node.get((k, node))
        if p is None:
            return None
        if p.solid:
            s, other = p.solid[0]
            return q[self.names[s]][(slice(part * self.d, (part + 1) * self.d), *other)]
        X = self.blocks[k].X[(slice(None), *node)]
        for face in p.outer:
            if motion := getattr(face.condition, "motion", None):
                return rate_of(motion, X, t) if part else motion(X, t) - X
        return None

    def volume_flux(self, k, grid):
        """b^k and w = d(z, s)/dt, which make the volume flux g of two nodes."""
        w = np.array([*grid.v[:-1], self.weight(grid.x) * grid.v[-1]])
        return self.flat_metrics(k, self.flat(grid.x)), w

    def volume_rate(self, k, grid):
        """J_t, per node."""
        total, (b, w) = 0.0, self.volume_flux(k, grid)
        for j, a in enumerate(b):
            total = total + dot(a, self.derivative(k, w, j)) + dot(w, self.derivative(k, a, j))
        return total

    def hoop_area(self, k, grid):
        """S: 0 without an axis."""
        return sum(self.derivative(k, grid.a[j, -1], j) for j in range(self.d))
