"""Functions through the points of a table, which formulas and functions of time take."""

from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from fsipetsc.errors import InputError
from fsipetsc.kernels.symbols import Symbol

#: part of the length of a table by which round-off may lead beyond it
SLACK = 1e-9


class Piecewise:
    """A piecewise polynomial of SciPy as a function of a number, an array or a symbol: it can be
    recorded, with exact derivatives.

    of: CubicSpline(t, x), PchipInterpolator(t, x), or another PPoly whose values are numbers.
    InputError for another one, and where the function is called outside of the table.
    """

    def __init__(self, of: PPoly) -> None:
        if not isinstance(of, PPoly) or of.c.ndim != 2:
            wanted = "expected CubicSpline(t, x) or the like, with one number for each t"
            raise InputError(f"Piecewise: {type(of).__name__}: {wanted}")
        self.of = of

    def derivative(self) -> "Piecewise":
        """Its derivative: the velocity of a place."""
        return Piecewise(self.of.derivative())

    def __call__(self, t: Any) -> Any:
        """The value at t."""
        ends, c = self.of.x, self.of.c
        slack, recorded = SLACK * (ends[-1] - ends[0]), isinstance(t, Symbol)
        inside = (t >= ends[0] - slack) & (t <= ends[-1] + slack)
        if recorded:
            left, *c = ends[0], *c[:, 0]
            for row in zip(ends[1:-1], *self.of.c[:, 1:]):
                left, *c = (np.where(t >= row[0], new, old) for old, new in zip((left, *c), row))
        else:
            k = np.clip(np.searchsorted(ends, t, "right") - 1, 0, len(ends) - 2)
            left, c = ends[k], c[:, k]
        value = 0.0
        for number in c:
            value = value * (t - left) + number
        if recorded:
            return np.where(inside, value, t * np.nan)  # nor is its derivative a number
        if not np.all(inside):
            where = np.ravel(t)[np.argmin(np.ravel(inside))]
            said = f"expected a number in {ends[0]:g} to {ends[-1]:g}, the table"
            raise InputError(f"Piecewise: t = {where:.9g}: {said}")
        return value
