"""What linear theories share: differences, the range of a projection, the step of RK4.

The classical Runge-Kutta method multiplies a mode exp(lambda t) by R(dt lambda) in a step, R(z) =
1 + z + z^2/2 + z^3/6 + z^4/24; the step limit is the largest dt with |R| <= 1 for all modes (one
that grows counts with its frequency alone).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Real, Complex = NDArray[np.float64], NDArray[np.complex128]
#: f' = sum_m c_m (f(x + m s) - f(x - m s)) / s with m = 1 ... 4, of order 8
CENTRAL = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
#: |z| at which each mode is amplified
FARTHEST = 3.2


def bisect(beyond: Callable[[float], bool], low: float, high: float) -> float:
    """Where beyond(x), false at low, becomes true on the way to high."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return high


def range_basis(projection: Real) -> Real:
    """(N, n), orthonormal, of what a projection (N, N) leaves as it is."""
    N = len(projection)
    changed = projection - np.eye(N)
    touched = np.flatnonzero(changed.any(axis=0) | changed.any(axis=1))
    others = np.setdiff1d(np.arange(N), touched)
    left, sizes, _ = np.linalg.svd(projection[np.ix_(touched, touched)])
    left = left[:, sizes > 1e-9 * sizes.max(initial=0.0)]
    basis = np.zeros((N, len(others) + left.shape[1]))
    basis[others, np.arange(len(others))] = 1.0
    basis[np.ix_(touched, len(others) + np.arange(left.shape[1]))] = left
    return basis


def step_limit(spectrum: Complex) -> float:
    """The largest dt [s] for which RK4 amplifies none of these modes.

    Along each ray of Re z <= 0 |R| <= 1 holds up to one point: a bisection finds the least.
    """
    spectrum = np.minimum(spectrum.real, 0.0) + 1j * spectrum.imag
    farthest = FARTHEST / float(np.abs(spectrum).max())
    return bisect(lambda dt: (amplification(dt * spectrum) > 1.0 + 1e-12).any(), 0.0, farthest)


def amplification(z: Complex) -> Real:
    """|R(z)|."""
    return np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
