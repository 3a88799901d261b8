"""Rates of a block of gas, without fluxes through its faces:

    weight_i (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v})

and a constant force, which is summed pair by pair like the fluxes. On a grid that moves J has the
flux - g, that of U = 1; fsipetsc.scheme.gas_procedures adds a^k . v of nodes at the end of an axis.
The weight of a node is the product of those along all axes; S_il of a pair along axis k is that of
fsipetsc.operators.bands times the weights along the other axes. The fluxes are those of
fsipetsc.equations.gas.

The flux of a pair is computed once and added to both of its nodes. The sum of the lower node
belongs to the row at work; that of the upper node waits in a row of its own. The fluxes reach a
node in an order that does not depend on how a block is cut, so neither do the bits of its rate.
Layers are loaded when they are needed: few rows are at work, and fit into the fastest memory. A row
has the primitive variables w of its nodes and, in viscous gases, J and the fluxes a^k . f_v of each
axis k. The kernels are at the end.
"""

from functools import partial
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.checks import Array
from fsipetsc.equations.gas import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.equations.vectors import add, along, mean, scale, sub
from fsipetsc.kernels.arrays import aligned
from fsipetsc.kernels.kernel import PLANES, ROWS, Kernel, floats_of
from fsipetsc.kernels.loops import each, pick, when
from fsipetsc.operators.bands import Band, Patch
from fsipetsc.scheme.gas_terms import Form
from fsipetsc.scheme.sweep import KINDS, Sweep, in_order, kept, order, pieces, store

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


def _tiles(d: int, patch: Patch) -> Array:
    """Tiles of the owned nodes: (n, 4) first node and first beyond, of two axes."""
    inner, deep = (1, DEPTH) if d == 3 else (2, 1)
    of_rows = pieces(patch.first[inner], patch.own[inner], deep, deep)
    of_nodes = pieces(patch.first[0], patch.own[0], TILES[d], 8)
    return np.array([(*x, *y) for y, x in product(of_rows, of_nodes)])


def _spans(S: Array, begin: int, end: int) -> Array:
    """Spans of the pairs along a row of which a node is one of begin … end - 1: (n, 3) distance,
    first lower node and first beyond. A few pairs of weight 0 are taken along where that saves a
    span.
    """
    spans = []
    for k in range(1, len(S)):
        lower = np.flatnonzero(S[k, :end])
        lower = lower[lower >= begin - k]
        runs = np.split(lower, 1 + np.flatnonzero(np.diff(lower) > GAP))
        spans += [(k, run[0], run[-1] + 1) for run in runs if run.size]
    return np.array(spans, np.int64).reshape(-1, 3)


