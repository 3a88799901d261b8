"""Logarithmic means, (a - b) / (ln a - ln b), of two positive numbers at each of a vector of points. Compiled.

With x = ln(a/b) and z = a/b + b/a - 2 = 4 sinh(x/2)^2,

    mean of a and b                  (a + b)/2 A(z),    A = tanh(x/2) / (x/2)
    1 / (mean of 1/a and 1/b)        (a + b)/2 B(z),    B = x / sinh(x)

Both are analytic in z. As b/a comes near 1, z loses digits, but then nothing depends on it: to round-off, the error of a
mean is that of (a + b)/2. If 1/a and 1/b are known, neither a division nor a logarithm is needed where the numbers are near
each other.
With arcsinh(y) / (y sqrt(1 + y^2)) = sum_n (-4 y^2)^n n!^2 / (2n + 1)! and y^2 = z/4,

    B = sum_n (-z)^n n!^2 / (2n + 1)!,    A = 1 / ((1 + z/4) B),

of which polynomials are made by leaving out Chebyshev's of higher degree (Lanczos' economization). A lane takes the
polynomial of low degree, that of high degree or logarithms depending on its own z alone.
"""

from __future__ import annotations

from fractions import Fraction
from math import factorial

from numba import njit

from fsipetsc.operators.kernels import FORMULA, OPTIONS
from fsipetsc.operators.lanes import any_above, where_above
from fsipetsc.operators.vectors import fma, larger, logarithm, root

#: z up to which the polynomials of low and of high degree hold: where a is within 4 % and 70 % of b
NEAR, FAR = 1.6e-3, 0.3
_TERMS = 24


def _series() -> tuple[list[Fraction], list[Fraction]]:
    """Those of A and B in z."""
    b = [Fraction((-1) ** n * factorial(n) ** 2, factorial(2 * n + 1)) for n in range(_TERMS)]
    per_a = [b[n] + (b[n - 1] / 4 if n else 0) for n in range(_TERMS)]
    a = [Fraction(1)]
    for n in range(1, _TERMS):
        a.append(-sum(per_a[k] * a[n - k] for k in range(1, n + 1)))
    return a, b


def economized(series: list[Fraction], degree: int, bound: float) -> tuple[float, ...]:
    """(degree + 1,) coefficients of a polynomial near a power series on 0 .. bound."""
    chebyshev = [[1], [-1, 2]]  # T_n(2 y - 1), powers of y
    while len(chebyshev) < len(series):
        last, before = chebyshev[-1], [*chebyshev[-2], 0, 0]
        double = [4 * (up or 0) - 2 * here for up, here in zip([0, *last], [*last, 0], strict=True)]
        chebyshev.append([d - e for d, e in zip(double, before, strict=False)])
    size = Fraction(bound)
    scaled = [c * size**n for n, c in enumerate(series)]
    while len(scaled) > degree + 1:
        last = scaled.pop()
        leave = chebyshev[len(scaled)]
        scaled = [c - last * part / leave[-1] for c, part in zip(scaled, leave, strict=False)]
    return tuple(float(c / size**n) for n, c in enumerate(scaled))


_A, _B = _series()
_NEAR_A, _NEAR_B = economized(_A, 3, NEAR), economized(_B, 3, NEAR)
_FAR_A, _FAR_B = economized(_A, 10, FAR), economized(_B, 10, FAR)


@njit(**FORMULA)
def distance(a, per_a, b, per_b):
    """z of a and b; per_a, per_b: 1 over each."""
    return fma(a, per_b, fma(b, per_a, -2.0))


@njit(**FORMULA)
def mean_factors(z_a, z_b):
    """A(z_a), B(z_b)."""
    a0, a1, a2, a3 = _NEAR_A
    b0, b1, b2, b3 = _NEAR_B
    a = fma(fma(fma(a3, z_a, a2), z_a, a1), z_a, a0)
    b = fma(fma(fma(b3, z_b, b2), z_b, b1), z_b, b0)
    if any_above(larger(z_a, z_b), NEAR):
        far_a, far_b = distant_factors(z_a, z_b)
        a, b = where_above(z_a, NEAR, far_a, a), where_above(z_b, NEAR, far_b, b)
    return a, b


@njit(**OPTIONS)
def distant_factors(z_a, z_b):
    """The same for z that are larger than NEAR."""
    a, b = fma(_FAR_A[10], z_a, _FAR_A[9]), fma(_FAR_B[10], z_b, _FAR_B[9])
    for n in range(8, -1, -1):
        a, b = fma(a, z_a, _FAR_A[n]), fma(b, z_b, _FAR_B[n])
    if any_above(larger(z_a, z_b), FAR):
        sinh, x = hyperbolic(z_a)
        a = where_above(z_a, FAR, 2.0 * sinh / (fma(0.5, z_a, 2.0) * x), a)  # tanh(x/2) = sinh x / (1 + cosh x)
        sinh, x = hyperbolic(z_b)
        b = where_above(z_b, FAR, x / sinh, b)
    return a, b


@njit(**FORMULA)
def hyperbolic(z):
    """(sinh x, |x|), with cosh x = 1 + z/2."""
    sinh = root(z * fma(0.25, z, 1.0))
    return sinh, logarithm(fma(0.5, z, 1.0) + sinh)
