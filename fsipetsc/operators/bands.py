"""SBP first derivatives as weights of pairs of nodes: what the volume terms are made of.

D = H^-1 Q with Q + Q^T = diag(-1, 0, …, 0, 1). Beside its diagonal Q is antisymmetric, so it is a
band of weights of pairs,

    S[k, i] = 2 Q[i, i + k],    k = 1 … K,

closures included; the diagonal, which holds the boundary terms, is left out. Its rows sum to 0, so

    (D f)_i   =  sum_l S_il (f_l - f_i) / 2 / weight_i    the derivative
    (D° f)_i  =  sum_l S_il (f_l + f_i) / 2 / weight_i    without the flux through the ends

with S_il = S[l - i, i] for l > i and -S[i - l, l] for l < i, and weight = h H.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fsipetsc.operators.sbp import OPERATORS

Array = NDArray[np.float64]
Triple = tuple[int, int, int]


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

    def part(self, begin: int, end: int) -> Band:
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
    weight = h * op.norm_weights(n)
    S = np.zeros((op.reach + 1, n))
    for k, c in enumerate(op.interior, start=1):
        S[k, op.rows : n - op.rows - k] = 2.0 * float(c)
    for i, row in enumerate(op.closure):
        for j in range(i + 1, len(row)):
            if row[j]:  # as fractions, so that the other end is the mirror image to the last bit
                S[j - i, i] = S[j - i, n - 1 - j] = float(2 * op.norm[i] * row[j])
    return Band(S, weight)


def centred_band(order: int, cells: int, kappa: int) -> Band:
    """That of an axis which goes on beyond its first node to its mirror image, half a cell before
    it: node -1 - i is the image of node i. Images come after the nodes, so that ``part`` finds them
    at numbers below 0. Around an axis (kappa = 1) nodes beside it have the weights AXIS.
    """
    n, whole = cells + 1, band(order, 2 * cells + 1)
    weight = whole.weight * ((2 * cells + 1) / cells)
    pairs = AXIS.get(order, {}) if kappa == 1 else {}
    farthest = max([whole.reach, *(l - i for i, l in pairs)])
    S = np.pad(whole.S, ((0, farthest - whole.reach), (0, 0)))
    for (i, l), w in pairs.items():
        S[l - i, [n + i, n - 1 - l]] = float(w)
    return Band(np.roll(S, n, axis=1), np.roll(weight, n))


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
    """A rank's part of a block: sizes along the three axes, axis 0 contiguous; of an axis that is
    not there 1, 1 and 0.

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
