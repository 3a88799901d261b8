"""Vectors: the values at LANES neighbouring points, side by side in a register. A type of numba's, for kernels.

Kernels say what is done to a vector at a time instead of leaving it to the compiler whether a loop becomes one: it
does not where it cannot prove that parts of the memory are apart. Arithmetic is that of scalars, lane by lane and bit
by bit; a scalar in a formula stands for all lanes. Where memory is named by an array s and an index i, lane j is s[i+j].

LANES is four on every machine: one AVX register, two of SSE or NEON, and enough for the widest stencil, which then
reaches from one vector into its neighbours only. Formulas may as well be given vectors of WIDE lanes, one register of
AVX-512, where that pays, or of TWICE as many: while a processor waits for the result of one half it works on the other.
Arithmetic, functions and comparisons take all of them, but not in one formula.
"""

from __future__ import annotations

import operator
from math import gcd

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from fsipetsc.operators.parts import PART

LANES = 4
WIDE = 8
TWICE = 16

DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
_INT = ir.IntType(32)
_EACH_LANE = range(LANES)


class VectorType(types.Type):
    """numba's type of vectors."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"vector{lanes}")

    @property
    def doubles(self) -> ir.VectorType:
        """LLVM's type of them."""
        return ir.VectorType(ir.DoubleType(), self.lanes)


vector, wide_vector, twice_vector = VectorType(LANES), VectorType(WIDE), VectorType(TWICE)


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, kind.doubles)


def shuffled(builder, a, b, lanes):
    """Lanes picked from a (0, 1, ...) and b (LANES, ...)."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INT, len(lanes)), list(lanes)))


def _spread(builder, value, kind=DOUBLES):
    """A scalar in all lanes."""
    nothing = ir.Constant(kind, ir.Undefined)
    return shuffled(builder, builder.insert_element(nothing, value, ir.Constant(_INT, 0)), nothing, [0] * kind.count)


def _as_vectors(builder, values, kinds):
    doubles = next(kind for kind in kinds if isinstance(kind, VectorType)).doubles
    return [
        v if isinstance(kind, VectorType) else _spread(builder, v, doubles) for v, kind in zip(values, kinds, strict=True)
    ]


def _define(op, instruction):
    """Arithmetic of two vectors, or of a vector and a scalar."""
    pairs = [pair for v in (vector, wide_vector, twice_vector) for pair in ((v, v), (v, types.float64), (types.float64, v))]

    class Template(ConcreteTemplate):
        key = op
        cases = tuple(signature(next(v for v in pair if v != types.float64), *pair) for pair in pairs)

    def lower(context, builder, sig, args):
        return getattr(builder, instruction)(*_as_vectors(builder, args, sig.args))

    infer_global(op)(Template)
    for pair in pairs:
        lower_builtin(op, *pair)(lower)


for _op, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _define(_op, _instruction)


def _function(name, kinds):
    """Signature and code of one of LLVM's own functions, of scalars or, if any argument is one, of vectors."""
    kinds = [kind if isinstance(kind, VectorType) else types.float64 for kind in kinds]
    result = next((kind for kind in kinds if isinstance(kind, VectorType)), types.float64)
    of_vectors = isinstance(result, VectorType)
    number, suffix = (result.doubles, f"v{result.lanes}f64") if of_vectors else (ir.DoubleType(), "f64")

    def codegen(context, builder, sig, args):
        values = _as_vectors(builder, args, sig.args) if of_vectors else args
        kind = ir.FunctionType(number, [number] * len(values))
        return builder.call(get_or_insert_function(builder.module, kind, f"llvm.{name}.{suffix}"), values)

    return signature(result, *kinds), codegen


@intrinsic
def fma(typingctx, a, b, c):
    """a * b + c, rounded once; of numbers or vectors, as those that follow."""
    return _function("fma", (a, b, c))


