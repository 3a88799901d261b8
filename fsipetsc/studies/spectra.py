"""What linear theories share: derivatives by differences, and the step of RK4.

The classical Runge-Kutta method multiplies a mode exp(lambda t) by R(dt lambda) in a step, R(z) =
1 + z + z^2/2 + z^3/6 + z^4/24; the step limit is the largest dt with |R| <= 1 for all modes (one
that grows counts with its frequency alone).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Real, Complex = NDArray[np.float64], NDArray[np.complex128]
#: f' = sum_m c_m (f(x + m s) - f(x - m s)) / s with m = 1 ... 4, of order 8
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
#: |z| at which each mode is amplified, and round-off of |R|
FARTHEST, ROUND_OFF = 3.2, 1e-12


def derivatives(f: Callable[[int, float], Any], steps: Sequence[float] | Real) -> Any:
    """(…, n) derivatives of an array by n numbers: f(i, change) is the array where number i is
    changed by so much. Central differences of order 8, with steps of these n sizes.
    """
    columns = []
    for i, step in enumerate(steps):
        total = 0.0
        for multiple, weight in enumerate(CENTRAL, 1):
            for sign in (1, -1):
                total = total + sign * weight / step * f(i, sign * multiple * step)
        columns.append(total)
    return np.stack(columns, axis=-1)


def step_limit(spectrum: Complex) -> float:
    """The largest dt [s] for which RK4 amplifies none of these modes: along each ray of Re z <= 0
    |R| <= 1 holds up to one point."""
    radius = float(np.abs(spectrum).max())
    modes = (np.minimum(spectrum.real, 0.0) + 1j * spectrum.imag) / radius

    def excess(x: float) -> float:
        z = x * modes
        return float(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))).max()) - 1 - ROUND_OFF

    return float(brentq(excess, 0.0, FARTHEST)) / radius
