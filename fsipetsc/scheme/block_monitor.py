"""Monitor of the nodes of a block after a step: bounds on the next one, bad states, integrals.

    convection   gas: sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
                 solid: sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice

They are taken column by column of a tile, so that loops become vector code: memory has the extremes
of each column, then its sums. Integrals are sums over nodes with their weights. Their last bits
depend on who owns the nodes; nothing else takes them.
"""

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import (
    EXACT_LOOP,
    INNER_CALL,
    MERGED_CALL,
    along,
    column,
    dot,
    larger,
    part_of,
    sub,
)
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.scheme.rows import ROW, TILE, U64, Array, add_moment, aligned, at, moments, put

#: extremes of a block: 1 if a state is unphysical, largest rates of convection and of diffusion
#: [1/s], minus the least J, largest |J - det D x| / J
UNPHYSICAL, CONVECTION, DIFFUSION, LEAST_J, J_ERROR = range(5)
MONITORED = 5
#: as many numbers
EXTREMES = (0.0, 0.0, 0.0, 0.0, 0.0)


def room_of(d: int) -> Array:
    """Memory of the monitor of a gas."""
    return aligned((MONITORED + sums_of(d)) * int(ROW))


def sums_of(d: int) -> int:
    """Sums that are monitored: mass, momentum, energy, entropy, angular momentum."""
    return d + 3 + moments(d)


@njit(**MERGED_CALL)
def gas_monitor(part, q, metrics):
    """Fill seen (MONITORED,) and sums (sums_of(d),) of the owned nodes; q: (M, d + 3).

    part: see fsipetsc.scheme.gas_record. metrics: those by which steps are bounded.
    """
    gas, like, grid, patch, per_h = part.laws, part.like, part.grid, part.patch, part.per_h
    masses, reference, room = part.masses, part.reference, part.room
    places = part.places.reshape(part.places.size)
    begin(room, ROW)
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    flat, flat_metrics = q.reshape(q.size), metrics.reshape(metrics.size)
    for z in range(n2):
        for y in range(n1):
            row, own = f0 + g0 * (y + f1 + g1 * (z + f2)), n0 * (y + n1 * z)
            for x in range(0, n0, TILE):
                at_q, first, n = U64(own + x), U64(row + x), U64(min(TILE, n0 - x))
                of_nodes = flat, flat_metrics, places, masses, reference, at_q, first, n
                measure(gas, like, per_h, grid, *of_nodes, room)
    collect(room, ROW, ROW, part.seen, part.sums)


@njit(**EXACT_LOOP)
def measure(gas, like, per_h, grid, q, metrics, places, masses, reference, own, first, n, room):
    """Add n nodes to the extremes and sums of the columns of a tile."""
    d, like_q, one = U64(len(like)), (*like, 0.0, 0.0, 0.0), U64(1)
    N = U64(metrics.size // (len(like) ** 2 + len(gas.of_grid(like)) + 1))
    first_sum, turns = U64(MONITORED) * ROW, (U64(MONITORED) + d + U64(3)) * ROW
    for i in range(n):
        here = at(like_q, q, own * U64(len(like_q)), one, i * U64(len(like_q)))
        w, per_J = gas.primitive(here), 1.0 / here[0]
        v = at(like, metrics, first + d * d * N, N, i)
        relative, c = sub(gas.velocity(w), v), gas.speed_of_sound(w)
        convection, squares = 0.0, 0.0
        for k in range(len(like)):
            a = at(like, metrics, first + U64(k) * d * N, N, i)
            size = dot(a, a) * per_h[k] * per_h[k]
            convection += abs(dot(a, relative)) * per_h[k] + c * np.sqrt(size)
            squares += size
        convection, spread = convection * per_J, squares * per_J * per_J
        diffusion = STIFFNESS_OF_WIDE * gas.diffusivity(w) * spread
        J, of_map = grid.jacobian(metrics, N, first + i, reference[own + i]), reference[own + i]
        good = convection < np.inf and diffusion < np.inf and min(w[0], w[2], here[0]) > 0.0
        bad, apart = 0.0 if good else 1.0, abs(here[0] - J) / abs(J)
        found = bad, convection, diffusion, -here[0] / of_map, apart
        put(room, U64(0), ROW, i, larger(found, at(EXTREMES, room, U64(0), ROW, i)))
        more = (*here[1:], here[0] * gas.entropy_density(w))
        total = along(at(like_q, room, first_sum, ROW, i), masses[own + i], more)
        put(room, first_sum, ROW, i, total)
        add_moment(at(like, places, first, N, i), here[2:-1], masses[own + i], room, turns, ROW, i)


@njit(**INNER_CALL)
def begin(room, width):
    """Clear columns, ``width`` apart."""
    for c in range(room.size):
        room[c] = -np.inf if c < MONITORED * width else 0.0


@njit(**INNER_CALL)
def collect(room, width, n, seen, sums):
    """The extremes and sums of the first n columns."""
    for c in range(MONITORED):
        seen[c] = -np.inf if c == LEAST_J else 0.0
        for i in range(n):
            seen[c] = max(seen[c], room[U64(c) * width + i])
    for c in range(sums.size):
        sums[c] = 0.0
        for i in range(n):
            sums[c] += room[U64(MONITORED + c) * width + i]


@njit(**MERGED_CALL)
def monitor_end(solid, like, q, F, node, S, found):
    """Fill found with displacement, velocity, sigma and T of an owned node in one dimension.

    S: prestress [Pa]. With heat 'elastic', S (F - 1) is energy.
    """
    d, strain = len(like), column(solid.unstrained(like), F, node)
    stored = (1.0 - solid.coupled) * S * (strain[0] - 1.0) / solid.m0
    found[0], found[1] = q[node, 0], q[node, d]
    found[2] = solid.line_stress(strain) + S
    found[3] = solid.temperature(part_of(like, q, node, d), q[node, 2 * d] - stored, strain)
