"""The natural logarithm as plain arithmetic, so that LLVM makes vector code of loops that take it.

x = 2^k (1 + f) with 1 + f between sqrt(1/2) and sqrt(2), and with s = f / (2 + f)

    ln x = k ln 2 + f - (f^2/2 - s (f^2/2 + R(s^2))),

as in FDLIBM (e_log.c, Sun Microsystems 1993, whose coefficients of R these are): below 1 ulp.

Near 1 the energy of a solid is of second order in x - 1. `logarithm_rest` is for it: of x - 1 and x
it makes x - 1 - ln x, which is what stands in the brackets where k = 0 and f = x - 1.
"""

from typing import Any

import numpy as np
from numba.extending import overload, register_jitable

#: bits of sqrt(1/2), 1 and 2^52
_SQRT_HALF, _ONE, _BIG = 0x3FE6A09E667F3BCD, 0x3FF0000000000000, 0x4330000000000000
#: of k | _BIG read as a number
_OFFSET = 2.0**52 + 1023.0
#: ln 2, in a part with few bits and the rest
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_R1, _R2, _R3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_R4, _R5 = 2.222219843214978396e-01, 1.818357216161805012e-01
_R6, _R7 = 1.531383769920937332e-01, 1.479819860510658591e-01


@register_jitable
def _remainder(z):
    """R(z) of the head."""
    return z * (_R1 + z * (_R2 + z * (_R3 + z * (_R4 + z * (_R5 + z * (_R6 + z * _R7))))))


@register_jitable
def _second_order(f):
    """f - ln(1 + f) for sqrt(1/2) < 1 + f < sqrt(2)."""
    s, half = f / (2.0 + f), 0.5 * f * f
    return half - s * (half + _remainder(s * s))


def log(x: Any) -> Any:
    """ln x of a positive number; compiled: not for 0, infinity and numbers below 1e-307."""
    return np.log(x)


@overload(log)
def _log(x):
    def compiled(x):
        bits = np.float64(x).view(np.int64)
        k = (bits + (_ONE - _SQRT_HALF)) >> 52  # with the bias of exponents
        f = np.int64(bits - (k << 52) + _ONE).view(np.float64) - 1.0
        power = np.int64(k | _BIG).view(np.float64) - _OFFSET
        s = f / (2.0 + f)
        R = _remainder(s * s)
        half = 0.5 * f * f
        return power * _LN2_HIGH - ((half - (s * (half + R) + power * _LN2_LOW)) - f)

    return compiled


def logarithm_rest(less: Any, x: Any) -> Any:
    """x - 1 - ln x of a positive number, without cancellation near 1; less: x - 1."""
    near = (x > np.sqrt(0.5)) & (x < np.sqrt(2.0))
    return np.where(near, _second_order(np.where(near, less, 0.0)), less - np.log(x))[()]


@overload(logarithm_rest)
def _logarithm_rest(less, x):
    def compiled(less, x):
        bits = np.float64(x).view(np.int64)
        k = (bits + (_ONE - _SQRT_HALF)) >> 52  # with the bias of exponents
        f = np.int64(bits - (k << 52) + _ONE).view(np.float64) - 1.0
        power = np.int64(k | _BIG).view(np.float64) - _OFFSET
        f = less if power == 0.0 else f
        return (less - f - power * _LN2_HIGH) + (_second_order(f) - power * _LN2_LOW)

    return compiled