def _chosen(name, kinds, comparison):
    """Signature and code of what picks one of two numbers, lane by lane; one that is not a number goes first.

    LLVM has functions for that, but not for all processors in all of its releases.
    """
    kept_signature, _ = _function(name, kinds)

    def codegen(context, builder, sig, args):
        a, b = _as_vectors(builder, args, sig.args) if isinstance(sig.return_type, VectorType) else args
        picked = builder.select(builder.fcmp_ordered(comparison, a, b), a, b)
        return builder.select(builder.fcmp_unordered("uno", a, a), a, picked)

    return kept_signature, codegen


@intrinsic
def maximum(typingctx, a, b):
    """The larger one; not a number if one of them is not."""
    return _chosen("maximum", (a, b), ">")


@intrinsic
def minimum(typingctx, a, b):
    """The smaller one; not a number if one of them is not."""
    return _chosen("minimum", (a, b), "<")


@intrinsic
def larger(typingctx, a, b):
    """a where it is larger, else b: one instruction, for what is only compared."""
    kept_signature, _ = _function("larger", (a, b))

    def codegen(context, builder, sig, args):
        a, b = _as_vectors(builder, args, sig.args) if isinstance(sig.return_type, VectorType) else args
        return builder.select(builder.fcmp_ordered(">", a, b), a, b)

    return kept_signature, codegen


@intrinsic
def on_aligned_stack(typingctx):
    """Let the stack of the function that this stands in begin with a cache line: vectors for which registers are missing would
    each lie in two, else.
    """

    def codegen(context, builder, sig, args):
        with builder.goto_entry_block():
            room = builder.alloca(wide_vector.doubles)
            room.align = 64
        kind = ir.FunctionType(ir.VoidType(), [room.type])
        builder.asm(kind, "", "r", [room], side_effect=True)  # no instruction, but one that the room must be there for
        return context.get_dummy_value()

    return types.none(), codegen


@intrinsic
def root(typingctx, a):
    """Square root."""
    return _function("sqrt", (a,))


@intrinsic
def exponential(typingctx, a):
    """e to the power of a."""
    return _function("exp", (a,))


@intrinsic
def logarithm(typingctx, a):
    """Natural logarithm."""
    return _function("log", (a,))


@intrinsic
def power(typingctx, a, b):
    """a to the power of b."""
    return _function("pow", (a, b))


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
    return where_above(x, 0.0, found + (x - x), fma(0.0, x, np.nan))


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


@intrinsic
def magnitude(typingctx, a):
    """Absolute value."""
    return _function("fabs", (a,))


@intrinsic
def spread(typingctx, a):
    """The vector that has the number a in all lanes; a itself if it is a vector."""
    if isinstance(a, VectorType):
        return a(a), lambda context, builder, sig, args: args[0]
    return _spread_to(vector)


def _spread_to(kind):
    """Signature and code of what makes a vector of a kind of a number."""
    return kind(types.float64), lambda context, builder, sig, args: _spread(builder, args[0], kind.doubles)


@intrinsic
def spread_wide(typingctx, a):
    """The number a in WIDE lanes."""
    return _spread_to(wide_vector)


@intrinsic
def spread_twice(typingctx, a):
    """The number a in TWICE lanes."""
    return _spread_to(twice_vector)


@intrinsic
def numbers_from(typingctx, i):
    """i, i+1, ... as doubles."""

    def codegen(context, builder, sig, args):
        first = builder.sitofp(args[0], ir.DoubleType())
        return builder.fadd(_spread(builder, first), ir.Constant(DOUBLES, [float(j) for j in _EACH_LANE]))

    return vector(types.intp), codegen


@intrinsic(prefer_literal=True)
def lane(typingctx, v, j):
    """Lane j, a literal, of a vector."""
    index = ir.Constant(_INT, j.literal_value)
    return types.float64(v, j), lambda context, builder, sig, args: builder.extract_element(args[0], index)


@intrinsic
def masked(typingctx, v, n, other):
    """The first n lanes of v, and the number ``other`` in those that follow."""
    words = ir.VectorType(ir.IntType(64), v.lanes)

    def codegen(context, builder, sig, args):
        numbers = ir.Constant(words, list(range(v.lanes)))
        wanted = builder.icmp_signed("<", numbers, _spread(builder, args[1], words))
        return builder.select(wanted, args[0], _spread(builder, args[2], v.doubles))

    return v(v, types.intp, types.float64), codegen


