"""Loops that are recorded and printed as C: what they do, and what is refused."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from recorded import recorded

from fsipetsc.errors import InputError
from fsipetsc.kernels.loops import each, number, otherwise, pick, stop, variable, when, whole
from fsipetsc.kernels.symbols import exact


class Inner(NamedTuple):
    table: Any
    scale: float


class Part(NamedTuple):
    inner: Inner
    at: Any
    first: int
    doubles: bool


def part(doubles=True, n=5):
    table = np.arange(3.0 * n).reshape(n, 3)
    return Part(Inner(table, 0.5), np.array([4, 0, 2]), 1, doubles)


def test_branches_variables_and_reading_again():
    def count(part, y):
        """A running sum until it is beyond 10; how often numbers were above 1."""
        total, often = variable(0.0), variable(0.0)
        for i in each(y.size):
            with when((y[i] > 1.0) & (i < 6)):
                often.value += 1.0
                y[i] = -y[i]
            with otherwise():
                y[i] = 100.0
            total.value += y[i] * y[i]
            stop(total.value > 50.0)
        y[0] = total.value
        y[1] = often.value
        y[-1] = number(pick(often.value > 2.0, part.first + 6, part.at[0]) % 3)
        y[-2] = number(part.at[whole(often.value) - 4])

    y = np.array([2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    recorded(count, part())(y)
    assert y.tolist() == [54.0, 4.0, -4.0, -5.0, 6.0, 7.0, 4.0, 7 % 3]


def test_exact_sums_are_not_fused():
    def mean(part, y):
        """The same sum of two products, seen from both sides, and fused."""
        a, b = part.inner.table, part.inner.scale
        for i in each(1, vector=True):
            y[0] = exact(a[0, 1] * b + a[0, 2] * a[1, 0])
            y[1] = exact(a[0, 2] * a[1, 0] + a[0, 1] * b)
            y[2] = a[1, 1] * a[1, 2] + y[i]
            y[3] = y[i] + exact(a[0, 1] * a[1, 1])

    text = recorded(mean, part()).text
    assert text.count("fma") == 1
    assert exact(2.0) == 2.0 and exact((1.0, 2.0)) == (1.0, 2.0)


def test_what_cannot_be_recorded_is_refused_with_its_line():
    def branches(part, y):
        if part.first > 0:
            y[0] = 1.0

    def counts(part, y):
        for _ in range(part.first):
            y[0] = 1.0

    for function in (branches, counts):
        with pytest.raises(InputError, match=rf"{function.__name__}, .*test_procedures.py:\d+"):
            recorded(function, part())
