"""What is recorded of loops, and how it is printed: lines of C, the symbols that they take, whole
numbers that are known only when C runs. See fsipetsc.kernels.loops.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.kernels.symbols import CONDITIONS, Record, Symbol, refuse, uses_of


def _operator(form: str, neutral: int | None = None) -> Any:
    """An operator; with its neutral number an Index is itself."""
    return lambda self, other: self if is_whole(other, neutral) else _made(form, self, other)


def _compared(sign: str) -> Any:
    """The operator of a comparison, whose result is a condition."""

    def compare(self: "Index", other: Any) -> Symbol:
        return recording().given(f"{self} {sign} {index_of(other)}", operation="holds")

    return compare


class Index:
    """A whole number, or an address, that is known only when C runs: an expression in C."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text

    __add__, __radd__ = _operator("({} + {})", 0), _operator("({1} + {0})", 0)
    __sub__, __rsub__ = _operator("({} - {})", 0), _operator("({1} - {0})")
    __floordiv__, __mod__ = _operator("quotient({}, {})", 1), _operator("remainder_of({}, {})")

    def __mul__(self, other: Any) -> Any:
        if is_whole(other, 0):
            return 0
        return self if is_whole(other, 1) else _made("({} * {})", self, other)

    __rmul__ = __mul__

    def __neg__(self) -> Any:
        return _made("(-{})", self)

    __eq__, __ne__ = _compared("=="), _compared("!=")
    __lt__, __le__, __gt__, __ge__ = map(_compared, ("<", "<=", ">", ">="))

    def __array_ufunc__(self, function: Any, method: str, *given: Any, **more: Any) -> Any:
        forms = {np.minimum: "least({}, {})", np.maximum: "most({}, {})"}
        if function in forms:
            return _made(forms[function], *given)
        raise refuse(f"np.{function.__name__} of a whole number cannot be recorded")

    def __bool__(self) -> bool:
        raise refuse("it branches on a number that is not known yet: write `with when(condition):`")

    def __index__(self) -> int:
        raise refuse("a number that is not known yet is no range and no length: write each(n)")

    __int__ = __float__ = __index__  # type: ignore[assignment]

    def __hash__(self) -> int:
        return hash(self.text)


def is_whole(value: Any, number: int | None) -> bool:
    """Whether a value is this whole number, which is known when it is recorded."""
    return isinstance(value, Integral) and int(value) == number


def index_of(value: Any) -> Index:
    """Return a whole number, or where an array begins, as C has it."""
    value = value.pointer() if hasattr(value, "pointer") else value
    if isinstance(value, Index):
        return value
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise refuse(f"{value!r} is no whole number")
    return Index(str(int(value)) if value >= 0 else f"({int(value)})")


def _made(form: str, *given: Any) -> Index:
    return Index(form.format(*map(index_of, given)))


# --- what is recorded


class Line(NamedTuple):
    """A line of C. form: has {} where values, or texts, stand."""

    form: str
    values: tuple[Any, ...] = ()


class Recording(Record):
    """The symbols and lines of a procedure; a symbol is known between the braces where it was made.

    items: Symbols and Lines in their order, wanted: the symbols that lines take. stores: how many
    there were, as what is read after one may be another number.
    """

    def __init__(self) -> None:
        super().__init__()
        self.items, self.wanted, self._within = list[Any](), list[Symbol](), [list[Any]()]
        self.stores, self.count = 0, 0

    def _keep(self, key: Any, made: Symbol) -> None:
        super()._keep(key, made)
        self.items.append(made)
        self._within[-1].append(key)

    def number_at(self, place: str) -> Symbol:
        """The number that C has at a place, which is read once between stores."""
        return self.given(place, stores=self.stores)

    def whole_at(self, place: str) -> Any:
        """The whole number that C has at a place, which is read once between stores."""
        key = "read", place, self.stores
        if key not in self._known:
            self._known[key] = self.whole(place)
            self._within[-1].append(key)
        return self._known[key]

    def line(self, form: str, *values: Any) -> None:
        """Record a line with numbers and whole numbers."""
        known = [v if isinstance(v, Index) else self.constant(v) for v in values]
        self.wanted += [value for value in known if isinstance(value, Symbol)]
        self.items.append(Line(form, tuple(known)))

    def store(self, place: str, value: Any) -> None:
        """Let C store a number, or a whole one, at a place."""
        self.line(f"{place} = {{}};", value)
        self.stores += 1

    def new(self, letter: str) -> str:
        """A name that nothing else has."""
        self.count += 1
        return f"{letter}{self.count}"

    def whole(self, form: str, *values: Any) -> Index:
        """A whole number that C computes once and keeps under a name."""
        name = self.new("n")
        self.line(f"const long {name} = {form};", *values)
        return Index(name)

    def open(self, head: str) -> None:
        self.line(f"{head} {{{{")
        self._within.append([])

    def close(self) -> None:
        self.line("}}")
        self.stores += 1  # what was stored within may be read after it
        for key in self._within.pop():
            del self._known[key]


