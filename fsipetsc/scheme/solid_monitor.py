"""Monitor of the nodes of a solid block after a step, with F: see fsipetsc.scheme.block_monitor.

The tiles and rows are those of fsipetsc.scheme.solid_rates: unknowns are loaded, F is found, and
what bounds the next step is found from both, column by column of a tile.
"""

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, EXACT_LOOP, add, along, dot, larger, sub
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.scheme.block_monitor import EXTREMES, MONITORED, begin, collect
from fsipetsc.scheme.rows import U64, add_moment, at, put
from fsipetsc.scheme.solid_rates import (
    differentiate,
    relieve,
    row_of,
    rows_of,
    strain,
    take,
)
from fsipetsc.scheme.solid_work import KNOWN, NONE, ONE, OWN, PLAIN, WIDTH, step_of


@njit(**CALL)
def solid_monitor(solid, like, q, X, metrics, prestress, per_h, masses, work, F, loses, seen, sums):
    """Fill seen (MONITORED,), sums (solid_work.sums_of(d) + 1,) and F (d d, M) of the owned nodes.

    sums: momentum, energy, angular momentum, kinetic and elastic energy, minus this. q, metrics,
    prestress, work: see fsipetsc.scheme.solid_record. X: (d, N) places at rest. per_h: (d,) cells
    per axis; masses: (M,) weight J0 m0. loses: 1 if the last two sums are wanted, else they are 0.
    """
    patch, layout, lags, boxes, jumps, weights, ends = work[:7]
    unknowns, strains, slopes, totals = work[7], work[8], work[12], work[13]
    q, metrics, F = q.reshape(q.size), metrics.reshape(metrics.size), F.reshape(F.size)
    X, extra, d = X.reshape(-1), prestress.reshape(-1), ONE * len(like)
    table = jumps, weights, ends, layout
    begin(totals, WIDTH)
    for tile in range(boxes.shape[0]):
        for z in range(boxes[tile, KNOWN, 2, 0], boxes[tile, OWN, 2, 1] + lags[0]):
            first, end = rows_of(boxes, tile, KNOWN, z)
            for y in range(first, end):
                take(like, q, row_of(patch, layout, boxes, tile, KNOWN, y, z), unknowns)
            first, end = rows_of(boxes, tile, OWN, z - lags[0])
            for y in range(first, end):
                row = row_of(patch, layout, boxes, tile, OWN, y, z - lags[0])
                add_up(like, row, unknowns, X, masses, totals)
                differentiate(like, table, row, PLAIN, unknowns, NONE, NONE, d, slopes, NONE)
                strain(solid, like, metrics, row, slopes, unknowns, strains)
                relieve(solid, like, extra, row, strains, unknowns)
                measure(solid, like, metrics, per_h, row, unknowns, strains, F, totals)
                if loses == 1:
                    add_energy(solid, like, extra, row, unknowns, strains, masses, totals)
    collect(totals, WIDTH, U64(layout.row), seen, sums[:-1])
    sums[-1] = -sums[-2]


@njit(**EXACT_LOOP)
def add_up(like, row, unknowns, X, masses, totals):
    """Add momentum, energy and angular momentum, X + D times momentum, of a row to its columns'."""
    d, step, node, own = U64(len(like)), U64(step_of(like)), U64(row.tile), U64(row.own)
    N, here, like_sum = U64(X.size // len(like)), U64(row.patch), (*like, 0.0)
    to = U64(MONITORED) * WIDTH
    turns = to + (d + U64(1)) * WIDTH
    for i in range(U64(row.n)):
        x = add(at(like, X, here, N, i), at(like, unknowns, node, step, i))
        both, mass = at(like_sum, unknowns, node + d * step, step, i), masses[own + i]
        put(totals, to, WIDTH, i, along(at(like_sum, totals, to, WIDTH, i), mass, both))
        add_moment(x, both[:-1], mass, totals, turns, WIDTH, i)


@njit(**EXACT_LOOP)
def add_energy(solid, like, extra, row, unknowns, strains, masses, totals):
    """Add kinetic and elastic energy, and that of a prestress S : (F - 1)."""
    nine, step, d = solid.unstrained(like), U64(step_of(like)), U64(len(like))
    node, own, to = U64(row.tile), U64(row.own), U64(totals.size) - WIDTH
    for i in range(U64(row.n)):
        v, F = at(like, unknowns, node + d * step, step, i), at(nine, strains, node, step, i)
        energy = 0.5 * dot(v, v) + solid.energy(F) / solid.m0
        totals[to + i] += masses[own + i] * energy
    N, g, n = U64(extra.size // len(nine)), U64(row.patch), row.n if extra.size > 0 else 0
    for i in range(U64(n)):
        S, F = at(nine, extra, g, N, i), at(nine, strains, node, step, i)
        totals[to + i] += masses[own + i] * dot(S, sub(F, solid.unstrained(like))) / solid.m0


@njit(**EXACT_LOOP)
def measure(solid, like, metrics, per_h, row, unknowns, strains, F_of, totals):
    """Keep F of a row; add it to the extremes of columns, with convection inf where the state is
    none.
    """
    step, d = U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    own, M = U64(row.own), U64(F_of.size // len(solid.unstrained(like)))
    spread = STIFFNESS_OF_WIDE * solid.kappa / (solid.m0 * solid.alpha)
    for i in range(U64(row.n)):
        J0, squares = metrics[g + d * d * N + i], 0.0
        for k in range(len(like)):
            a = at(like, metrics, g + U64(k) * d * N, N, i)
            squares += dot(a, a) * per_h[k] * per_h[k]
        squares = squares / (J0 * J0) + solid.curvature(metrics[U64(metrics.size) - N + g + i])
        F = at(solid.unstrained(like), strains, node, step, i)
        put(F_of, own, M, i, F)
        v, e = at(like, unknowns, node + d * step, step, i), unknowns[node + U64(2) * d * step + i]
        T, J = solid.temperature(v, e, F), solid.volume(F)
        modulus = solid.wave_modulus_at(F, T)
        good = J > 0.0 and T > 0.0 and modulus > -1e-300
        fastest = np.sqrt(max(modulus, 0.0) / solid.m0 * squares) if good else np.inf
        found = 0.0 if fastest < np.inf else 1.0, fastest, spread * squares, -J, 0.0
        put(totals, U64(0), WIDTH, i, larger(found, at(EXTREMES, totals, U64(0), WIDTH, i)))
