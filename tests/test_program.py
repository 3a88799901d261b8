"""Prepared calls made by a program, against what they are given and do."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from fsipetsc.operators.prepared import Prepared
from fsipetsc.operators.program import Program


@njit
def note(table, pair, number, flag, out, a, b):
    if flag:
        out[0] += table[1, 2] + pair[1][0] * number + a
    else:
        out[out.size - 1] -= b


@njit
def refuse(out, limit):
    out[0] += 1.0
    if out[0] > limit:
        raise ValueError


@njit
def double(x):
    return 2.0 * x


def test_each_call_gets_what_it_was_prepared_with_and_its_share_of_the_number():
    table, pair, out = np.arange(6.0).reshape(2, 3), (np.array([7.0]), np.array([11.0])), np.zeros(3)
    first, second = Prepared(note, table, pair, 3, True, out), Prepared(note, table, pair, 3, False, out[1:])
    program = Program([(first, (0.5, 0.0)), (second, (0.0, 2.0)), (first, (0.25, 0.0))])
    program(8.0)
    assert out.tolist() == [2 * (5.0 + 33.0) + 4.0 + 2.0, 0.0, -16.0]
    table[1, 2] = 0.0  # it is where it was, not as it was
    program(0.0)
    assert out[0] == 82.0 + 66.0


def test_an_exception_ends_it():
    out = np.zeros(1)
    program = Program([(Prepared(refuse, out, 1.5), ()), (Prepared(refuse, out, 9.0), ())])
    program(0.0)
    with pytest.raises(RuntimeError, match="refuse has raised"):
        program(0.0)
    assert out[0] == 3.0


def test_a_function_that_returns_something_is_refused():
    with pytest.raises(TypeError, match="double returns float64"):
        Program([(Prepared(double, 1.5), ())])