_recordings: list[Recording] = []


@contextmanager
def recorded() -> Iterator[Recording]:
    """Give a recording of all that is done within."""
    _recordings.append(record := Recording())
    try:
        yield record
    finally:
        _recordings.pop()


def recording() -> Recording:
    if not _recordings:
        raise refuse("each, when, stop and variable are for procedures that are recorded")
    return _recordings[-1]


# --- what is printed

#: what an operation is in C, if it is no function; also sums that are fused with a product
_FORMS = {
    **{name: f"{{0}} {name} {{1}}" for name in ("+", "-", "*", "/", *"<>", "<=", ">=", "==", "!=")},
    **{"&": "{0} & {1}", "|": "{0} | {1}", "not": "!{0}"},
    **{"neg": "-{0}", "abs": "fabs({0})", "sqrt": "sqrt({0})", "where": "{0} ? {1} : {2}"},
    **{"a b + c": "fma({0}, {1}, {2})", "a b - c": "fma({0}, {1}, -{2})"},
    "c - a b": "fma(-{0}, {1}, {2})",
}


def printed(
    record: Record, items: Iterable[Any], wanted: Sequence[Symbol], named: Iterable[Symbol] = ()
) -> list[str]:
    """Lines of C: the lines among the items, and before them each symbol that is needed for what is
    wanted, where it was made. named: symbols whose text is a name in C.
    """
    names = {symbol.number: symbol.text for symbol in named}
    constants = (symbol for symbol in record.symbols if symbol.value is not None)
    names.update((symbol.number, _constant(symbol.value)) for symbol in constants)
    uses, lines, inside = uses_of(wanted), list[str](), 1
    sums = (symbol for symbol in record.symbols if symbol.number in uses)
    fused = {symbol.number: found for symbol in sums if (found := _fused(symbol, uses))}
    left_out = {*names, *(product.number for product, *_ in fused.values())}
    for item in items:
        if isinstance(item, Line):
            given = (names[v.number] if isinstance(v, Symbol) else v for v in item.values)
            text = item.form.format(*given)
        elif item.number in uses and item.number not in left_out:
            plain = None, item.operation, item.operands
            _, operation, operands = fused.get(item.number, plain)
            given = [names[operand.number] for operand in operands]
            form = _FORMS.get(operation, f"{operation}_({', '.join(given)})")
            kind = "int" if item.operation in CONDITIONS else "double"
            text = f"const {kind} t{item.number} = {item.text or form.format(*given)};"
            names[item.number] = f"t{item.number}"
        else:
            continue
        inside -= text.startswith(("}", ")"))
        lines.append("  " * inside + text)
        inside += text.endswith(("{", ","))
    return lines


def _fused(symbol: Symbol, uses: dict[int, int]) -> Any:
    """The product that a sum is fused with, its last operand that nothing else takes, and operation
    and operands of both; None if there is none. What is exact is not fused.
    """
    exact = symbol.record.exact
    if symbol.operation not in ("+", "-") or symbol.number in exact:
        return None
    first, second = symbol.operands
    for product, other, minus in ((second, first, "c - a b"), (first, second, "a b - c")):
        alone = product.operation == "*" and uses[product.number] == 1
        if alone and not product.uniform and product.number not in exact:
            operation = "a b + c" if symbol.operation == "+" else minus
            return product, operation, (*product.operands, other)
    return None


def _constant(value: float | None) -> str:
    """A constant in C, to the last bit."""
    text = repr(value)
    text = {"inf": "INFINITY", "-inf": "(-INFINITY)", "nan": "NAN"}.get(text, text)
    return f"({text})" if text[0] == "-" else text
