"""Rates of a block of gas in d = 1, 2 or 3 dimensions, without fluxes through its faces.

    (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v}) / weight_i + J s

and J_t from the metrics, with F of fsipetsc.equations.gas, S and the weights of
fsipetsc.operators.bands. F is symmetric and S antisymmetric, so mass, momentum and energy stay.
Viscous fluxes follow from gradients of the entropy variables z = (u, -1)/T,

    grad z = 1/J sum_k a^k D_k z.

The nodes are swept in tiles: TILE nodes along the first axis, a few rows along the second one of
three, and layer after layer along the last axis, so that what is worked on stays in the fastest
memory. Each pair's flux is computed once and added to both of its nodes: the sum of the lower one
belongs to the row at work, that of the upper one waits in a row of its own. The fluxes reach a node
in an order that does not depend on how a block is cut, so neither do the bits of its rate.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from fsipetsc.equations.means import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import (
    EXACT_LOOP,
    INLINED_CALL,
    MERGED_CALL,
    add,
    along,
    choose,
    mean,
    scale,
    sub,
)
from fsipetsc.scheme.rows import MARGIN, ONE, ROW, TILE, U64, Array, aligned, at, put

#: rows of a tile along the second of three axes
DEPTH = 8
#: zeros between two nodes with pairs of one distance that make two spans of them
GAP = 16


class Place(NamedTuple):
    """Where a row of nodes has its numbers, of one axis where this matters."""

    state: np.uint64
    grid: np.uint64
    area: np.uint64
    densities: np.uint64
    flux: np.uint64
    viscous: np.uint64


class EntropyForm(NamedTuple):
    """Two-point fluxes that conserve entropy."""

    kind: int = 0

    def kept(self, like):
        """As many numbers as a node keeps for its pairs."""
        return ()

    def near(self, gas, like, w, place, i, j):
        """The flux of the nodes i and j of a row, which are near one another."""
        l, r = pair_of(like, w, place, i, j)
        return gas.near_pair_flux(l, r, *grid_of(gas, like, w, place, i, j))

    def any(self, gas, like, w, place, i, j):
        """The flux of any two nodes."""
        l, r = pair_of(like, w, place, i, j)
        return gas.pair_flux(l, r, *grid_of(gas, like, w, place, i, j))

    def distance(self, gas, like, w, place, i, j):
        """How far they are apart."""
        like_w = state_like(like)
        return gas.pair_distance(
            at(like_w, w, place.state, ROW, i), at(like_w, w, place.state, ROW, j)
        )

    def keep(self, gas, like, w, row, n):
        """Nothing is kept."""
        return None

    def two(self, gas, l, r, a_l, v_l, a_r, v_r):
        """The flux of two states."""
        return gas.pair_flux(l, r, a_l, v_l, a_r, v_r)

    def through(self, gas, l, r, a, g):
        """The same through the area a whose volume flux is g."""
        return gas.flux_through(l, r, a, g)


class DivergenceForm(NamedTuple):
    """Means of the fluxes of two nodes: for any gas law, without a statement on entropy."""

    kind: int = 0

    def kept(self, like):
        return (*outer(like, like), *like, *like, *like, 0.0, 0.0)

    def near(self, gas, like, w, place, i, j):
        like_f = (*like, 0.0, 0.0)
        U = mean(at(like_f, w, place.densities, ROW, i), at(like_f, w, place.densities, ROW, j))
        f = mean(at(like_f, w, place.flux, ROW, i), at(like_f, w, place.flux, ROW, j))
        a_l, v_l, a_r, v_r = grid_of(gas, like, w, place, i, j)
        return along(f, -gas.volume_flux(a_l, v_l, a_r, v_r), U)

    def any(self, gas, like, w, place, i, j):
        return self.near(gas, like, w, place, i, j)

    def distance(self, gas, like, w, place, i, j):
        return 0.0

    def keep(self, gas, like, w, row, n):
        keep_fluxes(gas, like, w, place_of(like, self, row, 0), n)

    def two(self, gas, l, r, a_l, v_l, a_r, v_r):
        return gas.mean_flux(l, r, a_l, v_l, a_r, v_r)

    def through(self, gas, l, r, a, g):
        return gas.mean_flux_through(l, r, a, g)


class Inviscid(NamedTuple):
    """No viscous fluxes; reach: how many times farther nodes are read."""

    reach: int = 0

    def less(self, like, F, w, place, i, j):
        """F less the viscous flux."""
        return F


class Viscous(NamedTuple):
    """Viscosity and conduction."""

    reach: int = 1

    def less(self, like, F, w, place, i, j):
        like_s = (*like, 0.0)
        s = mean(at(like_s, w, place.viscous, ROW, i), at(like_s, w, place.viscous, ROW, j))
        return (F[0], *sub(F[1:], s))


class Axis(NamedTuple):
    """One axis of a patch: band, owned nodes begin … end - 1 of size, distance in memory."""

    S: Array
    weight: Array
    begin: int
    end: int
    size: int
    stride: int


class Axes(NamedTuple):
    """first: the contiguous one. last: that of the sweep. inner: the other one of three."""

    first: Axis
    inner: Axis
    last: Axis


class Tile(NamedTuple):
    """Nodes x0 … x1 - 1 along the first axis, y0 … y1 - 1 along the inner one.

    weights: where its gain and loss begin. spans, end: its spans are those from `spans` to `end`.
    """

    x0: int
    x1: int
    y0: int
    y1: int
    weights: np.uint64
    spans: int
    end: int


class Work(NamedTuple):
    """Memory of a sweep.

    w: rows of nodes with `numbers` each, `layers` layers of `depth` rows, `before` of these before
    the tile. high: sums of each row as the upper one of pairs, low: of one row as the lower one.
    slope: D_k z of one row. Of each tile along the first axis: gain, loss (tiles, K + 1, ROW), S
    over the weight of the upper and the lower node of pairs by distance, 0 where there are none;
    spans (n, 3), distance, begin and end of pairs, those of tile m from number begins[m] on. Rows 0
    of gain and loss serve the other axes.
    """

    layers: int
    depth: int
    before: int
    numbers: int
    w: Array
    high: Array
    low: Array
    slope: Array
    gain: Array
    loss: Array
    spans: Any
    begins: Any


def scratch(like: Any, form: Any, friction: Any, bands: Any, patch: Any) -> Work:
    """Memory for `gas_rates` with the three bands of a patch."""
    d, reach, row = len(like), 1 + friction.reach, int(ROW)
    K = [len(band.S) - 1 for band in bands]
    inner, last = (K[1], K[2]) if d == 3 else (0, K[1])
    layers, depth = reach * last + 1, (DEPTH if d == 3 else 1) + 2 * reach * inner
    gain, loss, spans, begins = _weights(bands[0], patch)
    numbers = 2 * d + 6 + d * d + len(form.kept(like)) + d * (d + 1)
    return Work(
        layers,
        depth,
        reach * inner,
        numbers,
        w=aligned(layers * depth * row * numbers),
        high=aligned(layers * depth * row * (d + 2)),
        low=aligned(row * (d + 2)),
        slope=aligned(row * d * (d + 1)),
        gain=gain,
        loss=loss,
        spans=spans,
        begins=begins,
    )


def _weights(band: Any, patch: Any) -> tuple[Array, Array, Any, Any]:
    """gain, loss, spans and begins of a Work."""
    S, weight, size = band.S, band.weight, patch.ghosted[0]
    begin, own = int(patch.first[0]), int(patch.own[0])
    wide, spans, begins = tiles_of(own), [], [0]
    gain, loss = (aligned(wide * len(S) * int(ROW)).reshape(wide, len(S), -1) for _ in range(2))
    for m in range(wide):
        x0, x1 = part(begin, begin + own, m, wide), part(begin, begin + own, m + 1, wide)
        nodes = x0 - MARGIN + np.arange(int(ROW))
        for k in range(1, len(S)):
            column = np.flatnonzero((nodes >= 0) & (nodes < size - k))
            i = nodes[column]
            gain[m, k, column], loss[m, k, column] = S[k, i] / weight[i + k], S[k, i] / weight[i]
            found = np.flatnonzero(S[k, max(x0 - k, 0) : x1]) + max(x0 - k, 0)
            for span in np.split(found, np.flatnonzero(np.diff(found) >= GAP) + 1):
                if span.size:
                    spans.append((k, span[0], span[-1] + 1))
        begins.append(len(spans))
    listed = np.array(spans, np.int64).reshape(-1, 3)
    return gain.reshape(-1), loss.reshape(-1), listed, np.array(begins)


# a row of nodes: w, a^1 … a^d, velocity of the grid, A around an axis, what the form keeps,
# viscous fluxes


@register_jitable
def state_like(like):
    """As many numbers as primitive variables."""
    return (*like, 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def place_of(like, form, row, k):
    """Where the row that begins at `row` has what pairs along axis k take."""
    d = len(like)
    grid = d + 5 + d * d
    densities, viscous = grid + d + 1, grid + d + 1 + len(form.kept(like))
    return Place(
        row,
        row + U64(grid) * ROW,
        row + U64(d + 5 + k * d) * ROW,
        row + U64(densities) * ROW,
        row + U64(densities + (d + 2) * (k + 1)) * ROW,
        row + U64(viscous + k * (d + 1)) * ROW,
    )


@register_jitable
def pair_of(like, w, place, i, j):
    """States of two nodes."""
    like_w = state_like(like)
    return at(like_w, w, place.state, ROW, i), at(like_w, w, place.state, ROW, j)


@register_jitable
def grid_of(gas, like, w, place, i, j):
    """Areas and velocities of the grid of two nodes, in turn."""
    like_v = gas.of_grid(like)
    a_l, v_l = at(like, w, place.area, ROW, i), at(like_v, w, place.grid, ROW, i)
    return a_l, v_l, at(like, w, place.area, ROW, j), at(like_v, w, place.grid, ROW, j)


# loops over nodes of a row


@njit(**EXACT_LOOP)
def load_row(gas, like, q, at_q, metrics, at_m, step, w, row, n):
    """Primitive variables and metrics."""
    like_q, like_m = (*like, 0.0, 0.0, 0.0), (*outer(like, like), *gas.of_grid(like))
    count = U64(len(like_q))
    for i in range(n):
        state = gas.primitive(at(like_q, q, at_q, ONE, i * count))
        put(w, row, ROW, i, (*state, *at(like_m, metrics, at_m, step, i)))


@njit(**EXACT_LOOP)
def keep_fluxes(gas, like, w, place, n):
    """Conserved variables and the inviscid fluxes through all areas."""
    d = U64(len(like))
    for i in range(n):
        state = at(state_like(like), w, place.state, ROW, i)
        put(w, place.densities, ROW, i, gas.densities(state))
        for k in range(d):
            a = at(like, w, place.area + k * d * ROW, ROW, i)
            put(w, place.flux + k * (d + U64(2)) * ROW, ROW, i, gas.flux(state, a))


@njit(**EXACT_LOOP)
def pair_row(
    gas, like, form, friction, w, place, other, gain, loss, weights, low, lower, high, upper, n
):
    """Add fluxes of nodes of a row and those `other` numbers on to the sums of both.

    Returns how many are farther apart than NEAR: these are left out, but for their viscous flux.
    """
    like_f, far = (*like, 0.0, 0.0), 0
    nothing = scale(0.0, like_f)
    for i in range(n):
        j = i + other
        apart = form.distance(gas, like, w, place, i, j) > NEAR
        F = choose(apart, nothing, form.near(gas, like, w, place, i, j))
        F = friction.less(like, F, w, place, i, j)
        put(low, lower, ROW, i, along(at(like_f, low, lower, ROW, i), -loss[weights + i], F))
        put(high, upper, ROW, i, along(at(like_f, high, upper, ROW, i), gain[weights + i], F))
        far += apart
    return far


@njit(**EXACT_LOOP)
def far_row(gas, like, form, w, place, other, gain, loss, weights, low, lower, high, upper, n):
    """Add the fluxes that were left out."""
    like_f = (*like, 0.0, 0.0)
    for i in range(n):
        j = i + other
        if form.distance(gas, like, w, place, i, j) > NEAR:
            F = form.any(gas, like, w, place, i, j)
            put(low, lower, ROW, i, along(at(like_f, low, lower, ROW, i), -loss[weights + i], F))
            put(high, upper, ROW, i, along(at(like_f, high, upper, ROW, i), gain[weights + i], F))


@njit(**EXACT_LOOP)
def store_row(gas, like, low, high, upper, q, at_q, metrics, J_t, rates, to, n):
    """J_t and the rates of a row, interlaced."""
    like_f, like_q = (*like, 0.0, 0.0), (*like, 0.0, 0.0, 0.0)
    count, lower = U64(len(like_q)), U64(MARGIN)
    for i in range(n):
        total = add(at(like_f, low, lower, ROW, i), at(like_f, high, upper, ROW, i))
        force = gas.body_force(at(like_q, q, at_q, ONE, i * count))
        put(rates, to, ONE, i * count, (metrics[J_t + i], total[0], *add(total[1:], force)))


@njit(**EXACT_LOOP)
def clear(to, start, components, n):
    """Zeros."""
    for c in range(components):
        for i in range(n):
            to[start + U64(c) * ROW + i] = 0.0


@njit(**EXACT_LOOP)
def fill(gain, loss, upper, lower, n):
    """Weights of pairs across rows, which are the same for all nodes of a row."""
    for i in range(n):
        gain[i], loss[i] = upper, lower


# a tile


@register_jitable
def number_of(work, tile, layer, j):
    """Number of the row j of a layer among those in memory."""
    return U64((layer % work.layers) * work.depth + j - tile.y0 + work.before)


@register_jitable
def row_of(work, tile, layer, j):
    """Where it begins in work.w."""
    return number_of(work, tile, layer, j) * U64(work.numbers) * ROW


@njit(**INLINED_CALL)
def load_layer(gas, like, form, friction, q, metrics, axes, tile, work, layer):
    """The rows of a layer that are read."""
    inner, last, d = axes.inner, axes.last, len(like)
    ahead, beside, reach = last.S.shape[0] - 1, inner.S.shape[0] - 1, 1 + friction.reach
    within = last.begin - friction.reach * ahead <= layer < last.end + friction.reach * ahead
    more = reach * beside if within else 0
    step = U64(metrics.size // (d * d + len(gas.of_grid(like)) + 1))
    for j in range(max(tile.y0 - more, 0), min(tile.y1 + more, inner.size)):
        whole = (
            within and tile.y0 - friction.reach * beside <= j < tile.y1 + friction.reach * beside
        )
        longer = reach * (axes.first.S.shape[0] - 1) if whole else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, axes.first.size)
        row, n = row_of(work, tile, layer, j) + U64(MARGIN + x0 - tile.x0), U64(x1 - x0)
        node = U64(x0 + j * inner.stride + layer * last.stride)
        load_row(gas, like, q, node * U64(d + 3), metrics, node, step, work.w, row, n)
        form.keep(gas, like, work.w, row, n)
        clear(work.high, number_of(work, tile, layer, j) * U64(d + 2) * ROW, d + 2, ROW)


@njit(**INLINED_CALL)
def pairs(gas, like, form, friction, work, row, k, other, weights, column, upper, n):
    """Add the fluxes of n pairs along axis k, of nodes of a row and those `other` numbers on.

    column: of the first pair, weights: where gain and loss begin, upper: the upper nodes' sums.
    """
    place, whole = place_of(like, form, row + column, k), U64((n + 3) // 4 * 4)
    w, gain, loss, low, high = work.w, work.gain, work.loss, work.low, work.high
    more = weights, low, column, high, upper
    far = pair_row(gas, like, form, friction, w, place, other, gain, loss, *more, whole)
    if far > 0:
        far_row(gas, like, form, w, place, other, gain, loss, *more, U64(n))


@njit(**INLINED_CALL)
def pairs_across(gas, like, form, friction, axes, tile, work, layer, j, along_last):
    """The pairs of row j of a layer with those in layers (or rows) farther on."""
    axis, k_axis = (axes.last, len(like) - 1) if along_last else (axes.inner, 1)
    i, n, row = layer if along_last else j, tile.x1 - tile.x0, row_of(work, tile, layer, j)
    up, right = (1, 0) if along_last else (0, 1)
    for k in range(1, axis.S.shape[0]):
        s = axis.S[k, i]
        if s != 0.0 and i + k >= axis.begin:
            fill(work.gain, work.loss, s / axis.weight[i + k], s / axis.weight[i], U64(n + 3))
            there, column = number_of(work, tile, layer + k * up, j + k * right), U64(MARGIN)
            other = there * U64(work.numbers) * ROW - row
            upper = there * U64(len(like) + 2) * ROW + column
            pairs(gas, like, form, friction, work, row, k_axis, other, U64(0), column, upper, n)


@njit(**INLINED_CALL)
def sweep_layer(gas, like, form, friction, q, metrics, axes, tile, work, rates, layer):
    """Add the fluxes of the pairs that begin in a layer; its rates if it is owned."""
    first, inner, last, d = axes.first, axes.inner, axes.last, len(like)
    owned, n = layer >= last.begin, U64(tile.x1 - tile.x0)
    for j in range(max(tile.y0 - inner.S.shape[0] + 1, 0) if owned else tile.y0, tile.y1):
        clear(work.low, U64(0), d + 2, ROW)
        if owned and d == 3:
            pairs_across(gas, like, form, friction, axes, tile, work, layer, j, False)
        if j < tile.y0:
            continue
        if d > 1:
            pairs_across(gas, like, form, friction, axes, tile, work, layer, j, True)
        if owned:
            row, high = (
                row_of(work, tile, layer, j),
                number_of(work, tile, layer, j) * U64(d + 2) * ROW,
            )
            for m in range(tile.spans, tile.end):
                k, a, b = work.spans[m, 0], work.spans[m, 1], work.spans[m, 2]
                column, other = U64(MARGIN + a - tile.x0), U64(k)
                weights, upper = tile.weights + other * ROW + column, high + column + other
                pairs(gas, like, form, friction, work, row, 0, other, weights, column, upper, b - a)
            node = U64(tile.x0 + j * inner.stride + layer * last.stride)
            own = (layer - last.begin) * (inner.end - inner.begin) + j - inner.begin
            to = U64((own * (first.end - first.begin) + tile.x0 - first.begin) * (d + 3))
            J_t = U64(metrics.size - first.size * inner.size * last.size) + node
            at_q, upper = node * U64(d + 3), high + U64(MARGIN)
            store_row(gas, like, work.low, work.high, upper, q, at_q, metrics, J_t, rates, to, n)


@njit(**INLINED_CALL)
def sweep(gas, like, form, friction, q, metrics, axes, tile, work, rates):
    """Sweep a tile along the last axis: load layers, complete them, take pairs that begin there."""
    last = axes.last
    ahead = last.S.shape[0] - 1
    behind = friction.reach * ahead
    completed = max(last.begin - ahead, 0)
    loaded = max(completed - behind, 0)
    for layer in range(completed, last.end):
        while completed <= layer + ahead and completed < last.size:
            while loaded <= completed + behind and loaded < last.size:
                load_layer(gas, like, form, friction, q, metrics, axes, tile, work, loaded)
                loaded += 1
            if friction.reach > 0:
                viscous_layer(gas, like, form, q, axes, tile, work, completed)
            completed += 1
        sweep_layer(gas, like, form, friction, q, metrics, axes, tile, work, rates, layer)


@njit(**MERGED_CALL)
def gas_rates(gas, like, form, friction, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, work):
    """Rates of the nodes of a patch that are owned.

    q: (N, d + 3) over the ghosted array, metrics: (d d + d + 1, N): a^1 … a^d, velocity of the
    grid, J_t, and around an axis A before it. rates: (M, d + 3) of the owned nodes: J_t, and those
    of J rho, J rho u, J E.
    """
    own, size, first = patch.own, patch.ghosted, patch.first
    x = Axis(S0, w0, first[0], first[0] + own[0], size[0], 1)
    y = Axis(S1, w1, first[1], first[1] + own[1], size[1], size[0])
    z = Axis(S2, w2, first[2], first[2] + own[2], size[2], size[0] * size[1])
    axes = Axes(x, y, z) if len(like) == 3 else Axes(x, z, y)
    inner, q, metrics, rates = axes.inner, q.reshape(-1), metrics.reshape(-1), rates.reshape(-1)
    wide, deep = tiles_of(own[0]), (inner.end - inner.begin + DEPTH - 1) // DEPTH
    for m in range(deep):
        y0, y1 = part(inner.begin, inner.end, m, deep), part(inner.begin, inner.end, m + 1, deep)
        for n in range(wide):
            x0, x1 = part(x.begin, x.end, n, wide), part(x.begin, x.end, n + 1, wide)
            weights = U64(n * S0.shape[0]) * ROW
            tile = Tile(x0, x1, y0, y1, weights, work.begins[n], work.begins[n + 1])
            sweep(gas, like, form, friction, q, metrics, axes, tile, work, rates)


@register_jitable
def tiles_of(nodes):
    """Tiles along the first axis."""
    return (nodes + TILE - 1) // TILE


@register_jitable
def part(begin, end, m, count):
    """Where part m of so many begins."""
    return begin + (end - begin) * m // count


# viscous fluxes


@njit(**EXACT_LOOP)
def slope_row(gas, like, w, low, here, high, gain, below, loss, above, slope, to, n):
    """Add what the nodes before and after give to D z."""
    like_w, like_z = state_like(like), (*like, 0.0)
    for i in range(n):
        z = gas.entropy_variables(at(like_w, w, here, ROW, i))
        up = sub(gas.entropy_variables(at(like_w, w, high, ROW, i)), z)
        down = sub(z, gas.entropy_variables(at(like_w, w, low, ROW, i)))
        more = along(scale(0.5 * loss[above + i], up), 0.5 * gain[below + i], down)
        put(slope, to, ROW, i, add(at(like_z, slope, to, ROW, i), more))


@register_jitable
def slopes_of(like, w, areas, slope, to, i, k):
    """What the derivatives along axis k give to J grad (u/T) and J grad (-1/T)."""
    g = at((*like, 0.0), slope, to + k * U64(len(like) + 1) * ROW, ROW, i)
    a = at(like, w, areas + k * U64(len(like)) * ROW, ROW, i)
    return outer(g[:-1], a), scale(g[-1], a)


@njit(**EXACT_LOOP)
def viscous_row(gas, like, w, place, q, at_q, slope, to, n):
    """a^k . f_v of all axes k, from the derivatives of z along them."""
    d, count = U64(len(like)), U64(len(like) + 3)
    for i in range(n):
        scaled, inverse = slopes_of(like, w, place.area, slope, to, i, U64(0))
        if len(like) > 1:
            more, by = slopes_of(like, w, place.area, slope, to, i, ONE)
            scaled, inverse = add(scaled, more), add(inverse, by)
        if len(like) > 2:
            more, by = slopes_of(like, w, place.area, slope, to, i, U64(2))
            scaled, inverse = add(scaled, more), add(inverse, by)
        per_J = 1.0 / q[at_q + i * count]
        scaled, inverse = scale(per_J, scaled), scale(per_J, inverse)
        here = at(state_like(like), w, place.state, ROW, i)
        stress, heat = gas.viscous_stress(here, scaled, inverse), gas.conduction(here, inverse)
        for k in range(d):
            a = at(like, w, place.area + k * d * ROW, ROW, i)
            flux = gas.viscous_flux(here, stress, heat, a)
            put(w, place.viscous + k * (d + ONE) * ROW, ROW, i, flux)


@njit(**INLINED_CALL)
def slopes(gas, like, axes, tile, work, layer, j, column, n):
    """D_k z of a row for each axis k."""
    w, gain, loss, slope = work.w, work.gain, work.loss, work.slope
    of_axis = U64(len(like) + 1) * ROW
    clear(slope, column, len(like) * (len(like) + 1), n)
    here = row_of(work, tile, layer, j) + column
    for k in range(1, axes.first.S.shape[0]):
        at_loss, m = tile.weights + U64(k) * ROW + column, U64(k)
        weights = gain, at_loss - m, loss, at_loss
        slope_row(gas, like, w, here - m, here, here + m, *weights, slope, column, n)
    for m in range(1, len(like)):
        axis, i = (axes.last, layer) if m == len(like) - 1 else (axes.inner, j)
        up, right = (1, 0) if m == len(like) - 1 else (0, 1)
        for k in range(1, axis.S.shape[0]):
            before = axis.S[k, i - k] / axis.weight[i] if i >= k else 0.0
            after = axis.S[k, i] / axis.weight[i] if i + k < axis.size else 0.0
            low, high = here, here
            if before != 0.0:
                low = row_of(work, tile, layer - k * up, j - k * right) + column
            if after != 0.0:
                high = row_of(work, tile, layer + k * up, j + k * right) + column
            if before != 0.0 or after != 0.0:
                fill(gain, loss, before, after, n)
                to, none = column + U64(m) * of_axis, U64(0)
                slope_row(gas, like, w, low, here, high, gain, none, loss, none, slope, to, n)


@njit(**INLINED_CALL)
def viscous_layer(gas, like, form, q, axes, tile, work, layer):
    """Viscous fluxes of the rows of a layer that pairs with owned nodes take."""
    first, inner, last = axes.first, axes.inner, axes.last
    owned = last.begin <= layer < last.end
    beside = inner.S.shape[0] - 1 if owned else 0
    for j in range(max(tile.y0 - beside, 0), min(tile.y1 + beside, inner.size)):
        longer = first.S.shape[0] - 1 if owned and tile.y0 <= j < tile.y1 else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, first.size)
        column, n = U64(MARGIN + x0 - tile.x0), U64(x1 - x0)
        slopes(gas, like, axes, tile, work, layer, j, column, n)
        place = place_of(like, form, row_of(work, tile, layer, j) + column, 0)
        at_q = U64(x0 + j * inner.stride + layer * last.stride) * U64(len(like) + 3)
        viscous_row(gas, like, work.w, place, q, at_q, work.slope, column, n)
