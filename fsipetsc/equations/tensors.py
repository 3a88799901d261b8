"""Tensors as flat tuples of d*d numbers, row by row: F = (F_11, F_12, …, F_dd), d = 1, 2, 3.

d follows from the length; each function is written out for it, as those of
fsipetsc.operators.loops.
"""

from collections.abc import Callable
from itertools import product as product_of
from math import isqrt
from typing import Any

import numpy as np

from fsipetsc.operators.loops import by_length

Entry = Callable[[int, int, int], str]


def _tensor(entry: Entry) -> Callable[[int], str]:
    """Source of a tensor with the entry (i, j) for dimension d."""

    def body(n: int) -> str:
        d = isqrt(n)
        return " return (" + "".join(f"{entry(i, j, d)}," for i in range(d) for j in range(d)) + ")"

    return body


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
    return " return " + " + ".join(f"F[{j}] * ({_cofactor(0, j, 3)})" for j in range(3))


#: lines that find j = det F - 1 in two dimensions
_TWO = " a, b = F[0] - 1.0, F[3] - 1.0\n j = a + b + (a * b - F[1] * F[2])\n"


def _determinant_excess(n: int) -> str:
    if n == 1:
        return " return F[0] - 1.0"
    if n == 4:
        return _TWO + " return j"
    return """
 a, b, c = F[0] - 1.0, F[4] - 1.0, F[8] - 1.0
 bc, ca, ab = b * c - F[5] * F[7], c * a - F[2] * F[6], a * b - F[1] * F[3]
 cubic = a * bc + F[1] * (F[5] * F[6] - F[3] * c) + F[2] * (F[3] * F[7] - b * F[6])
 return a + b + c + (bc + ca + ab) + cubic"""


def _strain_entry(i: int, j: int, d: int) -> str:
    """Entry of F^T F - 1, F the sum of the unit tensor and what is small."""
    terms = [f"F[{k * d + i}] * F[{k * d + j}]" for k in range(d)]
    if i == j:
        terms[i] = f"(F[{i * d + i}] - 1.0) * (F[{i * d + i}] + 1.0)"
    return " + ".join(terms)


def _shear_excess(n: int) -> str:
    """In three dimensions minus the second and the third invariant of G = F^T F - 1."""
    if n == 1:
        return " return 0.0 * F[0]"
    if n == 4:
        return _TWO + " c, s = a - b, F[1] + F[2]\n return c * c + s * s - j * j"
    entries = [(i, j) for i in range(3) for j in range(i, 3)]
    lines = [f" g{i}{j} = {_strain_entry(i, j, 3)}" for i, j in entries]
    pairs = [f"(g{i}{i} * g{j}{j} - g{i}{j} * g{i}{j})" for i, j in entries if i < j]
    third = "g00 * (g11 * g22 - g12 * g12) + g01 * (g12 * g02 - g01 * g22)"
    third += " + g02 * (g01 * g12 - g11 * g02)"
    return "\n".join([*lines, f" return -({' + '.join(pairs)} + ({third}))"])


def _diagonal(hoops: int) -> str:
    """Source of diag(first, other, …) with so many others."""
    d = hoops + 1
    entries = ["first"] + (["0.0 * first"] * d + ["other"]) * hoops
    return f" return ({', '.join(entries)})"


def _contraction(name: str, arguments: str, indices: str) -> Callable[..., Any]:
    """A function of vectors and tensors by its indices, as "ik,kj->ij" for a product."""
    given, result = indices.split("->")
    factors = list(zip(arguments.split(", "), given.split(",")))
    summed = sorted(set(given) - set(result) - {","})

    def term(values: dict[str, int], d: int) -> str:
        """The product of the entries at values of all indices."""
        at = {name: [values[index] for index in of] for name, of in factors}
        return " * ".join(f"{name}[{k[0] * d + k[1] if k[1:] else k[0]}]" for name, k in at.items())

    def body(n: int) -> str:
        d, entries = isqrt(n) if any(len(of) == 2 for _, of in factors) else n, []
        for of_result in product_of(range(d), repeat=len(result)):
            at = [(*of_result, *k) for k in product_of(range(d), repeat=len(summed))]
            terms = [term(dict(zip([*result, *summed], values)), d) for values in at]
            entries.append(" + ".join(terms))
        return f" return ({', '.join(entries)},)" if result else f" return {entries[0]}"

    return by_length(name, arguments, body)


determinant = by_length("determinant", "F", _determinant)
#: det F times F^-T
cofactor = by_length("cofactor", "F", _tensor(_cofactor))
#: det F - 1, F^T F - 1 (twice the strain of Green) and |F|^2 - d - (det F^2 - 1), which is of
#: second order, without cancellation near the unit tensor
determinant_excess = by_length("determinant_excess", "F", _determinant_excess)
twice_strain = by_length("twice_strain", "F", _tensor(_strain_entry))
shear_excess = by_length("shear_excess", "F", _shear_excess)
#: F + c times the unit tensor
add_unit = by_length(
    "add_unit", "c, F", _tensor(lambda i, j, d: f"F[{i * d + j}]" + " + c" * (i == j))
)
#: diag(first, other) or diag(first, other, other), by the length of around
diagonal = by_length("diagonal", "around, first, other", _diagonal)
trace = _contraction("trace", "F", "ii->")
transpose = _contraction("transpose", "F", "ji->ij")
column_sums = _contraction("column_sums", "F", "ij->j")
#: F a and F^T a
apply = _contraction("apply", "F, a", "ij,j->i")
apply_transposed = _contraction("apply_transposed", "F, a", "ij,i->j")
#: a b^T, from two vectors
outer = _contraction("outer", "a, b", "i,j->ij")
#: F G, F^T G and F G^T
product = _contraction("product", "F, G", "ik,kj->ij")
transposed_product = _contraction("transposed_product", "F, G", "ki,kj->ij")
product_transposed = _contraction("product_transposed", "F, G", "ik,jk->ij")


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
