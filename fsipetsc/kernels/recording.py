"""What a procedure records: blocks of lines between braces, and whole numbers known only when C
runs. See fsipetsc.kernels.loops.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.kernels.symbols import Record, Symbol, refuse


def _compared(sign: str) -> Any:
    """The operator of a comparison, whose result is a condition."""

    def compare(self: "Index", other: Any) -> Symbol:
        found = _made(f"{{}} {sign} {{}}", self, other)
        return recording().symbol(("holds", found.text), found.text, found.needs, "holds")

    return compare


class Index:
    """A whole number that is known only when C runs: an expression in C, and the symbols in it."""

    __slots__ = ("needs", "text")

    def __init__(self, text: str, needs: tuple[Symbol, ...] = ()) -> None:
        self.text, self.needs = text, needs

    def __add__(self, other: Any) -> Any:
        return self if _is(other, 0) else _made("({} + {})", self, other)

    def __radd__(self, other: Any) -> Any:
        return self if _is(other, 0) else _made("({} + {})", other, self)

    def __sub__(self, other: Any) -> Any:
        return self if _is(other, 0) else _made("({} - {})", self, other)

    def __rsub__(self, other: Any) -> Any:
        return _made("({} - {})", other, self)

    def __mul__(self, other: Any) -> Any:
        if _is(other, 0):
            return 0
        return self if _is(other, 1) else _made("({} * {})", self, other)

    __rmul__ = __mul__

    def __floordiv__(self, other: Any) -> Any:
        return self if _is(other, 1) else _made("quotient({}, {})", self, other)

    def __mod__(self, other: Any) -> Any:
        return _made("remainder_of({}, {})", self, other)

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


def _is(value: Any, number: int) -> bool:
    return isinstance(value, (int, np.integer)) and int(value) == number


def index_of(value: Any) -> Index:
    if isinstance(value, Index):
        return value
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise refuse(f"{value!r} is no whole number")
    return Index(str(int(value)) if value >= 0 else f"({int(value)})")


def _made(form: str, *given: Any) -> Index:
    of = [index_of(value) for value in given]
    return Index(form.format(*(i.text for i in of)), tuple(n for i in of for n in i.needs))


# --- what is recorded


class Block:
    """Lines between braces, and the symbols that are known there, by a key."""

    def __init__(self, head: str, needs: tuple[Symbol, ...] = ()) -> None:
        self.head, self.needs = head, needs
        self.items: list[Any] = []
        self.known: dict[Any, Any] = {}


class Line(NamedTuple):
    """A line of C. form: has {0}, {1} … where values stand; needs: symbols that places have."""

    form: str
    values: tuple[Symbol, ...]
    needs: tuple[Symbol, ...]


class Recording(Record):
    """The blocks of a procedure; a symbol is known in the block that made it, and within."""

    def __init__(self) -> None:
        super().__init__()
        self.blocks = [Block("")]
        self.stores, self.count = 0, 0

    def known(self, key: Any) -> Any:
        """What has been recorded under a key, in this block or one around it; None if nothing."""
        of = (block.known[key] for block in self.blocks if key in block.known)
        return next(of, None)

    def _one(self, key: Any, operation: str, operands: tuple[Symbol, ...] = ()) -> Symbol:
        found: Symbol | None = self.known(key)
        if found is not None:
            return found
        symbol = Symbol(self, operation, operands)
        self.symbols.append(symbol)
        self.blocks[-1].known[key] = symbol
        self.blocks[-1].items.append(symbol)
        return symbol

    def symbol(
        self, key: Any, text: str, needs: tuple[Symbol, ...] = (), operation: str = "given"
    ) -> Symbol:
        """A symbol that C computes as ``text``; the operation "holds" makes it a condition."""
        symbol = self._one(key, operation, needs)
        symbol.text, symbol.uniform = text, False
        return symbol

    def line(self, form: str, values: Sequence[Any] = (), needs: tuple[Symbol, ...] = ()) -> None:
        """Record a line, as a store."""
        self.blocks[-1].items.append(Line(form, tuple(map(self.constant, values)), needs))

    def new(self, letter: str) -> str:
        """A name that nothing else has."""
        self.count += 1
        return f"{letter}{self.count}"

    def open(self, head: str, needs: tuple[Symbol, ...] = ()) -> None:
        self.blocks[-1].items.append(block := Block(head, needs))
        self.blocks.append(block)

    def close(self) -> None:
        self.stores += 1  # what was stored within may be read after it
        self.blocks.pop()


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
