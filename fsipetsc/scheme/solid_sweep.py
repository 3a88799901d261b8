"""Rates of the nodes of a solid block, without fluxes through its faces. fsipetsc.equations.solid
has the equations, fsipetsc.operators.bands the weights S_il of pairs. With

    D_k f   = sum_l S_il (f_l - f_i) / (2 weight_i)     derivative along axis k
    D°_k f  = sum_l S_il (f_l + f_i) / (2 weight_i)     the same without flux through the ends

and the tractions t^k = P A^k, the rates of displacement, velocity and energy are

    D_t = v,    J0 m0 v_t = sum_k D°_k t^k,
    J0 m0 e_t = v . sum_k D°_k t^k + sum_k t^k . D_k v.

The power is, pair by pair, S_il (t_i . v_l + t_l . v_i)/2: nothing is lost or won.

A layer is loaded, and its F and t^k are found, when rates that need them are next. Boxes of nodes
around a tile say where what is needed: F, T and t^k where its pairs reach, displacements where
these reach in turn; conduction reaches once more. What two tiles need is found twice by the same
operations: rates do not depend on tiles, nor on how a block is cut.
"""

from itertools import product
from typing import Any

import numpy as np

from fsipetsc.kernels.arrays import Array, aligned
from fsipetsc.kernels.kernel import numbers_of
from fsipetsc.kernels.loops import each, named, otherwise, pick, when
from fsipetsc.operators.bands import Band, Patch
from fsipetsc.scheme.sweep import Sweep, in_order, order, parts, pieces

#: kinds of derivatives: D_k and D°_k
PLAIN, FREE = range(2)
#: most nodes of a tile along the first axis, and along the second one of three, for d = 1, 2, 3
TILES = ((1024, 1), (128, 1), (64, 32))
#: longest pairs of all operators; nodes of a row with all that they reach
REACH = 7
WIDTH = 1024 + 6 * REACH
#: what is known of a tile's nodes: unknowns; F, T and t^k; heats; rates
KNOWN, STRAINED, HEATED, OWN = range(4)


def distances(layers: int, strides: Any, axes: Any, pairs: int) -> Array:
    """Return `far` of SolidSweep."""
    m, places = np.arange(1, pairs + 1), np.arange(layers)[:, None]
    found = np.zeros((2, layers, len(axes), pairs), np.int64)
    for sign, of_side in zip((1, -1), found, strict=True):
        for n, k in enumerate(axes):
            far = (places + sign * m) % layers - places if k == 2 else sign * m
            of_side[:, n] = far * strides[k]
    return found.reshape(2, layers, -1)


def tiles_of(patch: Patch, d: int) -> list[Any]:
    """Return the tiles of the owned nodes: (begin, end) along each axis."""
    most = *TILES[d - 1], patch.own[2]
    return list(product(*map(pieces, patch.first, patch.own, most)))


def boxes_of(bands: tuple[Band, ...], own: Any, conducts: bool) -> list[Any]:
    """Return the boxes KNOWN … OWN of a tile."""

    def reached(box: Any) -> Any:
        return [reached_along(b.S, *ends) for b, ends in zip(bands, box, strict=True)]

    near = reached(own)
    strained = reached(near) if conducts else near
    return [reached(strained), strained, near, own]


def reached_along(S: Array, begin: int, end: int) -> tuple[int, int]:
    """Return the first node and the first one beyond that have pairs with nodes begin … end - 1."""
    first = max(begin - len(S) + 1, 0)
    m, i = np.nonzero(S[:, first:end])
    i += first
    l = np.minimum(i + m, S.shape[1] - 1)
    inside = (i >= begin) | (begin <= l) & (l < end)
    return min([begin, *i[inside].tolist()]), max([end - 1, *l[inside].tolist()]) + 1


