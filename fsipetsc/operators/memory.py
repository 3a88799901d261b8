"""Vectors and memory: ``load`` and ``store``, and their likes for unknowns that stand together point by point. Compiled.

s is any contiguous array, seen as flat; nothing is checked.
"""

from __future__ import annotations

from math import gcd

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic

from fsipetsc.operators.vectors import DOUBLES, shuffled, vector, wide_vector


def _place(context, builder, sig, args, doubles=DOUBLES):
    """Pointer to a vector at an element of an array."""
    data = context.make_array(sig.args[0])(context, builder, args[0]).data
    return builder.bitcast(builder.gep(data, [args[1]]), doubles.as_pointer())


def _load(kind, s, i):
    """Signature and code of what loads a vector of a kind."""

    def codegen(context, builder, sig, args):
        value = builder.load(_place(context, builder, sig, args, kind.doubles))
        value.align = 8
        return value

    return kind(s, types.intp), codegen


@intrinsic
def load(typingctx, s, i):
    """s[i : i+LANES]."""
    return _load(vector, s, i)


@intrinsic
def load_wide(typingctx, s, i):
    """s[i : i+WIDE]."""
    return _load(wide_vector, s, i)


@intrinsic
def store(typingctx, s, i, v):
    """s[i : i+LANES] = v, or as many as v has."""

    def codegen(context, builder, sig, args):
        builder.store(args[2], _place(context, builder, sig, args, v.doubles)).align = 8
        return context.get_dummy_value()

    return types.none(s, types.intp, v), codegen


@intrinsic
def fetch(typingctx, s, i):
    """Have the cache line of s[i], wherever that is, brought to the second cache while other work goes on."""
    place, number = ir.IntType(8).as_pointer(), ir.IntType(32)

    def codegen(context, builder, sig, args):
        at = builder.bitcast(_place(context, builder, sig, args), place)
        kind = ir.FunctionType(ir.VoidType(), [place, number, number, number])
        to_read, second, data = number(0), number(2), number(1)
        builder.call(get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8"), [at, to_read, second, data])
        return context.get_dummy_value()

    return types.none(s, types.intp), codegen


@intrinsic
def store_interlaced(typingctx, s, i, values):
    """s[i + n j + c] = values[c][j] for a tuple of n vectors: what belongs to one point comes to stand together."""
    n = len(values)

    def codegen(context, builder, sig, args):
        joined = [builder.extract_value(args[2], c) for c in range(n)]
        while len(joined) > 2:  # pairs of equal length; the last one, if alone, with itself
            every = range(2 * joined[0].type.count)
            joined = [shuffled(builder, a, b, every) for a, b in zip(joined[::2], joined[1::2] + joined[-1:])]
        count = args[2].type.elements[0].count
        lanes = [c * count + j for j in range(count) for c in range(n)]
        result = shuffled(builder, joined[0], joined[-1], lanes)
        place = builder.bitcast(_place(context, builder, sig, args), result.type.as_pointer())
        builder.store(result, place).align = 8
        return context.get_dummy_value()

    return types.none(s, types.intp, values), codegen


def _load_interlaced(kind, s, i, n):
    """Signature and code of what loads n vectors of a kind."""
    count, lanes = n.literal_value, kind.lanes
    assert gcd(count, lanes) == 1  # so each lane is wanted of one of the vectors that stand there: first chosen, then in order

    def codegen(context, builder, sig, args):
        place = _place(context, builder, sig, args, kind.doubles)
        there = [builder.load(builder.gep(place, [ir.Constant(ir.IntType(32), k)])) for k in range(count)]
        for value in there:
            value.align = 8
        parts = []
        for c in range(count):
            at, picked = [c + count * j for j in range(lanes)], there[0]
            whose = {place % lanes: place // lanes for place in at}
            for k in range(1, count):
                picked = shuffled(builder, picked, there[k], [j + lanes * (whose[j] == k) for j in range(lanes)])
            parts.append(shuffled(builder, picked, picked, [place % lanes for place in at]))
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(kind, count)(s, types.intp, n), codegen
