"""exp, log, tanh and power of numpy arrays that have the same bits on any machine.

The last bits of numpy's depend on the processor; here they are made of +, -, *, / and exact
operations. Cases take them for initial states, forcing and exact solutions. In formulas that are
recorded numpy's names stand for functions in C with the same bits anywhere (kernels/prelude.h).

exp and log are those of FDLIBM (e_exp.c, e_log.c, Sun Microsystems 1993) but for subnormal numbers.
"""

from typing import Any

import numpy as np

_LN2, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_P1, _P2, _P3 = 1.66666666666666019037e-01, -2.77777777770155933842e-03, 6.61375632143793436117e-05
_P4, _P5 = -1.65339022054652515390e-06, 4.13813679705723846039e-08
_R1, _R2, _R3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_R4, _R5 = 2.222219843214978396e-01, 1.818357216161805012e-01
_R6, _R7 = 1.531383769920937332e-01, 1.479819860510658591e-01


def exp(x: Any) -> Any:
    """e^x of a number or an array, of its shape, with an error below 1 unit in the last place.

    e^x = 2^k e^r with |r| < 0.35: e^r = 1 + r + r c / (2 - c), c = r - r^2 P(r^2).
    """
    x = np.clip(np.asarray(x, float), -750.0, 720.0)
    k = np.rint(x * 1.4426950408889634)
    high, low = x - k * _LN2, k * _LN2_LOW
    r = high - low
    z = r * r
    c = r - z * (_P1 + z * (_P2 + z * (_P3 + z * (_P4 + z * _P5))))
    with np.errstate(over="ignore", invalid="ignore"):  # as np.exp(x) for large and for no numbers
        return np.ldexp(1.0 - ((low - r * c / (2.0 - c)) - high), k.astype(np.int32))[()]


def log(x: Any) -> Any:
    """ln x of a number or an array, of its shape, with an error below 1 unit in the last place;
    -inf at 0 and nan below.

    ln x = k ln 2 + ln(1 + f), 1 + f between sqrt(1/2) and sqrt(2).
    """
    m, k = np.frexp(np.asarray(x, float))
    small = m < 0.7071067811865476
    f, k = np.where(small, 2.0 * m, m) - 1.0, k - 1.0 * small
    with np.errstate(divide="ignore", invalid="ignore"):  # of 0, infinity and no numbers
        s, half = f / (2.0 + f), 0.5 * f * f
    value = k * _LN2 - ((half - (s * (half + _remainder(s * s)) + k * _LN2_LOW)) - f)
    known = np.where(np.asarray(x) == 0.0, -np.inf, np.where(np.asarray(x) == np.inf, x, np.nan))
    return np.where((f > -1.0) & (f < 1.0), value, known)[()]


def power(a: Any, b: Any) -> Any:
    """a^b of numbers or arrays of one shape, a above 0; relative error: |b log a| 2^-53."""
    return exp(b * log(a))


def tanh(x: Any) -> Any:
    """tanh x of a number or an array, of its shape, with an error of at most 2^-52.

    It is (1 - e) / (1 + e) with e = e^(-2 |x|), with the sign of x.
    """
    e = exp(-2.0 * np.abs(x))
    return np.copysign((1.0 - e) / (1.0 + e), x)


def logarithm_rest(less: Any, x: Any) -> Any:
    """x - 1 - ln x of a positive number without cancellation near 1; less: x - 1. Recorded, too.

    The energy of a solid is of second order in f = x - 1. For x between sqrt(1/2) and sqrt(2)

        f - ln(1 + f) = f^2/2 - s (f^2/2 + R(s^2)),    s = f / (2 + f).    Source: FDLIBM, e_log.c.
    """
    near = (x > np.sqrt(0.5)) & (x < np.sqrt(2.0))
    f = np.where(near, less, 0.0)
    s, half = f / (2.0 + f), 0.5 * f * f
    return np.where(near, half - s * (half + _remainder(s * s)), less - np.log(x))


def _remainder(z: Any) -> Any:
    """R(z) of logarithms: ln(1 + f) = f - f^2/2 + s (f^2/2 + R(s^2))."""
    return z * (_R1 + z * (_R2 + z * (_R3 + z * (_R4 + z * (_R5 + z * (_R6 + z * _R7))))))
