"""The natural logarithm as plain arithmetic, so that LLVM makes vector code of loops that take it.

x = 2^k (1 + f) with 1 + f between sqrt(1/2) and sqrt(2), and with s = f / (2 + f)

    ln x = k ln 2 + f - (f^2/2 - s (f^2/2 + R(s^2))),

as in FDLIBM (e_log.c, Sun Microsystems 1993, whose coefficients of R these are): below 1 ulp.
"""

from typing import Any

import numpy as np
from numba.extending import overload

#: bits of sqrt(1/2), 1 and 2^52
_SQRT_HALF, _ONE, _BIG = 0x3FE6A09E667F3BCD, 0x3FF0000000000000, 0x4330000000000000
#: of k | _BIG read as a number
_OFFSET = 2.0**52 + 1023.0
#: ln 2, in a part with few bits and the rest
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_R1, _R2, _R3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_R4, _R5 = 2.222219843214978396e-01, 1.818357216161805012e-01
_R6, _R7 = 1.531383769920937332e-01, 1.479819860510658591e-01


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
        z = s * s
        R = z * (_R1 + z * (_R2 + z * (_R3 + z * (_R4 + z * (_R5 + z * (_R6 + z * _R7))))))
        half = 0.5 * f * f
        return power * _LN2_HIGH - ((half - (s * (half + R) + power * _LN2_LOW)) - f)

    return compiled
