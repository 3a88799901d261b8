"""A look at the nodes of a solid block after a step, with F: see fsipetsc.scheme.block_look.

The tiles and rows are those of fsipetsc.scheme.solid_rates: unknowns are loaded, F is found, and
what bounds the next step is found from both, column by column of a tile.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.equations.tensors import outer
from fsipetsc.operators.loops import EXACT_LOOP, INNER_CALL, MERGED_CALL, dot
from fsipetsc.scheme.block_look import BAD, CONVECTION, DIFFUSION, J_ERROR, LEAST_J
from fsipetsc.scheme.rows import U64, at, put
from fsipetsc.scheme.solid_rates import (
    differentiate,
    relieve,
    row_of,
    rows_of,
    strain,
    stretch,
    take,
)
from fsipetsc.scheme.solid_work import KNOWN, NONE, ONE, OWN, PLAIN, WIDTH, step_of


@njit(**MERGED_CALL)
def solid_look(solid, like, q, metrics, prestress, per_h, stiffness, masses, work, F, seen, sums):
    """Fill seen (LOOKED,), sums (d + 1,), momentum and energy, and F (d d, M) of the owned nodes.

    q, metrics, prestress, work: see fsipetsc.scheme.solid_rates. per_h: (d,) cells per axis;
    masses: (M,) weight J0 m0.
    """
    patch, layout, lags, boxes, jumps, weights = work[:6]
    unknowns, strains, slopes, found = work[6], work[7], work[11], work[12]
    q, metrics, F = q.reshape(q.size), metrics.reshape(metrics.size), F.reshape(F.size)
    extra, table, d = prestress.reshape(prestress.size), (jumps, weights, layout), ONE * len(like)
    first_sum = len(like) * len(like)  # sums stand behind what differences need of slopes
    for i in range(U64(layout.row)):
        found[i], found[WIDTH + i], found[U64(2) * WIDTH + i] = 0.0, 0.0, -np.inf
        for c in range(len(like) + 1):
            slopes[U64(first_sum + c) * WIDTH + i] = 0.0
    for tile in range(boxes.shape[0]):
        for z in range(boxes[tile, KNOWN, 2, 0], boxes[tile, OWN, 2, 1] + lags[0]):
            begin, end = rows_of(boxes, tile, KNOWN, z)
            for y in range(begin, end):
                take(like, q, row_of(patch, layout, boxes, tile, KNOWN, y, z), unknowns)
            begin, end = rows_of(boxes, tile, OWN, z - lags[0])
            for y in range(begin, end):
                row = row_of(patch, layout, boxes, tile, OWN, y, z - lags[0])
                add_up(like, row, unknowns, masses, slopes)
                differentiate(like, table, row, PLAIN, unknowns, NONE, NONE, d, slopes, NONE)
                strain(like, metrics, row, slopes, strains)
                stretch(solid, like, metrics, row, unknowns, strains)
                keep(solid, like, row, strains, F)
                relieve(solid, like, extra, row, strains, unknowns)
                measure(solid, like, metrics, per_h, stiffness, row, unknowns, strains, found)
    collect(found, slopes, U64(layout.row), first_sum, seen, sums)


@njit(**EXACT_LOOP)
def add_up(like, row, unknowns, masses, totals):
    """Add momentum and energy of a row to those of its columns."""
    for c in range(len(like) + 1):
        first = U64((len(like) + c) * step_of(like) + row.tile)
        to, own = U64(len(like) * len(like) + c) * WIDTH, U64(row.own)
        for i in range(U64(row.n)):
            totals[to + i] += masses[own + i] * unknowns[first + i]


@njit(**EXACT_LOOP)
def keep(solid, like, row, strains, F):
    """F of a row goes to the array of all nodes."""
    nine, own = solid.unstrained(like), U64(row.own)
    N, node, step = U64(F.size // len(nine)), U64(row.tile), U64(step_of(like))
    for i in range(U64(row.n)):
        put(F, own, N, i, at(nine, strains, node, step, i))


@njit(**EXACT_LOOP)
def measure(solid, like, metrics, per_h, stiffness, row, unknowns, strains, found):
    """Add a row to the extremes of columns: squared rate of waves [1/s2], inf where the state is
    none; that of diffusion [1/s]; -det F.
    """
    nine, step, d = outer(like, like), U64(step_of(like)), U64(len(like))
    N, node, g = U64(metrics.size // (len(nine) + 1)), U64(row.tile), U64(row.patch)
    spread = stiffness * solid.kappa / (solid.m0 * solid.alpha)
    for i in range(U64(row.n)):
        J0, squares = metrics[g + d * d * N + i], 0.0
        for k in range(len(like)):
            a = at(like, metrics, g + U64(k) * d * N, N, i)
            squares += dot(a, a) * per_h[k] * per_h[k]
        squares = squares / (J0 * J0)
        F = at(solid.unstrained(like), strains, node, step, i)
        v, e = at(like, unknowns, node + d * step, step, i), unknowns[node + U64(2) * d * step + i]
        T, J = solid.temperature(v, e, F), solid.volume(F)
        modulus = solid.wave_modulus_at(F, T)
        good = J > 0.0 and T > 0.0 and modulus > -1e-300
        fastest = max(modulus, 0.0) / solid.m0 * squares if good else np.inf
        found[i] = max(found[i], fastest)
        found[WIDTH + i] = max(found[WIDTH + i], spread * squares)
        found[U64(2) * WIDTH + i] = max(found[U64(2) * WIDTH + i], -J)


@njit(**INNER_CALL)
def collect(found, totals, n, first_sum, seen, sums):
    """The extremes and sums of all columns."""
    fastest, seen[DIFFUSION], seen[LEAST_J], seen[J_ERROR] = 0.0, 0.0, -np.inf, 0.0
    for i in range(n):
        fastest = max(fastest, found[i])
        seen[DIFFUSION] = max(seen[DIFFUSION], found[WIDTH + i])
        seen[LEAST_J] = max(seen[LEAST_J], found[U64(2) * WIDTH + i])
    seen[BAD] = 0.0 if fastest < np.inf else 1.0
    seen[CONVECTION] = np.sqrt(fastest)
    for c in range(sums.size):
        sums[c], first = 0.0, U64(first_sum + c) * WIDTH
        for i in range(n):
            sums[c] += totals[first + i]
            totals[first + i] = 0.0  # without conduction rates find no heat there
