"""Viscous fluxes of the rows of a tile, from gradients of the entropy variables z = (u, -1)/T,

grad z = 1/J sum_k a^k D_k z.
"""

from numba import njit
from numba.extending import register_jitable

from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import EXACT_LOOP, INLINED_CALL, add, along, scale, sub
from fsipetsc.scheme.gas_memory import clear, fill, row_of
from fsipetsc.scheme.gas_rows import place_of, state_like
from fsipetsc.scheme.rows import MARGIN, ONE, ROW, U64, at, put


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
        for k in range(U64(1), d):
            more, by = slopes_of(like, w, place.area, slope, to, i, k)
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
            if before != 0.0 or after != 0.0:
                back, on = k if before != 0.0 else 0, k if after != 0.0 else 0
                low = row_of(work, tile, layer - back * up, j - back * right) + column
                high = row_of(work, tile, layer + on * up, j + on * right) + column
                fill(gain, loss, before, after, n)
                to, none = column + U64(m) * of_axis, U64(0)
                slope_row(gas, like, w, low, here, high, gain, none, loss, none, slope, to, n)


@njit(**INLINED_CALL)
def viscous_layer(gas, like, q, axes, tile, work, layer):
    """Viscous fluxes of the rows of a layer that pairs with owned nodes take."""
    first, inner, last = axes.first, axes.inner, axes.last
    owned = last.begin <= layer < last.end
    beside = inner.S.shape[0] - 1 if owned else 0
    for j in range(max(tile.y0 - beside, 0), min(tile.y1 + beside, inner.size)):
        longer = first.S.shape[0] - 1 if owned and tile.y0 <= j < tile.y1 else 0
        x0, x1 = max(tile.x0 - longer, 0), min(tile.x1 + longer, first.size)
        column, n = U64(MARGIN + x0 - tile.x0), U64(x1 - x0)
        slopes(gas, like, axes, tile, work, layer, j, column, n)
        place = place_of(gas, like, row_of(work, tile, layer, j) + column, 0)
        at_q = U64(x0 + j * inner.stride + layer * last.stride) * U64(len(like) + 3)
        viscous_row(gas, like, work.w, place, q, at_q, work.slope, column, n)
