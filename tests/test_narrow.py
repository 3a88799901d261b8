"""Narrow second derivatives in exact arithmetic: symmetry, sign, width, accuracy."""

from fractions import Fraction

import numpy as np
from test_operators import ALL

from fsipetsc.operators import SBPOperator
from fsipetsc.operators.narrow import ENDS, remainder


def exact(rows) -> np.ndarray:
    return np.array(rows, dtype=object)


def exact_norm(op: SBPOperator, n: int) -> list[Fraction]:
    return [*op.norm, *[Fraction(1)] * (n - 2 * op.rows), *reversed(op.norm)]


def pivots(matrix: np.ndarray) -> list[Fraction]:
    """Those of symmetric elimination; a pivot that is zero must have nothing beside it."""
    rest, found = matrix.copy(), []
    while len(rest):
        pivot = rest[0, 0]
        found.append(pivot)
        assert pivot != 0 or not rest[0].any()
        rest = rest[1:, 1:] - np.outer(rest[1:, 0], rest[0, 1:]) / (pivot or 1)
    return found


@ALL
def test_remainder_is_symmetric_and_positive_semidefinite(op: SBPOperator) -> None:
    """It vanishes on polynomials up to degree p, and at most on one more vector at either end,
    which D sees. With it, the interior formula has 2p + 1 points, where D twice has 4p + 1."""
    p, closed = op.p, op.rows + 2 * op.p
    n = 2 * closed + 1
    b = [Fraction(1 + (7 * i * i + 3 * i) % 11, 3 + i % 4) for i in range(n)]  # of no pattern
    D, H, R = exact(op.exact_matrix(n)), exact(exact_norm(op, n)), remainder(op.interior, b)
    wide = D.T @ (H[:, None] * exact(b)[:, None] * D)
    assert (R == R.T).all()
    found = pivots(R)
    assert min(found) >= 0 and found.count(0) == p + 1 + (2 if ENDS[op.order] else 0)
    found = pivots(wide + R)
    assert min(found) >= 0 and found.count(0) == 1
    for degree in range(p + 2):
        assert any(R @ exact([Fraction(i) ** degree for i in range(n)])) == (degree > p)
    for i in range(closed, n - closed):
        beyond = [j for j in range(n) if abs(i - j) > p]
        assert wide[i, beyond].any() and not (wide + R)[i, beyond].any()


@ALL
def test_accuracy(op: SBPOperator) -> None:
    """(b u')' of polynomials b and u: in the interior to order 2p, and where the closures reach as
    exact as D twice."""
    n, s = 2 * op.rows + 6 * op.p + 4, op.boundary_order
    x = [Fraction(i) for i in range(n)]
    D, norm = exact(op.exact_matrix(n)), exact(exact_norm(op, n))
    inner = slice(op.rows + 2 * op.p, n - op.rows - 2 * op.p)
    for power in range(3):
        b = [1 + value**power for value in x]
        R = remainder(op.interior, b)
        for degree in range(op.order + 2):
            u = exact([value**degree for value in x])
            # (u' + x^power u')'
            terms = ((degree * (degree + k - 1), degree + k - 2) for k in (0, power))
            truth = sum(exact([c * v ** max(e, 0) for v in x]) for c, e in terms)
            error = D @ (exact(b) * (D @ u)) - (R @ u) / norm - truth
            if degree + power <= op.order:  # b u is differentiated twice
                assert not error[inner].any(), (power, degree)
            if degree <= s and power + degree - 1 <= s:
                assert not error.any(), (power, degree)
    assert error[inner].any()
