"""Tensors as flat tuples of d*d numbers, row by row: F = (F_11, F_12, …, F_dd), d = 1, 2, 3.

d follows from the length. Sums are added in the order of their indices.
"""

from math import isqrt
from typing import Any

import numpy as np

from fsipetsc.equations.vectors import Vector, dot, total

Tensor = tuple[Any, ...]


def rows(F: Tensor) -> list[Vector]:
    """The rows of a tensor."""
    d = isqrt(len(F))
    return [F[i * d : (i + 1) * d] for i in range(d)]


def columns(F: Tensor) -> list[Vector]:
    """The columns of a tensor."""
    d = isqrt(len(F))
    return [F[j::d] for j in range(d)]


def trace(F: Tensor) -> Any:
    """F_ii."""
    return total(F[:: isqrt(len(F)) + 1])


def transpose(F: Tensor) -> Tensor:
    """F^T."""
    return tuple(entry for column in columns(F) for entry in column)


def column_sums(F: Tensor) -> Vector:
    """The sum of each column."""
    return tuple(total(column) for column in columns(F))


def apply(F: Tensor, a: Vector) -> Vector:
    """F a."""
    return tuple(dot(row, a) for row in rows(F))


def apply_transposed(F: Tensor, a: Vector) -> Vector:
    """F^T a."""
    return tuple(dot(column, a) for column in columns(F))


def outer(a: Vector, b: Vector) -> Tensor:
    """a b^T, of two vectors."""
    return tuple(p * q for p in a for q in b)


def product(F: Tensor, G: Tensor) -> Tensor:
    """F G."""
    return tuple(dot(row, column) for row in rows(F) for column in columns(G))


def transposed_product(F: Tensor, G: Tensor) -> Tensor:
    """F^T G."""
    return tuple(dot(of_F, of_G) for of_F in columns(F) for of_G in columns(G))


def product_transposed(F: Tensor, G: Tensor) -> Tensor:
    """F G^T."""
    return tuple(dot(of_F, of_G) for of_F in rows(F) for of_G in rows(G))


def add_unit(c: Any, F: Tensor) -> Tensor:
    """F + c times the unit tensor."""
    step = isqrt(len(F)) + 1
    return tuple(F[n] if n % step else F[n] + c for n in range(len(F)))


def diagonal(around: Vector, first: Any, other: Any) -> Tensor:
    """diag(first, other) or diag(first, other, other), by the length of around."""
    between = (0.0 * first,) * (len(around) + 1)
    return (first, *(*between, other) * len(around))


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
    """det F."""
    if len(F) == 1:
        return F[0]
    if len(F) == 4:
        return F[0] * F[3] - F[1] * F[2]
    return total(F[j] * _cofactor(F, 0, j) for j in range(3))


# without cancellation near the unit tensor


def determinant_excess(F: Tensor) -> Any:
    """det F - 1."""
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
    """F^T F - 1, twice the strain of Green."""
    d = isqrt(len(F))
    return tuple(_twice_strain(F, i, j) for i in range(d) for j in range(d))


def _twice_strain(F: Tensor, i: int, j: int) -> Any:
    """An entry: F_ki F_kj summed over k, but F_ii^2 - 1 as a product."""
    pairs = zip(columns(F)[i], columns(F)[j], strict=True)
    return total((a - 1.0) * (b + 1.0) if i == j == k else a * b for k, (a, b) in enumerate(pairs))


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
    xx, xy, xz, yy, yz, zz = (_twice_strain(F, i, j) for i in range(3) for j in range(i, 3))
    second = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz)
    third = xx * (yy * zz - yz * yz) + xy * (yz * xz - xy * zz) + xz * (xy * yz - yy * xz)
    return -(second + third)


# bounds


def largest_eigenvalue(B):
    """An upper bound of the eigenvalues of a positive tensor, exact for a diagonal one: the right
    end of Gershgorin's circles.
    """
    d, found = isqrt(len(B)), 0.0
    for i in range(d):
        others = [abs(B[i * d + j]) for j in range(d) if j != i]
        found = np.maximum(found, sum(others, B[i * d + i]))
    return found


def largest_stretch(F):
    """An upper bound of |F N|^2 over directions N, exact for a rotation or a diagonal F."""
    return largest_eigenvalue(transposed_product(F, F))
