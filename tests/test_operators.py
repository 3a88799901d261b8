"""The SBP operators: their defining properties in exact arithmetic, their spectra, and their record for kernels."""

from __future__ import annotations

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

from fsipetsc.operators import OPERATORS, SBPOperator, operator
from fsipetsc.paper.stencils import packed

ALL = pytest.mark.parametrize("op", OPERATORS.values(), ids=lambda op: op.name)

# max over theta of |2 sum_k c_k sin(k theta)|
INTERIOR_RADIUS = {2: 1.0, 4: 1.3722, 6: 1.5860, 8: 1.7306}


def exact_norm(op: SBPOperator, n: int) -> list[Fraction]:
    return [*op.norm, *[Fraction(1)] * (n - 2 * op.rows), *reversed(op.norm)]


def derivative_error(op: SBPOperator, n: int, degree: int) -> list[Fraction]:
    """D x^degree - degree x^(degree-1) on x = 0..n-1, exactly."""
    rows = op.exact_matrix(n)
    return [
        sum(weight * j**degree for j, weight in enumerate(row)) - degree * Fraction(i) ** max(degree - 1, 0)
        for i, row in enumerate(rows)
    ]


def closure_error(closure: np.ndarray, degree: int) -> np.ndarray:
    """The same for an array of closure rows."""
    rows, cols = closure.shape
    return closure @ np.arange(cols) ** degree - degree * np.arange(rows) ** (degree - 1)


def free_directions(order: int) -> list[np.ndarray]:
    """Antisymmetric changes of Q, (rows, rows) of integers, that vanish on polynomials up to the boundary order.

    They are a b^T - b a^T for a, b among the differences of order s + 1 that fit on the closure points.
    """
    op = operator(order)
    difference = np.array([1], dtype=object)
    for _ in range(op.boundary_order + 1):
        difference = np.convolve(difference, np.array([1, -1], dtype=object))
    shifts = range(op.rows - len(difference) + 1)
    fitted = [np.array([0] * k + list(difference) + [0] * (shifts[-1] - k), dtype=object) for k in shifts]
    pairs = [(a, b) for i, a in enumerate(fitted) for b in fitted[i + 1 :]]
    return [np.outer(a, b) - np.outer(b, a) for a, b in pairs]


def without_inflow(op: SBPOperator, n: int) -> np.ndarray:
    """hD with the row and column of the left end removed: u_t + u_x = 0 with u = 0 imposed there."""
    return op.matrix(n)[1:, 1:]


def test_orders_sizes_and_names() -> None:
    table = {
        op.name: (op.order, op.boundary_order, op.p, op.rows, op.reach, op.min_points) for op in OPERATORS.values()
    }
    assert table == {
        "2/1": (2, 1, 1, 1, 1, 2),
        "4/2": (4, 2, 2, 4, 3, 8),
        "6/3": (6, 3, 3, 6, 5, 12),
        "8/4": (8, 4, 4, 8, 7, 16),
    }
    assert all(operator(order) is op and op.order == order for order, op in OPERATORS.items())


def test_classical_closures() -> None:
    """2/1 and 4/2 have no free parameter: the rows as every table prints them."""
    assert operator(2).closure == ((-1, 1),)
    table = """
        -24/17  59/34  -4/17  -3/34   0      0
        -1/2    0      1/2    0       0      0
        4/43    -59/86 0      59/86   -4/43  0
        3/98    0      -59/98 0       32/49  -4/49
    """
    assert operator(4).closure == tuple(tuple(map(Fraction, line.split())) for line in table.strip().splitlines())


@ALL
@pytest.mark.parametrize("extra", [0, 1, 7])
def test_summation_by_parts(op: SBPOperator, extra: int) -> None:
    n = op.min_points + extra
    norm, rows = exact_norm(op, n), op.exact_matrix(n)
    boundary = [-1] + [0] * (n - 2) + [1]
    for i in range(n):
        for j in range(n):
            assert norm[i] * rows[i][j] + norm[j] * rows[j][i] == (boundary[i] if i == j else 0), (i, j)


@ALL
def test_order_of_accuracy(op: SBPOperator) -> None:
    """Each row is exact up to its order, and the rows of either kind are not all exact one degree further."""
    n, r, s = op.min_points + 2, op.rows, op.boundary_order
    for degree in range(op.order + 1):
        error = derivative_error(op, n, degree)
        assert not any(error[r:-r])
        if degree <= s:
            assert not any(error)
    assert all(derivative_error(op, n, op.order + 1)[r:-r])
    assert any(derivative_error(op, n, s + 1)[:r])


@ALL
def test_right_end_is_the_mirrored_left_end(op: SBPOperator) -> None:
    n = op.min_points + 3
    rows = op.exact_matrix(n)
    assert [[-weight for weight in reversed(row)] for row in reversed(rows)] == rows
    assert [tuple(row[: op.rows + op.p]) for row in rows[: op.rows]] == list(op.closure)
    assert op.norm_weights(n).tolist() == [float(weight) for weight in exact_norm(op, n)]


@ALL
def test_norm_is_a_positive_quadrature(op: SBPOperator) -> None:
    """SBP with u = x^i, v = x^j and i, j <= s integrates (uv)' exactly: degree 2s - 1 at most, and not more."""
    n = op.min_points + 1
    norm = exact_norm(op, n)
    assert min(norm) > 0
    for degree in range(2 * op.boundary_order + 1):
        quadrature = sum(weight * x**degree for x, weight in enumerate(norm))
        exact = Fraction((n - 1) ** (degree + 1), degree + 1)
        assert (quadrature == exact) == (degree < 2 * op.boundary_order)


