"""A kernel: one loop over nodes, pairs, faces or particles, printed as a function in C.

A kernel says what is read at an item of the loop, which formula it goes through, and where the
result is stored. It is made once, on symbols (fsipetsc.kernels.symbols):

    kernel = Kernel("heat", "The flux of heat of each node.")
    w, per_J = kernel.read("w", ROWS, 6), kernel.read("per_J", ROWS, 1)
    gas = kernel.parameters(gas)
    kernel.store("flux", ROWS, gas.heat_flux(w, per_J))

Procedures (fsipetsc.kernels.procedure) call it, with its arguments by their names, and with others
that it does not take: ``heat(64, w=row, per_J=…, flux=…)``.

a*b + c is printed as fma(a, b, c) where nothing else takes a*b, and compilers fuse nothing else.
So every node has the same bits in a vector and alone, with any compiler and instruction set. What
depends on parameters alone is computed before the loop.
"""

import re
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

from fsipetsc.kernels.loops import recording
from fsipetsc.kernels.printing import Line, printed, without_halves
from fsipetsc.kernels.symbols import Record, Symbol

# layouts: where component c of an item i stands in an array, as C has it; the caller gives the
# numbers in them, and arrays of whole numbers, but for ROW, which is a constant
#: rows of a tile: a component after the other, ROW apart
ROWS = "{c} * ROW + {i}"
#: planes of a block, N apart, and of the nodes that a rank owns, M apart
PLANES, OWNED = "{c} * N + {i}", "{c} * M + {i}"
#: numbers that all items share
SHARED = "{c}"


class Kernel:
    """See the head of this file. name: of the function in C; says: a sentence on what it does; few:
    it often has few items.
    """

    def __init__(self, name: str, says: str, few: bool = False) -> None:
        self.name, self.says, self.few, self.record = name, says, few, Record()
        self._arguments = {"n": "long "}
        self._stores: list[tuple[str, Symbol]] = []
        self._offsets = dict[str, str]()

    def read(self, array: str, layout: str, count: int, first: int = 0) -> tuple[Symbol, ...]:
        """The components ``first`` and so on of an item."""
        self._arguments.setdefault(array, "const double *restrict ")
        places = self._places(array, layout, count, first)
        return tuple(self.record.given(place, uniform=layout == SHARED) for place in places)

    def offset(self, text: str) -> str:
        """The name of a whole number that all items share, for layouts; text: how C finds it. C
        reads it before the loop: if it is read within, gcc takes the last items one by one.
        """
        self._declare(text)
        return self._offsets.setdefault(text, f"far{len(self._offsets)}")

    def number(self, name: str) -> Symbol:
        """A number that all items share."""
        self._arguments[name] = "double "
        return self.record.given(name, uniform=True)

    def parameters(self, equations: Any) -> Any:
        """The same equations with their floats as arguments of the kernel: the array p, as
        `floats_of` has it. Other numbers (int, bool) become text.
        """
        of = (self.read("p", SHARED, 1, n)[0] for n, _ in enumerate(floats_of(equations)))
        return _replaced(equations, lambda number: next(of))

    def store(self, array: str, layout: str, values: Sequence[Any], first: int = 0) -> None:
        """Store values as the components ``first`` and so on of an item."""
        self._arguments[array] = "double *restrict "
        places = self._places(array, layout, len(values), first)
        self._stores += [(f"{p} =", self.record.constant(v)) for p, v in zip(places, values)]

    def count(self, condition: Any) -> None:
        """Let the function return for how many items a condition holds."""
        self._stores.append(("counted +=", self.record.constant(condition)))

    def _places(self, array: str, layout: str, count: int, first: int) -> list[str]:
        self._declare(layout.replace("{c}", "").replace("{i}", ""))
        return [f"{array}[{layout.format(c=first + c, i='i')}]" for c in range(count)]

    def _declare(self, text: str) -> None:
        """Take the whole numbers that a text in C names as arguments."""
        for name, bracket in re.findall(r"\b([A-Za-z]\w*)(\[?)", text):
            if name != "ROW" and name not in self._offsets.values():
                self._arguments[name] = "const long *restrict " if bracket else "long "

    def __call__(self, n: Any, **given: Any) -> Symbol:
        """Let a procedure run it over n items, given from the first one on; returns its count."""
        record, known = recording(), {"n": n, **given}
        values = [known[name] for name in sorted(self._arguments)]
        call = f"{self.name}({', '.join(['{}'] * len(values))});"
        record.line(f"const long {(name := record.new('n'))} = {call}", *values)
        record.stores += 1
        record.kernels[self.text] = None
        return record.given(name, kind="long")

    @cached_property
    def text(self) -> str:
        record, values = self.record, [symbol for _, symbol in self._stores]
        if not record.exact:
            record, values = without_halves(values)
        stores = [Line(f"{place} {{}};", (v,)) for (place, _), v in zip(self._stores, values)]
        before = [symbol for symbol in record.items if symbol.uniform]
        within = [symbol for symbol in record.items if not symbol.uniform]
        counts = any(place == "counted +=" for place, _ in self._stores)
        before += [Line(f"const long {name} = {text};") for text, name in self._offsets.items()]
        simd = f"omp simd{' reduction(+ : counted)' * counts}"
        loop = Line(f"{'FEW_' * (self.few or counts)}ITEMS({simd},")
        items = [*before, loop, *within, *stores, Line(")")]
        given = ",\n    ".join(f"{kind}{name}" for name, kind in sorted(self._arguments.items()))
        head = f"/* {self.says} */", f"static NOINLINE long {self.name}(", f"    {given}) {{"
        lines = *head, "  long counted = 0;", *printed(items), "  return counted;", "}\n"
        return "\n".join(lines)


def _replaced(equations: Any, of: Callable[[float], Any]) -> Any:
    """Equations, nested tuples, with of(x) for each float x."""
    if isinstance(equations, float):
        return of(equations)
    if not isinstance(equations, tuple):
        return equations
    made = [_replaced(part, of) for part in equations]
    return type(equations)(*made) if hasattr(equations, "_fields") else tuple(made)


def floats_of(equations: Any) -> list[float]:
    """The floats of equations, in the order in which kernels take them as parameters."""
    found = list[float]()
    _replaced(equations, found.append)
    return found
