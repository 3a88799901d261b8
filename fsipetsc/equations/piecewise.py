"""Functions through the points of a table, which formulas and functions of time take."""

from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from fsipetsc.errors import InputError
from fsipetsc.kernels.symbols import Symbol


class Piecewise:
    """A piecewise polynomial of SciPy as a function of numbers, arrays and symbols: recorded.

    Args:
        of: `CubicSpline(t, x)`, `PchipInterpolator(t, x)`, or another `PPoly`, with one number for
            each t.
    """

    def __init__(self, of: PPoly) -> None:
        if not isinstance(of, PPoly) or of.c.ndim != 2:
            wanted = "expected CubicSpline(t, x) or the like, with one number for each t"
            raise InputError(f"Piecewise: {type(of).__name__}: {wanted}")
        self.of = of
        self._pieces = np.vstack([of.x[:-1], of.c])  # where each begins, and its coefficients

    def derivative(self) -> "Piecewise":
        """Its derivative: the velocity of a place."""
        return Piecewise(self.of.derivative())

    def __call__(self, t: Any) -> Any:
        ends, pieces = self.of.x, self._pieces
        first, last, value = ends[0], ends[-1], 0.0
        slack = 1e-9 * (last - first)  # to which round-off may lead
        inside = (t >= first - slack) & (t <= last + slack)
        if isinstance(t, Symbol):
            begin, *c = pieces[:, 0]
            for piece in pieces[:, 1:].T:
                begin, *c = (np.where(t >= piece[0], *one) for one in zip(piece, (begin, *c)))
        elif np.all(inside):
            begin, *c = pieces[:, np.clip(np.searchsorted(ends, t, "right") - 1, 0, len(ends) - 2)]
        else:
            wrong = np.ravel(t)[np.argmin(np.ravel(inside))]
            wanted = f"expected a number in {first:g} to {last:g}, the table"
            raise InputError(f"Piecewise: t = {wrong:.9g}: {wanted}")
        for number in c:
            value = value * (t - begin) + number
        # outside neither the value nor its derivatives are numbers
        return np.where(inside, value, t * np.nan) if isinstance(t, Symbol) else value
