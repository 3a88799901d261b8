"""Narrow second derivatives that belong to the SBP first derivatives, as exact fractions.

D acting twice leaves the shortest wave alone, (-1)^i being in the null space of the interior
formula, and reaches twice as far as it must. With the norm H of D (h = 1), b > 0 at the points, B =
diag(b) and E the difference of the two ends,

    H D B D   = -D^T H B D + E B D                     wide: D twice
    H D2(b)   = -(D^T H B D + R(b)) + E B D            narrow: D2(b) = D B D - H^-1 R(b)

    R(b) = sum_q  Delta_q^T  diag(mean_q b)  Delta_q  +  terms at the ends,     q = p+1 .. 2p

Delta_q are the undivided differences of order q, those alone that have all of their points on the
grid, and mean_q b is a sum, with positive weights, of b at the 2p - q + 1 points in the middle of a
difference. At either end the differences that begin at the first T points are left out, and the
first T of order p+1 have a term of their own instead, with b at point T:

    b_T  Delta_{p+1}^T  c L L^T  Delta_{p+1},             c the sum of the weights of mean_{p+1}

Whatever L is, R is symmetric and, for b >= 0, positive semidefinite; its columns add up to
nothing, so D2 conserves what D B D conserves; it vanishes on polynomials up to degree p, so near
the ends D2 is as exact as D B D, and in the interior of order h^2p. The boundary derivative of D2
is the closure row of D (a *fully compatible* operator).

The weights make the interior formula of D2 one of 2p + 1 points, whatever b is: D^T B D couples
points j apart, p < j <= 2p; a Delta_q couples points q apart by (-1)^q mean_q b, and nearer ones.
So the couplings are cancelled one after the other, from 2p down, in the one way there is
(``levels``).

Where a flux b u_X is imposed by the closure row of D, u takes on an error E h^(s+1) u^(s+1) near
the end, s = p, with D2 E = -(error of D2 on x^(s+1)/(s+1)!) at all points but the end point, and
the flux is wrong by phi h^s u^(s+1), phi = e_0 + (D E)_0. Without terms at the ends phi is 1/2,
-1/3, 0.31, -0.38. The L in ENDS make it 0 for 2/1, 4/2 and 6/3, with L L^T near to 1; 8/4 has no
such term. A flux that comes in by way of the norm, as with the conservative coupling, needs none.

Sources: K. Mattsson, J. Sci. Comput. 51 (2012), 650-682 (remainders of this form); B. Sjögreen and
N. A. Petersson, J. Sci. Comput. 52 (2012), 17-48 (narrow formulas with the boundary derivative in
mind).
"""

from collections.abc import Sequence
from fractions import Fraction
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Bound on the step for diffusion nu: dt <= C h^2 / (STIFFNESS nu), by interior order, and for D
#: twice. The spectral radii of D2(1), 4.0, 5.3, 6.0 and 7.1 at most with a ghost point at any
#: place, give the method of Runge and Kutta (|z| < 2.785) the Courant numbers 1.4 and 1.14 to 1.16.
#: For D twice they are 2.4 to 5.0.
STIFFNESS = {2: 2.0, 4: 2.2, 6: 2.5, 8: 2.9}
STIFFNESS_OF_WIDE = 2.0

#: L at the ends, (T, T) or its columns that are not 0, by interior order
ENDS = {
    2: ((),),
    4: tuple(
        tuple(map(Fraction, row.split()))
        for row in ("0.57 0", "0.51 0.8275808859653828", "-0.64 0.67")
    ),
    6: tuple(
        tuple(map(Fraction, row.split()))
        for row in ("0.51 0 0", "0.9 0.86 0", "-0.18 1.5909323365068795 0.02", "0.17 0.85 -1.12")
    ),
    8: (),
}


class Level(NamedTuple):
    """One of the terms of R."""

    order: int
    """q of the difference, which takes q + 1 points."""
    weights: tuple[Fraction, ...]
    """Of b at the points in the middle of these."""

    @property
    def skipped(self) -> int:
        """Points of the difference before those whose b counts."""
        return (self.order + 1 - len(self.weights)) // 2


def difference(order: int) -> list[int]:
    """Weights of the undivided difference of this order."""
    return [(-1) ** (order - k) * comb(order, k) for k in range(order + 1)]


def levels(interior: Sequence[Fraction]) -> tuple[Level, ...]:
    """The terms of R, q = p+1 .. 2p, for the centred stencil c_1 .. c_p of D."""
    p = len(interior)
    d = {sign * k: sign * Fraction(c) for k, c in enumerate(interior, start=1) for sign in (1, -1)}
    # what couples point 0 and point j by way of b at point m
    coupling = {
        (j, m): d.get(-m, 0) * d.get(j - m, 0)
        for j in range(2 * p + 1)
        for m in range(-3 * p, 3 * p + 1)
    }
    found = []
    for q in range(2 * p, p, -1):
        level = Level(q, tuple(-((-1) ** q) * coupling[q, m] for m in range(q - p, p + 1)))
        found.append(level)
        weights = difference(q)
        for a in range(q + 1):  # the difference that begins at -a
            for b in range(a, q + 1):
                for k, weight in enumerate(level.weights):
                    coupling[b - a, level.skipped + k - a] += weights[a] * weights[b] * weight
    return tuple(reversed(found))


def end_term(interior: Sequence[Fraction]) -> NDArray[Any]:
    """c L L^T, (T, T), of fractions."""
    rows, c = ENDS[2 * len(interior)], sum(levels(interior)[0].weights)
    products = [
        [sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0)) for b in rows] for a in rows
    ]
    return c * np.array(products, dtype=object)


def remainder(interior: Sequence[Fraction], b: Sequence[Any]) -> NDArray[Any]:
    """R(b), (n, n), of fractions if b are fractions, and of floats otherwise; interior: the centred
    stencil of D."""
    n, exact, end = len(b), all(isinstance(v, (int, Fraction)) for v in b), end_term(interior)
    result = np.full((n, n), Fraction(0), dtype=object)
    for level in levels(interior):
        weights = np.array(difference(level.order), dtype=object)
        products = np.outer(weights, weights)
        for t in range(len(end), n - level.order - len(end)):
            mean = sum(w * b[t + level.skipped + k] for k, w in enumerate(level.weights))
            result[t : t + level.order + 1, t : t + level.order + 1] += mean * products
    weights = np.array(difference(len(interior) + 1), dtype=object)
    for i, j in np.argwhere(end):
        for side in (slice(None), slice(None, None, -1)):
            at = result[side, side]
            at[i : i + len(weights), j : j + len(weights)] += (
                b[side][len(end)] * end[i, j] * np.outer(weights, weights)
            )
    return result if exact else result.astype(float)
