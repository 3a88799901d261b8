"""The SBP operators: their defining properties in exact arithmetic, and their spectra."""

from fractions import Fraction

import numpy as np
import pytest

from fsipetsc.operators.sbp import AXIS, OPERATORS, SBPOperator, centred_band, undivided
from fsipetsc.paper.stencils import MEANS, end_term

ALL = pytest.mark.parametrize("op", OPERATORS.values(), ids=lambda op: op.name)

# max over theta of |2 sum_k c_k sin(k theta)|
INTERIOR_RADIUS = {2: 1.0, 4: 1.3722, 6: 1.5860, 8: 1.7306}


def exact(rows) -> np.ndarray:
    return np.array(rows, dtype=object)


def exact_norm(op: SBPOperator, n: int) -> np.ndarray:
    return exact([*op.norm, *[Fraction(1)] * (n - 2 * op.rows), *reversed(op.norm)])


def derivative_error(op: SBPOperator, n: int, degree: int) -> np.ndarray:
    """D x^degree - degree x^(degree-1) on x = 0..n-1, exactly."""
    x = exact([Fraction(i) for i in range(n)])
    return exact(op.matrix(n)) @ x**degree - degree * x ** max(degree - 1, 0)


@ALL
@pytest.mark.parametrize("extra", [0, 7])
def test_summation_by_parts(op: SBPOperator, extra: int) -> None:
    """With a positive norm, which has the same numbers at both ends, as D has."""
    n = op.min_points + extra
    norm, D = exact_norm(op, n), exact(op.matrix(n))
    Q, boundary = norm[:, None] * D, np.diag([-1, *[0] * (n - 2), 1])
    assert min(norm) > 0 and np.array_equal(D, -D[::-1, ::-1])
    assert np.array_equal(Q + Q.T, boundary)
    assert np.array_equal(op.norm_weights(n), norm.astype(float))


@ALL
def test_order_of_accuracy(op: SBPOperator) -> None:
    """Rows are exact up to their order, and those of either kind are not all exact beyond it."""
    n, r, s = op.min_points + 2, op.rows, op.p
    for degree in range(op.order + 1):
        error = derivative_error(op, n, degree)
        assert not any(error[r:-r]) and (degree > s or not any(error))
    assert all(derivative_error(op, n, op.order + 1)[r:-r])
    assert any(derivative_error(op, n, s + 1)[:r])


@ALL
@pytest.mark.parametrize("n", [16, 60])
def test_spectrum_of_advection_with_injected_inflow(op: SBPOperator, n: int) -> None:
    """All modes of u_t = -D u decay; the spectral radius of hD is the interior's, from below."""
    eigenvalues = np.linalg.eigvals(op.matrix(n)[1:, 1:].astype(float))
    limit = INTERIOR_RADIUS[op.order]
    assert eigenvalues.real.min() > 1e-9
    assert (0.995 if n == 60 else 0.5) * limit < np.abs(eigenvalues).max() < limit


@pytest.mark.parametrize("order", AXIS)
def test_weights_beside_an_axis(order: int) -> None:
    """u = r and p = r^2 have their derivatives exactly; with the weights of a plane not."""
    cells = OPERATORS[order].min_points + 5
    n = cells + 1
    r = np.arange(-n, n) + 0.5

    def errors(kappa: int) -> list[np.ndarray]:
        band = centred_band(order, cells, kappa)
        S = np.zeros((2 * n, 2 * n))
        for k, weights in enumerate(np.roll(band.S, n, axis=1)):
            for i in np.flatnonzero(weights):
                S[i, i + k], S[i + k, i] = weights[i], -weights[i]
        assert np.array_equal(S, -S[::-1, ::-1])
        A = np.abs(r)
        areas = 0.25 * S * (A + A[:, None])
        J = 0.25 * (S * (r * A - (r * A)[:, None])).sum(axis=1)
        found = [
            S.sum(axis=1),
            (areas * (r**2 - (r**2)[:, None])).sum(axis=1) - 2.0 * J * r,
            (areas * (r + r[:, None])).sum(axis=1) - 2.0 * J,
        ]
        return [np.abs(f[n : n + 6]).max() for f in found]

    assert max(errors(1)) < 1e-13 < 0.05 < min(errors(2)[1:])