def neighbours(bands: Any) -> tuple[Array, Array, Array]:
    """jumps, weights and runs of SolidSweep."""
    most = max(2 * band.reach + 1 for band in bands)
    shape = 3, max(len(band.weight) for band in bands), 1 + most + -most % 4
    jumps, weights = np.zeros(shape, np.int64), np.zeros((2, *shape))
    for axis, (S, weight) in enumerate(bands):
        for i in range(len(weight)):
            pairs = [(m, S[m, i]) for m in range(1, min(len(S), len(weight) - i))]
            pairs += [(-m, -S[m, i - m]) for m in range(1, min(len(S), i + 1))]
            own = sum(S_il for _, S_il in pairs)
            pairs = [(m, S_il) for m, S_il in [*pairs, (0, own)] if abs(S_il) > 1e-12]
            here = slice(1, 1 + len(pairs))
            jumps[axis, i, 0], jumps[axis, i, here] = len(pairs), [m for m, _ in pairs]
            for kind, sign in ((PLAIN, -1.0), (FREE, 1.0)):
                signed = [S_il if m else sign * S_il for m, S_il in pairs]
                weights[kind, axis, i, here] = np.array(signed) / (2.0 * weight[i])
    n = len(bands[0].weight)
    all_of = np.concatenate([jumps[0, :n], *weights[:, 0, :n]], axis=1)
    ends = 1 + np.flatnonzero((all_of[1:] != all_of[:-1]).any(axis=1))
    return jumps, weights, np.stack([[0, *ends], [*ends, n]], axis=1)


