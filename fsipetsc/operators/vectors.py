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

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

LANES = 4
WIDE = 8
TWICE = 16

DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
INT = ir.IntType(32)
EACH_LANE = range(LANES)


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
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(INT, len(lanes)), list(lanes)))


def spread_value(builder, value, kind=DOUBLES):
    """A scalar in all lanes."""
    nothing = ir.Constant(kind, ir.Undefined)
    return shuffled(builder, builder.insert_element(nothing, value, ir.Constant(INT, 0)), nothing, [0] * kind.count)


def _as_vectors(builder, values, kinds):
    doubles = next(kind for kind in kinds if isinstance(kind, VectorType)).doubles
    return [
        v if isinstance(kind, VectorType) else spread_value(builder, v, doubles) for v, kind in zip(values, kinds, strict=True)
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
    return kind(types.float64), lambda context, builder, sig, args: spread_value(builder, args[0], kind.doubles)


@intrinsic
def numbers_from(typingctx, i):
    """i, i+1, ... as doubles."""

    def codegen(context, builder, sig, args):
        first = builder.sitofp(args[0], ir.DoubleType())
        return builder.fadd(spread_value(builder, first), ir.Constant(DOUBLES, [float(j) for j in EACH_LANE]))

    return vector(types.intp), codegen