# narrow second derivatives: symmetry, sign, width, accuracy


def pivots(matrix: np.ndarray) -> list[Fraction]:
    """Those of symmetric elimination; a pivot that is zero must have nothing beside it."""
    rest, found = matrix.copy(), []
    while len(rest):
        pivot = rest[0, 0]
        found.append(pivot)
        assert pivot != 0 or not rest[0].any()
        rest = rest[1:, 1:] - np.outer(rest[1:, 0], rest[0, 1:]) / (pivot or 1)
    return found


def remainder(op: SBPOperator, b: np.ndarray) -> np.ndarray:
    """R(b), (n, n), exactly."""
    n, T, R = len(b), len(end := exact(end_term(op.order))), 0
    for q, means in enumerate(MEANS[op.order], op.p + 1):
        weights = [*map(Fraction, undivided(q)), *[Fraction(0)] * (n - q)]
        Delta = exact([np.roll(weights, t)[:n] for t in range(n - q)])
        first = (q + 1 - len(means)) // 2
        mean = sum(w * b[first + k :][: n - q] for k, w in enumerate(means))
        inner = slice(T, n - q - T)
        R = R + Delta[inner].T @ (mean[inner, None] * Delta[inner])
        for side in (slice(None), slice(None, None, -1)) if q == op.p + 1 and T else ():
            rows = Delta[side][:T]
            R = R + b[side][T] * (rows.T @ end @ rows)
    return R


@ALL
def test_remainder_is_symmetric_and_positive_semidefinite(op: SBPOperator) -> None:
    """0 on degrees up to p and one vector at either end; interior rows have 2p + 1 points."""
    p, closed = op.p, op.rows + 2 * op.p
    n = 2 * closed + 1
    b = [Fraction(1 + (7 * i * i + 3 * i) % 11, 3 + i % 4) for i in range(n)]  # of no pattern
    D, H, R = exact(op.matrix(n)), exact_norm(op, n), remainder(op, exact(b))
    wide = D.T @ (H[:, None] * exact(b)[:, None] * D)
    assert (R == R.T).all()
    found = pivots(R)
    assert min(found) >= 0 and found.count(0) == p + 1 + 2 * bool(end_term(op.order))
    found = pivots(wide + R)
    assert min(found) >= 0 and found.count(0) == 1
    for degree in range(p + 2):
        assert any(R @ exact([Fraction(i) ** degree for i in range(n)])) == (degree > p)
    for i in range(closed, n - closed):
        beyond = [j for j in range(n) if abs(i - j) > p]
        assert wide[i, beyond].any() and not (wide + R)[i, beyond].any()


@ALL
def test_accuracy(op: SBPOperator) -> None:
    """(b u')' of polynomials: order 2p inside; where closures reach as exact as D twice."""
    n, s = 2 * op.rows + 6 * op.p + 4, op.p
    x = exact([Fraction(i) for i in range(n)])
    D, norm = exact(op.matrix(n)), exact_norm(op, n)
    inner = slice(op.rows + 2 * op.p, n - op.rows - 2 * op.p)
    for power in range(3):
        b = 1 + x**power
        R = remainder(op, exact(b))
        for degree in range(op.order + 2):
            u = x**degree
            # (u' + x^power u')'
            terms = ((degree * (degree + k - 1), degree + k - 2) for k in (0, power))
            truth = sum(c * x ** max(e, 0) for c, e in terms)
            error = D @ (b * (D @ u)) - (R @ u) / norm - truth
            if degree + power <= op.order:  # b u is differentiated twice
                assert not error[inner].any(), (power, degree)
            if degree <= s and power + degree - 1 <= s:
                assert not error.any(), (power, degree)
    assert error[inner].any()