class GasSweep(Sweep):
    """The sweep of a part of a block: its data, beside the record of the part, and what is recorded
    of a tile. bands: of the ghosted nodes along three axes.

    p: parameters of the kernels. steps: (n, 2) stages and layers (fsipetsc.scheme.sweep.order).
    tiles, spans: see `_tiles`, `_spans`. S, gain, loss: of each axis (1 + reach, n + 2 MARGIN)
    weights of pairs by distance and lower node, these over the weight of the upper and of the lower
    node; zeros at the ends. per_weight: 1 over the weights along the first axis.

    layers, depth, before: so many layers of so many rows are kept, with rows before the tile's;
    width: how many numbers a row has room for.
    rows, high: of all these the numbers of nodes, and the sums of upper nodes of pairs. low, slope,
    of_pair: of the row at work the sums of lower nodes, D_k z, and gain and loss of one distance.

    potential: (N,) Phi of the ghosted nodes, where a constant force acts pair by pair; supplied:
    (M (d + 1),) the force on each owned node and room for a power, interlaced, over the node's
    weight (fsipetsc.scheme.gas_terms); else (0,).
    """

    def __init__(self, gas: Any, d: int, kernels: Any, bands: Any, patch: Patch) -> None:
        self.kernels, self.p = kernels, np.array([*floats_of(gas), 0.0])
        far = 1 + kernels.viscous
        x, inner, last = in_order(bands, d)
        _, _, n = in_order(patch.ghosted, d)
        _, _, begin = in_order(patch.first, d)
        first = max(begin - last.reach, 0)
        loaded = max(first - (far - 1) * last.reach, 0), n
        ranges = loaded, *([(first, n)] * (far - 1)), (first, begin + in_order(patch.own, d)[2])
        self.steps = order(last.S, ranges)
        self.tiles = _tiles(d, patch)
        self.spans = _spans(x.S, patch.first[0], patch.first[0] + patch.own[0])
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
        self.reach = in_order([part.axes[k, 0] for k in range(3)], self.d)
        self.weight = in_order([part.weight[k] for k in range(3)], self.d)
        stages = self.load, *([self.find_viscous] * self.kernels.viscous), self.rates
        for t in each(self.tiles.shape[0]):
            self.x0, self.x1, self.y0, self.y1 = (self.tiles[t, c] for c in range(4))
            self.n = self.x1 - self.x0
            for s in each(self.steps.shape[0]):
                stage, layer = self.steps[s, 0], self.steps[s, 1]
                for number, do in enumerate(stages):
                    with when(stage == number):
                        do(layer)

    def row(self, rows, layer, j):
        """Row j of a layer in an array of rows that are kept."""
        return rows[layer % self.layers * self.depth + (j - self.y0 + self.before)]

    def at(self, x):
        """Where the node x is in a row."""
        return x - self.x0 + MARGIN

    def longer(self, more):
        """Where a row begins that is longer than the tile on both sides, and how many nodes it has;
        it ends where the grid does.
        """
        begin = np.maximum(self.x0 - more, 0)
        return begin, np.minimum(self.x1 + more, self.sizes[0]) - begin

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
            self.row(self.high, layer, j)[:, MARGIN : MARGIN + self.n] = 0.0

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
        d, at, here = self.d, self.at(x), self.row(self.rows, layer, j)
        run = partial(self.kernels.slope, n, here=here[0, at:], p=self.p)
        self.slope[:, at : at + n] = 0.0
        for k in each(1, self.reach[0] + 1):
            before, after = self.gain[0][k, x - k + MARGIN :], self.loss[0][k, x + MARGIN :]
            near = {"below": here[0, at - k :], "above": here[0, at + k :]}
            run(before=before, after=after, slope=self.slope[0, at:], **near)
        for m in range(1, d):
            sweep = m == d - 1
            i = layer if sweep else j
            for k in each(1, self.part.axes[m, 0] + 1):
                before, after = self.gain[m][k, i - k + MARGIN], self.loss[m][k, i + MARGIN]
                with when((before != 0.0) | (after != 0.0)):
                    of_pair, near = self.of_pair, {}
                    of_pair[0, :n], of_pair[1, :n] = before, after
                    for name, to, weight in ("below", -k, before), ("above", k, after):
                        to = pick(weight != 0.0, to, 0)
                        row = (layer + to, j) if sweep else (layer, j + to)
                        near[name] = self.row(self.rows, *row)[0, at:]
                    slope = self.slope[m * (d + 1), at:]
                    run(before=of_pair[0], after=of_pair[1], slope=slope, **near)

    def rates(self, layer):
        """Add the fluxes of the pairs that begin in a layer, and store its rates if it is owned."""
        owned = layer >= self.first[2]
        begin = np.maximum(self.y0 - self.reach[1], 0)
        for j in each(pick(owned, begin, self.y0), self.y1):
            self.low[:, MARGIN : MARGIN + self.n] = 0.0
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
        for k in each(1, np.minimum(self.part.axes[axis, 0] + 1, self.sizes[number] - i)):
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
        for m in each(self.spans.shape[0]):
            k = self.spans[m, 0]
            a = np.maximum(self.spans[m, 1], self.x0 - k)
            n = np.minimum(self.spans[m, 2], self.x1) - a
            with when(n > 0):
                at, place = self.at(a), self.ghosted_at(a, j, layer)
                of_node, ends = self.S[0][k, a + MARGIN :], ((at, place), (at + k, place + k))
                self.pairs(0, (row, row), ends, of_row, of_node, high, n)

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


@kept
def gas_kernels(gas: Any, d: int, form: Form, viscous: bool, moves: bool) -> SimpleNamespace:
    """All kernels of a gas in d dimensions. far: None where the form does not tell pairs apart;
    slope, viscous_fluxes: None without viscosity; raises: of the form. numbers, sums: what a row
    has of a node, and what is summed of it.
    """
    sums, kinds = d + 2 + d * form.raises, KINDS[:1] if form.raises else KINDS
    return SimpleNamespace(
        load=_load(gas, d, viscous),
        near=_pair(gas, d, form, viscous, moves, True),
        far=_pair(gas, d, form, viscous, moves, False) if form.entropy else None,
        stores=tuple(_store(d, sums, moves, number, kind) for number, kind in enumerate(kinds)),
        slope=_slope(gas, d) if viscous else None,
        viscous_fluxes=_viscous(gas, d) if viscous else None,
        viscous=viscous,
        raises=form.raises,
        numbers=d + 5 + viscous * (1 + d * (d + 1)),
        sums=sums + moves,
    )


def _load(gas: Any, d: int, viscous: bool) -> Kernel:
    kernel = Kernel("gas_load", "The primitive variables w of the nodes of a row, perhaps J.")
    q = kernel.read("q", PLANES, d + 3)
    kernel.store("w", ROWS, kernel.parameters(gas).primitive(q))
    if viscous:
        kernel.store("w", ROWS, q[:1], d + 5)
    return kernel


