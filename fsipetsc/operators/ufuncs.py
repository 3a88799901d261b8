"""What numpy and Python call functions of numbers, for vectors: so formulas of users may name them."""

from __future__ import annotations

import operator

import numpy as np
from llvmlite import ir
from numba import njit
from numba.extending import intrinsic, overload

from fsipetsc.operators.lanes import where_above
from fsipetsc.operators.parts import PART
from fsipetsc.operators.vectors import VectorType, exponential, fma, maximum, power, root


def _of_numpy(ufunc, function):
    """What numpy calls a function that vectors have, too: so formulas of users may name it."""

    @overload(ufunc)
    def of_vector(a):
        return (lambda a: function(a)) if isinstance(a, VectorType) else None


@intrinsic
def binary_exponent(typingctx, x):
    """The whole number n, as a double, for which x / 2^n is between sqrt(1/2) and sqrt(2); of normal numbers above 0."""
    words = ir.VectorType(ir.IntType(64), x.lanes)

    def codegen(context, builder, sig, args):
        above = builder.sub(builder.bitcast(args[0], words), ir.Constant(words, [_ROOT_OF_HALF] * x.lanes))
        return builder.sitofp(builder.ashr(above, ir.Constant(words, [52] * x.lanes)), sig.return_type.doubles)

    return x(x), codegen


@intrinsic
def scaled_down(typingctx, x, n):
    """x / 2^n for what ``binary_exponent`` gives."""
    words = ir.VectorType(ir.IntType(64), x.lanes)

    def codegen(context, builder, sig, args):
        shift = builder.shl(builder.fptosi(args[1], words), ir.Constant(words, [52] * x.lanes))
        return builder.bitcast(builder.sub(builder.bitcast(args[0], words), shift), sig.return_type.doubles)

    return x(x, n), codegen


_NOT_NORMAL = float(np.nextafter(np.finfo(float).tiny, 0.0))  # the largest one
_ROOT_OF_HALF = int(np.array(np.sqrt(0.5)).view(np.int64))
_LN2, _LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # together ln 2; n times the first is exact
#: 2/(2n + 1): ln x = 2 artanh f = sum_n 2 f^(2n + 1)/(2n + 1), f = (x - 1)/(x + 1), up to round-off for |f| <= 0.1716
_OF_ARTANH = tuple(2.0 / (2 * n + 1) for n in range(10, -1, -1))


@njit(**PART, forceinline=True, error_model="numpy")
def of_normal_numbers(x):
    """ln x without a call for each lane; not a number where x is not a normal one above 0."""
    n = binary_exponent(x)
    m = scaled_down(x, n)
    f = (m - 1.0) / (m + 1.0)
    z, found = f * f, 0.0 * f + _OF_ARTANH[0]
    for c in _OF_ARTANH[1:]:
        found = fma(found, z, c)
    found = fma(n, _LN2, fma(f, found, n * _LN2_REST))
    return where_above(x, _NOT_NORMAL, found + (x - x), fma(0.0, x, np.nan))


for _ufunc, _vectors in ((np.sqrt, root), (np.exp, exponential), (np.log, of_normal_numbers)):
    _of_numpy(_ufunc, _vectors)


@overload(max)
def _larger(a, b):
    if isinstance(a, VectorType) or isinstance(b, VectorType):
        return lambda a, b: maximum(a, b)
    return None


@overload(operator.pow)
def _to_the_power(a, b):
    return (lambda a, b: power(a, b)) if isinstance(a, VectorType) else None


@overload(operator.neg)
def _negative(a):
    return (lambda a: -1.0 * a) if isinstance(a, VectorType) else None
