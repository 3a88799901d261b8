"""Dissipation of a solid block: what motion it takes becomes heat at the same place.

Along each axis k, with undivided differences of the velocity (fsipetsc.operators.undivided),

    F = (a + b alpha) sqrt(K m0) |A^k| Delta_q v
    J0 m0 v_t  -=  H_k^-1 Delta_q^T F
    J0 m0 e_t  -=  v . H_k^-1 Delta_q^T F  -  H_k^-1 M_q^T (F . Delta_q v)

K: wave modulus at rest, M_q: the mean of the nodes in the middle of a difference, where A^k is
taken, too. Momentum and energy stay, and entropy grows, as F . Delta_q v >= 0.

Everywhere: q half the order of the scheme, a = sigma/4^q. At shocks: q = 1, a = 0, b = 0.7 times
the option; then the former has b = -a. alpha of a difference is the largest of its nodes. At a node

    alpha = min(1, max(0, 2.5 (s - 0.03))),   s = |d_+ - d_-| / (|d_+| + |d_-| + 0.02 sqrt(K/m0)),

d_+ = v_j+1 - v_j, d_- = v_j - v_j-1, |.| the length of a vector, and 0 at an end. In smooth motion
s falls with h^2 and alpha is 0.
"""

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.operators.loops import njit
from fsipetsc.operators.loops import CALL, EXACT_LOOP, add, dot, mean, scale, sub, zeros
from fsipetsc.operators.undivided import Differences
from fsipetsc.scheme.gas_dissipation import largest, sense, shifted_sum
from fsipetsc.scheme.rows import ONE, U64, Array, at, put

#: e of s, over the speed of sound
SMALL = 0.02
#: usual strength at shocks
AT_SHOCKS = 0.7


class SolidDamping(NamedTuple):
    """A term: a and b of F, sqrt(K m0) [kg/(m2 s)], the e of s [m/s]. F, alpha: memory, of N nodes,
    F and F . Delta_q v by components, each after zeros, and alpha. after: the next term, or none.
    """

    a: float
    b: float
    impedance: float
    small: float
    differences: Any
    F: Array
    alpha: Array
    after: Any

    def add(self, part, q, rates, gain):
        """This term and the next one."""
        solid_dissipation(part, self, q, rates)
        self.after.add(part, q, rates, gain)

    def power(self, part, q, rates):
        """Sum of v . v_t times the masses, if work is booked; q, rates: of the owned nodes."""
        d, masses, total = len(part.like), part.masses, 0.0
        for i in range(masses.size if part.loses == 1 else 0):
            for c in range(d, 2 * d):
                total += masses[i] * q[i, c] * rates[i, c]
        return total


def solid_damping(solid: Any, found: Differences, a: float, b: float, after: Any) -> SolidDamping:
    """Of a solid, fsipetsc.equations.solid, for the nodes of a patch."""
    d, nodes = len(solid.force), found.norm.shape[1]
    K = solid.law.wave_modulus(solid.tensor(solid.unstrained((0.0,) * d)))
    of_solid = np.sqrt(K * solid.m0), SMALL * np.sqrt(K / solid.m0)
    F = np.zeros((d + 1) * found.room(d))
    return SolidDamping(a, b, *of_solid, found, F, np.zeros(nodes), after)


class SolidWaves(NamedTuple):
    """What is sensed in a solid: the velocity. q: unknowns, small: the e of s."""

    like: Any
    q: Array
    small: float

    def steepness(self, i, stride):
        """s of a node."""
        d, dof = U64(len(self.like)), U64(2 * len(self.like) + 1)
        here = at(self.like, self.q, d, ONE, i * dof)
        rise = sub(at(self.like, self.q, d, ONE, (i + stride) * dof), here)
        fall = sub(here, at(self.like, self.q, d, ONE, (i - stride) * dof))
        turn = sub(rise, fall)
        lengths = np.sqrt(dot(rise, rise)) + np.sqrt(dot(fall, fall))
        return np.sqrt(dot(turn, turn)) / (lengths + self.small)


