"""The square root of a symmetric positive tensor, as of an acoustic tensor for impedances.

Jacobi's rotations make it diagonal (G. H. Golub and C. F. Van Loan, Matrix Computations, section
8.5), in one and two dimensions as a part of three. A diagonal tensor needs none, one in two
dimensions one, c + a a^T in three dimensions two or three, any other some ten, whether eigenvalues
are equal or not; more of them change round-off alone. They take +, -, *, / and square roots alone,
which are rounded in the same way everywhere. The closed formula for three eigenvalues takes an arc
cosine, and loses half of the digits where two are equal.
"""

from math import isqrt

import numpy as np

from fsipetsc.equations.vectors import along, scale

#: rotations in one, two and three dimensions
ROTATIONS = 0, 1, 18
#: eigenvalues below this part of the largest one are round-off of 0
LEAST = 1e-14


def upper(A):
    """The entries 11, 22, 33, 12, 13, 23, zeros where A has fewer."""
    d, pairs = isqrt(len(A)), ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(A[i * d + j] if max(i, j) < d else 0.0 * A[0] for i, j in pairs)


def sum_of_squares(d, a, b, c, x, y, z):
    """The first d rows and columns of a x x^T + b y y^T + c z z^T, of vectors of three numbers."""
    pairs = [(min(i, j), max(i, j)) for i in range(d) for j in range(d)]
    return tuple(a * x[i] * x[j] + b * y[i] * y[j] + c * z[i] * z[j] for i, j in pairs)


def tangent(p, q, pq):
    """The tangent of the smaller angle by which two axes turn so that their entry pq becomes 0."""
    apart = q - p
    size = abs(apart) + np.sqrt(apart * apart + 4.0 * pq * pq) + 1e-300
    return np.where(apart >= 0.0, 2.0, -2.0) * pq / size


def root(value, least):
    """The square root of an eigenvalue; 0 if that is not above ``least``."""
    return np.where(value > least, np.sqrt(np.maximum(value, 0.0)), 0.0)


def square_root(A):
    """The symmetric tensor U with U U = A, of the symmetric one A of d*d numbers; eigenvalues below
    0 count as 0.
    """
    d, (p, q, r, pq, pr, qr) = isqrt(len(A)), upper(A)
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    for _ in range(ROTATIONS[d - 1]):
        t = tangent(p, q, pq)
        c = 1.0 / np.sqrt(1.0 + t * t)
        s = t * c
        # the axes change their places, so that each pair has its turn: the second one is the first
        p, q, r, pq, pr, qr = q + t * pq, r, p - t * pq, s * pr + c * qr, 0.0, c * pr - s * qr
        x, y, z = along(scale(s, x), c, y), z, along(scale(c, x), -s, y)
    least = LEAST * np.maximum(np.maximum(p, q), r)
    return sum_of_squares(d, root(p, least), root(q, least), root(r, least), x, y, z)