@ALL
def test_matrix_is_the_exact_one_over_h(op: SBPOperator) -> None:
    n, h = op.min_points + 4, 0.125
    exact = np.array([[float(weight) for weight in row] for row in op.exact_matrix(n)])
    assert np.array_equal(op.matrix(n), exact)
    assert np.array_equal(op.matrix(n, h), exact / h)
    assert all(type(weight) is Fraction for row in op.exact_matrix(n) for weight in row)


def test_free_entry_of_63_minimises_the_truncation_error() -> None:
    """sum_i H_i e_i^2, e the closure's error on x^4, is stationary, exactly, in the one direction left free."""
    op = operator(6)
    (direction,) = free_directions(6)
    change = direction @ np.arange(op.rows) ** 4  # H times the change of e
    assert closure_error(np.array(op.closure, dtype=object), 4) @ change == 0


def test_free_entries_of_84_are_within_a_percent_of_the_least_truncation_error() -> None:
    """The same sum for x^5, relative to its least value over the three free entries."""
    op = operator(8)
    root = np.sqrt([float(weight) for weight in op.norm])
    error = root * closure_error(np.array(op.closure, dtype=float), 5)
    changes = np.array([direction @ np.arange(op.rows) ** 5 for direction in free_directions(8)], dtype=float).T
    changes /= root[:, None]
    least = error - changes @ np.linalg.lstsq(changes, error, rcond=None)[0]
    assert np.linalg.norm(error) < 1.01 * np.linalg.norm(least)


def test_truncation_error_does_not_decide_the_84_closure() -> None:
    """The warning in coefficients.py: the same error on x^5, and several times the spectral radius."""
    op = operator(8)
    first, second, third = free_directions(8)
    harmful = first - second + third
    assert [harmful[5, 6], harmful[5, 7], harmful[6, 7]] == [21, -6, 1]
    assert not any(harmful @ np.arange(op.rows) ** 5)
    closure = [list(row) for row in op.closure]
    for i, j in np.ndindex(harmful.shape):
        closure[i][j] += Fraction(int(harmful[i, j]), 100) / op.norm[i]
    other = dataclasses.replace(op, closure=tuple(map(tuple, closure)))
    assert not any(any(derivative_error(other, 20, degree)) for degree in range(5))
    assert np.abs(np.linalg.eigvals(without_inflow(other, 60))).max() > 8


@ALL
def test_interior_symbol(op: SBPOperator) -> None:
    theta = np.linspace(0, np.pi, 20001)
    symbol = 2 * sum(float(c) * np.sin(k * theta) for k, c in enumerate(op.interior, start=1))
    assert symbol.max() == pytest.approx(INTERIOR_RADIUS[op.order], abs=5e-5)


@ALL
@pytest.mark.parametrize("n", [60, 100])
def test_closure_costs_no_time_step(op: SBPOperator, n: int) -> None:
    """The spectral radius of hD without the inflow point is the interior's, from below."""
    radius = np.abs(np.linalg.eigvals(without_inflow(op, n))).max()
    assert 0.995 * INTERIOR_RADIUS[op.order] < radius < INTERIOR_RADIUS[op.order]


def test_spectral_radius_of_84() -> None:
    assert np.abs(np.linalg.eigvals(without_inflow(operator(8), 40))).max() == pytest.approx(1.7172, abs=5e-5)


@ALL
@pytest.mark.parametrize("n", [16, 40, 60])
def test_advection_with_injected_inflow_decays(op: SBPOperator, n: int) -> None:
    """All modes of u_t = -D u decay: Re > 0 for D, by more than the round-off of the eigenvalues."""
    assert np.linalg.eigvals(without_inflow(op, n)).real.min() > 1e-9


@ALL
def test_too_few_points(op: SBPOperator) -> None:
    n = op.min_points - 1
    for method in (op.matrix, op.exact_matrix, op.norm_weights):
        with pytest.raises(ValueError, match=f"{op.name} operator needs at least {op.min_points} points, not {n}"):
            method(n)


@pytest.mark.parametrize("order", [0, 3, 10, None])
def test_unknown_order_names_the_valid_ones(order: int | None) -> None:
    for function in (operator, packed):
        with pytest.raises(ValueError, match="2, 4, 6, 8"):
            function(order)


def test_operators_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        operator(4).order = 6


@ALL
def test_packed_record(op: SBPOperator) -> None:
    record = packed(op.order)[0]
    rows, cols = op.rows, op.rows + op.p
    assert [record[name] for name in ("p", "rows", "columns", "reach")] == [op.p, rows, cols, op.reach]
    n = op.min_points
    assert np.array_equal(record["closure"][:rows, :cols], op.matrix(n)[:rows, :cols])
    assert np.array_equal(record["norm"][:rows], op.norm_weights(n)[:rows])
    assert np.array_equal(record["interior"][: op.p], [float(c) for c in op.interior])
    padding = [record["closure"][rows:], record["closure"][:, cols:], record["norm"][rows:], record["interior"][op.p :]]
    assert not any(part.any() for part in padding)
