"""Tensors as flat tuples of d*d numbers, row by row: F = (F_11, F_12, …, F_dd), d = 1, 2, 3."""

from math import isqrt
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import Vector, along, dot, scale, total

Tensor = tuple[Any, ...]


def rows(F: Tensor) -> list[Vector]:
    d = isqrt(len(F))
    return [F[i * d : (i + 1) * d] for i in range(d)]


def transpose(F: Tensor) -> Tensor:
    d = isqrt(len(F))
    return tuple(entry for j in range(d) for entry in F[j::d])


def trace(F: Tensor) -> Any:
    return total(F[:: isqrt(len(F)) + 1])


def column_sums(F: Tensor) -> Vector:
    return tuple(map(total, rows(transpose(F))))


def apply(F: Tensor, a: Vector) -> Vector:
    return tuple(dot(row, a) for row in rows(F))


def outer(a: Vector, b: Vector) -> Tensor:
    return tuple(p * q for p in a for q in b)


def product(F: Tensor, G: Tensor) -> Tensor:
    return tuple(dot(row, column) for row in rows(F) for column in rows(transpose(G)))


def add_unit(c: Any, F: Tensor) -> Tensor:
    """F + c times the unit tensor."""
    step = isqrt(len(F)) + 1
    return tuple(F[n] if n % step else F[n] + c for n in range(len(F)))


def bordered(F: Tensor, c: Any, more: int) -> Tensor:
    """F with so many more rows and columns, which have c on the diagonal."""
    d, zero = isqrt(len(F)), 0.0 * F[0]
    wider = [(*row, *(zero,) * more) for row in rows(F)]
    last = [tuple(c if j == i else zero for j in range(d + more)) for i in range(d, d + more)]
    return tuple(entry for row in (*wider, *last) for entry in row)


def cofactor(F: Tensor) -> Tensor:
    """det F times F^-T."""
    if len(F) == 1:
        return (1.0 + 0.0 * F[0],)
    if len(F) == 4:
        return (F[3], -F[2], -F[1], F[0])
    return tuple(_cofactor(F, i, j) for i in range(3) for j in range(3))


def _cofactor(F: Tensor, i: int, j: int) -> Any:
    """An entry of the cofactor in three dimensions."""
    k, l, m, n = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
    return F[3 * k + m] * F[3 * l + n] - F[3 * k + n] * F[3 * l + m]


def determinant(F: Tensor) -> Any:
    if len(F) == 1:
        return F[0]
    if len(F) == 4:
        return F[0] * F[3] - F[1] * F[2]
    return total(F[j] * _cofactor(F, 0, j) for j in range(3))


def determinant_excess(F: Tensor) -> Any:
    """det F - 1 without cancellation near the unit tensor, as in the next ones."""
    if len(F) == 1:
        return F[0] - 1.0
    if len(F) == 4:
        a, b = F[0] - 1.0, F[3] - 1.0
        return a + b + (a * b - F[1] * F[2])
    a, b, c = F[0] - 1.0, F[4] - 1.0, F[8] - 1.0
    bc, ca, ab = b * c - F[5] * F[7], c * a - F[2] * F[6], a * b - F[1] * F[3]
    cubic = a * bc + F[1] * (F[5] * F[6] - F[3] * c) + F[2] * (F[3] * F[7] - b * F[6])
    return a + b + c + (bc + ca + ab) + cubic


def twice_strain(F: Tensor) -> Tensor:
    """F^T F - 1, twice the strain of Green, with F_ii^2 - 1 as a product."""
    every, columns = range(isqrt(len(F))), rows(transpose(F))

    def term(i: int, j: int, k: int) -> Any:
        a, b = columns[i][k], columns[j][k]
        return (a - 1.0) * (b + 1.0) if i == j == k else a * b

    return tuple(total(term(i, j, k) for k in every) for i in every for j in every)


def shear_excess(F: Tensor) -> Any:
    """|F|^2 - d - (det F^2 - 1), which is of second order.

    In three dimensions minus the second and the third invariant of G = F^T F - 1.
    """
    if len(F) == 1:
        return 0.0 * F[0]
    if len(F) == 4:
        j = determinant_excess(F)
        c, s = (F[0] - 1.0) - (F[3] - 1.0), F[1] + F[2]
        return c * c + s * s - j * j
    xx, xy, xz, _, yy, yz, _, _, zz = twice_strain(F)
    second = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz)
    third = xx * (yy * zz - yz * yz) + xy * (yz * xz - xy * zz) + xz * (xy * yz - yy * xz)
    return -(second + third)


def largest_eigenvalue(B):
    """An upper bound of the eigenvalues of a positive tensor, by Gershgorin's circles."""
    d, found = isqrt(len(B)), 0.0
    for i in range(d):
        others = [abs(B[i * d + j]) for j in range(d) if j != i]
        found = np.maximum(found, sum(others, B[i * d + i]))
    return found


def largest_stretch(F):
    """An upper bound of |F N|^2 over directions N, exact for a rotation or a diagonal F."""
    return largest_eigenvalue(product(transpose(F), F))


#: of Jacobi's rotations in one, two and three dimensions
ROTATIONS = 0, 1, 18
#: eigenvalues below this part of the largest one are round-off of 0
LEAST = 1e-14


def square_root(A):
    """The symmetric tensor U with U U = A, of the symmetric one A of d*d numbers, as an acoustic
    tensor; eigenvalues below 0 count as 0.

    Jacobi's rotations make A diagonal (G. H. Golub and C. F. Van Loan, Matrix Computations, section
    8.5), in one and two dimensions as a part of three. The closed formula for three eigenvalues
    loses half of the digits where two are equal.
    """
    d, pairs = isqrt(len(A)), ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    p, q, r, pq, pr, qr = (A[i * d + j] if max(i, j) < d else 0.0 * A[0] for i, j in pairs)
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    for _ in range(ROTATIONS[d - 1]):
        apart = q - p
        size = abs(apart) + np.sqrt(apart * apart + 4.0 * pq * pq) + 1e-300
        t = np.where(apart >= 0.0, 2.0, -2.0) * pq / size  # tangent of the smaller angle
        c = 1.0 / np.sqrt(1.0 + t * t)
        s = t * c
        # the axes change their places, so that each pair has its turn: the second one is the first
        p, q, r, pq, pr, qr = q + t * pq, r, p - t * pq, s * pr + c * qr, 0.0, c * pr - s * qr
        x, y, z = along(scale(s, x), c, y), z, along(scale(c, x), -s, y)
    least = LEAST * np.maximum(np.maximum(p, q), r)
    a, b, c = (np.where(n > least, np.sqrt(np.maximum(n, 0.0)), 0.0) for n in (p, q, r))
    ordered = [(min(i, j), max(i, j)) for i in range(d) for j in range(d)]
    return tuple(a * x[i] * x[j] + b * y[i] * y[j] + c * z[i] * z[j] for i, j in ordered)
