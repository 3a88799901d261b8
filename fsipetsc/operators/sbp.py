"""Summation-by-parts first derivatives: exact coefficients and dense matrices."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

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
        closure = np.array([[number(w) for w in row] for row in self.closure], dtype=dtype)
        rows, cols = closure.shape
        matrix[:rows, :cols] = closure
        matrix[n - rows :, n - cols :] = 0 - closure[::-1, ::-1]  # -closure would hold -0.0
        return matrix

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