@intrinsic
def within(typingctx, v, i, a, b):
    """Lane j of v where a <= i + j < b, else 0."""
    words = ir.VectorType(ir.IntType(64), v.lanes)

    def codegen(context, builder, sig, args):
        value, at, first, end = args
        numbers = builder.add(_spread(builder, at, words), ir.Constant(words, list(range(v.lanes))))
        above = builder.icmp_signed(">=", numbers, _spread(builder, first, words))
        below = builder.icmp_signed("<", numbers, _spread(builder, end, words))
        return builder.select(builder.and_(above, below), value, ir.Constant(v.doubles, [0.0] * v.lanes))

    return v(v, types.intp, types.intp, types.intp), codegen


@intrinsic
def any_above(typingctx, v, limit):
    """Whether a lane of v is larger than a number; one that is not a number is not."""
    bits = ir.IntType(v.lanes)

    def codegen(context, builder, sig, args):
        larger = builder.fcmp_ordered(">", args[0], _spread(builder, args[1], v.doubles))
        return builder.icmp_unsigned("!=", builder.bitcast(larger, bits), ir.Constant(bits, 0))

    return types.boolean(v, types.float64), codegen


@intrinsic
def where_above(typingctx, v, limit, larger, other):
    """Lane by lane ``larger`` where v is larger than a number, else ``other``."""

    def codegen(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(">", args[0], _spread(builder, args[1], v.doubles)), args[2], args[3])

    return v(v, types.float64, v, v), codegen


@intrinsic
def mirrored(typingctx, v):
    """The lanes in the opposite order."""
    return vector(v), lambda context, builder, sig, args: shuffled(builder, args[0], args[0], _EACH_LANE[::-1])


@intrinsic(prefer_literal=True)
def centred_difference(typingctx, before, v, after, k):
    """Values k points to the right less those k points to the left of v, between its neighbours; k literal, <= LANES."""
    n = k.literal_value

    def codegen(context, builder, sig, args):
        left, here, right, _ = args
        ahead = shuffled(builder, here, right, [n + j for j in _EACH_LANE])
        behind = shuffled(builder, left, here, [LANES - n + j for j in _EACH_LANE])
        return builder.fsub(ahead, behind)

    return vector(before, v, after, k), codegen


@intrinsic(prefer_literal=True)
def half(typingctx, v, k):
    """The first (k = 0, literal) or second wide vector of one of TWICE lanes."""
    first = WIDE * k.literal_value

    def codegen(context, builder, sig, args):
        return shuffled(builder, args[0], args[0], range(first, first + WIDE))

    return wide_vector(twice_vector, k), codegen


@intrinsic
def interlaced(typingctx, values):
    """n vectors of what ``store_interlaced`` would store of n: the first begins with lane 0 of each."""
    n, lanes = len(values), values[0].lanes
    apart = gcd(n, lanes) == 1  # then what one of them gives to all results goes to a lane each: first there, then chosen

    def codegen(context, builder, sig, args):
        found = [builder.extract_value(args[0], c) for c in range(n)]
        if apart:
            places = [sorted(range(lanes), key=lambda j, c=c: (c + n * j) % lanes) for c in range(n)]
            found = [shuffled(builder, v, v, order) for v, order in zip(found, places, strict=True)]
        parts = []
        for k in range(0, n * lanes, lanes):
            result = ir.Constant(values[0].doubles, ir.Undefined)
            for c in range(n):
                picked = list(range(lanes))
                for at, number in enumerate(range(k, k + lanes)):
                    if number % n == c:
                        picked[at] = lanes + (at if apart else number // n)
                result = shuffled(builder, result, found[c], picked)
            parts.append(result)
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(values[0], n)(values), codegen


@intrinsic(prefer_literal=True)
def joined(typingctx, before, v, k):
    """The last k lanes (k literal) of a vector and the first ones of that which follows: values k points to the left of v."""
    n, lanes = k.literal_value, v.lanes

    def codegen(context, builder, sig, args):
        return shuffled(builder, args[0], args[1], [lanes - n + j for j in range(lanes)])

    return v(before, v, k), codegen
