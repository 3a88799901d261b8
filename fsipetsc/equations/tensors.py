"""Tensors as flat tuples of d*d numbers, row by row: F = (F_11, F_12, …, F_dd), d = 1, 2, 3.

d follows from the length; each function is written out for it when it is compiled, as those of
fsipetsc.operators.loops, and works in plain Python as well.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isqrt

from numba.extending import register_jitable

from fsipetsc.operators.loops import _by_length as by_length

Entry = Callable[[int, int, int], str]


def _tensor(entry: Entry) -> Callable[[int], str]:
    """Source of a tensor with the entry (i, j) for dimension d."""

    def body(n: int) -> str:
        d = isqrt(n)
        return " return (" + "".join(f"{entry(i, j, d)}," for i in range(d) for j in range(d)) + ")"

    return body


def _vector(entry: Callable[[int, int], str]) -> Callable[[int], str]:
    """Source of a vector with the entry i for dimension d."""
    return lambda n: " return (" + "".join(f"{entry(i, isqrt(n))}," for i in range(isqrt(n))) + ")"


def _sum(d: int, term: Callable[[int], str]) -> str:
    return " + ".join(term(k) for k in range(d))


def _cofactor(i: int, j: int, d: int) -> str:
    """Entry of the cofactor matrix: of F^-T times the determinant."""
    if d == 1:
        return "1.0 + 0.0 * F[0]"
    if d == 2:
        return f"{'-' if i != j else ''}F[{(1 - i) * 2 + 1 - j}]"
    k, l, m, n = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
    return f"F[{3 * k + m}] * F[{3 * l + n}] - F[{3 * k + n}] * F[{3 * l + m}]"


def _determinant(n: int) -> str:
    if n == 1:
        return " return F[0]"
    if n == 4:
        return " return F[0] * F[3] - F[1] * F[2]"
    return " return " + _sum(3, lambda j: f"F[{j}] * ({_cofactor(0, j, 3)})")


def _trace(n: int) -> str:
    return " return " + _sum(isqrt(n), lambda k: f"F[{k * isqrt(n) + k}]")


def _invariant_excess(n: int) -> str:
    """|F|^2 - d without cancellation near the unit tensor."""
    off = " + ".join(f"F[{k}] * F[{k}]" for k in range(n) if k % (isqrt(n) + 1))
    unit = " + ".join(f"(F[{k}] - 1.0) * (F[{k}] + 1.0)" for k in range(0, n, isqrt(n) + 1))
    return " return " + unit + (" + " + off if off else "")


def _largest_eigenvalue(n: int) -> str:
    """The right end of Gershgorin's circles."""
    d = isqrt(n)
    row = [
        " + ".join(f"abs(B[{i * d + j}])" for j in range(d) if j != i) or "0.0" for i in range(d)
    ]
    ends = [f"B[{i * d + i}] + {row[i]}" for i in range(d)]
    nested = ends[0]
    for end in ends[1:]:
        nested = f"max({nested}, {end})"
    return " return " + nested


determinant = by_length("determinant", "F", _determinant)
#: det F times F^-T
cofactor = by_length("cofactor", "F", _tensor(_cofactor))
#: sum of F_ii
trace = by_length("trace", "F", _trace)
#: |F|^2 - d
invariant_excess = by_length("invariant_excess", "F", _invariant_excess)
#: an upper bound of the eigenvalues of a symmetric tensor, exact for a diagonal one
largest_eigenvalue = by_length("largest_eigenvalue", "B", _largest_eigenvalue)
transpose = by_length("transpose", "F", _tensor(lambda i, j, d: f"F[{j * d + i}]"))
#: F + c times the unit tensor
add_unit = by_length(
    "add_unit", "c, F", _tensor(lambda i, j, d: f"F[{i * d + j}]" + " + c" * (i == j))
)
#: F G
product = by_length(
    "product",
    "F, G",
    _tensor(lambda i, j, d: _sum(d, lambda k: f"F[{i * d + k}] * G[{k * d + j}]")),
)
#: F^T G
transposed_product = by_length(
    "transposed_product",
    "F, G",
    _tensor(lambda i, j, d: _sum(d, lambda k: f"F[{k * d + i}] * G[{k * d + j}]")),
)
#: F a, sum_j F_ij a_j
apply = by_length(
    "apply", "F, a", _vector(lambda i, d: _sum(d, lambda j: f"F[{i * d + j}] * a[{j}]"))
)
#: F^T a
apply_transposed = by_length(
    "apply_transposed", "F, a", _vector(lambda j, d: _sum(d, lambda i: f"F[{i * d + j}] * a[{i}]"))
)
#: sum_i F_ij
column_sums = by_length(
    "column_sums", "F", _vector(lambda j, d: _sum(d, lambda i: f"F[{i * d + j}]"))
)
#: a b^T, from two vectors
outer = by_length("outer", "a, b", lambda d: _tensor(lambda i, j, d: f"a[{i}] * b[{j}]")(d * d))
#: A B^T
product_transposed = by_length(
    "product_transposed",
    "A, B",
    _tensor(lambda i, j, d: _sum(d, lambda k: f"A[{i * d + k}] * B[{j * d + k}]")),
)


@register_jitable
def largest_stretch(F):
    """An upper bound of |F N|^2 over directions N, exact for a rotation or a diagonal F."""
    return largest_eigenvalue(transposed_product(F, F))
