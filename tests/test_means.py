"""Logarithmic means of vectors, against 40 digits."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from numba import njit

from fsipetsc.operators.means import distance, mean_factors
from fsipetsc.operators.memory import load_wide, store
from fsipetsc.operators.vectors import WIDE


@njit
def means(a, b, arithmetic, harmonic):
    for i in range(0, len(a), WIDE):
        x, y = load_wide(a, i), load_wide(b, i)
        z = distance(x, 1.0 / x, y, 1.0 / y)
        of_mean, of_inverse = mean_factors(z, z)
        store(arithmetic, i, 0.5 * (x + y) * of_mean)
        store(harmonic, i, 0.5 * (x + y) * of_inverse)


def off(found, exact):
    """Largest relative error."""
    return max(float(abs(Decimal(float(f)) - e) / abs(e)) for f, e in zip(found, exact, strict=True))


@pytest.mark.parametrize(("least", "most"), [(1e-12, 1e-3), (1e-3, 0.06), (0.06, 0.6), (0.6, 30.0)])
def test_logarithmic_means(least, most):
    """Of numbers whose ratio is exp of something in this range."""
    rng = np.random.default_rng(1)
    a = np.exp(rng.uniform(-9, 9, 200))
    b = a * np.exp(rng.choice([-1, 1], a.size) * np.exp(rng.uniform(np.log(least), np.log(most), a.size)))
    arithmetic, harmonic = np.empty_like(a), np.empty_like(a)
    means(a, b, arithmetic, harmonic)
    with localcontext() as context:
        context.prec = 40
        pairs = [(x, y, (x / y).ln()) for x, y in zip(map(Decimal, a.tolist()), map(Decimal, b.tolist()), strict=True)]
        pairs = [(x, y, ratio) if x != y else (x, y, None) for x, y, ratio in pairs]
        assert off(arithmetic, [x if r is None else (x - y) / r for x, y, r in pairs]) < 8e-16
        assert off(harmonic, [x if r is None else x * y * r / (x - y) for x, y, r in pairs]) < 8e-16


def test_means_of_equal_numbers():
    a = np.array([1.0, 3.0, 0.1, 1e-30, 1e30, 7.0, 0.7, 2.0 / 3.0])
    arithmetic, harmonic = np.empty_like(a), np.empty_like(a)
    means(a, a.copy(), arithmetic, harmonic)
    assert np.abs(arithmetic / a - 1).max() < 4e-16 and np.abs(harmonic / a - 1).max() < 4e-16


def test_a_lane_does_not_see_the_others():
    rng = np.random.default_rng(2)
    a, b = rng.uniform(1, 1.02, 64), rng.uniform(1, 1.02, 64)
    alone, together = (np.empty(64), np.empty(64)), (np.empty(64), np.empty(64))
    means(a, b, *alone)
    far = b.copy()
    far[3::8] = 50.0
    means(a, far, *together)
    same = np.arange(64) % 8 != 3
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one[same], other[same])
