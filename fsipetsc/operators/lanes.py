"""Lanes of vectors: what picks them, moves them and chooses between them."""

from __future__ import annotations

from math import gcd

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from fsipetsc.operators.vectors import EACH_LANE, INT, LANES, WIDE, shuffled, spread_value, twice_vector, vector, wide_vector


@intrinsic(prefer_literal=True)
def lane(typingctx, v, j):
    """Lane j, a literal, of a vector."""
    index = ir.Constant(INT, j.literal_value)
    return types.float64(v, j), lambda context, builder, sig, args: builder.extract_element(args[0], index)


@intrinsic
def masked(typingctx, v, n, other):
    """The first n lanes of v, and the number ``other`` in those that follow."""
    words = ir.VectorType(ir.IntType(64), v.lanes)

    def codegen(context, builder, sig, args):
        numbers = ir.Constant(words, list(range(v.lanes)))
        wanted = builder.icmp_signed("<", numbers, spread_value(builder, args[1], words))
        return builder.select(wanted, args[0], spread_value(builder, args[2], v.doubles))

    return v(v, types.intp, types.float64), codegen


@intrinsic
def within(typingctx, v, i, a, b):
    """Lane j of v where a <= i + j < b, else 0."""
    words = ir.VectorType(ir.IntType(64), v.lanes)

    def codegen(context, builder, sig, args):
        value, at, first, end = args
        numbers = builder.add(spread_value(builder, at, words), ir.Constant(words, list(range(v.lanes))))
        above = builder.icmp_signed(">=", numbers, spread_value(builder, first, words))
        below = builder.icmp_signed("<", numbers, spread_value(builder, end, words))
        return builder.select(builder.and_(above, below), value, ir.Constant(v.doubles, [0.0] * v.lanes))

    return v(v, types.intp, types.intp, types.intp), codegen


@intrinsic
def any_above(typingctx, v, limit):
    """Whether a lane of v is larger than a number; one that is not a number is not."""
    bits = ir.IntType(v.lanes)

    def codegen(context, builder, sig, args):
        larger = builder.fcmp_ordered(">", args[0], spread_value(builder, args[1], v.doubles))
        return builder.icmp_unsigned("!=", builder.bitcast(larger, bits), ir.Constant(bits, 0))

    return types.boolean(v, types.float64), codegen


@intrinsic
def where_above(typingctx, v, limit, larger, other):
    """Lane by lane ``larger`` where v is larger than a number, else ``other``."""

    def codegen(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(">", args[0], spread_value(builder, args[1], v.doubles)), args[2], args[3])

    return v(v, types.float64, v, v), codegen


@intrinsic
def mirrored(typingctx, v):
    """The lanes in the opposite order."""
    return vector(v), lambda context, builder, sig, args: shuffled(builder, args[0], args[0], EACH_LANE[::-1])


@intrinsic(prefer_literal=True)
def centred_difference(typingctx, before, v, after, k):
    """Values k points to the right less those k points to the left of v, between its neighbours; k literal, <= LANES."""
    n = k.literal_value

    def codegen(context, builder, sig, args):
        left, here, right, _ = args
        ahead = shuffled(builder, here, right, [n + j for j in EACH_LANE])
        behind = shuffled(builder, left, here, [LANES - n + j for j in EACH_LANE])
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
    """n vectors of what ``store_interlaced`` would store of n, an odd number: the first begins with lane 0 of each."""
    n, lanes = len(values), values[0].lanes
    assert gcd(n, lanes) == 1  # so what one of them gives to all results goes to a lane each: first there, then chosen

    def codegen(context, builder, sig, args):
        parts = [ir.Constant(values[0].doubles, ir.Undefined)] * n
        for c in range(n):
            there = sorted(range(lanes), key=lambda j: (c + n * j) % lanes)
            v = builder.extract_value(args[0], c)
            v = shuffled(builder, v, v, there)
            for k in range(n):
                chosen = [j + lanes * ((k * lanes + j) % n == c) for j in range(lanes)]
                parts[k] = shuffled(builder, parts[k], v, chosen)
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(values[0], n)(values), codegen


@intrinsic(prefer_literal=True)
def joined(typingctx, before, v, k):
    """The last k lanes (k literal) of a vector and the first ones of that which follows: values k points to the left of v."""
    n, lanes = k.literal_value, v.lanes

    def codegen(context, builder, sig, args):
        return shuffled(builder, args[0], args[1], [lanes - n + j for j in range(lanes)])

    return v(before, v, k), codegen