def _pair(gas: Any, d: int, form: Form, viscous: bool, moves: bool, near: bool) -> Kernel:
    """The kernel of pairs of near nodes, which counts the other pairs, or the kernel of those. It
    adds what the lower node of a pair loses and the upper one gains, times the weight of the
    pair: that of the row, times that of the node. It is 0 of pairs that are not of the kernel's
    kind; those formulas are finite for ratios of states up to 1e28.
    """
    name, pairs = ("near", "pairs of near nodes") if near else ("far", "the other pairs of nodes")
    kernel = Kernel(f"gas_{name}", f"The fluxes of {pairs}, added to the sums of both.")
    gas = kernel.parameters(gas)
    l, r = kernel.read("l", ROWS, d + 5), kernel.read("r", ROWS, d + 5)
    a_l, a_r = kernel.read("a_l", PLANES, d), kernel.read("a_r", PLANES, d)
    of_row, (of_node,) = kernel.number("of_row"), kernel.read("of_node", ROWS, 1)
    if form.entropy:
        apart = gas.pair_distance(l, r) > NEAR
        of_node = np.where(apart, *((0.0, of_node) if near else (of_node, 0.0)))
        kernel.count(apart)
    g = 0.0
    if moves:
        grid = len(gas.of_grid((0.0,) * d))
        v_l, v_r = kernel.read("v_l", PLANES, grid), kernel.read("v_r", PLANES, grid)
        g = gas.volume_flux(a_l, v_l, a_r, v_r)
    rise = 0.0
    if form.raises:
        (low,), (high,) = kernel.read("potential_l", ROWS, 1), kernel.read("potential_r", ROWS, 1)
        rise = high - low
    both = form.pair(gas, l, r, a_l, a_r, g, rise, near)
    if viscous:
        s = mean(kernel.read("s_l", ROWS, d + 1), kernel.read("s_r", ROWS, d + 1))
        both = tuple((F[0], *sub(F[1 : d + 2], s), *F[d + 2 :]) for F in both)
    if moves:
        both = tuple((*F, -g) for F in both)
    less, more = (scale(of_row * of_node, numbers) for numbers in both)
    low, high = (kernel.read(name, ROWS, len(less)) for name in ("low", "high"))
    kernel.store("low", ROWS, sub(low, less))
    kernel.store("high", ROWS, add(high, more))
    return kernel


def _store(d: int, sums: int, moves: bool, number: int, kind: str) -> Kernel:
    says = "J_t, the rates of J rho, J rho u, J E, the force, of a row, or what follows from them."
    kernel = Kernel(f"gas_{kind}", says)
    of_row, (of_node,) = kernel.number("of_row"), kernel.read("of_node", ROWS, 1)
    total = add(*(kernel.read(name, ROWS, sums + moves) for name in ("low", "high")))
    total = scale(of_row * of_node, total)
    store(kernel, number, (total[-1] if moves else 0.0, *total[: d + 2]))
    if sums > d + 2:
        kernel.store("supplied", f"{{c}} + {{i}} * {d + 1}", (*total[d + 2 : sums], 0.0))
    return kernel


def _slope(gas: Any, d: int) -> Kernel:
    """D_k z of the entropy variables z, from the nodes of one distance before and after."""
    kernel = Kernel("gas_slope", "What the nodes of one distance give to D z, added to it.")
    gas = kernel.parameters(gas)
    below, z, above = (
        gas.entropy_variables(kernel.read(name, ROWS, d + 5)) for name in ("below", "here", "above")
    )
    before, after = kernel.read("before", ROWS, 1)[0], kernel.read("after", ROWS, 1)[0]
    more = along(scale(0.5 * after, sub(above, z)), 0.5 * before, sub(z, below))
    kernel.store("slope", ROWS, add(kernel.read("slope", ROWS, d + 1), more))
    return kernel


def _viscous(gas: Any, d: int) -> Kernel:
    kernel = Kernel("gas_viscous", "The viscous fluxes a^k . f_v of all axes k of a row's nodes.")
    gas, w = kernel.parameters(gas), kernel.read("w", ROWS, d + 5)
    (J,) = kernel.read("w", ROWS, 1, d + 5)
    areas = [kernel.read("a", PLANES, d, k * d) for k in range(d)]
    slopes = [kernel.read("slope", ROWS, d + 1, k * (d + 1)) for k in range(d)]
    scaled, inverse = outer(slopes[0][:-1], areas[0]), scale(slopes[0][-1], areas[0])
    for slope, area in zip(slopes[1:], areas[1:], strict=True):
        scaled, inverse = add(scaled, outer(slope[:-1], area)), along(inverse, slope[-1], area)
    scaled, inverse = scale(1.0 / J, scaled), scale(1.0 / J, inverse)
    stress, heat = gas.viscous_stress(w, scaled, inverse), gas.conduction(w, inverse)
    for k, area in enumerate(areas):
        kernel.store("s", ROWS, gas.viscous_flux(w, stress, heat, area), k * (d + 1))
    return kernel