@njit(**CALL)
def solid_dissipation(part, term, q, rates):
    """Add a term to the rates (M, 2d + 1) of the owned nodes; q: as fsipetsc/scheme/solid.c has it,
    with a halo of q + 1 nodes at least.
    """
    like, metrics, patch, difference = part.like, part.metrics, part.patch, term.differences
    q, metrics, rates = q.reshape(q.size), metrics.reshape(metrics.size), rates.reshape(rates.size)
    own, ghosted, first, weights = patch.own, patch.ghosted, patch.first, difference.weights
    m0 = part.laws.m0
    for k in range(len(like)):
        stride, of_axis = int(difference.strides[k]), (weights, difference.per_weight[k])
        if term.b != 0.0:
            sense(SolidWaves(like, q, term.small), term.alpha, stride, ghosted[k])
        lose(like, term, q, metrics, k, stride, weights, difference.norm[k])
        for z in range(own[2]):
            for y in range(own[1]):
                g = first[0] + ghosted[0] * (first[1] + y + ghosted[1] * (first[2] + z))
                to, n = own[0] * (y + own[1] * z), own[0]
                collect(like, m0, q, metrics, stride, *of_axis, term.F, g, to, n, rates)


@njit(**EXACT_LOOP)
def lose(like, term, q, metrics, k, stride, weights, norm):
    """F and F . Delta v of the differences that begin at each node; norm is 0 where none fits."""
    d, dof, order, N = len(like), U64(2 * len(like) + 1), len(weights) - 1, norm.size
    area, step, apart = U64(k * d * N), U64(N), U64(term.F.size // (len(like) + 1))
    low, high, next_one = U64(order // 2 * stride), U64((order + 1) // 2 * stride), U64(stride)
    for i in range(U64(N - order * stride)):
        change = shifted_sum(like, q, U64(d), ONE, i * dof, next_one * dof, weights)
        A = mean(at(like, metrics, area, step, i + low), at(like, metrics, area, step, i + high))
        alpha = largest(term.alpha, i, next_one, weights)
        speed = (term.a + term.b * alpha) * norm[i] * term.impedance * np.sqrt(dot(A, A))
        F = scale(speed, change)
        put(term.F, apart - step, apart, i, (*F, dot(F, change)))
    for i in range(U64(N - order * stride), U64(N)):
        put(term.F, apart - step, apart, i, (*zeros(like), 0.0))


@njit(**EXACT_LOOP)
def collect(like, m0, q, metrics, stride, weights, per_weight, F, g, to, n, rates):
    """Add what differences give to the rates of a row of owned nodes."""
    d, dof, order, N = len(like), U64(2 * len(like) + 1), len(weights) - 1, per_weight.size
    apart, next_one = U64(F.size // (len(like) + 1)), U64(stride)
    here = apart - U64(N) + U64(g)
    back, loss = here - U64(order) * next_one, here + U64(d) * apart
    low, high = U64(order // 2 * stride), U64((order + 1) // 2 * stride)
    sign = 1.0 - 2.0 * (order % 2)  # of Delta^T, whose weights are those of Delta in reverse order
    for i in range(U64(n)):
        node = U64(g) + i
        per_mass = per_weight[node] / (metrics[U64(d * d * N) + node] * m0)
        total = shifted_sum(like, F, back, apart, i, next_one, weights)
        force = scale(-sign * per_mass, total)
        v, place = at(like, q, U64(d), ONE, node * dof), (U64(to) + i) * dof + U64(d)
        heat = 0.5 * per_mass * (F[loss - low + i] + F[loss - high + i])
        power = dot(v, force) + heat
        before = at((*like, 0.0), rates, place, ONE, U64(0))
        put(rates, place, ONE, U64(0), (*add(before[:-1], force), before[-1] + power))
