"""A look at the nodes of a block after a step: bounds on the next one, bad states, integrals.

    convection   gas: sum_k (|a^k . (u - v)| + c |a^k|) / (J h_k)
                 solid: sqrt(sum_k (c |A^k| / (J0 h_k))^2),  c^2 the largest wave modulus over m0
    diffusion    z nu sum_k |a^k|^2 / (J h_k)^2,  nu = max(4/3 mu/rho, kappa/(rho cv)),
                 z the stiffness of D twice

Integrals are sums over nodes with their weights. Their last bits depend on who owns the nodes;
nothing else takes them.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.loops import EXACT_LOOP, INNER_CALL, MERGED_CALL, dot, sub
from fsipetsc.scheme.rows import U64, at

BAD, CONVECTION, DIFFUSION, LEAST_J, J_ERROR = range(5)
#: numbers of a look
LOOKED = 5


@njit(**MERGED_CALL)
def gas_look(gas, like, q, metrics, per_h, stiffness, w0, w1, w2, patch, found, seen, sums):
    """Fill seen (LOOKED,) and sums (d + 3,): mass, momentum, energy, entropy of the owned nodes.

    q: (N, d + 3), metrics: (d d + d + 1, N), per_h: (d,) cells per axis. found: (5, nodes of a
    row), memory. J_ERROR is left as it is.
    """
    seen[:4], sums[:] = 0.0, 0.0
    seen[LEAST_J] = -np.inf
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    weight, flat, flat_metrics = w0[f0 : f0 + n0], q.reshape(q.size), metrics.reshape(metrics.size)
    for z in range(n2):
        for y in range(n1):
            first = f0 + g0 * (y + f1 + g1 * (z + f2))
            measure(gas, like, flat, flat_metrics, per_h, stiffness, first, found)
            note(found, seen)
            add_up(q, first, w1[y + f1] * w2[z + f2], weight, found, sums)


@njit(**EXACT_LOOP)
def measure(gas, like, q, metrics, per_h, stiffness, first, found):
    """Rows of found: rates of convection and of diffusion [1/s], the lesser of rho and T, J, and
    J times the entropy.
    """
    d, like_q = U64(len(like)), (*like, 0.0, 0.0, 0.0)
    N, g = U64(metrics.size // (len(like) * len(like) + len(like) + 1)), U64(first)
    for i in range(U64(found.shape[1])):
        here = at(like_q, q, g * U64(len(like_q)), U64(1), i * U64(len(like_q)))
        w = gas.primitive(here)
        v = at(like, metrics, g + d * d * N, N, i)
        relative, c = sub(gas.velocity(w), v), gas.speed_of_sound(w)
        convection, squares = 0.0, 0.0
        for k in range(len(like)):
            a = at(like, metrics, g + U64(k) * d * N, N, i)
            size = dot(a, a) * per_h[k] * per_h[k]
            convection += abs(dot(a, relative)) * per_h[k] + c * np.sqrt(size)
            squares += size
        per_J = 1.0 / here[0]
        found[0, i] = convection * per_J
        found[1, i] = stiffness * gas.diffusivity(w) * squares * per_J * per_J
        found[2, i], found[3, i] = min(w[0], w[2]), here[0]
        found[4, i] = here[0] * gas.entropy_density(w)


@njit(**INNER_CALL)
def note(found, seen):
    """The extremes of a row; BAD where one is no number, or not positive."""
    fastest, spreading, least_J, good = 0.0, 0.0, np.inf, True
    for i in range(found.shape[1]):
        good &= found[0, i] < np.inf and found[1, i] < np.inf and found[2, i] > 0.0
        fastest, spreading = max(fastest, found[0, i]), max(spreading, found[1, i])
        least_J = min(least_J, found[3, i])
    if not (good and least_J > 0.0):
        seen[BAD] = 1.0
    seen[CONVECTION] = max(seen[CONVECTION], fastest)
    seen[DIFFUSION] = max(seen[DIFFUSION], spreading)
    seen[LEAST_J] = max(seen[LEAST_J], -least_J)


@njit(**INNER_CALL)
def add_up(q, first, across, weight, found, sums):
    """Mass, momentum, energy and entropy of a row."""
    for i in range(weight.size):
        volume = weight[i] * across
        for c in range(sums.size - 1):
            sums[c] += volume * q[first + i, 1 + c]
        sums[sums.size - 1] += volume * found[4, i]


@njit(**MERGED_CALL)
def look_at_end(solid, q, F, at, own, S, found):
    """Fill found with displacement, velocity, sigma and T of a node in one dimension.

    at, own: its numbers in q and F. S: prestress [Pa]. With heat 'elastic', S (F - 1) is energy.
    """
    strain = (F[0, own],)
    stored = (1.0 - solid.coupled) * S * (strain[0] - 1.0) / solid.m0
    found[0], found[1] = q[at, 0], q[at, 1]
    found[2] = solid.law.stress(strain)[0] + S
    found[3] = solid.temperature((q[at, 1],), q[at, 2] - stored, strain)
