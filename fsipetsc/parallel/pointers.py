"""Memory by its address, for compiled code: the plan's as arrays of other shapes, and what ranks of a node share."""

from __future__ import annotations

from llvmlite import ir
from numba import carray, njit
from numba.core import types
from numba.extending import intrinsic

from fsipetsc.operators.kernels import ARRAYS


def _pointer_to(kind):
    @intrinsic
    def pointer(typingctx, address):
        """The integer ``address`` as a pointer."""

        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], context.get_value_type(types.CPointer(kind)))

        return types.CPointer(kind)(types.intp), codegen

    return pointer


_doubles, _words = _pointer_to(types.float64), _pointer_to(types.uint64)


@njit(**ARRAYS)
def rows_of(address, rows, columns):
    """The doubles at an address as an array of shape (rows, columns), without a count of references."""
    return carray(_doubles(address), (rows, columns))


@njit(**ARRAYS)
def rows_at(memory, at, rows, columns):
    """memory[at:] as an array of shape (rows, columns), likewise."""
    return rows_of(memory.ctypes.data + 8 * at, rows, columns)


@njit(**ARRAYS)
def words_at(address, count):
    """``count`` 64-bit words at an address."""
    return carray(_words(address), (count,))


@intrinsic
def load_acquire(typingctx, address):
    """The 64-bit integer at an address; what follows reads nothing that was written before it became what it is."""

    def codegen(context, builder, signature, args):
        return builder.load_atomic(builder.inttoptr(args[0], ir.IntType(64).as_pointer()), "acquire", 8)

    return types.int64(types.intp), codegen


@intrinsic
def store_release(typingctx, address, value):
    """Set the 64-bit integer at an address; who sees it sees all that was written before."""

    def codegen(context, builder, signature, args):
        builder.store_atomic(args[1], builder.inttoptr(args[0], ir.IntType(64).as_pointer()), "release", 8)
        return context.get_dummy_value()

    return types.void(types.intp, types.int64), codegen
