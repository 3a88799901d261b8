"""Rates of a block of gas in d = 1, 2 or 3 dimensions, without fluxes through its faces.

    (J U)_t,i = - sum_k sum_l S_il (F^k(i, l) - {a^k . f_v}) / weight_i + J s,      J_t from the metrics,

F of fsipetsc.equations.gas, S and the weights of fsipetsc.operators.bands. F is symmetric and S antisymmetric, so mass,
momentum and energy stay. Viscous fluxes follow from gradients of the entropy variables z = (u, -1)/T,

    grad z = 1/J sum_k a^k D_k z.

The nodes are swept in tiles: TILE nodes along the first axis, a few rows along the second one of three, and layer after layer
along the last axis, so that what is worked on stays in the fastest memory. Each pair's flux is computed once and kept
until both of its nodes have it. The fluxes reach a node in an order that does not depend on how a block is cut, so
neither do the bits of its rate.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from fsipetsc.equations.gas import volume_flux
from fsipetsc.equations.means import NEAR
from fsipetsc.equations.tensors import outer
from fsipetsc.materials import formulas as _  # noqa: F401  (names of the formulas of laws)
from fsipetsc.operators.loops import CALL, INNER_CALL, INNER_LOOP, add, along, dot, formulas, mean, scale, sub, zeros
from fsipetsc.scheme.rows import MARGIN, ONE, ROW, TILE, U64, Array, aligned, at, put

#: rows of a tile along the second of three axes
DEPTH = 8
#: zeros between two nodes with pairs of one distance, from which on they are apart; more than any distance
GAP = 16

formulas("values_like", "flux_like", "pair", "far_pair", "distance", "load", "friction_like", "less", "prepare", "complete")


class EntropyForm(NamedTuple):
    """Two-point fluxes that conserve entropy."""

    kind: int = 0

    def values_like(self, like):
        return (*like, 0.0, 0.0, 0.0, 0.0, 0.0)

    def flux_like(self, like):
        return ()

    def pair(self, gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r):
        return gas.near_pair_flux(l, r, a_l, v_l, a_r, v_r)

    def far_pair(self, gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r):
        return gas.pair_flux(l, r, a_l, v_l, a_r, v_r)

    def distance(self, gas, l, r):
        return gas.pair_distance(l, r)

    def load(self, gas, like, columns, w, row, n):
        return None


class DivergenceForm(NamedTuple):
    """Means of the fluxes of two nodes: cheaper, for any gas law, without a statement on entropy."""

    kind: int = 0

    def values_like(self, like):
        return (*like, 0.0, 0.0)

    def flux_like(self, like):
        return (*like, 0.0, 0.0)

    def pair(self, gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r):
        return along(mean(f_l, f_r), -volume_flux(a_l, v_l, a_r, v_r), mean(l, r))

    def far_pair(self, gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r):
        return along(mean(f_l, f_r), -volume_flux(a_l, v_l, a_r, v_r), mean(l, r))

    def distance(self, gas, l, r):
        return 0.0

    def load(self, gas, like, columns, w, row, n):
        load_fluxes(gas, like, columns, w, row, w, n)


class Inviscid(NamedTuple):
    """No viscous fluxes."""

    reach: int = 0

    def friction_like(self, like):
        return ()

    def less(self, F, s_l, s_r):
        return F

    def prepare(self, gas, like, columns, q, first, w, row, n, k):
        return None

    def complete(self, gas, like, axes, tile, work, layer):
        return None


class Viscous(NamedTuple):
    """Viscosity and conduction; reach: how many times farther nodes are read."""

    reach: int = 1

    def friction_like(self, like):
        return (*like, 0.0)

    def less(self, F, s_l, s_r):
        return (F[0], *sub(F[1:], mean(s_l, s_r)))

    def prepare(self, gas, like, columns, q, first, w, row, n, k):
        load_entropy_variables(gas, like, q, first, w, row + columns.primitives, w, row + columns.scaled, n)
        clear_slopes(like, w, row + columns.scaled - k, k)
        clear_slopes(like, w, row + columns.scaled + n, k)

    def complete(self, gas, like, axes, tile, work, layer):
        viscous_layer(gas, like, axes, tile, work, layer)


class Columns(NamedTuple):
    """Where a row of nodes has its numbers, in rows of components: each begins at a multiple of ROW.

    primitives: w. areas: a^1 … a^d. grid: its velocity. points: what pairs take of nodes,
    primitive or conserved variables. fluxes: inviscid ones through a^1 … a^d, frictions: viscous ones. scaled:
    (u, -1)/T and 1/J. size: of a row.
    """

    primitives: np.uint64
    areas: np.uint64
    grid: np.uint64
    points: np.uint64
    fluxes: np.uint64
    frictions: np.uint64
    scaled: np.uint64
    size: np.uint64


class Axis(NamedTuple):
    """One axis of a patch: pair weights and weights, the nodes begin … end - 1 of size that are owned, and their distance in
    memory.
    """

    S: Array
    weight: Array
    begin: int
    end: int
    size: int
    stride: int


class Axes(NamedTuple):
    """first: the contiguous one. last: along which layers are swept. inner: the other one of three dimensions."""

    first: Axis
    inner: Axis
    last: Axis


class Tile(NamedTuple):
    """Nodes x0 … x1 - 1 along the first axis, y0 … y1 - 1 along the inner one."""

    x0: int
    x1: int
    y0: int
    y1: int


class Work(NamedTuple):
    """Memory of a sweep.

    w: rows of nodes, `layers` layers of `depth` rows. first, inner, last: fluxes of pairs along each
    axis: of one row, of some rows, of some layers. rate: of one row. slope: of z, of one row.
    gain, loss: (K + 1, ROW) S / weight of the pairs (i - k, i) and (i, i + k). spans: (n, 3) k, begin and end of pairs.
    """

    columns: Columns
    layers: int
    depth: int
    w: Array
    first: Array
    inner: Array
    last: Array
    rate: Array
    slope: Array
    gain: Array
    loss: Array
    spans: Any


def columns_of(like: Any, form: Any, friction: Any) -> Columns:
    """Where rows of nodes have their numbers."""
    d = len(like)
    pairs_take_state = len(form.values_like(like)) == d + 5
    viscous = len(friction.friction_like(like)) > 0
    counts = {
        "primitives": d + 5,
        "areas": d * d,
        "grid": d,
        "points": 0 if pairs_take_state else d + 2,
        "fluxes": d * len(form.flux_like(like)),
        "frictions": d * len(friction.friction_like(like)),
        "scaled": d + 2 if viscous else 0,
    }
    starts = dict(zip(counts, np.cumsum([0, *counts.values()]), strict=False))
    if pairs_take_state:
        starts["points"] = starts["primitives"]
    return Columns(**{name: U64(start) * ROW for name, start in starts.items()}, size=U64(sum(counts.values())) * ROW)


def scratch(like: Any, form: Any, friction: Any, bands: Any) -> Work:
    """Memory for `gas_rates` with the three bands of a patch."""
    d, reach = len(like), 1 + friction.reach
    K = [len(band.S) - 1 for band in bands]
    inner, last = (K[1], K[2]) if d == 3 else (0, K[1])
    columns = columns_of(like, form, friction)
    layers, depth = reach * last + 1, (DEPTH if d == 3 else 1) + 2 * reach * inner
    row, flux = int(columns.size), (d + 2) * int(ROW)
    return Work(
        columns,
        layers,
        depth,
        w=aligned(layers * depth * row),
        first=aligned(flux),
        inner=aligned(ring(inner + 1) * flux),
        last=aligned(ring(last + 1) * (DEPTH if d == 3 else 1) * flux),
        rate=aligned(flux),
        slope=aligned(d * (d + 1) * int(ROW)),
        gain=aligned((K[0] + 1) * int(ROW)),
        loss=aligned((K[0] + 1) * int(ROW)),
        spans=np.zeros((4 * (K[0] + 1) * TILE // GAP, 3), np.int64),
    )


@register_jitable
def ring(k):
    """Where fluxes of pairs of distance k begin: those of distance m < k take m + 1 places."""
    return (k - 1) * (k + 2) // 2 if k > 0 else 0


# loops over nodes of a row


@njit(**INNER_LOOP)
def load_state(gas, like, q, first, w, row, n):
    """Primitive variables of interlaced nodes."""
    like_q = (*like, 0.0, 0.0, 0.0)
    count = U64(len(like_q))
    for i in range(n):
        put(w, row, ROW, i, gas.primitive(at(like_q, q, first, ONE, i * count)))


@njit(**INNER_LOOP)
def load_metrics(like, metrics, first, step, w, row, n):
    """A part of the metrics."""
    for i in range(n):
        put(w, row, ROW, i, at(like, metrics, first, step, i))


@njit(**INNER_LOOP)
def load_values(gas, like, w, state, to, values, n):
    """Conserved variables."""
    like_w = (*like, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(n):
        put(to, values, ROW, i, gas.densities(at(like_w, w, state, ROW, i)))


@njit(**INNER_LOOP)
def load_flux(gas, like, w, state, area, to, flux, n):
    """Inviscid fluxes through one of the areas."""
    like_w = (*like, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(n):
        put(to, flux, ROW, i, gas.flux(at(like_w, w, state, ROW, i), at(like, w, area, ROW, i)))


@njit(**INNER_CALL)
def load_fluxes(gas, like, columns, w, row, to, n):
    """Conserved variables and inviscid fluxes through all areas."""
    d = U64(len(like))
    load_values(gas, like, w, row + columns.primitives, to, row + columns.points, n)
    for k in range(d):
        area, flux = row + columns.areas + k * d * ROW, row + columns.fluxes + k * (d + U64(2)) * ROW
        load_flux(gas, like, w, row + columns.primitives, area, to, flux, n)


@njit(**INNER_LOOP)
def pair_row(gas, like, form, friction, w, values, velocity, area, flux, viscous, other, to, at_to, n):
    """Fluxes of nodes of a row and those `other` numbers on; how many are farther apart than NEAR."""
    like_w, like_f, like_s = form.values_like(like), form.flux_like(like), friction.friction_like(like)
    far = 0
    for i in range(n):
        j = i + other
        l, r = at(like_w, w, values, ROW, i), at(like_w, w, values, ROW, j)
        v_l, v_r = at(like, w, velocity, ROW, i), at(like, w, velocity, ROW, j)
        a_l, a_r = at(like, w, area, ROW, i), at(like, w, area, ROW, j)
        f_l, f_r = at(like_f, w, flux, ROW, i), at(like_f, w, flux, ROW, j)
        s_l, s_r = at(like_s, w, viscous, ROW, i), at(like_s, w, viscous, ROW, j)
        F = form.pair(gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r)
        put(to, at_to, ROW, i, friction.less(F, s_l, s_r))
        far += form.distance(gas, l, r) > NEAR
    return far


@njit(**INNER_LOOP)
def far_row(gas, like, form, friction, w, values, velocity, area, flux, viscous, other, to, at_to, n):
    """The same again for pairs that are farther apart than NEAR."""
    like_w, like_f, like_s = form.values_like(like), form.flux_like(like), friction.friction_like(like)
    for i in range(n):
        j = i + other
        l, r = at(like_w, w, values, ROW, i), at(like_w, w, values, ROW, j)
        if form.distance(gas, l, r) > NEAR:
            v_l, v_r = at(like, w, velocity, ROW, i), at(like, w, velocity, ROW, j)
            a_l, a_r = at(like, w, area, ROW, i), at(like, w, area, ROW, j)
            f_l, f_r = at(like_f, w, flux, ROW, i), at(like_f, w, flux, ROW, j)
            s_l, s_r = at(like_s, w, viscous, ROW, i), at(like_s, w, viscous, ROW, j)
            F = form.far_pair(gas, l, v_l, a_l, f_l, r, v_r, a_r, f_r)
            put(to, at_to, ROW, i, friction.less(F, s_l, s_r))


@njit(**INNER_LOOP)
def gather_first(like, flux, low, high, gain, loss, at_gain, rate, at_rate, n):
    """rate += gain F_low - loss F_high, with pair weights of each node."""
    like_f = (*like, 0.0, 0.0)
    for i in range(n):
        here = at(like_f, rate, at_rate, ROW, i)
        here = along(here, gain[at_gain + i], at(like_f, flux, low, ROW, i))
        put(rate, at_rate, ROW, i, along(here, -loss[at_gain + i], at(like_f, flux, high, ROW, i)))


@njit(**INNER_LOOP)
def gather(like, flux, low, high, gain, loss, rate, at_rate, n):
    """rate += gain F_low - loss F_high."""
    like_f = (*like, 0.0, 0.0)
    for i in range(n):
        here = at(like_f, rate, at_rate, ROW, i)
        here = along(here, gain, at(like_f, flux, low, ROW, i))
        put(rate, at_rate, ROW, i, along(here, -loss, at(like_f, flux, high, ROW, i)))


@njit(**INNER_LOOP)
def clear(like, to, start, n):
    """Zeros."""
    for i in range(n):
        put(to, start, ROW, i, zeros((*like, 0.0, 0.0)))


@njit(**INNER_LOOP)
def clear_slopes(like, to, start, n):
    """Zeros."""
    for i in range(n):
        put(to, start, ROW, i, zeros((*like, 0.0)))


@njit(**INNER_LOOP)
def store_rates(like, rate, at_rate, metrics, J_t, rates, first, n):
    """J_t and the rates of a row, interlaced."""
    like_f = (*like, 0.0, 0.0)
    count = U64(len(like) + 3)
    for i in range(n):
        put(rates, first, ONE, i * count, (metrics[J_t + i], *at(like_f, rate, at_rate, ROW, i)))


@njit(**INNER_LOOP)
def add_body_force(gas, like, q, first, rates, to, n):
    """rates += J s."""
    like_q = (*like, 0.0, 0.0, 0.0)
    count = U64(len(like_q))
    for i in range(n):
        force = gas.body_force(at(like_q, q, first, ONE, i * count))
        here = at(like_q, rates, to, ONE, i * count)
        put(rates, to, ONE, i * count, add(here, (0.0, 0.0, *force)))


# a tile


@njit(**INNER_CALL)
def weigh_first(axis, tile, gain, loss):
    """S / weight of nodes of a tile, of the pairs (i - k, i) and (i, i + k)."""
    for k in range(1, axis.S.shape[0]):
        more = axis.S.shape[0] - 1
        for i in range(max(tile.x0 - more, 0), min(tile.x1 + more, axis.size)):
            to = k * int(ROW) + MARGIN + i - tile.x0
            gain[to] = axis.S[k, i - k] / axis.weight[i] if i >= k else 0.0
            loss[to] = axis.S[k, i] / axis.weight[i]


@njit(**INNER_CALL)
def find_spans(axis, tile, spans):
    """Where along the first axis there are pairs: spans[m] = (k, a, b), of the nodes a … b - 1 and those k on; how many."""
    count = 0
    for k in range(1, axis.S.shape[0]):
        last = -GAP
        for i in range(max(tile.x0 - k, 0), tile.x1):
            if axis.S[k, i] != 0.0:
                if i - last >= GAP:
                    spans[count, 0], spans[count, 1] = k, i
                    count += 1
                last = i
                spans[count - 1, 2] = i + 1
    return count


@njit(**INNER_CALL)
def row_of(work, inner, tile, reach, layer, j):
    """Where the row j of a layer begins in work.w."""
    first = tile.y0 - reach * (inner.S.shape[0] - 1)
    return U64((layer % work.layers) * work.depth + j - first) * work.columns.size


@njit(**INNER_CALL)
def load_layer(gas, like, form, friction, q, metrics, axes, tile, work, layer):
    """The rows of a layer that are read."""
    inner, last, columns, w = axes.inner, axes.last, work.columns, work.w
    reach = 1 + friction.reach
    ahead, beside, along = last.S.shape[0] - 1, inner.S.shape[0] - 1, axes.first.S.shape[0] - 1
    within = last.begin - friction.reach * ahead <= layer < last.end + friction.reach * ahead
    more = reach * beside if within else 0
    step = U64(metrics.size // (len(like) * len(like) + len(like) + 1))
    like_q = (*like, 0.0, 0.0, 0.0)
    for j in range(max(tile.y0 - more, 0), min(tile.y1 + more, inner.size)):
        whole = within and tile.y0 - friction.reach * beside <= j < tile.y1 + friction.reach * beside
        longer = reach * along if whole else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, axes.first.size)
        row = row_of(work, inner, tile, reach, layer, j) + U64(MARGIN + x0 - tile.x0)
        node, n = U64(x0 + j * inner.stride + layer * last.stride), U64(x1 - x0)
        load_state(gas, like, q, node * U64(len(like_q)), w, row + columns.primitives, n)
        for c in range(len(like) + 1):  # a^1 … a^d, the velocity of the grid
            of_vector = U64(c * len(like))
            load_metrics(like, metrics, node + of_vector * step, step, w, row + columns.areas + of_vector * ROW, n)
        form.load(gas, like, columns, w, row, n)
        friction.prepare(gas, like, columns, q, node * U64(len(like_q)), w, row, n, U64(along))


@njit(**INNER_CALL)
def pairs(gas, like, form, friction, work, row, k_axis, other, to, at_to, n):
    """Fluxes of n pairs of nodes: of a row, from its column at `row`, and those `other` numbers on, along an axis."""
    columns, d = work.columns, len(like)
    values, velocity = row + columns.points, row + columns.grid
    area, flux = row + columns.areas + U64(k_axis * d) * ROW, row + columns.fluxes + U64(k_axis * (d + 2)) * ROW
    viscous = row + columns.frictions + U64(k_axis * (d + 1)) * ROW
    whole = U64((n + 3) // 4 * 4)
    w = work.w
    if pair_row(gas, like, form, friction, w, values, velocity, area, flux, viscous, other, to, at_to, whole) > 0:
        far_row(gas, like, form, friction, w, values, velocity, area, flux, viscous, other, to, at_to, U64(n))


@njit(**INNER_CALL)
def rates_along(gas, like, form, friction, tile, work, row, count):
    """What pairs of nodes of a row give it."""
    for m in range(count):
        k, a, b = work.spans[m]
        at_flux = U64(MARGIN + a - tile.x0)
        pairs(gas, like, form, friction, work, row + at_flux, 0, U64(k), work.first, at_flux, b - a)
        clear(like, work.first, at_flux - U64(k), U64(k))
        clear(like, work.first, at_flux + U64(b - a), U64(k))
        i, n = max(a, tile.x0), min(b + k, tile.x1) - max(a, tile.x0)
        at_rate = U64(MARGIN + i - tile.x0)
        gather_first(
            like, work.first, at_rate - U64(k), at_rate, work.gain, work.loss,
            U64(k) * ROW + at_rate, work.rate, at_rate, U64(n)
        )


@njit(**INNER_CALL)
def gather_across(like, axis, flux, place, size, here, i, work, n):
    """What pairs across rows or layers give node i of an axis; their fluxes stand `place` on in a ring of pieces of `size`."""
    for k in range(1, axis.S.shape[0]):
        gain = axis.S[k, i - k] / axis.weight[i] if i >= k else 0.0
        loss = axis.S[k, i] / axis.weight[i]
        if gain != 0.0 or loss != 0.0:
            high = U64((ring(k) + i % (k + 1)) * size + place)
            low = U64((ring(k) + (i - k) % (k + 1)) * size + place) if gain != 0.0 else high
            high = high if loss != 0.0 else low
            gather(like, flux, low, high, gain, loss, work.rate, here, n)


@njit(**INNER_CALL)
def pairs_across(gas, like, form, friction, axes, tile, work, layer, j, along_last, flux, place, size):
    """Fluxes of pairs of row j of a layer and those in layers (or rows) farther on."""
    axis, k_axis = (axes.last, len(like) - 1) if along_last else (axes.inner, 1)
    i, reach = layer if along_last else j, 1 + friction.reach
    row = row_of(work, axes.inner, tile, reach, layer, j)
    for k in range(1, axis.S.shape[0]):
        if axis.S[k, i] != 0.0 and i + k >= axis.begin:
            up, right = (k, 0) if along_last else (0, k)
            other = row_of(work, axes.inner, tile, reach, layer + up, j + right) - row
            to = U64((ring(k) + i % (k + 1)) * size + place + MARGIN)
            pairs(gas, like, form, friction, work, row + U64(MARGIN), k_axis, other, flux, to, tile.x1 - tile.x0)


@njit(**INNER_CALL)
def rates_of_layer(gas, like, form, friction, q, metrics, axes, tile, work, rates, layer, count):
    """Fluxes of the pairs that begin in a layer; its rates if it is owned."""
    inner, last = axes.inner, axes.last
    owned, size = layer >= last.begin, (len(like) + 2) * int(ROW)
    depth = tile.y1 - tile.y0
    n, here, columns = U64(tile.x1 - tile.x0), U64(MARGIN), len(like) + 3
    first_row = max(tile.y0 - inner.S.shape[0] + 1, 0) if owned else tile.y0
    for j in range(first_row, tile.y1):
        if owned:
            pairs_across(gas, like, form, friction, axes, tile, work, layer, j, False, work.inner, 0, size)
        if j < tile.y0:
            continue
        place = (j - tile.y0) * size
        pairs_across(gas, like, form, friction, axes, tile, work, layer, j, True, work.last, place, depth * size)
        if owned:
            clear(like, work.rate, here, n)
            row = row_of(work, inner, tile, 1 + friction.reach, layer, j)
            rates_along(gas, like, form, friction, tile, work, row, count)
            gather_across(like, inner, work.inner, MARGIN, size, here, j, work, n)
            gather_across(like, last, work.last, place + MARGIN, depth * size, here, layer, work, n)
            node = tile.x0 + j * inner.stride + layer * last.stride
            own = (layer - last.begin) * (inner.end - inner.begin) + j - inner.begin
            to = U64((own * (axes.first.end - axes.first.begin) + tile.x0 - axes.first.begin) * columns)
            J_t = U64(metrics.size - axes.first.size * inner.size * last.size + node)
            store_rates(like, work.rate, here, metrics, J_t, rates, to, n)
            if dot(gas.force, gas.force) > 0.0:
                add_body_force(gas, like, q, U64(node * columns), rates, to, n)


@njit(**INNER_CALL)
def rates_of_tile(gas, like, form, friction, q, metrics, axes, tile, work, rates):
    """Sweep along the last axis: load layers, complete them, take the pairs that begin in them."""
    last = axes.last
    ahead = last.S.shape[0] - 1
    behind = friction.reach * ahead
    weigh_first(axes.first, tile, work.gain, work.loss)
    count = find_spans(axes.first, tile, work.spans)
    completed = max(last.begin - ahead, 0)
    loaded = max(completed - behind, 0)
    for layer in range(completed, last.end):
        while completed <= layer + ahead and completed < last.size:
            while loaded <= completed + behind and loaded < last.size:
                load_layer(gas, like, form, friction, q, metrics, axes, tile, work, loaded)
                loaded += 1
            friction.complete(gas, like, axes, tile, work, completed)
            completed += 1
        rates_of_layer(gas, like, form, friction, q, metrics, axes, tile, work, rates, layer, count)


@njit(**CALL)
def gas_rates(gas, like, form, friction, q, metrics, S0, S1, S2, w0, w1, w2, patch, rates, work):
    """Rates of the nodes of a patch that are owned.

    q: (N, d + 3) over the ghosted array, metrics: (d d + d + 1, N): a^1 … a^d, velocity of the grid, J_t.
    rates: (M, d + 3) of the owned nodes: J_t, and those of J rho, J rho u, J E.
    """
    own, size, first = patch.own, patch.ghosted, patch.first
    x = Axis(S0, w0, first[0], first[0] + own[0], size[0], 1)
    y = Axis(S1, w1, first[1], first[1] + own[1], size[1], size[0])
    z = Axis(S2, w2, first[2], first[2] + own[2], size[2], size[0] * size[1])
    axes = Axes(x, y, z) if len(like) == 3 else Axes(x, z, y)
    inner, q, metrics, rates = axes.inner, q.reshape(-1), metrics.reshape(-1), rates.reshape(-1)
    wide, deep = parts(own[0], TILE), parts(inner.end - inner.begin, DEPTH)
    for m in range(deep):
        y0, y1 = part(inner.begin, inner.end, m, deep), part(inner.begin, inner.end, m + 1, deep)
        for n in range(wide):
            tile = Tile(part(x.begin, x.end, n, wide), part(x.begin, x.end, n + 1, wide), y0, y1)
            rates_of_tile(gas, like, form, friction, q, metrics, axes, tile, work, rates)


@njit(**INNER_CALL)
def parts(count, most):
    """Into how many parts of at most so many."""
    return (count + most - 1) // most


@njit(**INNER_CALL)
def part(begin, end, m, count):
    """Where part m of so many begins."""
    return begin + (end - begin) * m // count


# viscous fluxes


@njit(**INNER_LOOP)
def load_entropy_variables(gas, like, q, first, w, state, to, entropy, n):
    """(u, -1)/T and 1/J."""
    like_w, count = (*like, 0.0, 0.0, 0.0, 0.0, 0.0), U64(len(like) + 3)
    for i in range(n):
        z = gas.entropy_variables(at(like_w, w, state, ROW, i))
        put(to, entropy, ROW, i, (*z, 1.0 / q[first + i * count]))


@njit(**INNER_LOOP)
def slopes_first(like, w, low, here, high, gain, loss, at_gain, slope, to, n):
    """Adds what pairs along a row give to the derivatives of z."""
    like_z = (*like, 0.0)
    for i in range(n):
        z = at(like_z, w, here, ROW, i)
        up, down = sub(at(like_z, w, high, ROW, i), z), sub(z, at(like_z, w, low, ROW, i))
        more = along(scale(0.5 * loss[at_gain + i], up), 0.5 * gain[at_gain + i], down)
        put(slope, to, ROW, i, add(at(like_z, slope, to, ROW, i), more))


@njit(**INNER_LOOP)
def slopes_across(like, w, low, here, high, gain, loss, slope, to, n):
    """The same of pairs across rows."""
    like_z = (*like, 0.0)
    for i in range(n):
        z = at(like_z, w, here, ROW, i)
        up, down = sub(at(like_z, w, high, ROW, i), z), sub(z, at(like_z, w, low, ROW, i))
        more = along(scale(0.5 * loss, up), 0.5 * gain, down)
        put(slope, to, ROW, i, add(at(like_z, slope, to, ROW, i), more))


@register_jitable
def slopes_of(like, w, area, slope, to, i, k):
    """What the derivatives along axis k give to J grad (u/T) and J grad (-1/T)."""
    g = at((*like, 0.0), slope, to + k * U64(len(like) + 1) * ROW, ROW, i)
    a = at(like, w, area + k * U64(len(like)) * ROW, ROW, i)
    return outer(g[:-1], a), scale(g[-1], a)


@njit(**INNER_LOOP)
def viscous_row(gas, like, w, state, area, entropy, slope, to, result, friction, n):
    """a^k . f_v of all axes k, from the derivatives of z along them."""
    like_w, d = (*like, 0.0, 0.0, 0.0, 0.0, 0.0), U64(len(like))
    per_J = entropy + (d + ONE) * ROW
    for i in range(n):
        scaled, inverse = slopes_of(like, w, area, slope, to, i, U64(0))
        if len(like) > 1:
            more, by = slopes_of(like, w, area, slope, to, i, ONE)
            scaled, inverse = add(scaled, more), add(inverse, by)
        if len(like) > 2:
            more, by = slopes_of(like, w, area, slope, to, i, U64(2))
            scaled, inverse = add(scaled, more), add(inverse, by)
        scaled, inverse = scale(w[per_J + i], scaled), scale(w[per_J + i], inverse)
        here = at(like_w, w, state, ROW, i)
        stress, heat = gas.viscous_stress(here, scaled, inverse), gas.conduction(here, inverse)
        for k in range(d):
            a = at(like, w, area + k * d * ROW, ROW, i)
            put(result, friction + k * (d + ONE) * ROW, ROW, i, gas.viscous_flux(here, stress, heat, a))


@njit(**INNER_CALL)
def slopes_along(like, axis, work, row, slope, at_column, n):
    """Derivatives of z along a row."""
    for k in range(1, axis.S.shape[0]):
        z = row + work.columns.scaled
        at_gain = U64(k) * ROW + at_column
        low, high = z - U64(k), z + U64(k)
        slopes_first(like, work.w, low, z, high, work.gain, work.loss, at_gain, work.slope, slope, n)


@njit(**INNER_CALL)
def slopes_beside(like, axes, tile, work, layer, j, along_last, column, slope, n):
    """Derivatives of z across rows or layers."""
    axis, i = (axes.last, layer) if along_last else (axes.inner, j)
    z = row_of(work, axes.inner, tile, 2, layer, j) + work.columns.scaled + column
    for k in range(1, axis.S.shape[0]):
        gain = axis.S[k, i - k] / axis.weight[i] if i >= k else 0.0
        loss = axis.S[k, i] / axis.weight[i] if i + k < axis.size else 0.0
        up, right = (k, 0) if along_last else (0, k)
        low, high = z, z
        if gain != 0.0:
            low = row_of(work, axes.inner, tile, 2, layer - up, j - right) + work.columns.scaled + column
        if loss != 0.0:
            high = row_of(work, axes.inner, tile, 2, layer + up, j + right) + work.columns.scaled + column
        if gain != 0.0 or loss != 0.0:
            slopes_across(like, work.w, low, z, high, gain, loss, work.slope, slope, n)


@njit(**INNER_CALL)
def viscous_layer(gas, like, axes, tile, work, layer):
    """Viscous fluxes of the rows of a layer that pairs with owned nodes take."""
    inner, last, columns = axes.inner, axes.last, work.columns
    owned = last.begin <= layer < last.end
    more = inner.S.shape[0] - 1 if owned else 0
    for j in range(max(tile.y0 - more, 0), min(tile.y1 + more, inner.size)):
        longer = axes.first.S.shape[0] - 1 if owned and tile.y0 <= j < tile.y1 else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, axes.first.size)
        column, n = U64(MARGIN + x0 - tile.x0), U64(x1 - x0)
        row = row_of(work, inner, tile, 2, layer, j) + column
        of_axis = U64(len(like) + 1) * ROW
        for k in range(len(like)):
            clear_slopes(like, work.slope, column + U64(k) * of_axis, n)
        slopes_along(like, axes.first, work, row, column, column, n)
        if len(like) == 3:
            slopes_beside(like, axes, tile, work, layer, j, False, column, column + of_axis, n)
        if len(like) > 1:
            slopes_beside(like, axes, tile, work, layer, j, True, column, column + U64(len(like) - 1) * of_axis, n)
        w = work.w
        viscous_row(
            gas, like, w, row + columns.primitives, row + columns.areas, row + columns.scaled,
            work.slope, column, w, row + columns.frictions, n
        )
