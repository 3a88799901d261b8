"""Logarithmic means, (a - b) / (ln a - ln b), of two positive numbers.

With x = ln(a/b) and the distance z = a/b + b/a - 2 = 4 sinh(x/2)^2,

    mean of a and b                  (a + b)/2 A(z),    A = tanh(x/2) / (x/2)
    1 / (mean of 1/a and 1/b)        (a + b)/2 B(z),    B = x / sinh(x)

Both are analytic in z. Where 1/a and 1/b are known, near numbers need neither a division nor a
logarithm; near equality z loses digits, but then nothing depends on it. With
arcsinh(y) / (y sqrt(1 + y^2)) = sum_n (-4 y^2)^n n!^2 / (2n + 1)! and y^2 = z/4,

    B = sum_n (-z)^n n!^2 / (2n + 1)!,    A = 1 / ((1 + z/4) B).

These series, cut in terms of Chebyshev polynomials (C. Lanczos, Applied Analysis, 1956,
'economization'), are polynomials for z <= NEAR whose errors are below 4e-17.
"""

from typing import Any

import numpy as np

#: distance up to which two numbers are near: within 18 % of each other
NEAR = 0.03
#: polynomials of degree 5 in z that are A and B for z <= NEAR
_A0, _A1, _A2 = 1.0, -0.0833333333333038, 0.015277777766281236
_A3, _A4, _A5 = -0.003158067145849683, 0.0006880007798053454, -0.00015131755901776796
_B0, _B1, _B2 = 1.0, -0.1666666666665971, 0.03333333330625483
_B3, _B4, _B5 = -0.007142853286583752, 0.00158705313550121, -0.00035335621566035354


def select(condition: Any, a: Any, b: Any) -> Any:
    """a where a condition holds, else b."""
    return np.where(condition, a, b)


def distance(a, b, per_a, per_b):
    """z of a and b; per_a, per_b: 1 over each."""
    return a * per_b + (b * per_a - 2.0)


def near_mean(a, b, z):
    """The logarithmic mean of a and b, of distance z <= NEAR."""
    return 0.5 * (a + b) * (_A0 + z * (_A1 + z * (_A2 + z * (_A3 + z * (_A4 + z * _A5)))))


def near_harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b), for z <= NEAR."""
    return 0.5 * (a + b) * (_B0 + z * (_B1 + z * (_B2 + z * (_B3 + z * (_B4 + z * _B5)))))


def logarithm_of_ratio(a, b, z):
    """ln(a/b) if z > NEAR, else 1."""
    return np.log(select(z > NEAR, a / b, np.e))


def logarithmic_mean(a, b, z):
    """The logarithmic mean of any two positive numbers, of distance z."""
    return select(z > NEAR, (a - b) / logarithm_of_ratio(a, b, z), near_mean(a, b, z))


def harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b)."""
    far = a * b * (logarithm_of_ratio(a, b, z) / select(z > NEAR, a - b, 1.0))
    return select(z > NEAR, far, near_harmonic_mean(a, b, z))
