"""The diagonal-norm SBP first derivatives 2/1, 4/2, 6/3 and 8/4 in numbers, as exact fractions.

On a grid of spacing h, D = Q/(h H): H is diagonal with the norm weights, which are 1 away from the
ends, and Q + Q^T = diag(-1, 0, ..., 0, 1) is summation by parts. Away from the ends Q holds the
centred stencil of order 2p, (Qv)_i = sum_k c_k (v_{i+k} - v_{i-k}), k = 1..p. The first r = 1, 4,
6, 8 rows are the boundary closure, exact for polynomials up to degree s = p; the other end is its
mirror image with the sign changed.

What has to be written down is short: the norm, the stencil, and the entries of Q that accuracy
leaves free. The closure follows by linear equations (`closure_rows`), so that there is no long
table in which a digit can be wrong.

The free entries, Q_ij with s < i < j < r (counted from 0):

6/3  One. It minimises sum_i H_i e_i^2, e being the truncation error of the closure on x^4.
8/4  Three. The truncation error on x^5 does not change along (Q_56, Q_57, Q_67) = (21, -6, 1) t.
     The spectral radius of hD, with the inflow point removed, does, from 1.72 to more than 8: it
     shows in the time step alone. The values below keep it under that of the interior stencil
     (1.73), with an error within 1 % of the smallest possible.

Sources: H.-O. Kreiss and G. Scherer, in Mathematical Aspects of Finite Elements in Partial
Differential Equations (1974), 195-212 (existence, norms); B. Strand, J. Comput. Phys. 110 (1994),
47-67 (the operators and their free parameters).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import prod
from typing import NamedTuple


class Coefficients(NamedTuple):
    """What determines one operator; indices count from 0 at the boundary point."""

    boundary_order: int
    """s: the closure rows are exact for polynomials up to this degree."""
    norm: tuple[Fraction, ...]
    """(r,) Weights of the first r points, without h."""
    interior: tuple[Fraction, ...]
    """(p,) c_1..c_p of the centred stencil."""
    free: Mapping[tuple[int, int], Fraction] = {}
    """Entries (i, j), i < j, of Q that accuracy leaves free."""


def _fractions(text: str) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, text.split()))


COEFFICIENTS: dict[int, Coefficients] = {
    2: Coefficients(
        boundary_order=1,
        norm=_fractions("1/2"),
        interior=_fractions("1/2"),
    ),
    4: Coefficients(
        boundary_order=2,
        norm=_fractions("17/48 59/48 43/48 49/48"),
        interior=_fractions("2/3 -1/12"),
    ),
    6: Coefficients(
        boundary_order=3,
        norm=_fractions("13649/43200 12013/8640 2711/4320 5359/4320 7877/8640 43801/43200"),
        interior=_fractions("3/4 -3/20 1/60"),
        free={(4, 5): Fraction(5591070156686698065364559, 7931626489314500743872000)},  # 0.7049
    ),
    8: Coefficients(
        boundary_order=4,
        norm=_fractions(
            "1498139/5080320 1107307/725760 20761/80640 1304999/725760 299527/725760 103097/80640 "
            "670091/725760 5127739/5080320"
        ),
        interior=_fractions("4/5 -1/5 4/105 -1/280"),
        free={(5, 6): Fraction(7, 10), (5, 7): Fraction(-61, 500), (6, 7): Fraction(1519, 2000)},
    ),
}
"""By interior order."""


def closure_rows(coefficients: Coefficients) -> tuple[tuple[Fraction, ...], ...]:
    """The first r rows of hD, shape (r, r + p), exact.

    Row i of Q is exact for polynomials up to degree s. Going from the last row up, antisymmetry and
    the free entries leave at most the first s + 1 columns of a row unknown, and with l_m the
    polynomial that is 1 at column m and 0 at the other unknown ones, exactness for l_m reads
    Q_im = H_i l_m'(i) - sum over the known j of Q_ij l_m(j). The equations beyond these, such as
    all of row 0, hold because the norm is the right one.
    """
    s, norm, interior, free = coefficients
    r, p = len(norm), len(interior)
    q = [[Fraction(0)] * (r + p) for _ in range(r)]
    q[0][0] = Fraction(-1, 2)
    for i in range(r):
        for k in range(r - i, p + 1):
            q[i][i + k] = interior[k - 1]  # what interior row i + k has at column i, sign changed
    for (i, j), value in free.items():
        q[i][j], q[j][i] = value, -value
    for i in reversed(range(1, r)):
        unknown = range(min(i, s + 1))
        known = [j for j in range(len(unknown), r + p) if q[i][j]]
        for m in unknown:
            from_known = sum(q[i][j] * _lagrange(unknown, m, j) for j in known)
            value = norm[i] * _lagrange_derivative(unknown, m, i) - from_known
            q[i][m], q[m][i] = value, -value
    return tuple(tuple(entry / weight for entry in row) for row, weight in zip(q, norm))


def _lagrange(nodes: Sequence[int], m: int, x: int) -> int:
    """l_m(x) for consecutive integer nodes and an integer x, where it is an integer."""
    others = [k for k in nodes if k != m]
    return prod(x - k for k in others) // prod(m - k for k in others)


def _lagrange_derivative(nodes: Sequence[int], m: int, x: int) -> Fraction:
    """l_m'(x)."""
    others = [k for k in nodes if k != m]
    by_product_rule = sum(prod(x - k for k in others if k != left_out) for left_out in others)
    return Fraction(by_product_rule, prod(m - k for k in others))


def _pairs(text: str) -> dict[tuple[int, int], Fraction]:
    words = iter(text.split())
    return {(int(i), int(l)): Fraction(weight) for i, l, weight in zip(words, words, words)}


#: Weights S_il, i < l, of pairs of nodes beside an axis, where areas are A = |r|, by interior
#: order. Node -1 - j is the image of node j, and S_(-1-l)(-1-i) = S_il. All other pairs have the
#: weights of a plane.
#: |r| has a kink at r = 0. With the weights of a plane div u of u = r is wrong by 4 to 9 % at the
#: first node on any grid, velocities there have order 1, and frequencies order 4. With these, on
#: r = 1/2, 3/2, ... and with J = D (r A/2),
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
