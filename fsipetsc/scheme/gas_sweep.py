"""Rates of a block of gas, without fluxes through its faces:

    weight_i (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v})

and a constant force, which is summed pair by pair like the fluxes. On a grid that moves J has the
flux of U = 1; fsipetsc.scheme.gas_procedures adds a^k . v of nodes at the end of an axis. The
weight of a node is the product of those along all axes; S_il of a pair along axis k is that of
fsipetsc.operators.bands times the weights along the other axes. The fluxes are those of
fsipetsc.equations.gas, in the kernels of fsipetsc.scheme.gas_kernels.

The flux of a pair is computed once and added to both of its nodes. The sum of the lower node
belongs to the row at work; that of the upper node waits in a row of its own. The fluxes reach a
node in an order that does not depend on how a block is cut, so neither do the bits of its rate.
Layers are loaded when they are needed: few rows are at work, and fit into the fastest memory.
"""

from typing import Any

import numpy as np

from fsipetsc.kernels.arrays import Array, aligned
from fsipetsc.kernels.kernel import numbers_of
from fsipetsc.kernels.loops import each, named, pick, when
from fsipetsc.operators.bands import Band, Patch
from fsipetsc.scheme.sweep import Sweep, in_order, order, pieces

#: most nodes of a tile along the first axis, by dimension; in three most rows along the second one
TILES, DEPTH = {1: 232, 2: 136, 3: 72}, 8
#: nodes beside a tile that it reaches, at most
MARGIN = 24


#: zeros between two nodes with pairs of one distance that make two spans of them
GAP = 16


def _weights(band: Band) -> tuple[Array, Array, Array]:
    """S, gain and loss of an axis."""
    reach, n = len(band.S) - 1, len(band.weight)
    found = np.zeros((3, reach + 1, n + 2 * MARGIN))
    for k in range(1, min(reach + 1, n)):
        S = band.S[k, : n - k]
        found[:, k, MARGIN : MARGIN + n - k] = S, S / band.weight[k:], S / band.weight[: n - k]
    return tuple(found)


def _tiles(d: int, S: Array, patch: Patch) -> tuple[Any, Any]:
    """Tiles, and their spans."""
    tiles, spans, deep = [], list[Any](), DEPTH if d == 3 else 1
    _, inner, _ = in_order(range(3), d)
    for y0, y1 in pieces(patch.first[inner], patch.own[inner], deep, deep):
        for x0, x1 in pieces(patch.first[0], patch.own[0], TILES[d], 8):
            before, spans = len(spans), [*spans, *_spans(S, x0, x1)]
            tiles.append((x0, x1, y0, y1, before, len(spans)))
    return np.array(tiles, np.int64), np.array(spans, np.int64).reshape(-1, 3)


def _spans(S: Array, x0: int, x1: int) -> list[tuple[int, int, int]]:
    """Spans of the pairs along a row of which a node is in a tile. A few pairs of weight 0 are
    taken along where that saves a span.
    """
    spans = []
    for k in range(1, len(S)):
        first = max(x0 - k, 0)
        lower = first + np.flatnonzero(S[k, first : min(x1, S.shape[1] - k)])
        if lower.size:
            runs = np.split(lower, 1 + np.flatnonzero(np.diff(lower) > GAP))
            spans += [(k, run[0], run[-1] + 1) for run in runs]
    return spans


