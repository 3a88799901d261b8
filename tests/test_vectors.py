"""Vectors of neighbouring points, lane by lane against numpy."""

from __future__ import annotations

import itertools
import operator

import numpy as np
import pytest

numba = pytest.importorskip("numba")

from fsipetsc.operators import vectors
from fsipetsc.operators.kernels import store_lanes
from fsipetsc.operators.lanes import centred_difference, interlaced, lane, masked, mirrored
from fsipetsc.operators.memory import load, load_twice, load_wide, load_wide_interlaced, store, store_interlaced
from fsipetsc.operators.vectors import LANES, TWICE, WIDE, fma, spread
from fsipetsc.scheme.plane.look import squared_sum

A, B, C = np.random.default_rng(7).uniform(-2, 2, (3, LANES))
ODD = np.array([1.0, -1.0, np.inf, -np.inf, np.nan, 0.0])


def lanes(formula):
    """formula(vectors of the rows of its argument) as a function of rows that returns the lanes."""

    @numba.njit
    def call(rows):
        flat = np.zeros(LANES)
        store(flat, 0, formula(load(rows, 0), load(rows, LANES), load(rows, 2 * LANES)))
        return flat

    return lambda *rows: call(np.array(rows))


@pytest.mark.parametrize("op", [operator.add, operator.sub, operator.mul, operator.truediv], ids=lambda op: op.__name__)
def test_arithmetic_is_that_of_scalars(op):
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: op(a, b)))(A, B, C), op(A, B))
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: op(a, 3.0)))(A, B, C), op(A, 3.0))
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: op(3.0, a)))(A, B, C), op(3.0, A))


def test_fma_rounds_once():
    a = np.full(LANES, 1 + 2.0**-30)
    once = lanes(numba.njit(lambda a, b, c: fma(a, b, c)))(a, a, -a * a)
    assert np.all(once == 2.0**-60), "the part of the product that a second rounding would lose"


@pytest.mark.parametrize(("name", "reference"), [("maximum", np.maximum), ("minimum", np.minimum)])
def test_extremes_let_through_what_is_not_a_number(name, reference):
    chosen = getattr(vectors, name)
    of_vectors = lanes(numba.njit(lambda a, b, c: chosen(a, b)))
    of_numbers = numba.njit(lambda a, b: chosen(a, b))
    for a, b in itertools.product(ODD, ODD):
        expected = reference(a, b)
        assert np.array_equal(of_vectors(np.full(LANES, a), np.full(LANES, b), C), np.full(LANES, expected), equal_nan=True)
        assert np.array_equal(of_numbers(a, b), expected, equal_nan=True)


def test_roots_and_magnitudes():
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: vectors.root(vectors.magnitude(a))))(A, B, C), np.sqrt(np.abs(A)))


@pytest.mark.parametrize("k", range(1, LANES + 1))
def test_differences_reach_into_the_neighbours(k):
    row = np.concatenate([A, B, C])
    here = np.arange(LANES, 2 * LANES)
    source = f"lambda a, b, c: apart(a, b, c, {k})"  # k is a literal
    difference = numba.njit(eval(source, {"apart": centred_difference}))
    assert np.array_equal(lanes(difference)(A, B, C), row[here + k] - row[here - k])


def test_lanes():
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: mirrored(a)))(A, B, C), A[::-1])
    assert np.array_equal(lanes(numba.njit(lambda a, b, c: spread(lane(a, 2))))(A, B, C), np.full(LANES, A[2]))
    for n in range(-1, LANES + 2):
        expected = np.where(np.arange(LANES) < n, A, 9.0)
        assert np.array_equal(lanes(numba.njit(lambda a, b, c: masked(a, n, 9.0)))(A, B, C), expected)  # noqa: B023


@pytest.mark.parametrize(("a", "b"), list(itertools.product(range(-1, LANES + 2), repeat=2)))
def test_only_the_lanes_asked_for_are_stored(a, b):
    @numba.njit
    def put(row, a, b):
        store_lanes(row, 3, load(row, 8), a, b)

    row = np.arange(12.0)
    expected = row.copy()
    for j in range(max(a, 0), min(b, LANES)):
        expected[3 + j] = row[8 + j]
    put(row, a, b)
    assert np.array_equal(row, expected)


@pytest.mark.parametrize("n", [3, 4])
def test_interlaced(n):
    rows = np.random.default_rng(n).uniform(size=(4, LANES))

    @numba.njit
    def put(rows, out, three):
        a, b, c = load(rows, 0), load(rows, LANES), load(rows, 2 * LANES)
        if three:
            store_interlaced(out, 1, (a, b, c))
        else:
            store_interlaced(out, 1, (a, b, c, load(rows, 3 * LANES)))

    out = np.zeros(n * LANES + 2)
    put(rows, out, n == 3)
    assert np.array_equal(out[1:-1], rows[:n].T.ravel()) and out[0] == out[-1] == 0


def test_five_unknowns_that_stand_together_are_taken_apart_and_put_together():
    together = np.random.default_rng(5).uniform(size=5 * WIDE)

    @numba.njit
    def there_and_back(source, apart, back):
        values = load_wide_interlaced(source, 0, 5)
        for c, (one, other) in enumerate(zip(values, interlaced(values))):
            store(apart, c * WIDE, one)
            store(back, c * WIDE, other)

    apart, back = np.zeros(5 * WIDE), np.zeros(5 * WIDE)
    there_and_back(together, apart, back)
    assert np.array_equal(apart.reshape(5, WIDE), together.reshape(WIDE, 5).T)
    assert np.array_equal(back, together)


def test_squares_of_sums_of_roots():
    """Of a modulus below 0 none, also where both are, whose product has a root."""
    x = np.array([4.0, 0.0, -1.0, -1.0, 2.0, 0.0, 9.0, np.nan] * 2)
    y = np.array([9.0, 0.0, -1.0, 4.0, -0.5, 3.0, np.inf, 1.0] * 2)

    @numba.njit
    def squares(x, y, out):
        store(out, 0, squared_sum(load_twice(x, 0), load_twice(y, 0)))

    squares(x, y, out := np.zeros(TWICE))
    expected = [25.0, 0.0, np.nan, np.nan, np.nan, 3.0, np.inf, np.nan] * 2
    np.testing.assert_allclose(out, expected, rtol=1e-15)


def test_logarithms_of_numbers_that_are_not_normal():
    tiny = np.finfo(float).tiny
    x = np.array([tiny, np.nextafter(tiny, 0.0), 5e-324, 0.0, -1.0, np.inf, np.nan, 1.0])

    @numba.njit
    def logs(x, out):
        store(out, 0, np.log(load_wide(x, 0)))

    logs(x, out := np.zeros(WIDE))
    assert np.isnan(out[1:7]).all() and out[7] == 0.0 and abs(out[0] / np.log(tiny) - 1) < 1e-15
