"""Dissipation of a solid block: what motion it takes becomes heat at the same place.

Along each axis k, with undivided differences of the velocity (fsipetsc.operators.bands),

    F = (a + b alpha) sqrt(K m0) |A^k| Delta_q v
    J0 m0 v_t  -=  H_k^-1 Delta_q^T F
    J0 m0 e_t  -=  v . H_k^-1 Delta_q^T F  -  H_k^-1 M_q^T (F . Delta_q v)

K: wave modulus at rest, M_q: the mean of the nodes in the middle of a difference, where A^k is
taken, too. Momentum and energy stay, and entropy grows, as F . Delta_q v >= 0.

Everywhere: q half the order of the scheme, a = sigma/4^q. At shocks: q = 1, a = 0, b = 0.7 times
the option; then the former has b = -a. alpha of a difference is the largest of its nodes,

    alpha = min(1, max(0, 2.5 (s - 0.03))),   s = |d_+ - d_-| / (|d_+| + |d_-| + 0.02 sqrt(K/m0)),

d_+ = v_j+1 - v_j, d_- = v_j - v_j-1, |.| the length of a vector, and 0 at an end. In smooth motion
s falls with h^2 and alpha is 0.
"""

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import dot, mean, scale, sub
from fsipetsc.kernels.arrays import column, row
from fsipetsc.kernels.loops import each, variable, when
from fsipetsc.operators.bands import Differences, difference
from fsipetsc.scheme.gas_dissipation import largest, sense
from fsipetsc.scheme.part import area, rows_of

#: e of s, over the speed of sound
SMALL = 0.02
#: usual strength at shocks
AT_SHOCKS = 0.7


class SolidDamping(SimpleNamespace):
    """A term for the nodes of a patch, with a and b of F. after: the next term, or none.

    impedance: sqrt(K m0) [kg/(m2 s)], small: the e of s [m/s]. Memory by components of N nodes: F
    and F . Delta_q v, each after zeros; alpha; work of columns.
    """

    def __init__(self, solid: Any, found: Differences, a: float, b: float, after: Any) -> None:
        d, nodes = len(solid.force), found.norm.shape[1]
        K = solid.law.wave_modulus(solid.tensor(solid.unstrained((0.0,) * d)))
        self.a, self.b, self.differences, self.after = a, b, found, after
        self.impedance = float(np.sqrt(K * solid.m0))
        self.small = float(SMALL * np.sqrt(K / solid.m0))
        self.F, (self.alpha, self.work) = np.zeros((d + 1, found.room(d))), np.zeros((2, nodes))

    def add(self, part, q, rates, gain):
        """Add this term and the next one to the rates (M, 2d + 1) of the owned nodes; q (N, 2d +
        1): with a halo of q + 1 nodes at least. Returns their work if that is booked.
        """
        d, ghosted, strides = len(part.like), part.patch.ghosted, self.differences.strides
        for i in each(part.patch.own[0], vector=True):
            self.work[i] = 0.0
        for k in range(d):
            stride = strides[k]
            with when(self.b != 0.0):
                sense(partial(steepness, part, q, self.small), self.alpha, stride, ghosted[k])
            lose(part, self, q, k, stride)
            for node, own, n in rows_of(part):
                for i in each(n, vector=True):
                    force, power, heat = collected(part, self, q, k, stride, node + i)
                    for c, value in enumerate((*force, power + heat), d):
                        rates[own + i, c] += value
                    if part.loses:
                        self.work[i] += part.masses[own + i] * power
        total = variable(0.0)
        if part.loses:
            for i in each(part.patch.own[0]):
                total.value += self.work[i]
        return total.value + self.after.add(part, q, rates, gain)


def steepness(part, q, small, i, stride):
    """The steepness s of a node; small: the e of s."""
    nodes = i - stride, i, i + stride
    below, here, above = (row(part.like, q, n, len(part.like)) for n in nodes)
    rise, fall = sub(above, here), sub(here, below)
    turn = sub(rise, fall)
    lengths = np.sqrt(dot(rise, rise)) + np.sqrt(dot(fall, fall))
    return np.sqrt(dot(turn, turn)) / (lengths + small)


def lose(part, term, q, k, stride):
    """F and F . Delta v of the differences that begin at each node; norm is 0 where none fits."""
    weights, norm = term.differences.weights, term.differences.norm
    d, order, N = len(part.like), len(weights) - 1, term.alpha.size
    zeros, begin = (0.0,) * d, term.F.shape[1] - N
    low, high = order // 2 * stride, (order + 1) // 2 * stride
    for i in each(N - order * stride, vector=True):
        change = difference(lambda n: row(zeros, q, n, d), i, stride, weights)
        A = mean(*(area(part, k, i + j) for j in (low, high)))
        alpha = largest(term.alpha, i, stride, weights)
        speed = (term.a + term.b * alpha) * norm[k, i] * term.impedance * np.sqrt(dot(A, A))
        F = scale(speed, change)
        term.F[:, begin + i] = *F, dot(F, change)
    for c in range(d + 1):
        for i in each(N - order * stride, N, vector=True):
            term.F[c, begin + i] = 0.0


def collected(part, term, q, k, stride, node):
    """What differences along axis k give to the rates of a node: of velocity, and of energy by the
    power of these and by heat.
    """
    weights, d, N = term.differences.weights, len(part.like), term.alpha.size
    order, zeros, here = len(weights) - 1, (0.0,) * d, term.F.shape[1] - N + node
    per_mass = term.differences.per_weight[k, node]
    per_mass = per_mass / (part.metrics[d * d, node] * part.laws.m0)
    # weights of Delta^T: those of Delta in reverse order, perhaps with sign -1
    F = difference(lambda n: column(zeros, term.F, n), here - order * stride, stride, weights)
    force = scale((2.0 * (order % 2) - 1.0) * per_mass, F)
    loss = [term.F[d, here - j * stride] for j in (order // 2, (order + 1) // 2)]
    heat = 0.5 * per_mass * (loss[0] + loss[1])
    return force, dot(row(zeros, q, node, d), force), heat
