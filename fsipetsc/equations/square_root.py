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

from fsipetsc.operators.loops import along, by_length, scale

#: rotations in one, two and three dimensions
ROTATIONS = 0, 1, 18
#: eigenvalues below this part of the largest one are round-off of 0
LEAST = 1e-14


def _upper(n: int) -> str:
    """Source of the entries 11, 22, 33, 12, 13, 23, of which there may be fewer."""
    d = isqrt(n)
    pairs = (0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)
    entries = (f"A[{i * d + j}]" if max(i, j) < d else "0.0 * A[0]" for i, j in pairs)
    return f" return ({', '.join(entries)})"


def _sum_of_squares(n: int) -> str:
    """Source of a x x^T + b y y^T + c z z^T, of as many entries as A has; n is 3 where that is one,
    because vectors have three numbers.
    """
    d = isqrt(n)
    terms = "a * x[{0}] * x[{1}] + b * y[{0}] * y[{1}] + c * z[{0}] * z[{1}]"
    entries = (terms.format(min(i, j), max(i, j)) for i in range(d) for j in range(d))
    return f" return ({', '.join(entries)},)"


upper = by_length("upper", "A", _upper)
sum_of_squares = by_length("sum_of_squares", "A, a, b, c, x, y, z", _sum_of_squares)


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
    p, q, r, pq, pr, qr = upper(A)
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    for _ in range(ROTATIONS[isqrt(len(A)) - 1]):
        t = tangent(p, q, pq)
        c = 1.0 / np.sqrt(1.0 + t * t)
        s = t * c
        # the axes change their places, so that each pair has its turn: the second one is the first
        p, q, r, pq, pr, qr = q + t * pq, r, p - t * pq, s * pr + c * qr, 0.0, c * pr - s * qr
        x, y, z = along(scale(s, x), c, y), z, along(scale(c, x), -s, y)
    least = LEAST * np.maximum(np.maximum(p, q), r)
    return sum_of_squares(A, root(p, least), root(q, least), root(r, least), x, y, z)
