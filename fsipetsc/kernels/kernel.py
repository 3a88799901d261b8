"""A kernel: one loop over nodes, pairs, faces or particles, printed as a function in C.

A kernel says what is read at an item of the loop, which formula it goes through, and where the
result is stored. It is made once, on symbols (fsipetsc.kernels.symbols):

    kernel = Kernel("heat", "The flux of heat of each node.")
    w, per_J = kernel.read("w", ROWS, 6), kernel.read("per_J", ROWS, 1)
    gas = kernel.parameters(gas)
    kernel.store("flux", ROWS, gas.heat_flux(w, per_J))

Procedures (fsipetsc.kernels.procedure) call it, with its arguments by their names, and with others
that it does not take: ``heat(64, w=row, per_J=…, flux=…)``.

a*b + c is printed as fma(a, b, c) where nothing else takes a*b, and compilers are told to fuse
nothing else (fsipetsc.kernels.build). So every node has the same bits in a vector and alone, with
any compiler and instruction set. What depends on parameters alone is computed before the loop.
"""

from collections.abc import Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from fsipetsc.kernels.halves import without_halves
from fsipetsc.kernels.recording import Index, Line, index_of, printed, recording
from fsipetsc.kernels.symbols import Record, Symbol


class Layout(NamedTuple):
    """How far components of an item, and items, are apart in an array: expressions in C.

    given: the first is a name of a number that the caller gives.
    """

    component: str
    item: str = "1"
    given: bool = False


#: rows of a tile: a component after the other, ROW apart, a constant
ROWS = Layout("ROW")
#: planes of a block: a component after the other, N apart, which the caller gives
PLANES = Layout("N", given=True)
#: planes of the nodes that a rank owns, M apart
OWNED = Layout("M", given=True)
#: one number that all items share
SHARED = Layout("1", "0")


def interlaced(count: str) -> Layout:
    """The numbers of an item side by side; count: how many an item has."""
    return Layout("1", count)


