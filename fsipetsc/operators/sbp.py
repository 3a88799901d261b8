"""The diagonal-norm SBP first derivatives 2/1, 4/2, 6/3 and 8/4, as exact fractions, and as weights
of pairs of nodes, of which volume terms are made.

On a grid of spacing h, D = Q/(h H): H is diagonal with the norm weights, which are 1 away from the
ends, and Q + Q^T = diag(-1, 0, ..., 0, 1) is summation by parts. Away from the ends Q holds the
centred stencil of order 2p, (Qv)_i = sum_k c_k (v_{i+k} - v_{i-k}), k = 1..p. The first r = 1, 4,
6, 8 rows are the boundary closure, exact for polynomials up to degree s = p; the other end is its
mirror image with the sign changed.

The norm, the stencil, and the entries of Q that accuracy leaves free are written down; the closure
follows by linear equations. The free entries, Q_ij with s < i < j < r (counted from 0):

6/3  One. It minimises sum_i H_i e_i^2, e being the truncation error of the closure on x^4.
8/4  Three. They keep the spectral radius of hD, with the inflow point removed, under that of the
     interior stencil (1.73), with an error on x^5 within 1 % of the smallest possible.

Beside its diagonal Q is antisymmetric, so it is a band of weights of pairs,

    S[k, i] = 2 Q[i, i + k],    k = 1 … K,

closures included; the diagonal, which holds the boundary terms, is left out. Its rows sum to 0, so

    (D f)_i   =  sum_l S_il (f_l - f_i) / 2 / weight_i    the derivative
    (D° f)_i  =  sum_l S_il (f_l + f_i) / 2 / weight_i    without the flux through the ends

with S_il = S[l - i, i] for l > i and -S[i - l, l] for l < i, and weight = h H.

Sources: H.-O. Kreiss and G. Scherer, in Mathematical Aspects of Finite Elements in Partial
Differential Equations (1974), 195-212 (existence, norms); B. Strand, J. Comput. Phys. 110 (1994),
47-67 (the operators and their free parameters).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import comb
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import Array

Triple = tuple[int, int, int]

#: Bound on the step for diffusion nu, with D twice: dt <= C h^2 / (STIFFNESS_OF_WIDE nu). Spectral
#: radii allow the method of Runge and Kutta (|z| < 2.785) Courant numbers of 2.4 to 5.0.
STIFFNESS_OF_WIDE = 2.0


@dataclass(frozen=True)
class SBPOperator:
    """A diagonal-norm SBP first derivative of interior order 2p on n equidistant points, with a
    closure of ``rows`` rows and order p at both ends.

    Exact coefficients for h = 1 and the left end, whose points are counted from 0.

    norm: (rows,) weights at the points of the closure, 1 elsewhere. interior: (p,) weights of
    v[i+1], v[i+2], ...; those of v[i-1], ... are their negatives. free: entries (i, j), i < j, of Q
    that accuracy leaves free.
    """

    norm: tuple[Fraction, ...]
    interior: tuple[Fraction, ...]
    free: Mapping[tuple[int, int], Fraction] = field(default_factory=dict, compare=False)

    @property
    def rows(self) -> int:
        return len(self.norm)

    @property
    def p(self) -> int:
        return len(self.interior)

    @property
    def order(self) -> int:
        return 2 * self.p

    @property
    def name(self) -> str:
        """Interior and boundary order, as in "4/2"."""
        return f"{self.order}/{self.p}"

    @property
    def min_points(self) -> int:
        """Fewest grid points on which the closures of both ends fit."""
        return 2 * self.rows

    @cached_property
    def closure(self) -> tuple[tuple[Fraction, ...], ...]:
        """(rows, rows + p) Row j gives the derivative at point j.

        Row i of Q is exact for polynomials up to degree s. Going from the last row up, antisymmetry
        and the free entries leave at most the first s + 1 columns of a row unknown, and with l_m
        the polynomial that is 1 at column m and 0 at the other unknown ones, exactness for l_m
        reads Q_im = H_i l_m'(i) - sum over the known j of Q_ij l_m(j). The equations beyond these,
        such as all of row 0, hold because the norm is the right one.
        """
        r, p = self.rows, self.p
        q = [[Fraction(0)] * (r + p) for _ in range(r)]
        q[0][0] = Fraction(-1, 2)
        for i in range(r):
            for k in range(r - i, p + 1):  # what interior row i + k has at column i, sign changed
                q[i][i + k] = self.interior[k - 1]
        for (i, j), value in self.free.items():
            q[i][j], q[j][i] = value, -value
        for i in reversed(range(1, r)):
            unknown = range(min(i, p + 1))
            known = [j for j in range(len(unknown), r + p) if q[i][j]]
            for m in unknown:
                l = np.poly1d([k for k in unknown if k != m], True)  # l_m l(m): whole numbers
                from_known = sum(q[i][j] * Fraction(l(j)) for j in known)
                value = (self.norm[i] * Fraction(l.deriv()(i)) - from_known) / Fraction(l(m))
                q[i][m], q[m][i] = value, -value
        return tuple(tuple(entry / weight for entry in row) for row, weight in zip(q, self.norm))

    @property
    def reach(self) -> int:
        """Largest distance, in points, from a point to one that its derivative uses."""
        rows = enumerate(self.closure)
        return max(self.p, *(abs(j - i) for i, row in rows for j, w in enumerate(row) if w))

    def matrix(self, n: int) -> Array:
        """D for h = 1, (n, n), of fractions; n: min_points or more."""
        matrix, closure = np.full((n, n), Fraction(0), dtype=object), np.array(self.closure)
        for k, weight in enumerate(self.interior, start=1):
            i = np.arange(n - k)
            matrix[i, i + k], matrix[i + k, i] = weight, -weight
        rows, cols = closure.shape
        matrix[:rows, :cols] = closure
        matrix[n - rows :, n - cols :] = -closure[::-1, ::-1]
        return matrix

    def norm_weights(self, n: int) -> Array:
        """The diagonal of H, (n,), without h; n: min_points or more."""
        norm = np.array(self.norm, float)
        return np.concatenate([norm, np.ones(n - 2 * self.rows), norm[::-1]])


def fractions(text: str) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, text.split()))


def undivided(q: int) -> tuple[float, ...]:
    """The weights of an undivided difference of order q."""
    return tuple(float((-1) ** (q - k) * comb(q, k)) for k in range(q + 1))


_NORM_OF_6 = "13649/43200 12013/8640 2711/4320 5359/4320 7877/8640 43801/43200"
_NORM_OF_8 = (
    "1498139/5080320 1107307/725760 20761/80640 1304999/725760 299527/725760 103097/80640 "
    "670091/725760 5127739/5080320"
)
_FREE_OF_6 = {(4, 5): Fraction(5591070156686698065364559, 7931626489314500743872000)}  # 0.7049
_FREE_OF_8 = {(5, 6): Fraction(7, 10), (5, 7): Fraction(-61, 500), (6, 7): Fraction(1519, 2000)}
#: by interior order
OPERATORS = {
    2: SBPOperator(fractions("1/2"), fractions("1/2")),
    4: SBPOperator(fractions("17/48 59/48 43/48 49/48"), fractions("2/3 -1/12")),
    6: SBPOperator(fractions(_NORM_OF_6), fractions("3/4 -3/20 1/60"), _FREE_OF_6),
    8: SBPOperator(fractions(_NORM_OF_8), fractions("4/5 -1/5 4/105 -1/280"), _FREE_OF_8),
}


def row_length(op: SBPOperator) -> int:
    """Number of points that the closure row at an end reaches."""
    return op.rows if op.rows > 1 else 2


class Band(NamedTuple):
    """Pair weights of one axis of n nodes.

    S: (K + 1, n), S[k, i] of the nodes i and i + k, 0 where there is no such pair, S[0] is 0;
    periodic: i + k counts on from the beginning. weight: (n,), h times the norm.
    """

    S: Array
    weight: Array

    @property
    def reach(self) -> int:
        """K, the largest distance between two nodes of a pair."""
        return len(self.S) - 1

    def part(self, begin: int, end: int) -> "Band":
        """That of the nodes begin … end - 1, which may lie beyond the ends of a periodic axis."""
        chosen = np.arange(begin, end) % len(self.weight)
        return Band(np.ascontiguousarray(self.S[:, chosen]), self.weight[chosen])


#: an axis that is not there: one node, no pairs
NO_AXIS = Band(np.zeros((1, 1)), np.ones(1))


def band(order: int, cells: int, periodic: bool = False) -> Band:
    """The pair weights of the operator of this order on [0, 1] with so many cells.

    cells + 1 nodes, or as many as cells on a periodic axis.
    """
    op, h = OPERATORS[order], 1.0 / cells
    if periodic:
        S = np.zeros((op.p + 1, cells))
        S[1:] = 2.0 * np.array(op.interior, float)[:, None]
        return Band(S, np.full(cells, h))
    n = cells + 1
    S = np.zeros((op.reach + 1, n))
    for k, c in enumerate(op.interior, start=1):
        S[k, op.rows : n - op.rows - k] = 2.0 * float(c)
    for i, row in enumerate(op.closure):
        for j in range(i + 1, len(row)):
            if row[j]:  # as fractions, so that the other end is the mirror image to the last bit
                S[j - i, i] = S[j - i, n - 1 - j] = float(2 * op.norm[i] * row[j])
    return Band(S, h * op.norm_weights(n))


def centred_band(order: int, cells: int, hoops: int) -> Band:
    """That of an axis which goes on beyond its first node to its mirror image, half a cell before
    it: node -1 - i is the image of node i. Images come after the nodes, so that ``part`` finds them
    at numbers below 0. Around an axis (one hoop) nodes beside it have the weights AXIS.
    """
    n, whole = cells + 1, band(order, 2 * cells + 1)
    pairs = AXIS.get(order, {}) if hoops == 1 else {}
    farthest = max([whole.reach, *(l - i for i, l in pairs)])
    S = np.pad(whole.S, ((0, farthest - whole.reach), (0, 0)))
    for (i, l), w in pairs.items():
        S[l - i, [n + i, n - 1 - l]] = float(w)
    return Band(np.roll(S, n, axis=1), np.roll(whole.weight * ((2 * cells + 1) / cells), n))


def _pairs(text: str) -> dict[tuple[int, int], Fraction]:
    words = iter(text.split())
    return {(int(i), int(l)): Fraction(weight) for i, l, weight in zip(words, words, words)}


#: Weights S_il, i < l, of pairs of nodes beside an axis, where areas are A = |r|, by interior
#: order. Node -1 - j is the image of node j, and S_(-1-l)(-1-i) = S_il. All other pairs have the
#: weights of a plane, with which div u of u = r is wrong by 4 to 9 % at the first node on any grid,
#: as |r| has a kink at r = 0. With these, on r = 1/2, 3/2, ... and with J = D (r A/2),
#:
#:     sum_l S_il                             = 0
#:     sum_l S_il (A_i + A_l) (p_l - p_i) / 4 = J_i 2 r_i    for p = r^2
#:     sum_l S_il (A_i + A_l) (u_i + u_l) / 4 = J_i 2        for u = r
#:
#: exactly. Where this leaves a choice, distant images have weight 0. Derived for this program.
AXIS: dict[int, Mapping[tuple[int, int], Fraction]] = {
    4: _pairs("""
        0 1 261233/158112     0 2 -1747/5856        1 2 218269/158112
        -1 0 181801/105408    -2 0 -69817/158112    -3 0 7453/105408
        -2 1 -3367/316224     -3 1 4369/316224
    """),
    6: _pairs("""
        0 1 1459421/790560    0 2 -12071/29280      1 2 240725/158112
        -1 0 1027621/527040   -2 0 -474133/790560   -3 0 12341/105408
        -2 1 1105/316224      -3 1 9517/1581120
    """),
    8: _pairs("""
        0 1 1028472673/559883520    0 2 -9072637/19995840    0 3 35480311/559883520
        1 2 295136707/186627840     1 3 -7593149/19995840    2 3 890974289/559883520
        -1 0 26793131/13997088      -2 0 -1871005/3110464    -3 0 1238387/9331392
        -4 0 -166379/27994176       -2 1 41185/1166424       -3 1 0
    """),
}


class Patch(NamedTuple):
    """A rank's part of a block: sizes of three axes, axis 0 contiguous; absent ones have 1, 1, 0.

    own: nodes that the rank owns. ghosted: nodes of the array with halos; at an end of the block
    there is no halo. first: where those that it owns begin in that array.
    """

    own: Triple
    ghosted: Triple
    first: Triple

    def ghosted_rows(self, i: Any) -> Any:
        """The number in the ghosted array of the owned node i, of an array or of one."""
        (n0, n1, _), (g0, g1, _), (f0, f1, f2) = self
        return f0 + i % n0 + g0 * (f1 + i // n0 % n1 + g1 * (f2 + i // (n0 * n1)))
