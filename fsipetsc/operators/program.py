"""Prepared calls, made one after the other by compiled code: a step of many small ones does not go back to Python between them.

Where a row of points takes a microsecond, to hand a dozen arrays over takes another one. So what each call is given, addresses
and numbers, is written into a function of a few machine instructions for each, made when the calls are known.
"""

from __future__ import annotations

from collections.abc import Iterable
from ctypes import CFUNCTYPE, c_double, c_int32
from itertools import count
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core.cgutils import intp_t
from numba.core.compiler_lock import global_compiler_lock

from fsipetsc.operators.prepared import Prepared

_CODE, _DOUBLE = ir.IntType(32), ir.DoubleType()
#: of programs of this process, whose names must differ
_numbers = count()


class Program:
    """``program(x)``: (call, factors) in turn, each call given x times its factors beside what it has been prepared with.

    The compiled functions return nothing. All that the calls have been prepared with stays where it is, and is kept.
    RuntimeError if one of them raises. Other threads go on while it runs.
    """

    def __init__(self, calls: Iterable[tuple[Prepared, tuple[float, ...]]]) -> None:
        self._calls = list(calls)
        context = self._calls[0][0].entry.targetctx
        self._library = context.codegen().create_library("program")
        module = self._library.create_ir_module("program")
        function = ir.Function(module, ir.FunctionType(_CODE, [_DOUBLE]), f"fsipetsc.program.{next(_numbers)}")
        builder = ir.IRBuilder(function.append_basic_block())
        room = builder.alloca(ir.IntType(64)), builder.alloca(ir.IntType(64))  # for what is returned, and for an exception
        for number, (call, factors) in enumerate(self._calls, 1):
            others = [builder.fmul(function.args[0], ir.Constant(_DOUBLE, factor)) for factor in factors]
            _call(context, builder, call, room, others, number)
        builder.ret(ir.Constant(_CODE, 0))
        with global_compiler_lock:
            self._library.add_ir_module(module)
            self._library.finalize()
        self._run = CFUNCTYPE(c_int32, c_double)(_address(self._library, function.name))

    def __call__(self, x: float) -> None:
        raised = self._run(x)
        if raised:
            raise RuntimeError(f"{self._calls[raised - 1][0].entry.__name__} has raised an exception")


def _address(library: Any, name: str) -> int:
    address = library.get_pointer_to_function(name)
    if not address:
        raise RuntimeError(f"there is no machine code of {name}")
    return int(address)


def _call(
    context: Any, builder: ir.IRBuilder, call: Prepared, room: tuple[ir.Value, ...], others: list[ir.Value], number: int
) -> None:
    """Code that makes a call, and leaves with its number if it raises."""
    kinds = [numba.typeof(argument) for argument in call.arguments]
    compiled = call.found((*kinds, *(types.float64 for _ in others)))
    kind = context.call_conv.get_function_type(compiled.signature.return_type, compiled.signature.args)
    if compiled.signature.return_type != types.none:
        raise TypeError(f"{call.entry.__name__} returns {compiled.signature.return_type}: there is no room for it")
    address = _address(compiled.library, compiled.fndesc.llvm_func_name)
    callee = builder.inttoptr(ir.Constant(intp_t, address), kind.as_pointer())
    parts = [part for number, value in zip(kinds, call.arguments, strict=True) for part in _parts(number, value)]
    values = [*room, *parts, *others]
    given = [_as(builder, value, wanted) for value, wanted in zip(values, kind.args, strict=True)]
    raised = builder.icmp_signed("!=", builder.call(callee, given), ir.Constant(_CODE, 0))
    with builder.if_then(raised, likely=False):
        builder.ret(ir.Constant(_CODE, number))


def _parts(kind: Any, value: Any) -> list[float]:
    """What a compiled function is given for a number, an array or a tuple of them: of an array no owner and no parent, how
    many items it has and of how many bytes, where they are, its shape and strides.
    """
    if isinstance(kind, types.BaseTuple):
        return [part for own, number in zip(kind, value, strict=True) for part in _parts(own, number)]
    if isinstance(kind, types.Array):
        return [0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides]
    return [value]


def _as(builder: ir.IRBuilder, value: Any, kind: ir.Type) -> ir.Value:
    """A number, an address or a value of the program as that of a type of LLVM's."""
    if isinstance(value, ir.Value):
        return value if value.type == kind else builder.bitcast(value, kind)
    if isinstance(kind, ir.PointerType):
        return builder.inttoptr(ir.Constant(intp_t, int(value)), kind)
    return ir.Constant(kind, float(value) if kind == _DOUBLE else int(value))
