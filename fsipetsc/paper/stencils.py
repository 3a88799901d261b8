"""The SBP first derivative on rows of values.

Rows hold the points of a rank with their halos. The closures stand at the first and the last active
point, A and B. The same formula is evaluated in the same order for a point whoever owns it, so
results do not depend on the number of ranks.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsipetsc.kernels.loops import each, named, when
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, difference, end_term, levels
from fsipetsc.operators.sbp import operator, row_length

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Stencils:
    """D for h = 1, and narrow second derivatives if ``narrow`` (fsipetsc.operators.narrow): facts
    of a procedure.

    The interior is sum_k interior[k-1] (v[i+k] - v[i-k]), the closure has a row for each point at
    the left end; norm: weights of the same points; n: points that the first row reaches; diffusion:
    its bound on the step. differences: the weights of Delta_q in row q-1; means: those of
    Delta_{p+1+k} in row k; end: of the term at an end.
    """

    interior: Numbers
    closure: tuple[Numbers, ...]
    norm: Numbers
    reach: int
    n: int
    diffusion: float
    narrow: bool
    differences: tuple[Numbers, ...]
    means: tuple[Numbers, ...]
    end: tuple[Numbers, ...]

    @property
    def p(self) -> int:
        """Half width of the interior formula."""
        return len(self.interior)

    @property
    def rows(self) -> int:
        """Points of a closure."""
        return len(self.closure)

    @property
    def halo(self) -> int:
        """Points of other ranks that rates and ends need: D acts twice."""
        return max(2 * self.reach, 6)


def stencils(order: int, narrow: bool = False) -> Stencils:
    """Those of an interior order. ValueError if there is none."""
    op = operator(order)

    def rows(table: Any) -> tuple[Numbers, ...]:
        return tuple(tuple(map(float, row)) for row in table)

    return Stencils(
        *(rows([op.interior])[0], rows(op.closure), rows([op.norm])[0], op.reach, row_length(op)),
        STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE,
        narrow,
        rows(difference(q) for q in range(1, 9)),
        rows(level.weights for level in levels(op.interior)),
        rows(end_term(op.interior)),
    )


def near_ends(op: Stencils, a: Any, b: Any, A: Any, B: Any) -> Iterator[tuple[int, Any, Any, int]]:
    """(r, i, end, step): each point i of a .. b-1 that is point number r from an end, A or B, from
    which ``step`` leads inwards. What the loop does is done where there is such a point.
    """
    for end, step in ((A, 1), (B, -1)):
        for r in range(op.rows):
            i = end + step * r
            with when((a <= i) & (i < b)):
                yield r, i, end, step


def derivative(op, q, of, w, to, count, a, b, A, B, scale):
    """w[to + c] = scale h D q[of + c], c = 0 .. count - 1, at the points a .. b-1; q[of + c] is
    known where that reaches, or to A, B."""
    first, end = named(np.maximum(a, A + op.rows)), named(np.minimum(b, B + 1 - op.rows))
    weights = [scale * weight for weight in op.interior]
    for c in each(count):
        f, out = q[c + of], w[c + to]
        for i in each(first, end, vector=True):
            out[i] = sum(v * (f[i + k] - f[i - k]) for k, v in enumerate(weights, 1))
        for r, i, edge, step in near_ends(op, a, b, A, B):
            row = sum(v * f[edge + step * k] for k, v in enumerate(op.closure[r]))
            out[i] = step * scale * row


def weight(op: Stencils, r: int) -> float:
    """Norm weight of the point number r from an end."""
    return op.norm[r] if r < op.rows else 1.0
