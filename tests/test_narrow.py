"""Narrow second derivatives in exact arithmetic: symmetry, sign, width, accuracy; what they damp;
how large steps may be."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from test_operators import ALL, exact_norm

from fsipetsc.operators import OPERATORS, SBPOperator
from fsipetsc.operators.narrow import ENDS, STIFFNESS, levels, remainder

ORDERS = pytest.mark.parametrize("order", OPERATORS)
#: -h^2 times the interior formula of D2(1) on (-1)^i, and times that of D twice on its own worst
#: wave
SHORTEST = {2: Fraction(4), 4: Fraction(16, 3), 6: Fraction(272, 45), 8: Fraction(2048, 315)}
#: where the method of Runge and Kutta is stable on the negative axis
REAL_INTERVAL = 2.785


def coefficients(n: int) -> list[Fraction]:
    """Positive and of no pattern."""
    return [Fraction(1 + (7 * i * i + 3 * i) % 11, 3 + i % 4) for i in range(n)]


def exact(rows) -> np.ndarray:
    return np.array(rows, dtype=object)


def stiffness_matrices(op: SBPOperator, b) -> tuple[np.ndarray, np.ndarray]:
    """(D^T H B D, R(b)), exactly."""
    n = len(b)
    D = exact(op.exact_matrix(n))
    return D.T @ (exact(exact_norm(op, n))[:, None] * exact(b)[:, None] * D), remainder(
        op.interior, b
    )


def pivots(matrix: np.ndarray) -> list[Fraction]:
    """Those of symmetric elimination; a pivot that is zero must have nothing beside it."""
    rest, found = matrix.copy(), []
    while len(rest):
        pivot = rest[0, 0]
        found.append(pivot)
        if pivot == 0:
            assert not rest[0].any()
            rest = rest[1:, 1:]
        else:
            rest = rest[1:, 1:] - np.outer(rest[1:, 0], rest[0, 1:]) / pivot
    return found


@ALL
def test_remainder_is_symmetric_and_positive_semidefinite(op: SBPOperator) -> None:
    """And vanishes on polynomials up to degree p, and at most on one more vector at either end,
    which D sees."""
    n = op.min_points + 5
    wide, R = stiffness_matrices(op, coefficients(n))
    assert (R == R.T).all()
    found = pivots(R)
    assert min(found) >= 0
    assert sum(pivot == 0 for pivot in found) == op.p + 1 + (2 if ENDS[op.order] else 0)
    found = pivots(wide + R)
    assert min(found) >= 0 and sum(pivot == 0 for pivot in found) == 1
    for degree in range(op.p + 2):
        assert any(R @ exact([Fraction(i) ** degree for i in range(n)])) == (degree > op.p)
    assert all(weight > 0 for level in levels(op.interior) for weight in level.weights)
    assert not sum(R).any(), "what is taken from one point comes to others"


@ALL
def test_interior_formula_is_narrow(op: SBPOperator) -> None:
    """For any coefficient: 2p + 1 points, where D twice has 4p + 1; 2/1 is the formula that all
    know."""
    n, r, p = 2 * op.rows + 6 * op.p + 3, op.rows, op.p
    b = coefficients(n)
    wide, R = stiffness_matrices(op, b)
    narrow = wide + R
    for i in range(r + 2 * p, n - r - 2 * p):
        beyond = [j for j in range(n) if abs(i - j) > p]
        assert not narrow[i, beyond].any()
        assert wide[i, beyond].any() and narrow[i, i + p]
        if op.order == 2:
            means = (b[i - 1] + b[i]) / 2, (b[i] + b[i + 1]) / 2
            assert list(narrow[i, i - 1 : i + 2]) == [-means[0], sum(means), -means[1]]


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
            slope = [degree * value ** max(degree - 1, 0) for value in x]
            curved = [degree * (degree - 1) * value ** max(degree - 2, 0) for value in x]
            b_slope = [power * value ** max(power - 1, 0) for value in x]
            truth = exact(
                [bs * sl + c * cu for bs, sl, c, cu in zip(b_slope, slope, b, curved, strict=True)]
            )
            error = D @ (exact(b) * (D @ u)) - (R @ u) / norm - truth
            if degree + power <= op.order:  # b u is differentiated twice
                assert not error[inner].any(), (power, degree)
            if degree <= s and power + degree - 1 <= s:
                assert not error.any(), (power, degree)
    assert error[inner].any()


@ALL
def test_step_bound(op: SBPOperator) -> None:
    """Courant number 1.1 is stable with a Dirichlet ghost point anywhere, and with two natural
    ends; 1.5 is not with all."""
    n, largest = 40, 0.0
    D = op.matrix(n)
    R = remainder(op.interior, np.ones(n)) / op.norm_weights(n)[:, None]
    natural = -(D.T * op.norm_weights(n)) @ D / op.norm_weights(n)[:, None] - R
    largest = np.abs(np.linalg.eigvals(natural)).max()
    for delta in np.linspace(0.0, 1.0, 11):
        weights = np.array(
            [(delta - 1) * (delta - 2) / 2, delta * (2 - delta), delta * (delta - 1) / 2]
        )
        weights += max(0.0, 0.25 - weights[0]) * np.array([1, -2, 1])
        ghost = np.zeros((n, n - 2))
        ghost[1:-1], ghost[0, :2] = np.eye(n - 2), -weights[1:] / weights[0]
        values = np.linalg.eigvals(((D @ D - R) @ ghost)[1:-1])
        assert values.real.max() < 0
        largest = max(largest, np.abs(values).max())
    assert 1.1 * largest < REAL_INTERVAL * STIFFNESS[op.order] < 1.5 * largest


@pytest.mark.parametrize("order", [2, 4, 6])
def test_flux_at_an_end(order) -> None:
    """Where the closure row of D imposes a flux, it is right to the order of D twice: phi = 0, see
    operators.narrow."""
    op, n = OPERATORS[order], 60
    s, D, x = order // 2, op.matrix(n), np.arange(float(n))
    D2 = D @ D - remainder(op.interior, np.ones(n)) / op.norm_weights(n)[:, None]
    u = x ** (s + 1) / math.factorial(s + 1)
    error = (D2 @ u - x ** (s - 1) / math.factorial(s - 1))[1:40]
    error[op.rows + 2 * op.p :] = 0.0
    E = np.linalg.lstsq(D2[1:40, :30], -error, rcond=None)[0]
    np.testing.assert_allclose(D2[1:40, :30] @ E, -error, atol=1e-11)
    assert abs((D @ u)[0] + D[0, :30] @ E) < 1e-9
