"""Dissipation of a solid block: what motion it takes becomes heat at the same place.

Along each axis k, with undivided differences of the velocity (fsipetsc.operators.undivided),

    F = (a + b alpha) sqrt(K m0) |A^k| Delta_q v
    J0 m0 v_t  -=  H_k^-1 Delta_q^T F
    J0 m0 e_t  -=  v . H_k^-1 Delta_q^T F  -  H_k^-1 M_q^T (F . Delta_q v)

K: wave modulus at rest, M_q: the mean of the nodes in the middle of a difference, where A^k is
taken, too. Momentum and energy stay, and entropy grows, as F . Delta_q v >= 0.

Everywhere: q half the order of the scheme, a = sigma/4^q. At shocks: q = 1, a = 0, b = 0.7 times
the option; then the former has b = -a. alpha of a difference is the largest of its nodes, that of a
node the largest of the components of v,

    alpha = min(1, max(0, 2.5 (s - 0.03))),   s = |d_+ - d_-| / (|d_+| + |d_-| + 0.02 sqrt(K/m0)),

d_+ = v_j+1 - v_j, d_- = v_j - v_j-1, and 0 at an end. In smooth motion s falls with h^2 and alpha
is 0.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from fsipetsc.operators.loops import CALL, EXACT_LOOP, add, dot, mean, scale, zeros
from fsipetsc.operators.undivided import Differences
from fsipetsc.scheme.gas_dissipation import largest, sense, shifted_sum
from fsipetsc.scheme.rows import ONE, U64, Array, at, put

#: e of s, over the speed of sound
SMALL = 0.02
#: usual strength at shocks
AT_SHOCKS = 0.7


class Damping(NamedTuple):
    """a and b of F, sqrt(K m0) [kg/(m2 s)], m0 [kg/m3] and the e of s [m/s]."""

    a: float
    b: float
    impedance: float
    m0: float
    small: float


class Room(NamedTuple):
    """Memory, of N nodes: F and F . Delta_q v by components, each after zeros, and alpha."""

    F: Array
    alpha: Array


def room(d: int, difference: Differences) -> Room:
    """For the nodes of a patch."""
    return Room(np.zeros((d + 1) * difference.room(d)), np.zeros(difference.norm.shape[1]))


@njit(**CALL)
def solid_dissipation(like, term, q, metrics, patch, rates):
    """Add a term to the rates (M, 2d + 1) of the owned nodes.

    term: fsipetsc.scheme.solid_record.SolidDamping. q, metrics, patch: as in
    fsipetsc.scheme.solid_rates, with a halo of q + 1 nodes at least.
    """
    damping, difference, room = term.damping, term.differences, term.room
    q, metrics, rates = q.reshape(q.size), metrics.reshape(metrics.size), rates.reshape(rates.size)
    own, ghosted, first = patch.own, patch.ghosted, patch.first
    for k in range(len(like)):
        stride = int(difference.strides[k])
        if damping.b != 0.0:
            of_v = q, U64(len(like)), ONE, U64(2 * len(like) + 1), 0.0, damping.small
            sense(like, *of_v, room.alpha, stride, ghosted[k])
        lose(like, damping, q, metrics, k, stride, difference.weights, difference.norm[k], room)
        for z in range(own[2]):
            for y in range(own[1]):
                g = first[0] + ghosted[0] * (first[1] + y + ghosted[1] * (first[2] + z))
                to = own[0] * (y + own[1] * z)
                weights, per = difference.weights, difference.per_weight[k]
                collect(like, damping, q, metrics, stride, weights, per, room, g, to, own[0], rates)


@njit(**EXACT_LOOP)
def lose(like, damping, q, metrics, k, stride, weights, norm, room):
    """F and F . Delta v of the differences that begin at each node; norm is 0 where none fits."""
    d, dof, order, N = len(like), U64(2 * len(like) + 1), len(weights) - 1, norm.size
    area, step, apart = U64(k * d * N), U64(N), U64(room.F.size // (len(like) + 1))
    low, high, next_one = U64(order // 2 * stride), U64((order + 1) // 2 * stride), U64(stride)
    for i in range(U64(N - order * stride)):
        change = shifted_sum(like, q, U64(d), ONE, i * dof, next_one * dof, weights)
        A = mean(at(like, metrics, area, step, i + low), at(like, metrics, area, step, i + high))
        alpha = largest(room.alpha, i, next_one, weights)
        speed = (damping.a + damping.b * alpha) * norm[i] * damping.impedance * np.sqrt(dot(A, A))
        F = scale(speed, change)
        put(room.F, apart - step, apart, i, (*F, dot(F, change)))
    for i in range(U64(N - order * stride), U64(N)):
        put(room.F, apart - step, apart, i, (*zeros(like), 0.0))


@njit(**EXACT_LOOP)
def collect(like, damping, q, metrics, stride, weights, per_weight, room, g, to, n, rates):
    """Add what differences give to the rates of a row of owned nodes."""
    d, dof, order, N = len(like), U64(2 * len(like) + 1), len(weights) - 1, per_weight.size
    apart, next_one = U64(room.F.size // (len(like) + 1)), U64(stride)
    here = apart - U64(N) + U64(g)
    back, loss = here - U64(order) * next_one, here + U64(d) * apart
    low, high = U64(order // 2 * stride), U64((order + 1) // 2 * stride)
    sign = 1.0 - 2.0 * (order % 2)  # of Delta^T, whose weights are those of Delta in reverse order
    for i in range(U64(n)):
        node = U64(g) + i
        per_mass = per_weight[node] / (metrics[U64(d * d * N) + node] * damping.m0)
        total = shifted_sum(like, room.F, back, apart, i, next_one, weights)
        force = scale(-sign * per_mass, total)
        v, place = at(like, q, U64(d), ONE, node * dof), (U64(to) + i) * dof + U64(d)
        heat = 0.5 * per_mass * (room.F[loss - low + i] + room.F[loss - high + i])
        power = dot(v, force) + heat
        before = at((*like, 0.0), rates, place, ONE, U64(0))
        put(rates, place, ONE, U64(0), (*add(before[:-1], force), before[-1] + power))