class SolidSweep(Sweep):
    """The sweeps of a part of a block: their data, beside the record of the part, and what is
    recorded of a tile. bands: of the ghosted nodes along three axes; here axes are first, inner and
    last one. Methods take n nodes from x on along the first axis, of row y in layer z.

    p: parameters of the kernels. boxes: (tiles, 4, 3, 2) first node and first beyond of KNOWN …
    OWN. steps, to_strains: (n, 2) stages and layers (fsipetsc.scheme.sweep.order) of rates and of
    strains. jumps: (3, n, most) of each axis and node how many neighbours there are, and how far;
    weights: (2, 3, n, most) S_il/(2 weight_i) of these, for PLAIN and FREE, which differ at the
    node itself; runs: (n, 2) of the nodes along the first axis those for which they are the same.
    inside: three pairs, first node and first beyond of those of the interior, None of axes that are
    not there; far: (2, layers, d pairs) of these, how far those of a pair are ahead and behind in a
    tile, by place in the ring; inner: (d pairs,) weights of both. row, layer: nodes of a row and of
    a layer of a tile; layers: how many are kept. By components, of the nodes of a tile: unknowns,
    strains F, tractions t^k, temperatures T, heats A^k . h; of those of a row: slopes.
    """

    def __init__(self, solid: Any, d: int, kernels: Any, bands: Any, patch: Patch) -> None:
        bands, patch = in_order(bands, d), Patch(*(in_order(of_axes, d) for of_axes in patch))
        self.kernels, self.p = kernels, np.array([*numbers_of(solid), 0.0])
        conducts, pairs = kernels.conduct is not None, kernels.pairs
        self.boxes = np.array([boxes_of(bands, own, conducts) for own in tiles_of(patch, d)])
        known, *stages = [tuple(box) for box in self.boxes[0, :, 2].tolist()]  # those of all tiles
        stages = stages if conducts else [stages[0], stages[-1]]
        self.steps = order(bands[2].S, (known, *stages))
        self.to_strains = order(bands[2].S, (known, stages[-1]))
        self.jumps, self.weights, self.runs = neighbours(bands)
        axes = (0, 2) if d == 2 else range(d)
        inside = [band.interior(pairs) if k in axes else None for k, band in enumerate(bands)]
        of_pairs = [self.weights[PLAIN, k, inside[k][0], 1 : 1 + pairs] for k in axes]
        sizes = self.boxes[:, KNOWN, :2, 1] - self.boxes[:, KNOWN, :2, 0]
        self.row, inner = sizes.max(axis=0).tolist()
        self.layer, self.layers = self.row * inner, (3 + conducts) * bands[2].reach + 1
        strides = 1, self.row, self.layer
        self.inside, self.far = tuple(inside), distances(self.layers, strides, axes, pairs)
        self.inner = np.concatenate(of_pairs)
        # whole vectors, an odd number: components do not compete for one place of the fast memory
        step = 8 * (self.layers * self.layer // 16 * 2 + 3)
        counts = 2 * d + 1, len(solid.unstrained((0.0,) * d)), d * d, 1, d
        self.unknowns, self.strains, self.tractions, self.temperatures, self.heats = (
            aligned(c * step).reshape(c, step) for c in counts
        )
        self.slopes = np.zeros((2 * d * d + d, WIDTH))

    def sweep(self, part, found, y, q, f):
        """Store the rates of the owned nodes, or what becomes of them (fsipetsc.scheme.sweep), in
        f; y, q: planes of the owned nodes, and of all with a halo of two interior reaches, with
        conduction of three.
        """
        heats = [(self.find_heats, HEATED)] * (self.kernels.conduct is not None)
        stages = (self.load, KNOWN), (self.pull, STRAINED), *heats, (self.store, OWN)
        self.begin(part, found, y, q, f)
        self.take(self.steps, stages)

    def sweep_strains(self, part, y, q, F):
        """Fill planes of the strains F of the owned nodes; y, q: planes of their unknowns, and of
        those of a halo of one reach.
        """
        stages = (self.load, KNOWN), (self.find_strains, OWN)
        self.begin(part, None, y, q, F)
        self.take(self.to_strains, stages)

    def take(self, steps, stages):
        """Take the stages of all tiles: what is done with a row of nodes, and the box of these
        rows.
        """
        boxes = self.boxes
        for t in each(boxes.shape[0]):
            self.x0, self.y0 = (boxes[t, KNOWN, k, 0] for k in range(2))
            for s in each(steps.shape[0]):
                stage, z = steps[s, 0], steps[s, 1]
                for number, (do, box) in enumerate(stages):
                    with when(stage == number):
                        for y in each(boxes[t, box, 1, 0], boxes[t, box, 1, 1]):
                            x = boxes[t, box, 0, 0]
                            do(x, named(boxes[t, box, 0, 1] - x), y, z)

    def at(self, x, y, z):
        """The place of a node in planes of the tile."""
        return named(z % self.layers * self.layer + (y - self.y0) * self.row + (x - self.x0))

    def given(self, x, y, z):
        """What kernels take of the nodes from one on."""
        part, at, place = self.part, self.at(x, y, z), self.ghosted_at(x, y, z)
        names = "unknowns", "strains", "tractions", "temperatures", "heats"
        found = {name: getattr(self, name)[0, at:] for name in names}
        if part.prestress is not None:
            found["prestress"] = part.prestress[0, place:]
        metrics, pairs = part.metrics[0, place:], z % self.layers
        return found | {
            **{"metrics": metrics, "N": self.N, "step": self.unknowns.shape[1], "p": self.p},
            **{
                "slopes": self.slopes.reshape(-1),
                "far": self.far[0, pairs],
                "back": self.far[1, pairs],
            },
            "w": self.inner,
        }

    def load(self, x, n, y, z):
        """Load unknowns."""
        for begin, count, q, N in self.loaded(x, x + n, y, z):
            unknowns = self.unknowns[0, self.at(begin, y, z) :]
            self.kernels.take(count, q=q, N=N, unknowns=unknowns, step=self.unknowns.shape[1])

    def differentiate(self, kind, f, first, following, count, to, x, n, y, z):
        """Store D_k f for k = 1 … d in planes of slopes, from ``to`` on; if kind is FREE, D°_k f.
        Along axis k these are derivatives of count planes of f, from first + k following on. Nodes
        with the same neighbours are taken together: along the row those in the interior, across it
        all.
        """
        runs = self.runs
        for k in range(self.d):
            axis = 2 * k if self.d == 2 else k
            of_f, to_slopes = first + k * following, to + k * count
            if axis:
                node = (y, z)[axis - 1]
                self.combine(kind, axis, node, f, of_f, count, to_slopes, x, x, n, y, z)
                continue
            for run in each(runs.shape[0]):
                begin = named(np.maximum(runs[run, 0], x))
                many = named(np.minimum(runs[run, 1], x + n) - begin)
                with when(many > 0):
                    self.combine(kind, 0, begin, f, of_f, count, to_slopes, x, begin, many, y, z)

    def combine(self, kind, axis, node, f, first, count, to, x, begin, n, y, z):
        """The same along one axis, of n nodes from ``begin`` on of the row that begins at x; node:
        whose neighbours they have along the axis.
        """
        at = self.at(begin, y, z)
        for group in each((self.jumps[axis, node, 0] + 3) // 4):
            m = named(4 * group + 1)
            far = [self.away(axis, self.jumps[axis, node, m + i], z) for i in range(4)]
            for c in each(count):
                plane = f[first + c]
                given = dict(zip("abcd", (plane[at + one :] for one in far), strict=True))
                given |= {
                    "w": self.weights[kind, axis, node, m:],
                    "out": self.slopes[to + c, begin - x :],
                }
                with when(group == 0):
                    self.kernels.combine(n, **given)
                with otherwise():
                    self.kernels.add(n, **given)

    def away(self, axis, jump, z):
        """Numbers between a node and a neighbour along an axis in planes of the tile."""
        if axis < 2:
            return named(jump * self.row) if axis else jump
        there = z % self.layers + jump
        around = pick(there < 0, self.layers, pick(there < self.layers, 0, -self.layers))
        return named((jump + around) * self.layer)

    def pull(self, x, n, y, z):
        """Find F, T and the tractions t^k, within the interior with kernels of its own."""
        for begin, count, inside in parts(x, x + n, y, z, self.inside):
            with when(inside):
                self.kernels.pull_inside(count, **self.given(begin, y, z))
            with otherwise():
                place = begin, count, y, z
                self.differentiate(PLAIN, self.unknowns, 0, 0, self.d, 0, *place)
                self.kernels.pull(count, **self.given(begin, y, z))

    def find_heats(self, x, n, y, z):
        """Find the heats A^k . h."""
        self.differentiate(PLAIN, self.temperatures, 0, 0, 1, 0, x, n, y, z)
        self.kernels.conduct(n, **self.given(x, y, z))

    def find_strains(self, x, n, y, z):
        """Store F."""
        own, at = self.own_at(x, y, z), self.at(x, y, z)
        self.differentiate(PLAIN, self.unknowns, 0, 0, self.d, 0, x, n, y, z)
        self.kernels.strain(n, **self.given(x, y, z))
        for c in each(self.strains.shape[0]):
            for i in each(n, vector=True):
                self.f[c, own + i] = self.strains[c, at + i]

    def store(self, x, n, y, z):
        """Store rates, but the next stage of nodes to whose rates nothing is added."""
        d = self.d
        for first, length, kind in self.stored(x, x + n, y, z):
            for begin, count, inside in parts(first, first + length, y, z, self.inside):
                own, given = self.own_at(begin, y, z), self.given(begin, y, z)
                with when(inside):
                    self.run(self.kernels.stores_inside, kind, count, own, **given)
                with otherwise():
                    place = begin, count, y, z
                    self.differentiate(FREE, self.tractions, 0, d, d, 0, *place)
                    self.differentiate(PLAIN, self.unknowns, d, 0, d, d * d, *place)
                    if self.kernels.conduct is not None:
                        self.differentiate(FREE, self.heats, 0, 1, 1, 2 * d * d, *place)
                    self.run(self.kernels.stores, kind, count, own, **given)
