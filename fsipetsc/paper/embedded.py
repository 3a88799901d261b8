"""Formulas of an embedded boundary, which stands between the nodes of a frame's grid.

It stands at x_w; the ghost point is the first point of the grid at or beyond it, delta in [0, 1)
cells outside. ``nodes`` are lists of rho, u, T at the ghost point (number 0) and inside of it.
"""

import numpy as np

from fsipetsc.kernels.loops import number

#: nodes that a formula may use, ghost point included
NODES = 8
#: least weight of the ghost point in the formula for data that are given
LEAST = 0.25
#: of an insulated wall, by s, and for q = s + 1, s + 2, s + 3: coefficients of eta_q in powers of
#: delta
ETA = np.zeros((4, 3, 4))
ETA[0, 0, :2] = 0.0, 0.5
ETA[1, 0, :3] = 0.0882352941176471, 0.0883801777493091, -0.1766154718669562
ETA[2, 0] = 0.2222164620745679, -0.4850917636042938, 0.1267629370385567, 0.0198481621891904
ETA[3, :, :3] = (1.267, -2.9, 1.178), (-0.888, 1.872, -0.677), (0.193, -0.389, 0.131)
#: with narrow second derivatives
ETA_NARROW = ETA.copy()
ETA_NARROW[2, 0] = 0.2289158450015872, -0.4914033185443774, 0.1207498614024324, 0.0225285974796345


def distance(layer, side):
    """From the interface to the embedded boundary, in cells, from where the frame is: not by
    (4.25)."""
    return np.absolute(layer.end_x[side] - layer.x_interface) / layer.h


def beyond_boundary(layer, side):
    """delta: how far the ghost point lies outside, in cells."""
    return number(layer.hi - layer.lo) - distance(layer, side)


def depth_of(op):
    """Points inside the ghost point that are taken. Who owns the next point to come in must have
    them in its halo; no layer has fewer (fsipetsc.paper.layout)."""
    return min(NODES, op.halo) - 1


def fetch(part, ghost, side):
    """The nodes of a gas whose ghost point has the number ``ghost`` among its points."""
    step, q, found = 1 - 2 * side, part.local, []
    for k in range(depth_of(part.op) + 1):
        rho, m, e = (q[c, ghost + step * k] for c in range(3))
        found.append((rho, *part.law.velocity_and_temperature(rho, m, e)))
    return [list(values) for values in zip(*found, strict=True)]


def lagrange(delta, degree):
    """Lagrange weights and their derivatives at delta for the nodes 0, 1, ..., degree.

    Node 0 is the ghost point and the boundary lies delta cells inside of it; (4.26) is degree 2,
    with the sign of its third weight corrected so that the weights sum to one.
    """
    weights, slopes = [], []
    for k in range(degree + 1):
        value, denominator, slope = 1.0, 1.0, 0.0
        for m in range(degree + 1):
            if m != k:
                slope = slope * (delta - m) + value
                value *= delta - m
                denominator *= k - m
        weights.append(value / denominator)
        slopes.append(slope / denominator)
    return weights, slopes


def dirichlet_ghost(g, v, weights, degree, least):
    """Value of the ghost point (node 0) so that the interpolant takes the value g at the boundary.

    v[1..degree] are the nodes inside. The q-th difference is added with eta = max(0, least - L_0):
    the formula of Kreiss & Petersson (2006) as in (4.26), but with an eta that vanishes where L_0
    is large enough, because a constant one spoils the accuracy when the boundary is close to the
    ghost point.
    """
    eta = np.maximum(0.0, least - weights[0])
    s, binomial = g, 1.0
    for k in range(1, degree + 1):
        binomial *= -(degree + 1.0 - k) / k
        s -= (weights[k] + eta * binomial) * v[k]
    return s / (weights[0] + eta)


def insulated_ghost(op, T, delta):
    """T of the ghost point so that no heat flows through a wall at delta.

    The interpolant of degree s has zero slope there (Kreiss et al. 2004); differences of the orders
    s + 1 ... are added, with eta fitted to the error that D makes at its closure.
    """
    s = op.p
    last = s + 3 if s == 4 else s + 1
    _, slopes = lagrange(delta, s)
    for q in range(s + 1, last + 1):
        eta, binomial = 0.0, 1.0
        for coefficient in (ETA_NARROW if op.narrow else ETA)[s - 1, q - s - 1, ::-1]:
            eta = eta * delta + float(coefficient)
        slopes += [0.0] * (q + 1 - len(slopes))
        for k in range(q + 1):
            slopes[k] = slopes[k] + eta * binomial
            binomial *= -(q - k) / (k + 1.0)
    return -sum(slopes[k] * T[k] for k in range(1, last + 1)) / slopes[0]
