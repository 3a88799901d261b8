"""How loops are compiled, and functions of tuples: one source serves one, two and three dimensions.

Equations and laws are NamedTuple classes whose methods are scalar formulas, as
``gas.pressure(rho, T)``. The same source runs in plain Python, on numpy arrays, and in compiled
loops.

Functions of tuples are written out for the length of their arguments when they are compiled. Loops
over rows get tuples of rows; LLVM turns them into vector instructions because ``noalias`` says that
the arrays of a call do not overlap.
"""

from collections.abc import Callable
from functools import cache
from inspect import isfunction
from typing import Any

from numba import njit, types
from numba.core.compiler import Compiler
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate
from numba.extending import infer_getattr, lower_builtin, overload

from fsipetsc.operators.kernel_cache import use_kernel_cache

use_kernel_cache()  # before the first kernel is defined


class NoAlias(Compiler):
    """numba's compiler with its flag ``noalias``: arrays given to a function do not overlap."""

    def compile_extra(self, func: Any) -> Any:
        self.state.flags.noalias = True
        return super().compile_extra(func)


#: of loops whose arrays do not overlap; contract: a*b + c may be rounded once
LOOP = {
    "fastmath": {"contract", "nsz"},
    "error_model": "numpy",
    "boundscheck": False,
    "nogil": True,
    "cache": True,
    "pipeline_class": NoAlias,
}
#: of functions that call loops
CALL = {"error_model": "numpy", "boundscheck": False, "nogil": True, "cache": True}
#: of functions that are put into compiled callers before these are compiled, which spares a
#: compilation of each; Python can call them, too
MERGED_CALL = {**CALL, "inline": "always"}
#: spares compile time in functions that compiled code alone calls; Python crashes if it calls them
_INNER = {"cache": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
INNER_LOOP, INNER_CALL = {**LOOP, **_INNER}, {**CALL, **_INNER}
#: of parts of a sweep: put into what calls them, they count no references to arrays
INLINED_CALL = {**INNER_CALL, "forceinline": True}
#: of loops that round each operation by itself: the same bits in vectors and in the rest of a row
EXACT_LOOP = {**INNER_LOOP, "fastmath": {"nsz"}}
#: the same of formulas, which are always put into the loops that call them
_FORMULA = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": True}


@infer_getattr
class _Formulas(AttributeTemplate):
    """Lets compiled code call the methods of NamedTuple classes."""

    key = types.BaseNamedTuple

    def generic_resolve(self, law: Any, name: str) -> Any:
        found = getattr(law.instance_class, name, None)
        return types.BoundFunction(_method(found), law) if isfunction(found) else None


@cache
def _method(formula: Callable[..., Any]) -> Any:
    """What numba must know of a method: its type for given arguments, and how it is called."""
    dispatcher = njit(**_FORMULA)(formula)

    class Method(AbstractTemplate):
        key = formula

        def generic(self, arguments: Any, keywords: Any) -> Any:
            compiled, given = types.Dispatcher(dispatcher), (self.this, *arguments)
            return compiled.get_call_type(self.context, given, keywords).as_method()

    @lower_builtin(formula, types.VarArg(types.Any))
    def call(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        compiled = types.Dispatcher(dispatcher)
        found = compiled.get_call_type(context.typing_context, signature.args, {})
        function = context.get_function(compiled, found)
        context.add_linking_libs(getattr(function, "libs", ()))
        return function(builder, arguments)

    return Method


def by_length(name: str, arguments: str, body: Callable[[int], str], inline: str = "never") -> Any:
    """A function of tuples, by its source for tuples of length n, in Python and compiled."""
    made: dict[int, Any] = {}

    def source(n: int) -> Any:
        if n not in made:
            space: dict[str, Any] = {}
            exec(f"def {name}({arguments}):\n{body(n)}", space)
            made[n] = space[name]
        return made[n]

    def build(*kinds: Any) -> Any:
        return source(max(kind.count for kind in kinds if isinstance(kind, types.BaseTuple)))

    space: dict[str, Any] = {"source": source, "build": build}
    length = "max(len(v) for v in (" + arguments + ",) if isinstance(v, tuple))"
    exec(f"def {name}({arguments}):\n return source({length})({arguments})", space)
    exec(f"def _build({arguments}): return build({arguments})", space)
    overload(space[name], inline=inline, jit_options=_FORMULA)(space["_build"])
    return space[name]


def numbers(item: str) -> Callable[[int], str]:
    """Source of a tuple of so many numbers; @: the number of one."""
    return lambda n: " return (" + "".join(item.replace("@", str(k)) + "," for k in range(n)) + ")"


def _last(item: str) -> Callable[[int], str]:
    others = " return ({}" + item.replace("@", "{}") + ",)"
    return lambda n: others.format("".join(f"a[{k}], " for k in range(n - 1)), n - 1)


def _lines(line: str) -> Callable[[int], str]:
    return lambda n: "\n".join(" " + line.replace("@", str(k)) for k in range(n))


def total_of(term: str) -> Callable[[int], str]:
    """Source of a sum."""
    return lambda n: " return " + " + ".join(term.replace("@", str(k)) for k in range(n))


dot = by_length("dot", "a, b", total_of("a[@] * b[@]"))
add = by_length("add", "a, b", numbers("a[@] + b[@]"))
sub = by_length("sub", "a, b", numbers("a[@] - b[@]"))
scale = by_length("scale", "c, a", numbers("c * a[@]"))
mean = by_length("mean", "a, b", numbers("0.5 * (a[@] + b[@])"))
per = by_length("per", "a, c", numbers("a[@] / c"))
#: a + c b
along = by_length("along", "a, c, b", numbers("a[@] + c * b[@]"))
total = by_length("total", "a", total_of("a[@]"))
larger = by_length("larger", "a, b", numbers("max(a[@], b[@])"))
#: (a_1, …, c a_n), and (a_1, …, a_n + c)
last_times = by_length("last_times", "c, a", _last("c * a[@]"))
add_last = by_length("add_last", "c, a", _last("a[@] + c"))
zeros = by_length("zeros", "a", numbers("0.0 * a[@]"))
choose = by_length("choose", "first, a, b", numbers("a[@] if first else b[@]"))
#: rows[c][i], as a tuple
load = by_length("load", "rows, i", numbers("rows[@][i]"))
store = by_length("store", "rows, i, values", _lines("rows[@][i] = values[@]"))
#: array[c, a:b] for each c of like, made where it is used: else numba counts references to views
rows = by_length("rows", "like, array, a, b", numbers("array[@, a:b]"), inline="always")
#: array[c, n] for each c of like: the numbers of one node of an array by components
column = by_length("column", "like, array, n", numbers("array[@, n]"))
#: the same from array[first, n] on
column_of = by_length("column_of", "like, array, first, n", numbers("array[first + @, n]"))
#: array[n, c] for each c of like: the numbers of one node of an interlaced array
node = by_length("node", "like, array, n", numbers("array[n, @]"))
#: the same from array[n, first] on
part_of = by_length("part_of", "like, array, n, first", numbers("array[n, first + @]"))
put_part = by_length(
    "put_part", "array, n, first, values", _lines("array[n, first + @] = values[@]")
)
