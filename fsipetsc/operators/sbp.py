"""Summation-by-parts first derivatives: exact coefficients and dense matrices."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from fsipetsc.operators.coefficients import COEFFICIENTS, closure_rows


@dataclass(frozen=True)
class SBPOperator:
    """A diagonal-norm SBP first derivative on n equidistant points, closed at both ends.

    With H = diag(norm_weights) and spacing h, D = matrix(n, h) satisfies hHD + (hHD)^T =
    diag(-1, 0, ..., 0, 1). Exact coefficients, all for h = 1 and the left end; at the right end
    columns are mirrored and signs change.
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
        rows = enumerate(self.closure)
        return max(self.p, *(abs(j - i) for i, row in rows for j, w in enumerate(row) if w))

    @property
    def min_points(self) -> int:
        """Fewest grid points on which the closures of both ends fit."""
        return 2 * self.rows

    def matrix(self, n: int, h: float = 1.0) -> NDArray[np.float64]:
        """D as a dense (n, n) array on spacing h > 0. ValueError if n < min_points."""
        return np.array(self.exact_matrix(n), float) / h

    def exact_matrix(self, n: int) -> list[list[Fraction]]:
        """D for h = 1 as n rows of n fractions. ValueError if n < min_points."""
        self._require(n)
        matrix = np.full((n, n), Fraction(0), dtype=object)
        for k, weight in enumerate(self.interior, start=1):
            i = np.arange(n - k)
            matrix[i, i + k], matrix[i + k, i] = weight, -weight
        closure = np.array(self.closure, dtype=object)
        rows, cols = closure.shape
        matrix[:rows, :cols] = closure
        matrix[n - rows :, n - cols :] = -closure[::-1, ::-1]
        found: list[list[Fraction]] = matrix.tolist()
        return found

    def norm_weights(self, n: int) -> NDArray[np.float64]:
        """The diagonal of H, shape (n,), without h. ValueError if n < min_points."""
        self._require(n)
        weights = np.ones(n)
        weights[: self.rows] = [float(w) for w in self.norm]
        weights[n - self.rows :] = weights[: self.rows][::-1]
        return weights

    def _require(self, n: int) -> None:
        if n < self.min_points:
            least = f"at least {self.min_points} points"
            raise ValueError(f"the {self.name} operator needs {least}, not {n}")


OPERATORS: dict[int, SBPOperator] = {
    order: SBPOperator(order, c.boundary_order, c.norm, c.interior, closure_rows(c))
    for order, c in COEFFICIENTS.items()
}
"""By interior order: 2, 4, 6, 8."""


def operator(order: int) -> SBPOperator:
    """The operator of this interior order. ValueError, naming the valid ones, if there is none."""
    if order not in OPERATORS:
        valid = ", ".join(map(str, OPERATORS))
        raise ValueError(f"there is no SBP operator of order {order}; valid orders are {valid}")
    return OPERATORS[order]


def row_length(op: SBPOperator) -> int:
    """Number of points that the closure row at an end reaches."""
    return op.rows if op.rows > 1 else 2
