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

from fsipetsc.equations.tensors import determinant, outer
from fsipetsc.operators.loops import CALL, INNER_CALL, INNER_LOOP, column, dot, node, sub
from fsipetsc.scheme.rows import U64

BAD, CONVECTION, DIFFUSION, LEAST_J, J_ERROR = range(5)
#: numbers of a look
LOOKED = 5


@njit(**CALL)
def gas_look(gas, like, q, metrics, per_h, stiffness, w0, w1, w2, patch, seen, sums):
    """Fill seen (LOOKED,) and sums (d + 3,): mass, momentum, energy, entropy of the owned nodes.

    q: (N, d + 3), metrics: (d d + d + 1, N), per_h: (d,) cells per axis. J_ERROR is left as it is.
    """
    seen[:4], sums[:] = 0.0, 0.0
    seen[LEAST_J] = -np.inf
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    for z in range(n2):
        for y in range(n1):
            first = f0 + g0 * (y + f1 + g1 * (z + f2))
            across = w1[y + f1] * w2[z + f2]
            gas_row(
                gas,
                like,
                q,
                metrics,
                per_h,
                stiffness,
                first,
                n0,
                w0[f0 : f0 + n0],
                across,
                seen,
                sums,
            )


@njit(**INNER_LOOP)
def gas_row(gas, like, q, metrics, per_h, stiffness, first, n, weight, across, seen, sums):
    """The nodes of a row."""
    d, like_q = len(like), (*like, 0.0, 0.0, 0.0)
    least, fastest, spreading, least_J = np.inf, 0.0, 0.0, np.inf
    for i in range(n):
        here = node(like_q, q, U64(first + i))
        w = gas.primitive(here)
        v = column(like, metrics[d * d :], U64(first + i))
        relative, c = sub(gas.velocity(w), v), gas.speed_of_sound(w)
        convection, squares = 0.0, 0.0
        for k in range(d):
            a = column(like, metrics[k * d :], U64(first + i))
            size = dot(a, a) * per_h[k] * per_h[k]
            convection += abs(dot(a, relative)) * per_h[k] + c * np.sqrt(size)
            squares += size
        per_J = 1.0 / here[0]
        fastest = max(fastest, convection * per_J)
        spreading = max(spreading, stiffness * gas.diffusivity(w) * squares * per_J * per_J)
        least, least_J = min(least, min(w[0], w[2])), min(least_J, here[0])
        volume = weight[i] * across
        for c in range(d + 2):
            sums[c] += volume * q[first + i, 1 + c]
        sums[d + 2] += volume * here[0] * gas.entropy_density(w)
    if not (least > 0.0 and least_J > 0.0 and fastest < np.inf and spreading < np.inf):
        seen[BAD] = 1.0
    seen[CONVECTION], seen[DIFFUSION] = (
        max(seen[CONVECTION], fastest),
        max(seen[DIFFUSION], spreading),
    )
    seen[LEAST_J] = max(seen[LEAST_J], -least_J)


@njit(**CALL)
def deformation(like, q, metrics, S0, S1, S2, w0, w1, w2, patch, F):
    """Fill F (d d, M) = 1 + 1/J0 sum_k D_k D A^k of the owned nodes from q (N, 2d + 1)."""
    d = len(like)
    F[:] = 0.0
    for c in range(d):
        F[c * d + c] = 1.0
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    strides = 1, g0, g0 * g1
    for z in range(n2):
        for y in range(n1):
            first, own = f0 + g0 * (y + f1 + g1 * (z + f2)), n0 * (y + n1 * z)
            for k in range(d):
                S, w = (S0, w0) if k == 0 else ((S1, w1) if k == 1 else (S2, w2))
                place = f0 if k == 0 else (y + f1 if k == 1 else z + f2)
                step = 1 if k == 0 else 0
                strain_row(like, q, metrics, S, w, k, strides[k], place, step, first, own, n0, F)


@njit(**INNER_LOOP)
def strain_row(like, q, metrics, S, w, k, stride, place, step, first, own, n, F):
    """Add 1/J0 D_k D A^k of the nodes of a row; place: of the first one along axis k."""
    d = len(like)
    for i in range(n):
        at, p = first + i, place + i * step
        for c in range(d):
            slope = 0.0
            for m in range(1, S.shape[0]):
                if S[m, p] != 0.0:
                    slope += S[m, p] * (q[at + m * stride, c] - q[at, c])
                if p >= m and S[m, p - m] != 0.0:
                    slope -= S[m, p - m] * (q[at - m * stride, c] - q[at, c])
            slope *= 0.5 / (w[p] * metrics[d * d, at])
            for b in range(d):
                F[c * d + b, own + i] += slope * metrics[k * d + b, at]


@njit(**CALL)
def solid_look(solid, like, q, metrics, per_h, stiffness, w0, w1, w2, patch, F, seen, sums):
    """Fill seen (LOOKED,), sums (d + 1,): momentum, energy of the owned nodes; F: (d d, M)."""
    seen[:], sums[:] = 0.0, 0.0
    seen[LEAST_J] = -np.inf
    d = len(like)
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = patch.own, patch.ghosted, patch.first
    for z in range(n2):
        for y in range(n1):
            first, own = f0 + g0 * (y + f1 + g1 * (z + f2)), n0 * (y + n1 * z)
            for i in range(n0):
                at = first + i
                mass = w0[f0 + i] * w1[y + f1] * w2[z + f2] * metrics[d * d, at] * solid.m0
                for c in range(d + 1):
                    sums[c] += mass * q[at, d + c]
                look_at_solid(solid, like, q, metrics, per_h, stiffness, at, own + i, F, seen)


@njit(**CALL)
def look_at_end(solid, q, F, at, own, S, found):
    """Fill found with displacement, velocity, sigma and T of a node in one dimension.

    at, own: its numbers in q and F. S: prestress [Pa]. With heat 'elastic', S (F - 1) is energy.
    """
    strain = (F[0, own],)
    stored = (1.0 - solid.coupled) * S * (strain[0] - 1.0) / solid.m0
    found[0], found[1] = q[at, 0], q[at, 1]
    found[2] = solid.law.stress(strain)[0] + S
    found[3] = solid.temperature((q[at, 1],), q[at, 2] - stored, strain)


@njit(**INNER_CALL)
def look_at_solid(solid, like, q, metrics, per_h, stiffness, at, own, F, seen):
    """One node."""
    d = len(like)
    here = column((*like, *like, 0.0), q.T, U64(at))
    strain = column(outer(like, like), F, U64(own))
    T = solid.temperature(here[len(like) : -1], here[-1], strain)
    modulus = solid.wave_modulus_at(strain, T)
    squares = 0.0
    for k in range(d):
        a = column(like, metrics[k * d :], U64(at))
        squares += dot(a, a) * (per_h[k] / metrics[d * d, at]) ** 2
    J = determinant(strain)
    if not (J > 0.0 and T > 0.0 and modulus > -1e-300 and modulus < np.inf):
        seen[BAD] = 1.0
    seen[CONVECTION] = max(seen[CONVECTION], np.sqrt(max(modulus, 0.0) / solid.m0 * squares))
    spreading = stiffness * solid.kappa / (solid.m0 * solid.alpha) * squares
    seen[DIFFUSION] = max(seen[DIFFUSION], spreading)
    seen[LEAST_J] = max(seen[LEAST_J], -J)