class Kernel:
    """See the head of this file. name: of the function in C; says: a sentence on what it does.
    counted: the condition that it counts, if any.
    """

    def __init__(self, name: str, says: str) -> None:
        self.name, self.says, self.record = name, says, Record()
        self._arguments = {"n": "long "}
        self._stores: list[tuple[str, Symbol]] = []
        self.counted: Symbol | None = None
        self._distances: dict[str, str] = {}
        self._parameters = 0

    # what is read

    def read(
        self, array: str, layout: Layout, count: int, first: int = 0, far: tuple[str, int] = ("", 0)
    ) -> tuple[Symbol, ...]:
        """The components ``first`` and so on of an item, or of one that is far from it: an array of
        whole numbers says how far, which one.
        """
        self._argument(array, "const double *", layout)
        item, (distances, number) = "i", far
        if distances:
            self._argument(distances, "const long *")
            self._distances[f"{distances}_{number}"] = f"{distances}[{number}]"
            item = f"(i + {distances}_{number})"
        places = (_place(array, layout, first + c, item) for c in range(count))
        return tuple(self.record.given(place, layout.item == "0") for place in places)

    def number(self, name: str) -> Symbol:
        """A number that all items share."""
        self._argument(name, "double ")
        return self.record.given(name, uniform=True)

    def parameters(self, equations: Any) -> Any:
        """The same equations with their floats as arguments of the kernel: the array p, in the
        order of fsipetsc.kernels.kernel.numbers_of. Other numbers (int, bool) become text.
        """
        if isinstance(equations, float):
            self._argument("p", "const double *")
            self._parameters += 1
            return self.record.given(f"p[{self._parameters - 1}]", uniform=True)
        if isinstance(equations, tuple):
            made = [self.parameters(part) for part in equations]
            return type(equations)(*made) if hasattr(equations, "_fields") else tuple(made)
        return equations

    # what is written

    def store(self, array: str, layout: Layout, values: Sequence[Any], first: int = 0) -> None:
        """Store values as the components ``first`` and so on of an item."""
        self._argument(array, "double *", layout)
        for c, value in enumerate(values):
            place = _place(array, layout, first + c, "i")
            self._stores.append((f"{place} =", self.record.constant(value)))

    def add(self, array: str, layout: Layout, values: Sequence[Any], first: int = 0) -> None:
        """Add values to the components ``first`` and so on of an item."""
        before = self.read(array, layout, len(values), first)
        self.store(array, layout, [a + b for a, b in zip(before, values, strict=True)], first)

    def count(self, condition: Any) -> None:
        """Let the function return for how many items a condition holds."""
        self.counted = self.record.constant(condition)
        self._stores.append(("counted +=", self.counted))

    def _argument(self, name: str, kind: str, layout: Layout = SHARED) -> None:
        known = self._arguments.get(name, "")
        if kind == "double *" or not known:
            self._arguments[name] = kind
        if layout.given:
            self._arguments[layout.component] = "long "

    # in procedures

    def __call__(self, n: Any, **given: Any) -> Index | None:
        """Let a procedure run the kernel over n items. An array is given from its first item on.
        Returns how many items were counted, of a kernel that counts.
        """
        record, texts, values = recording(), list[str](), list[Symbol]()
        given = {"n": n, **given}
        for one in (given[name] for name in sorted(self._arguments)):
            if isinstance(one, Symbol):
                texts.append(f"{{{len(values)}}}")
                values.append(one)
            else:
                texts.append(str(one.pointer() if hasattr(one, "pointer") else index_of(one)))
        counted = None if self.counted is None else Index(record.new("n"))
        result = "" if counted is None else f"const long {counted} = "
        record.line(f"{result}{self.name}({', '.join(texts)});", values)
        record.stores += 1
        return counted

    # what is printed

    def text(self) -> str:
        """The function in C."""
        values = [symbol for _, symbol in self._stores]
        record, values = without_halves(self.record, values)
        stores = [Line(f"{place} {{0}};", (v,)) for (place, _), v in zip(self._stores, values)]
        before = [symbol for symbol in record.symbols if symbol.uniform]
        within = [symbol for symbol in record.symbols if not symbol.uniform]
        counts = self.counted is not None
        loop = f'ITEMS("omp simd{" reduction(+ : counted)" * counts}",'
        items = *before, Line(loop, inside=1), *within, *stores, Line(")", inside=-1)
        arguments = sorted(self._arguments.items())
        given = (f"{kind}{'restrict ' * (kind[-1] == '*')}{name}" for name, kind in arguments)
        return "\n".join(
            [
                f"/* {self.says} */",
                f"static NOINLINE {'long' if counts else 'void'} {self.name}(",
                "    " + ",\n    ".join(given) + ") {",
                *(f"  const long {name} = {text};" for name, text in self._distances.items()),
                *["  long counted = 0;"] * counts,
                *printed(record, items, values),
                *["  return counted;"] * counts,
                "}\n",
            ]
        )


def numbers_of(equations: Any) -> list[float]:
    """The floats of equations, in the order in which kernels take them as parameters."""
    if isinstance(equations, float):
        return [equations]
    if isinstance(equations, tuple):
        return [number for part in equations for number in numbers_of(part)]
    return []


def _place(array: str, layout: Layout, component: int, item: str) -> str:
    """Return the C expression of where a number stands."""
    terms = []
    for factor, step in ((str(component), layout.component), (item, layout.item)):
        if "0" not in (factor, step):
            terms.append(factor if step == "1" else f"{factor} * {step}")
    return f"{array}[{' + '.join(terms) or '0'}]"


def unit(*texts: str) -> str:
    """Return the text of a translation unit."""
    return "\n".join([c_source("fsipetsc.kernels", "prelude.h"), *texts])


def c_source(package: str, name: str) -> str:
    """Return the text of a C file in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")
