"""How loops are compiled, and functions of tuples, by which one source serves one, two and three dimensions.

Equations and laws are NamedTuple classes whose methods are scalar formulas, as ``gas.pressure(rho, T)``. The same source runs
in plain Python, on numpy arrays, and in compiled loops: `formulas` makes methods of these names known to numba.

Functions of tuples are written out for the length of their arguments when they are compiled. Loops over rows get tuples of
rows; LLVM turns them into vector instructions because ``noalias`` says that the arrays of a call do not overlap.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core.compiler import Compiler
from numba.extending import overload, overload_method, register_jitable

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

_known: set[str] = set()
_formulas: dict[Callable[..., Any], Callable[..., Any]] = {}


def formulas(*names: str) -> None:
    """Let compiled code call methods of these names of NamedTuple classes; no NamedTuple may have fields of these names."""
    for name in names:
        if name not in _known:
            _known.add(name)
            _register(name)


def _register(name: str) -> None:
    @overload_method(types.BaseNamedTuple, name, jit_options={"forceinline": True})
    def method(law, *arguments):
        found = getattr(law.instance_class, name, None)
        if found is None:
            return None
        formula = _formulas.setdefault(found, register_jitable(forceinline=True)(found))

        def call(law, *arguments):
            return formula(law, *arguments)

        return call


def _by_length(name: str, arguments: str, body: Callable[[int], str], inline: str = "never") -> Any:
    """A function of tuples, defined by its source for tuples of length n, in Python and compiled."""
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
    overload(space[name], inline=inline, jit_options={"forceinline": True})(space["_build"])
    return space[name]


def _tuple(item: str) -> Callable[[int], str]:
    return lambda n: " return (" + "".join(item.replace("@", str(k)) + "," for k in range(n)) + ")"


def _lines(line: str) -> Callable[[int], str]:
    return lambda n: "\n".join(" " + line.replace("@", str(k)) for k in range(n))


def _sum(term: str) -> Callable[[int], str]:
    return lambda n: " return " + " + ".join(term.replace("@", str(k)) for k in range(n))


dot = _by_length("dot", "a, b", _sum("a[@] * b[@]"))
add = _by_length("add", "a, b", _tuple("a[@] + b[@]"))
sub = _by_length("sub", "a, b", _tuple("a[@] - b[@]"))
scale = _by_length("scale", "c, a", _tuple("c * a[@]"))
mean = _by_length("mean", "a, b", _tuple("0.5 * (a[@] + b[@])"))
#: a + c b
along = _by_length("along", "a, c, b", _tuple("a[@] + c * b[@]"))
zeros = _by_length("zeros", "a", _tuple("0.0 * a[@]"))
#: rows[c][i], as a tuple
load = _by_length("load", "rows, i", _tuple("rows[@][i]"))
store = _by_length("store", "rows, i, values", _lines("rows[@][i] = values[@]"))
add_to = _by_length("add_to", "rows, i, c, values", _lines("rows[@][i] += c * values[@]"))
#: array[c, a:b] for each c of like; views must be made where they are used, else numba counts references to them
rows = _by_length("rows", "like, array, a, b", _tuple("array[@, a:b]"), inline="always")
#: array[c, n] for each c of like: the numbers of one node of an array by components
column = _by_length("column", "like, array, n", _tuple("array[@, n]"))
#: array[n, c] for each c of like: the numbers of one node of an interlaced array
node = _by_length("node", "like, array, n", _tuple("array[n, @]"))
put_node = _by_length("put_node", "array, n, values", _lines("array[n, @] = values[@]"))
