"""x - 1 - ln x without cancellation near 1: the energy of a solid is of second order in x - 1.

With f = x - 1 and s = f / (2 + f)

    f - ln(1 + f) = f^2/2 - s (f^2/2 + R(s^2)),

as in FDLIBM (e_log.c, Sun Microsystems 1993, whose coefficients of R these are), for 1 + f between
sqrt(1/2) and sqrt(2).
"""

from typing import Any

import numpy as np

_R1, _R2, _R3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_R4, _R5 = 2.222219843214978396e-01, 1.818357216161805012e-01
_R6, _R7 = 1.531383769920937332e-01, 1.479819860510658591e-01


def remainder(z):
    """R(z) of the head."""
    return z * (_R1 + z * (_R2 + z * (_R3 + z * (_R4 + z * (_R5 + z * (_R6 + z * _R7))))))


def _second_order(f):
    """f - ln(1 + f) for sqrt(1/2) < 1 + f < sqrt(2)."""
    s, half = f / (2.0 + f), 0.5 * f * f
    return half - s * (half + remainder(s * s))


def logarithm_rest(less: Any, x: Any) -> Any:
    """x - 1 - ln x of a positive number; less: x - 1."""
    near = (x > np.sqrt(0.5)) & (x < np.sqrt(2.0))
    return np.where(near, _second_order(np.where(near, less, 0.0)), less - np.log(x))[()]
