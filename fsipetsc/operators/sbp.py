"""Summation-by-parts first derivatives: exact coefficients, dense matrices, and a record for compiled kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from fsipetsc.operators.coefficients import COEFFICIENTS, closure_rows
from fsipetsc.operators.narrow import STIFFNESS, STIFFNESS_OF_WIDE, end_term, levels

LEVELS = np.dtype(
    [
        ("first", np.int64),
        ("last", np.int64),
        ("counts", np.int64, (4,)),
        ("weights", np.float64, (4, 4)),
        ("skipped", np.int64),
        ("ends", np.int64),
        ("end", np.float64, (4, 4)),
    ]
)
"""Differences of the orders first .. last of which a term of the rates is made, for compiled kernels: how many points in the
middle of one have a say in its coefficient, and with what weights; how many differences of each order are left out at either
end, how many of the first order have a term of their own there, and its matrix."""
OPERATOR = np.dtype(
    [
        ("p", np.int64),
        ("rows", np.int64),
        ("cols", np.int64),
        ("reach", np.int64),
        ("interior", np.float64, (4,)),
        ("closure", np.float64, (8, 12)),
        ("columns", np.float64, (12, 8)),
        ("norm", np.float64, (8,)),
        ("narrowing", LEVELS),
        ("dissipation", LEVELS),
        ("shocks", LEVELS),
        ("dissipation_ends", np.float64, (8,)),
        ("shock_ends", np.float64, (8,)),
        ("narrow", np.int64),
        ("stiffness", np.float64),
        ("pace", np.float64),
    ]
)
"""One operator for compiled kernels, padded with zeros, for grid spacing 1: interior[:p], closure[:rows, :cols] and its
transpose columns, norm[:rows]; what makes second derivatives narrow (fsipetsc.operators.narrow); the differences of
dissipation, of order p and 1, and how much the first ones at an end count; 1 if second
derivatives are to be narrow, and what bounds the step accordingly; what the rate of convection, which bounds it, too, is
multiplied with."""

#: by order of the difference: weights of the points in its middle, for the state at which dissipation is taken
_DISSIPATION = {1: (1, 1), 2: (1, 2, 1), 3: (1, 3, 3, 1), 4: (1, 2, 1)}
#: by interior order: how much shorter steps are with dissipation of strength 1 at shocks. That alone is a number of -1.6 at
#: Courant number 0.8, of 2.785 that the classical method bears; next to the ends of 8/4 more.
_PACE_AT_SHOCKS = {2: 1.0, 4: 1.0, 6: 1.0, 8: 4 / 3}


@dataclass(frozen=True)
class SBPOperator:
    """A diagonal-norm SBP first derivative on n equidistant points, closed at both ends.

    With H = diag(norm_weights) and grid spacing h, D = matrix(n, h) satisfies hHD + (hHD)^T = diag(-1, 0, ..., 0, 1).
    Exact coefficients, all for h = 1 and the left end; at the right end columns are mirrored and signs change.
    """

    order: int
    """Interior order of accuracy: 2, 4, 6 or 8."""
    boundary_order: int
    """Order of accuracy of the closure rows: 1, 2, 3 or 4."""
    norm: tuple[Fraction, ...]
    """(rows,) Norm weights at the points of the closure; 1 elsewhere."""
    interior: tuple[Fraction, ...]
    """(p,) Weights of v[i+1], v[i+2], ...; those of v[i-1], v[i-2], ... are their negatives."""
    closure: tuple[tuple[Fraction, ...], ...]
    """(rows, rows + p) Row j gives the derivative at point j."""

    @property
    def name(self) -> str:
        """Interior and boundary order, as in "4/2"."""
        return f"{self.order}/{self.boundary_order}"

    @property
    def p(self) -> int:
        """Half width of the interior stencil."""
        return len(self.interior)

    @property
    def rows(self) -> int:
        """Number of closure rows at each end."""
        return len(self.closure)

    @property
    def reach(self) -> int:
        """Largest distance, in points, from a point to one that its derivative uses."""
        in_closure = (abs(j - i) for i, row in enumerate(self.closure) for j, weight in enumerate(row) if weight)
        return max(self.p, *in_closure)

    @property
    def min_points(self) -> int:
        """Fewest grid points on which the closures of both ends fit."""
        return 2 * self.rows

    def matrix(self, n: int, h: float = 1.0) -> NDArray[np.float64]:
        """D as a dense (n, n) array, a true derivative on spacing h > 0. ValueError if n < min_points."""
        return self._assemble(n, float, np.float64) / h

    def exact_matrix(self, n: int) -> list[list[Fraction]]:
        """D for h = 1 as n rows of n fractions. ValueError if n < min_points."""
        return self._assemble(n, Fraction, object).tolist()

    def norm_weights(self, n: int) -> NDArray[np.float64]:
        """The diagonal of H, shape (n,), without h. ValueError if n < min_points."""
        self._require(n)
        weights = np.ones(n)
        weights[: self.rows] = [float(w) for w in self.norm]
        weights[n - self.rows :] = weights[: self.rows][::-1]
        return weights

    def _assemble(self, n: int, number: Callable[[Any], Any], dtype: DTypeLike) -> NDArray[Any]:
        self._require(n)
        matrix = np.full((n, n), number(0), dtype=dtype)
        for k, weight in enumerate(self.interior, start=1):
            i = np.arange(n - k)
            matrix[i, i + k] = number(weight)
            matrix[i + k, i] = number(-weight)
        closure = np.array([[number(weight) for weight in row] for row in self.closure], dtype=dtype)
        rows, cols = closure.shape
        matrix[:rows, :cols] = closure
        matrix[n - rows :, n - cols :] = 0 - closure[::-1, ::-1]  # not -closure, which would hold -0.0
        return matrix

    def _require(self, n: int) -> None:
        if n < self.min_points:
            raise ValueError(f"the {self.name} operator needs at least {self.min_points} points, not {n}")


OPERATORS: dict[int, SBPOperator] = {
    order: SBPOperator(order, c.boundary_order, c.norm, c.interior, closure_rows(c))
    for order, c in COEFFICIENTS.items()
}
"""By interior order: 2, 4, 6, 8."""


def operator(order: int) -> SBPOperator:
    """The operator of this interior order. ValueError, naming the valid ones, if there is none."""
    if order not in OPERATORS:
        raise ValueError(
            f"there is no SBP operator of order {order}; valid orders are {', '.join(map(str, OPERATORS))}"
        )
    return OPERATORS[order]


def row_length(op: Any) -> int:
    """Number of points that the closure row at an end reaches: of an operator, or of its record."""
    return op.rows if op.rows > 1 else 2


def packed(order: int, narrow: bool = False, shocks: float = 0.0) -> np.void:
    """The operator of this interior order as a new record of dtype OPERATOR. ValueError as in `operator`.

    narrow: whether second derivatives are to be narrow, rather than D twice; shocks: how strong dissipation is there.
    """
    record = _numbers(order).copy()
    record["pace"] = max(1.0, shocks * _PACE_AT_SHOCKS[order])
    record["narrow"] = narrow
    record["stiffness"] = STIFFNESS[order] if narrow else STIFFNESS_OF_WIDE
    return record


@cache
def _numbers(order: int) -> np.void:
    """What is the same in all records of an operator: fractions take milliseconds to become numbers."""
    op = operator(order)
    record = np.zeros((), dtype=OPERATOR)
    record["p"], record["rows"], record["cols"], record["reach"] = op.p, op.rows, op.rows + op.p, op.reach
    record["interior"][: op.p] = [float(w) for w in op.interior]
    record["closure"][: op.rows, : op.rows + op.p] = [[float(w) for w in row] for row in op.closure]
    record["columns"] = record["closure"].T
    record["norm"][: op.rows] = [float(w) for w in op.norm]
    terms, found = record["narrowing"], levels(op.interior)
    terms["first"], terms["last"] = found[0].order, found[-1].order
    for k, level in enumerate(found):
        terms["counts"][k] = len(level.weights)
        terms["weights"][k, : len(level.weights)] = [float(w) for w in level.weights]
    end = end_term(op.interior)
    terms["skipped"], terms["ends"] = len(end), len(end) if end.any() else 0
    terms["end"][: len(end), : len(end)] = end
    for name, q, weights in (("dissipation", op.p, _DISSIPATION[op.p]), ("shocks", 1, (1,))):
        terms = record[name]
        terms["first"] = terms["last"] = q
        terms["counts"][0] = len(weights)
        terms["weights"][0, : len(weights)] = [w / sum(weights) for w in weights]
    H = np.append(record["norm"][: op.rows], np.ones(op.p))
    for r in range(op.rows):
        record["dissipation_ends"][r] = min(1.0, H[r : r + op.p + 1].min())
        record["shock_ends"][r] = min(1.0, np.sqrt(H[r] * H[r + 1]))
    return record[()]
