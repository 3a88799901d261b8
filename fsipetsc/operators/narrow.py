"""Narrow second derivatives that belong to the SBP first derivatives, as exact fractions.

D acting twice leaves the shortest wave alone, (-1)^i being in the null space of the interior
formula, and reaches twice as far as it must. With the norm H of D (h = 1), b > 0 at the points, B =
diag(b) and E the difference of the two ends,

    H D B D   = -D^T H B D + E B D                     wide: D twice
    H D2(b)   = -(D^T H B D + R(b)) + E B D            narrow: D2(b) = D B D - H^-1 R(b)

    R(b) = sum_q  Delta_q^T  diag(mean_q b)  Delta_q  +  terms at the ends,     q = p+1 .. 2p

Delta_q are the undivided differences of order q, those alone that have all of their points on the
grid, and mean_q b is a sum of b at the 2p - q + 1 points in the middle of a difference, with the
weights that make the interior formula of D2 one of 2p + 1 points. At either end the differences
that begin at the first T points are left out, and the first T of order p+1 have a term of their own
instead, with b at point T:

    b_T  Delta_{p+1}^T  c L L^T  Delta_{p+1},             c the sum of the weights of mean_{p+1}

Whatever L is, R is symmetric and, for b >= 0, positive semidefinite; its columns add up to
nothing, so D2 conserves what D B D conserves; it vanishes on polynomials up to degree p, so near
the ends D2 is as exact as D B D, and in the interior of order h^2p. The boundary derivative of D2
is the closure row of D (a *fully compatible* operator).

Where a flux b u_X is imposed by the closure row of D, u takes on an error E h^(s+1) u^(s+1) near
the end, s = p, with D2 E = -(error of D2 on x^(s+1)/(s+1)!) at all points but the end point, and
the flux is wrong by phi h^s u^(s+1), phi = e_0 + (D E)_0. Without terms at the ends phi is 1/2,
-1/3, 0.31, -0.38. The L, in _ENDS, make it 0 for 2/1, 4/2 and 6/3, with L L^T near to 1; 8/4 has no
such term. A flux that comes in by way of the norm, as with the conservative coupling, needs none.

Sources: K. Mattsson, J. Sci. Comput. 51 (2012), 650-682 (remainders of this form); B. Sjögreen and
N. A. Petersson, J. Sci. Comput. 52 (2012), 17-48 (narrow formulas with the boundary derivative in
mind).
"""

from typing import Any

import numpy as np

from fsipetsc.operators.sbp import fractions

#: Bound on the step for diffusion nu: dt <= C h^2 / (STIFFNESS nu), by interior order, and for D
#: twice. The spectral radii of D2(1), 4.0, 5.3, 6.0 and 7.1 at most with a ghost point at any
#: place, give the method of Runge and Kutta (|z| < 2.785) the Courant numbers 1.4 and 1.14 to 1.16.
#: For D twice they are 2.4 to 5.0.
STIFFNESS = {2: 2.0, 4: 2.2, 6: 2.5, 8: 2.9}
STIFFNESS_OF_WIDE = 2.0
_MEANS = {
    2: ("1/4",),
    4: ("1/36 1/36", "1/144"),
    6: ("1/240 1/240 1/240", "1/1200 1/1200", "1/3600"),
    8: ("1/1400 1/1400 1/1400 1/1400", "1/8400 1/6300 1/8400", "1/29400 1/29400", "1/78400"),
}
#: weights of mean_q, q = p+1 .. 2p, by interior order
MEANS = {order: tuple(map(fractions, rows)) for order, rows in _MEANS.items()}
_ENDS: dict[int, tuple[str, ...]] = {
    2: ("0",),
    4: ("0.57 0", "0.51 0.8275808859653828", "-0.64 0.67"),
    6: ("0.51 0 0", "0.9 0.86 0", "-0.18 1.5909323365068795 0.02", "0.17 0.85 -1.12"),
    8: (),
}


def end_term(order: int) -> list[list[Any]]:
    """c L L^T, (T, T), of fractions, of the operator of an interior order."""
    rows, c = [np.array(fractions(row)) for row in _ENDS[order]], sum(MEANS[order][0])
    return [[c * (a @ b) for b in rows] for a in rows]