class GasSweep(Sweep):
    """The sweep of a part of a block: its data, beside the record of the part, and what is recorded
    of a tile. bands: of the ghosted nodes along three axes.

    p: parameters of the kernels. steps: (n, 2) stages and layers (fsipetsc.scheme.sweep.order).
    tiles: (tiles, 6) x0, x1, y0, y1, first and first beyond of its spans. spans: (n, 3) distance,
    first lower node and first beyond of pairs along a row. S, gain, loss: of each axis (1 + reach,
    n + 2 MARGIN) weights of pairs by distance and lower node, these over the weight of the upper
    and of the lower node; zeros at the ends. per_weight: 1 over the weights along the first axis.

    layers, depth, before: so many layers of so many rows are kept, with rows before the tile's;
    width: how many numbers a row has room for.
    rows, high: of all these the numbers of nodes, and the sums of upper nodes of pairs. low, slope,
    of_pair: of the row at work the sums of lower nodes, D_k z, and gain and loss of one distance.

    potential: (N,) Phi of the ghosted nodes, where a constant force acts pair by pair; supplied:
    (M (d + 1),) the force on each owned node and room for a power, interlaced, over the node's
    weight (fsipetsc.scheme.gas_force); else (0,).
    """

    def __init__(self, gas: Any, d: int, kernels: Any, bands: Any, patch: Patch) -> None:
        self.kernels, self.p = kernels, np.array([*numbers_of(gas), 0.0])
        far = 1 + kernels.viscous
        x, inner, last = in_order(bands, d)
        _, _, n = in_order(patch.ghosted, d)
        _, _, begin = in_order(patch.first, d)
        first = max(begin - last.reach, 0)
        loaded = max(first - (far - 1) * last.reach, 0), n
        ranges = loaded, *([(first, n)] * (far - 1)), (first, begin + in_order(patch.own, d)[2])
        self.steps = order(last.S, ranges)
        self.tiles, self.spans = _tiles(d, x.S, patch)
        self.S, self.gain, self.loss = zip(*map(_weights, bands[:d]), strict=True)
        self.per_weight = 1.0 / x.weight
        self.layers, self.before = far * last.reach + 1, far * inner.reach
        self.depth, self.width = (DEPTH if d == 3 else 1) + 2 * self.before, TILES[d] + 2 * MARGIN
        kept, sums = self.layers * self.depth, kernels.sums
        shapes = (kept, kernels.numbers), (kept, sums), (sums,), (d * (d + 1),), (2,)
        self.rows, self.high, self.low, self.slope, self.of_pair = (
            aligned(int(np.prod(shape)) * self.width).reshape(*shape, self.width)
            for shape in shapes
        )
        raised = int(kernels.raises)
        self.potential = np.zeros(raised * int(np.prod(patch.ghosted)))
        self.supplied = np.zeros(raised * int(np.prod(patch.own)) * (d + 1))

    def sweep(self, part, found, y, q, f):
        """Store the rates of the owned nodes, or what becomes of them (fsipetsc.scheme.sweep), in
        f; y, q: planes of the owned nodes, and of all with a halo.
        """
        self.begin(part, found, y, q, f)
        self.reach = [S.shape[0] - 1 for S in in_order(part.S, self.d)]
        self.weight = in_order(part.weight, self.d)
        stages = self.load, *([self.find_viscous] * self.kernels.viscous), self.rates
        for t in each(self.tiles.shape[0]):
            tile = [self.tiles[t, c] for c in range(6)]
            self.x0, self.x1, self.y0, self.y1, *self.ends_of_spans = tile
            self.n = named(self.x1 - self.x0)
            for s in each(self.steps.shape[0]):
                stage, layer = self.steps[s, 0], self.steps[s, 1]
                for number, do in enumerate(stages):
                    with when(stage == number):
                        do(layer)

    def row(self, rows, layer, j):
        """Row j of a layer in an array of rows that are kept."""
        return rows[named(layer % self.layers * self.depth + (j - self.y0 + self.before))]

    def at(self, x):
        """Where the node x is in a row."""
        return x - self.x0 + MARGIN

    def longer(self, more):
        """Where a row begins that is longer than the tile on both sides, and how many nodes it has;
        it ends where the grid does.
        """
        begin = named(np.maximum(self.x0 - more, 0))
        return begin, named(np.minimum(self.x1 + more, self.sizes[0]) - begin)

    def beside(self, more):
        """A loop over the rows of the tile and so many beside it."""
        begin, end = np.maximum(self.y0 - more, 0), np.minimum(self.y1 + more, self.sizes[1])
        return each(begin, end)

    def is_owned(self, layer, around=0):
        """Whether a layer is owned, or so many beside such layers."""
        return (layer >= self.first[2] - around) & (layer < self.end[2] + around)

    def load(self, layer):
        """Find the primitive variables of the rows of a layer that the tile reads; clear their
        sums.
        """
        viscous = self.kernels.viscous
        reach_x, reach_y, reach_z = self.reach
        far, beside = 1 + viscous, viscous * reach_y
        within = self.is_owned(layer, viscous * reach_z)
        for j in self.beside(pick(within, far * reach_y, 0)):
            whole = within & (j >= self.y0 - beside) & (j < self.y1 + beside)
            begin, n = self.longer(pick(whole, far * reach_x, 0))
            row = self.row(self.rows, layer, j)
            for x, count, q, N in self.loaded(begin, begin + n, j, layer):
                self.kernels.load(count, q=q, N=N, w=row[0, self.at(x) :], p=self.p)
            clear(self.row(self.high, layer, j), MARGIN, self.n)

    def find_viscous(self, layer):
        """Find the viscous fluxes of the rows of a layer that pairs with owned nodes take."""
        owned, areas = self.is_owned(layer), self.part.metrics
        for j in self.beside(pick(owned, self.reach[1], 0)):
            within = owned & (j >= self.y0) & (j < self.y1)
            x, n = self.longer(pick(within, self.reach[0], 0))
            self.find_slopes(layer, j, x, n)
            row, at = self.row(self.rows, layer, j), self.at(x)
            place = self.ghosted_at(x, j, layer)
            given = {"w": row[0, at:], "s": row[self.d + 6, at:], "slope": self.slope[0, at:]}
            self.kernels.viscous_fluxes(n, a=areas[0, place:], N=self.N, p=self.p, **given)

    def find_slopes(self, layer, j, x, n):
        """Find D_k z of a row for each axis k."""
        d, at = self.d, self.at(x)
        here = self.row(self.rows, layer, j)
        clear(self.slope, at, n)
        for k in each(1, self.reach[0] + 1):
            before, after = self.gain[0][k, x - k + MARGIN :], self.loss[0][k, x + MARGIN :]
            near = here[0, at - k :], here[0, at + k :]
            self.add_slope(near, here[0, at:], before, after, self.slope[0, at:], n)
        for m in range(1, d):
            sweep = m == d - 1
            i = layer if sweep else j
            for k in each(1, self.part.S[m].shape[0]):
                before, after = self.gain[m][k, i - k + MARGIN], self.loss[m][k, i + MARGIN]
                with when((before != 0.0) | (after != 0.0)):
                    back, on = pick(before != 0.0, k, 0), pick(after != 0.0, k, 0)
                    for c in each(n, vector=True):
                        self.of_pair[0, c], self.of_pair[1, c] = before, after
                    rows = [(layer + to, j) if sweep else (layer, j + to) for to in (-back, on)]
                    near = [self.row(self.rows, *row)[0, at:] for row in rows]
                    slope = self.slope[m * (d + 1), at:]
                    self.add_slope(near, here[0, at:], self.of_pair[0], self.of_pair[1], slope, n)

    def add_slope(self, near, here, before, after, slope, n):
        """Add to D z what nodes of one distance give."""
        given = {"below": near[0], "here": here, "above": near[1], "p": self.p}
        self.kernels.slope(n, before=before, after=after, slope=slope, **given)

    def rates(self, layer):
        """Add the fluxes of the pairs that begin in a layer, and store its rates if it is owned."""
        owned = layer >= self.first[2]
        begin = np.maximum(self.y0 - self.reach[1], 0)
        for j in each(pick(owned, begin, self.y0), self.y1):
            clear(self.low, MARGIN, self.n)
            if self.d == 3:
                with when(owned):
                    self.across(layer, j, False)
            with when(j >= self.y0):
                if self.d > 1:
                    self.across(layer, j, True)
                with when(owned):
                    self.along(layer, j)
                    self.store(layer, j)

    def across(self, layer, j, sweep):
        """Add the pairs of row j of a layer with rows farther on: of other layers if it is a sweep,
        else of the same layer.
        """
        axis, i, number = (self.d - 1, layer, 2) if sweep else (1, j, 1)
        S, x0 = self.part.S[axis], self.x0
        stride = self.sizes[0] if axis == 1 else self.sizes[0] * self.sizes[1]
        beside = self.weight[1][j] if sweep else self.weight[2][layer]
        for k in each(1, np.minimum(S.shape[0], self.sizes[number] - i)):
            s = S[k, i]
            with when((s != 0.0) & (i + k >= self.first[number])):
                to = (layer + k, j) if sweep else (layer, j + k)
                rows = self.row(self.rows, layer, j), self.row(self.rows, *to)
                place = self.ghosted_at(x0, j, layer)
                of_node, high = self.weight[0][x0:], self.row(self.high, *to)
                ends = (MARGIN, place), (MARGIN, place + k * stride)
                self.pairs(axis, rows, ends, s * beside, of_node, high, self.n)

    def along(self, layer, j):
        """Add the pairs along row j of a layer."""
        row = self.row(self.rows, layer, j)
        of_row, high = self.weight[1][j] * self.weight[2][layer], self.row(self.high, layer, j)
        for m in each(*self.ends_of_spans):
            k, a, b = (self.spans[m, c] for c in range(3))
            at, place = self.at(a), self.ghosted_at(a, j, layer)
            of_node, ends = self.S[0][k, a + MARGIN :], ((at, place), (at + k, place + k))
            self.pairs(0, (row, row), ends, of_row, of_node, high, b - a)

    def pairs(self, axis, rows, ends, of_row, of_node, high, n):
        """Add the fluxes of n pairs of nodes along an axis. rows: of lower and of upper nodes;
        ends: where the first ones are in rows and in ghosted arrays.
        """
        metrics, d, kernels = self.part.metrics, self.d, self.kernels
        given = {"of_row": of_row, "of_node": of_node, "p": self.p, "N": self.N}
        given |= {"low": self.low[0, ends[0][0] :], "high": high[0, ends[1][0] :]}
        for side, row, (at, place) in zip("lr", rows, ends, strict=True):
            given[side] = row[0, at:]
            given[f"s_{side}"] = row[d + 6 + axis * (d + 1), at:]
            given[f"a_{side}"], given[f"v_{side}"] = (
                metrics[first, place:] for first in (axis * d, d * d)
            )
            given[f"potential_{side}"] = self.potential[place:]
        apart = kernels.near(n, **given)
        if kernels.far is not None:
            with when(apart > 0):
                kernels.far(n, **given)

    def store(self, layer, j):
        """Store the rates of row j of a layer and, of nodes that nothing else adds to, the next
        stage.
        """
        high = self.row(self.high, layer, j)
        of_row = 1.0 / (self.weight[1][j] * self.weight[2][layer])
        for x, n, kind in self.stored(self.x0, self.x1, j, layer):
            at, own = self.at(x), self.own_at(x, j, layer)
            given = {"low": self.low[0, at:], "high": high[0, at:], "of_node": self.per_weight[x:]}
            given["supplied"] = self.supplied[own * (self.d + 1) :]
            self.run(self.kernels.stores, kind, n, own, of_row=of_row, **given)


def clear(row, at, n):
    """Set the numbers of n nodes of a row to 0."""
    for c in each(row.shape[0]):
        for i in each(n, vector=True):
            row[c, at + i] = 0.0
