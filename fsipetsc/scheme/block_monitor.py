"""Monitor of the nodes of a block after a step: bounds on the next one, bad states, integrals.

    convection   gas: sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
                 solid: sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice

They are taken column by column of a tile, so that loops become vector code. Integrals are sums over
nodes with their weights. Their last bits depend on who owns the nodes;
nothing else takes them.
"""

import numpy as np
from numba import njit

from fsipetsc.operators.loops import EXACT_LOOP, INNER_CALL, MERGED_CALL, along, column, dot, sub
from fsipetsc.operators.loops import _by_length as by_length
from fsipetsc.scheme.rows import ROW, TILE, U64, Array, add_moment, aligned, at, moments, put

#: extremes of a block: 1 if a state is unphysical, largest rates of convection and of diffusion
#: [1/s], minus the least J, largest |J - det D x| / J
UNPHYSICAL, CONVECTION, DIFFUSION, LEAST_J, J_ERROR = range(5)
MONITORED = 5
#: the larger ones of the numbers of two tuples
largest = by_length(
    "largest",
    "a, b",
    lambda n: " return (" + "".join(f"max(a[{k}], b[{k}])," for k in range(n)) + ")",
)


def room_of(d: int) -> Array:
    """Memory of the monitor: by columns of a tile, the four extremes, what is bad, and the sums."""
    return aligned((MONITORED + sums_of(d)) * int(ROW))


def sums_of(d: int) -> int:
    """Sums that are monitored: mass, momentum, energy, entropy, angular momentum."""
    return d + 3 + moments(d)


@njit(**MERGED_CALL)
def gas_monitor(part, q, metrics, stiffness):
    """Fill seen (MONITORED,) and sums (sums_of(d),) of the owned nodes; q: (M, d + 3).

    part: see fsipetsc.scheme.gas_record. metrics: those by which steps are bounded.
    """
    gas, like, grid, patch, per_h = part.laws, part.like, part.grid, part.patch, part.per_h
    masses, reference, places = part.masses, part.reference, part.places
    room, seen, sums = part.room, part.seen, part.sums
    for c in range(room.size):
        room[c] = -np.inf if c < MONITORED * ROW else 0.0
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    if patch.own == patch.ghosted:  # rows follow one another
        n0, n1, n2 = n0 * n1 * n2, 1, 1
    flat, flat_metrics = q.reshape(q.size), metrics.reshape(metrics.size)
    for z in range(n2):
        for y in range(n1):
            row, own = f0 + g0 * (y + f1 + g1 * (z + f2)), n0 * (y + n1 * z)
            for x in range(0, n0, TILE):
                at_q, first, n = U64(own + x), U64(row + x), U64(min(TILE, n0 - x))
                of_nodes = flat, flat_metrics, masses, reference, at_q, first, n
                measure(gas, like, per_h, stiffness, grid, *of_nodes, room)
                turn(like, q, places, masses, at_q, first, n, room)
    collect(room, seen, sums)


@njit(**EXACT_LOOP)
def measure(gas, like, per_h, stiffness, grid, q, metrics, masses, reference, own, first, n, room):
    """Add n nodes to the extremes and sums of the columns of a tile."""
    d, like_q, one = U64(len(like)), (*like, 0.0, 0.0, 0.0), U64(1)
    rows, extremes = len(like) ** 2 + len(gas.of_grid(like)) + 1, (0.0, 0.0, 0.0, 0.0, 0.0)
    N = U64(metrics.size // rows)
    like_sums, first_sum = (*like, 0.0, 0.0, 0.0), U64(MONITORED) * ROW
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
        diffusion = stiffness * gas.diffusivity(w) * spread
        J, of_map = grid.jacobian(metrics, N, first + i, reference[own + i]), reference[own + i]
        good = convection < np.inf and diffusion < np.inf and min(w[0], w[2], here[0]) > 0.0
        bad, apart = 0.0 if good else 1.0, abs(here[0] - J) / abs(J)
        found = bad, convection, diffusion, -here[0] / of_map, apart
        put(room, U64(0), ROW, i, largest(found, at(extremes, room, U64(0), ROW, i)))
        more = (*here[1:], here[0] * gas.entropy_density(w))
        total = along(at(like_sums, room, first_sum, ROW, i), masses[own + i], more)
        put(room, first_sum, ROW, i, total)


@njit(**EXACT_LOOP)
def turn(like, q, places, masses, own, first, n, room):
    """Add the angular momentum of n nodes to the sums."""
    d, dof, N = len(like), U64(len(like) + 3), U64(places.size // len(like))
    q, x_of, begin = q.reshape(q.size), places.reshape(places.size), U64(MONITORED + d + 3) * ROW
    for i in range(n):
        momentum, x = at(like, q, own * dof + U64(2), U64(1), i * dof), at(like, x_of, first, N, i)
        add_moment(x, momentum, masses[own + i], room, begin, ROW, i)


@njit(**INNER_CALL)
def collect(room, seen, sums):
    """The extremes and sums of all columns."""
    for c in range(MONITORED):
        seen[c] = -np.inf if c == LEAST_J else 0.0
        for i in range(ROW):
            seen[c] = max(seen[c], room[U64(c) * ROW + i])
    for c in range(sums.size):
        sums[c] = 0.0
        for i in range(ROW):
            sums[c] += room[U64(MONITORED + c) * ROW + i]


@njit(**MERGED_CALL)
def monitor_end(solid, q, F, node, S, found):
    """Fill found with displacement, velocity, sigma and T of an owned node in one dimension.

    S: prestress [Pa]. With heat 'elastic', S (F - 1) is energy.
    """
    strain = column(solid.unstrained((0.0,)), F, node)
    stored = (1.0 - solid.coupled) * S * (strain[0] - 1.0) / solid.m0
    found[0], found[1] = q[node, 0], q[node, 1]
    found[2] = solid.line_stress(strain) + S
    found[3] = solid.temperature((q[node, 1],), q[node, 2] - stored, strain)
