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

from fsipetsc.kernels.procedure import each, variable, when
from fsipetsc.operators.loops import along, column, column_of, dot, mean, part_of, scale, sub
from fsipetsc.operators.undivided import Differences
from fsipetsc.scheme.rows import Array

#: s up to which there is no shock, and how fast alpha rises from there
NO_SHOCK, RISE = 0.03, 2.5
#: e of s, over the speed of sound
SMALL = 0.02
#: usual strength at shocks
AT_SHOCKS = 0.7


class SolidDamping(NamedTuple):
    """A term: a and b of F, sqrt(K m0) [kg/(m2 s)], the e of s [m/s]. F: (d + 1, zeros and N
    nodes), memory of F and F . Delta_q v; alpha: (N,). after: the next term, or none.
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
        if not part.loses:
            return 0.0
        d, total = len(part.like), variable(0.0)
        for i in each(part.masses.size):
            for c in range(d, 2 * d):
                total.value += part.masses[i] * q[i, c] * rates[i, c]
        return total.value


def solid_damping(solid: Any, found: Differences, a: float, b: float, after: Any) -> SolidDamping:
    """Of a solid, fsipetsc.equations.solid, for the nodes of a patch."""
    d, nodes = len(solid.force), found.norm.shape[1]
    K = solid.law.wave_modulus(solid.tensor(solid.unstrained((0.0,) * d)))
    of_solid = float(np.sqrt(K * solid.m0)), float(SMALL * np.sqrt(K / solid.m0))
    return SolidDamping(
        a, b, *of_solid, found, np.zeros((d + 1, found.room(d))), np.zeros(nodes), after
    )


def steepness(q, d, small, i, stride):
    """s of a node, from the velocities among the unknowns q (N, 2d + 1)."""
    below, here, above = (part_of((0.0,) * d, q, j, d) for j in (i - stride, i, i + stride))
    rise, fall = sub(above, here), sub(here, below)
    turn = sub(rise, fall)
    lengths = np.sqrt(dot(rise, rise)) + np.sqrt(dot(fall, fall))
    return np.sqrt(dot(turn, turn)) / (lengths + small)


def solid_dissipation(part, term, q, rates):
    """Add a term to the rates (M, 2d + 1) of the owned nodes; q (N, 2d + 1): as
    fsipetsc/scheme/solid.c has it, with a halo of q + 1 nodes at least.
    """
    ghosted, strides = part.patch.ghosted, term.differences.strides
    for k in range(len(part.like)):
        stride = strides[k]
        with when(term.b != 0.0):
            sense(term, len(part.like), q, stride, ghosted[k])
        lose(part, term, q, k, stride)
        collect(part, term, q, k, stride, rates)


def sense(term, d, q, stride, length):
    """alpha of all nodes along an axis of so many."""
    alpha, block = term.alpha, stride * length
    for line in each(alpha.size // block):
        first = line * block
        begin = first + stride
        end = np.maximum(begin, first + block - stride)
        for i in each(first, begin, vector=True):
            alpha[i] = 0.0
        for i in each(begin, end, vector=True):
            s = steepness(q, d, term.small, i, stride)
            alpha[i] = np.minimum(1.0, np.maximum(0.0, RISE * (s - NO_SHOCK)))
        for i in each(end, first + block, vector=True):
            alpha[i] = 0.0


def lose(part, term, q, k, stride):
    """F and F . Delta v of the differences that begin at each node; norm is 0 where none fits."""
    weights, norm, metrics = term.differences.weights, term.differences.norm, part.metrics
    d, order, N = len(part.like), len(weights) - 1, part.metrics.shape[1]
    zeros, begin = (0.0,) * d, term.F.shape[1] - N
    low, high = order // 2 * stride, (order + 1) // 2 * stride
    for i in each(N - order * stride, vector=True):
        change = shifted_sum(lambda j: part_of(zeros, q, j, d), i, stride, weights)
        A = mean(*(column_of(zeros, metrics, k * d, i + j) for j in (low, high)))
        alpha = term.alpha[i]
        for m in range(1, order + 1):
            alpha = np.maximum(alpha, term.alpha[i + m * stride])
        speed = (term.a + term.b * alpha) * norm[k, i] * term.impedance * np.sqrt(dot(A, A))
        F = scale(speed, change)
        for c, value in enumerate((*F, dot(F, change))):
            term.F[c, begin + i] = value
    for c in range(d + 1):
        for i in each(N - order * stride, N, vector=True):
            term.F[c, begin + i] = 0.0


def collect(part, term, q, k, stride, rates):
    """Add what differences give to the rates of the owned nodes."""
    (n0, n1, n2), (g0, g1, _), (f0, f1, f2) = part.patch.own, part.patch.ghosted, part.patch.first
    for z in each(n2):
        for y in each(n1):
            row, own = f0 + g0 * (f1 + y + g1 * (f2 + z)), n0 * (y + n1 * z)
            for i in each(n0, vector=True):
                force, power = collected(part, term, q, k, stride, row + i)
                for c, value in enumerate((*force, power), len(force)):
                    rates[own + i, c] += value


def collected(part, term, q, k, stride, node):
    """What differences give to the rates of velocity and energy of a node."""
    weights, d, N = term.differences.weights, len(part.like), part.metrics.shape[1]
    order, zeros, here = len(weights) - 1, (0.0,) * d, term.F.shape[1] - N + node
    per_mass = term.differences.per_weight[k, node]
    per_mass = per_mass / (part.metrics[d * d, node] * part.laws.m0)
    # weights of Delta^T: those of Delta in reverse order, perhaps with sign -1
    F = shifted_sum(lambda j: column(zeros, term.F, j), here - order * stride, stride, weights)
    force = scale((2.0 * (order % 2) - 1.0) * per_mass, F)
    loss = [term.F[d, here - j * stride] for j in (order // 2, (order + 1) // 2)]
    heat = 0.5 * per_mass * (loss[0] + loss[1])
    return force, dot(part_of(zeros, q, node, d), force) + heat


def shifted_sum(numbers, i, stride, weights):
    """sum_m weights_m f_(i + m stride), f = numbers(i) those of a node."""
    found = scale(weights[0], numbers(i))
    for m in range(1, len(weights)):
        found = along(found, weights[m], numbers(i + m * stride))
    return found
