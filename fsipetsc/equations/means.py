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

import numpy as np

#: distance up to which two numbers are near: within 18 % of each other
NEAR = 0.03
#: polynomials of degree 5 in z that are A and B for z <= NEAR
_A = (1.0, -0.0833333333333038, 0.015277777766281236)
_A += (-0.003158067145849683, 0.0006880007798053454, -0.00015131755901776796)
_B = (1.0, -0.1666666666665971, 0.03333333330625483)
_B += (-0.007142853286583752, 0.00158705313550121, -0.00035335621566035354)


def distance(a, b, per_a, per_b):
    """z of a and b; per_a, per_b: 1 over each."""
    return a * per_b + (b * per_a - 2.0)


def near_mean(a, b, z):
    """The logarithmic mean of a and b, of distance z <= NEAR."""
    return 0.5 * (a + b) * _quintic(z, *_A)


def near_harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b), for z <= NEAR."""
    return 0.5 * (a + b) * _quintic(z, *_B)


def _quintic(z, c0, c1, c2, c3, c4, c5):
    """c0 + c1 z + … + c5 z^5, whose pairs of terms do not wait for one another."""
    square = z * z
    return (c0 + z * c1) + square * ((c2 + z * c3) + square * (c4 + z * c5))


def logarithm_of_ratio(a, b, z):
    """ln(a/b) if z > NEAR, else 1."""
    return np.log(np.where(z > NEAR, a / b, np.e))


def logarithmic_mean(a, b, z):
    """The logarithmic mean of any two positive numbers, of distance z."""
    return np.where(z > NEAR, (a - b) / logarithm_of_ratio(a, b, z), near_mean(a, b, z))


def harmonic_mean(a, b, z):
    """1 / (the logarithmic mean of 1/a and 1/b)."""
    far = a * b * (logarithm_of_ratio(a, b, z) / np.where(z > NEAR, a - b, 1.0))
    return np.where(z > NEAR, far, near_harmonic_mean(a, b, z))
