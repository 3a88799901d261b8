"""Monitor of the nodes of a solid block after a step, with F: see fsipetsc.scheme.block_monitor.

The tiles and rows are those of fsipetsc.scheme.solid_rates: unknowns are loaded, F is found, and
what bounds the next step is found from both, column by column of a tile.
"""

import numpy as np
from numba import njit

from fsipetsc.operators.loops import CALL, EXACT_LOOP, INNER_CALL, add, along, dot, sub
from fsipetsc.scheme.block_monitor import CONVECTION, DIFFUSION, J_ERROR, LEAST_J, UNPHYSICAL
from fsipetsc.scheme.rows import U64, add_moment, at, put
from fsipetsc.scheme.solid_rates import (
    differentiate,
    relieve,
    row_of,
    rows_of,
    strain,
    take,
)
from fsipetsc.scheme.solid_work import EXTREMES, KNOWN, NONE, ONE, OWN, PLAIN, WIDTH, step_of


@njit(**CALL)
def solid_monitor(
    solid, like, q, X, metrics, prestress, per_h, stiffness, masses, work, F, loses, seen, sums
):
    """Fill seen (MONITORED,), sums (solid_work.sums_of(d) + 1,) and F (d d, M) of the owned nodes.

    sums: momentum, energy, angular momentum, kinetic and elastic energy, minus this. q, metrics,
    prestress, work: see fsipetsc.scheme.solid_rates. X: (d, N) places at rest. per_h: (d,) cells
    per axis; masses: (M,) weight J0 m0. loses: 1 if the last two sums are wanted, else they are 0.
    """
    patch, layout, lags, boxes, jumps, weights = work[:6]
    unknowns, strains, slopes, totals = work[6], work[7], work[11], work[13]
    q, metrics, F = q.reshape(q.size), metrics.reshape(metrics.size), F.reshape(F.size)
    X = X.reshape(X.size)
    extra, table, d = prestress.reshape(prestress.size), (jumps, weights, layout), ONE * len(like)
    for i in range(totals.size):
        totals[i] = 0.0
    for i in range(U64(layout.row)):
        totals[U64(EXTREMES - 1) * WIDTH + i] = -np.inf
    for tile in range(boxes.shape[0]):
        for z in range(boxes[tile, KNOWN, 2, 0], boxes[tile, OWN, 2, 1] + lags[0]):
            begin, end = rows_of(boxes, tile, KNOWN, z)
            for y in range(begin, end):
                take(like, q, row_of(patch, layout, boxes, tile, KNOWN, y, z), unknowns)
            begin, end = rows_of(boxes, tile, OWN, z - lags[0])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, OWN, y, z - lags[0])
                add_up(like, row, unknowns, X, masses, totals)
                differentiate(like, table, row, PLAIN, unknowns, NONE, NONE, d, slopes, NONE)
                strain(solid, like, metrics, row, slopes, unknowns, strains)
                relieve(solid, like, extra, row, strains, unknowns)
                measure(solid, like, metrics, per_h, stiffness, row, unknowns, strains, F, totals)
                if loses == 1:
                    add_energy(solid, like, extra, row, unknowns, strains, masses, totals)
    collect(totals, U64(layout.row), seen, sums)


@njit(**EXACT_LOOP)
def add_up(like, row, unknowns, X, masses, totals):
    """Add momentum, energy and angular momentum, X + D times momentum, of a row to its columns'."""
    d, step, node, own = U64(len(like)), U64(step_of(like)), U64(row.tile), U64(row.own)
    N, here, like_sum = U64(X.size // len(like)), U64(row.patch), (*like, 0.0)
    to = U64(EXTREMES) * WIDTH
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
def measure(solid, like, metrics, per_h, stiffness, row, unknowns, strains, F_of, totals):
    """Keep F of a row; add it to the extremes of columns: squared rate of waves [1/s2], inf where
    the state is none; that of diffusion [1/s]; -det F.
    """
    step, d = U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // solid.rows(like)), U64(row.tile), U64(row.patch)
    own, M = U64(row.own), U64(F_of.size // len(solid.unstrained(like)))
    spread = stiffness * solid.kappa / (solid.m0 * solid.alpha)
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
        fastest = max(modulus, 0.0) / solid.m0 * squares if good else np.inf
        totals[i] = max(totals[i], fastest)
        totals[WIDTH + i] = max(totals[WIDTH + i], spread * squares)
        totals[U64(2) * WIDTH + i] = max(totals[U64(2) * WIDTH + i], -J)


@njit(**INNER_CALL)
def collect(totals, n, seen, sums):
    """The extremes and sums of all columns; the last sum is minus the one before."""
    fastest, seen[DIFFUSION], seen[LEAST_J], seen[J_ERROR] = 0.0, 0.0, -np.inf, 0.0
    for i in range(n):
        fastest = max(fastest, totals[i])
        seen[DIFFUSION] = max(seen[DIFFUSION], totals[WIDTH + i])
        seen[LEAST_J] = max(seen[LEAST_J], totals[U64(2) * WIDTH + i])
    seen[UNPHYSICAL] = 0.0 if fastest < np.inf else 1.0
    seen[CONVECTION] = np.sqrt(fastest)
    for c in range(sums.size - 1):
        sums[c], first = 0.0, U64(EXTREMES + c) * WIDTH
        for i in range(n):
            sums[c] += totals[first + i]
    sums[sums.size - 1] = -sums[sums.size - 2]
