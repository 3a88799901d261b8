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

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from fsipetsc.kernels.halves import without_halves
from fsipetsc.kernels.recording import Index, index_of, recording
from fsipetsc.kernels.symbols import CONDITIONS, Record, Symbol, uses_of


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


#: what an operation is in C
_FORMS = {
    **{name: f"{{0}} {name} {{1}}" for name in ("+", "-", "*", "/", *"<>", "<=", ">=", "==", "!=")},
    **{"&": "{0} & {1}", "|": "{0} | {1}", "not": "!{0}"},
    **{"neg": "-{0}", "abs": "fabs({0})", "sqrt": "sqrt({0})", "where": "{0} ? {1} : {2}"},
}


class Kernel:
    """See the head of this file. name: of the function in C; says: a sentence on what it does.
    counted: the condition that it counts, if any.
    """

    def __init__(self, name: str, says: str) -> None:
        self.name, self.says, self.record = name, says, Record()
        self._arguments: dict[str, str] = {}
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
            self._distances[f"{distances}_{number}"] = f"in->{distances}[{number}]"
            item = f"(i + {distances}_{number})"
        places = (_place(array, layout, first + c, item) for c in range(count))
        return tuple(self.record.given(place, layout.item == "0") for place in places)

    def number(self, name: str) -> Symbol:
        """A number that all items share."""
        self._argument(name, "double ")
        return self.record.given(f"in->{name}", uniform=True)

    def parameters(self, equations: Any) -> Any:
        """The same equations with their floats as arguments of the kernel: the array p, in the
        order of fsipetsc.kernels.kernel.numbers_of. Other numbers (int, bool) become text.
        """
        if isinstance(equations, float):
            self._argument("p", "const double *")
            self._parameters += 1
            return self.record.given(f"in->p[{self._parameters - 1}]", uniform=True)
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
            self._stores.append((place, self.record.constant(value)))

    def add(self, array: str, layout: Layout, values: Sequence[Any], first: int = 0) -> None:
        """Add values to the components ``first`` and so on of an item."""
        self._argument(array, "double *", layout)
        for c, value in enumerate(values):
            place = _place(array, layout, first + c, "i")
            before = self.record.given(place)
            self._stores.append((place, self.record.apply("+", before, value)))

    def count(self, condition: Any) -> None:
        """Let the function return for how many items a condition holds."""
        self.counted = self.record.constant(condition)

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
        record, texts, values, needs = recording(), list[str](), list[Symbol](), list[Symbol]()
        given = {"n": n, **given}
        for name in sorted({**self._arguments, "n": ""}):
            one = given[name]
            if isinstance(one, Symbol):
                texts.append(f".{name} = {{{len(values)}}}")
                values.append(one)
            else:
                place = one.pointer() if hasattr(one, "pointer") else index_of(one)
                texts.append(f".{name} = {place.text}")
                needs += place.needs
        counted = None if self.counted is None else Index(record.new("n"))
        result = f"const long {counted.text} = " if counted is not None else ""
        record.line(f"{result}{self.name}({', '.join(texts)});", values, tuple(needs))
        record.stores += 1
        return counted

    # what is printed

    def text(self) -> str:
        """The function in C, behind the struct of its arguments."""
        before, body = _lines(self.record, self._stores, self.counted)
        kind = "long" if self.counted is not None else "void"
        arguments = sorted({**self._arguments, "n": "long "}.items())
        members = [f"  {kind}{name};" for name, kind in arguments]
        locals_ = [
            f"  {kind}{'restrict ' * (kind[-1] == '*')}{name} = in->{name};"
            for name, kind in arguments
            if name != "p" and kind not in ("const long *", "double ")
        ]
        counts = self.counted is not None
        return "\n".join(
            [
                f"/* {self.says} */",
                f"struct {self.name}_in {{",
                *members,
                "};",
                f"static NOINLINE {kind} {self.name}_(const struct {self.name}_in *in) {{",
                *locals_,
                *(f"  const long {name} = {text};" for name, text in self._distances.items()),
                *(["  long counted = 0;"] if counts else []),
                *(f"  {line}" for line in before),
                f'  ITEMS("omp simd{" reduction(+ : counted)" if counts else ""}",',
                *(f"    {line}" for line in body),
                "  )",
                *(["  return counted;"] if counts else []),
                "}",
                f"#define {self.name}(...) {self.name}_(&(struct {self.name}_in){{__VA_ARGS__}})",
                "",
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


def _lines(
    record: Record, stores: Sequence[tuple[str, Symbol]], counted: Symbol | None
) -> tuple[list[str], list[str]]:
    """Lines before the loop and of its body: all symbols that stores need, in the order in which
    they were made.
    """
    wanted = [symbol for _, symbol in stores] + ([] if counted is None else [counted])
    record, wanted = without_halves(record, wanted)
    uses = uses_of(wanted)
    fused = fused_products(record, uses)
    before, body, names = [], [], {}
    for symbol in record.symbols:
        if symbol.number not in uses or symbol.number in fused.values():
            continue
        if symbol.operation == "constant":
            names[symbol.number] = _constant(symbol)
            continue
        text = line_of(symbol, fused, names)
        kind = "int" if symbol.operation in CONDITIONS else "double"
        names[symbol.number] = f"t{symbol.number}"
        lines = before if symbol.uniform else body
        lines.append(f"const {kind} t{symbol.number} = {text};")
    places = [f"{place} = " for place, _ in stores] + ["counted += "] * (counted is not None)
    body += [f"{p}{names[s.number]};" for p, s in zip(places, wanted, strict=True)]
    return before, body


def line_of(symbol: Symbol, fused: dict[int, int], names: dict[int, str]) -> str:
    """Return the C expression of a symbol. names: of its operands."""
    if symbol.number in fused:
        return _fma(symbol, fused[symbol.number], names)
    if symbol.operation == "constant":
        return _constant(symbol)
    if symbol.operation in ("given", "holds"):
        return symbol.text
    operands = [names[operand.number] for operand in symbol.operands]
    form = _FORMS.get(symbol.operation)
    call = f"{symbol.operation}_({', '.join(operands)})"
    return form.format(*operands) if form else call


def fused_products(record: Record, uses: dict[int, int]) -> dict[int, int]:
    """Sums -> the product that each is fused with: the last operand that nothing else takes. What
    is exact is not fused.
    """
    fused = {}
    for symbol in record.symbols:
        sums = symbol.operation in ("+", "-") and symbol.number not in record.exact
        if symbol.number in uses and sums:
            for operand in reversed(symbol.operands):
                alone = operand.operation == "*" and uses[operand.number] == 1
                if alone and not operand.uniform and operand.number not in record.exact:
                    fused[symbol.number] = operand.number
                    break
    return fused


def _fma(symbol: Symbol, product: int, names: dict[int, str]) -> str:
    """Return a sum or difference and the product among its operands as one operation."""
    first, second = symbol.operands
    factors = first if first.number == product else second
    other = names[(second if first.number == product else first).number]
    a, b = (names[factor.number] for factor in factors.operands)
    if symbol.operation == "+":
        return f"fma({a}, {b}, {other})"
    return f"fma({a}, {b}, -{other})" if factors is first else f"fma(-{a}, {b}, {other})"


def _constant(symbol: Symbol) -> str:
    """A constant in C, to the last bit."""
    text = repr(symbol.value)
    text = {"inf": "INFINITY", "-inf": "(-INFINITY)", "nan": "NAN"}.get(text, text)
    return f"({text})" if text[0] == "-" else text


# --- a translation unit

_HEAD = """#include <math.h>
#include <string.h>
#define NOINLINE __attribute__((noinline))
static inline long most(long a, long b) { return a > b ? a : b; }
static inline long least(long a, long b) { return a < b ? a : b; }
static inline long quotient(long a, long b) { return a / b - (a % b != 0 && (a < 0) != (b < 0)); }
static inline long remainder_of(long a, long b) { return a - b * quotient(a, b); }
/* A kernel's loop over items i. With vectors of eight numbers, those left over are one more vector
   whose other lanes are neither read nor stored: gcc would take them one by one. */
#ifdef __AVX512F__
#define ITEMS(simd, ...) \
  _Pragma(simd) for (long i = 0; i < (n & -8L); ++i) { __VA_ARGS__ } \
  if (n > 0 && n & 7) { \
    const long first_ = n & -8L; \
    _Pragma(simd) for (long lane_ = 0; lane_ < 8; ++lane_) { \
      const long i = first_ + lane_; \
      if (i < n) { __VA_ARGS__ } \
    } \
  }
#else
#define ITEMS(simd, ...) _Pragma(simd) for (long i = 0; i < n; ++i) { __VA_ARGS__ }
#endif
"""


def unit(constants: Mapping[str, int], kernels: Sequence[Kernel], *loops: str) -> str:
    """Return the text of a translation unit. loops: C code that calls the kernels."""
    defined = "".join(f"#define {name} {value}\n" for name, value in constants.items())
    printed = "\n".join(kernel.text() for kernel in kernels)
    return "\n".join([_HEAD + defined, c_source("fsipetsc.kernels", "prelude.h"), printed, *loops])


def c_source(package: str, name: str) -> str:
    """Return the text of a C file in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")
