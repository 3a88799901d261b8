"""Logarithmic means, (a - b) / (ln a - ln b), of two positive numbers.

With x = ln(a/b) and the distance z = a/b + b/a - 2 = 4 sinh(x/2)^2,

    mean of a and b                  (a + b)/2 A(z),    A = tanh(x/2) / (x/2)
    1 / (mean of 1/a and 1/b)        (a + b)/2 B(z),    B = x / sinh(x)

Both are analytic in z. Where 1/a and 1/b are known, near numbers need neither a division nor a
logarithm; near equality z loses digits, but then nothing depends on it. With
arcsinh(y) / (y sqrt(1 + y^2)) = sum_n (-4 y^2)^n n!^2 / (2n + 1)! and y^2 = z/4,

    B = sum_n (-z)^n n!^2 / (2n + 1)!,    A = 1 / ((1 + z/4) B).

From these series follow polynomials for z <= NEAR by leaving out Chebyshev polynomials of higher
degree (C. Lanczos, Applied Analysis, 1956, 'economization'): errors below 4e-17.
"""

from __future__ import annotations

from fractions import Fraction
from math import factorial
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable

from fsipetsc.equations.logarithm import log

#: distance up to which two numbers are near: within 18 % of each other
NEAR = 0.03
_DEGREE, _TERMS = 5, 16


def _series() -> tuple[list[Fraction], list[Fraction]]:
    """Those of A and B in z."""
    b = [Fraction((-1) ** n * factorial(n) ** 2, factorial(2 * n + 1)) for n in range(_TERMS)]
    per_a = [b[n] + (b[n - 1] / 4 if n else 0) for n in range(_TERMS)]
    a = [Fraction(1)]
    for n in range(1, _TERMS):
        a.append(-sum((per_a[k] * a[n - k] for k in range(1, n + 1)), Fraction(0)))
    return a, b


def _economized(series: list[Fraction]) -> tuple[float, ...]:
    """Coefficients of a polynomial near a power series on 0 .. NEAR."""
    chebyshev = [[1], [-1, 2]]  # T_n(2 y - 1), by powers of y
    while len(chebyshev) < len(series):
        last, before = chebyshev[-1], [*chebyshev[-2], 0, 0]
        double = [4 * up - 2 * here for up, here in zip([0, *last], [*last, 0])]
        chebyshev.append([d - e for d, e in zip(double, before)])
    scaled = [c * Fraction(NEAR) ** n for n, c in enumerate(series)]
    while len(scaled) > _DEGREE + 1:
        last_one = scaled.pop()
        leave = chebyshev[len(scaled)]
        scaled = [c - last_one * part / leave[-1] for c, part in zip(scaled, leave)]
    return tuple(float(c / Fraction(NEAR) ** n) for n, c in enumerate(scaled))


_A, _B = (_economized(series) for series in _series())
_A0, _A1, _A2, _A3, _A4, _A5 = _A
_B0, _B1, _B2, _B3, _B4, _B5 = _B


def select(condition: Any, a: Any, b: Any) -> Any:
    """a where a condition holds, else b."""
    return np.where(condition, a, b)


@overload(select)
def _select(condition, a, b):
    return lambda condition, a, b: a if condition else b


@register_jitable
def distance(a, b, per_a, per_b):
    """z of a and b; per_a, per_b: 1 over each."""
    return a * per_b + (b * per_a - 2.0)


@register_jitable
def near_mean(a, b, z):
    """The logarithmic mean of a and b, of distance z <= NEAR."""
    return 0.5 * (a + b) * (_A0 + z * (_A1 + z * (_A2 + z * (_A3 + z * (_A4 + z * _A5)))))


@register_jitable
def near_harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b), for z <= NEAR."""
    return 0.5 * (a + b) * (_B0 + z * (_B1 + z * (_B2 + z * (_B3 + z * (_B4 + z * _B5)))))


@register_jitable
def logarithm_of_ratio(a, b, z):
    """ln(a/b) if z > NEAR, else 1."""
    return log(select(z > NEAR, a / b, np.e))


@register_jitable
def logarithmic_mean(a, b, z):
    """The logarithmic mean of any two positive numbers, of distance z."""
    return select(z > NEAR, (a - b) / logarithm_of_ratio(a, b, z), near_mean(a, b, z))


@register_jitable
def harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b)."""
    far = a * b * (logarithm_of_ratio(a, b, z) / select(z > NEAR, a - b, 1.0))
    return select(z > NEAR, far, near_harmonic_mean(a, b, z))
