"""Loops over nodes, faces and members that are recorded, for fsipetsc.kernels.procedure.

Numbers that differ from node to node are Symbols (fsipetsc.kernels.symbols), and formulas of them
are recorded as in a kernel. So are whole numbers that are known only later, as sizes and places in
arrays. Bools, None, `Known` numbers and the lengths of tuples are known when a procedure is
recorded: ``if`` and ``range`` of them are plain Python, and decide what is printed. So it is with
dataclasses, which hold facts: their numbers become constants of the text.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from itertools import accumulate, count, zip_longest
from math import prod
from operator import mul
from typing import Any

import numpy as np

from fsipetsc.kernels.printing import Line
from fsipetsc.kernels.symbols import Record, Symbol, refuse

#: of whole numbers that are known
WHOLE = int, np.integer
_arrays = count()  # of `zeros` so far


class Known(int):
    """A whole number of a record that is known when procedures are recorded, such as the number of
    dimensions: it says how many numbers tuples have, and what is unrolled.
    """


class Recording(Record):
    """The symbols and lines of a procedure; a symbol is known between the braces where it was made.

    latest: the one that was begun last, which is at work. items: symbols and Lines, in their order.
    stores: how many there were, as what is read after one may be another number. kernels: the texts
    of those that are called.
    """

    latest: "Recording"

    def __init__(self) -> None:
        super().__init__()
        Recording.latest = self
        self.stores, self.kernels = 0, dict[str, None]()

    def whole(self, value: Any) -> Symbol:
        return self.constant(value, whole=True)

    def line(self, form: str, *values: Any) -> None:
        """Record a line with numbers, whole numbers, and where arrays begin."""
        known = (v.pointer() if isinstance(v, Array) else v for v in values)
        self.items.append(Line(form, tuple(self.constant(v, isinstance(v, WHOLE)) for v in known)))

    def store(self, form: str, *values: Any) -> None:
        """Let C store the last one of values."""
        self.line(f"{form} = {{}};", *values)
        self.stores += 1

    def new(self, letter: str) -> str:
        """A name that nothing else has."""
        return f"{letter}{len(self.items)}"

    @contextmanager
    def block(self, head: str, *values: Any) -> Iterator[None]:
        """What is recorded within stands between braces, and is known there alone."""
        self.line(f"{head} {{{{", *values)
        before, self._known = self._known, {**self._known}
        yield
        self.line("}}")
        self.stores += 1  # what was stored within may be read after it
        self._known = before


def recording() -> Recording:
    return Recording.latest


def each(*ends: Any, vector: bool = False) -> Iterator[Symbol]:
    """A loop whose number goes from 0, or from the first of two ends, to below the last end. It
    ends by `stop`, not by break. vector: its passes do not depend on one another.
    """
    record = recording()
    first, last = map(record.whole, ends if len(ends) == 2 else (0, *ends))
    i = record.new("i")
    if vector:
        record.line("#pragma omp simd")
    record.stores += 1  # what is read in the first pass may be stored before the next one
    with record.block(f"for (long {i} = {{}}; {i} < {{}}; ++{i})", first, last):
        yield record.given(i, kind="long")


def tally(first: Any, last: Any, holds: Callable[[Symbol], Any]) -> Symbol:
    """Return for how many numbers i, from a first one to below the last, holds(i) is true."""
    record = recording()
    record.line(f"long {(found := record.new('n'))} = 0;")
    record.line(f"#pragma omp simd reduction(+ : {found})")
    for i in each(first, last):
        record.line(f"{found} += {{}};", holds(i))
    return record.given(found, kind="long", stores=record.stores)


def when(condition: Any) -> AbstractContextManager[None]:
    """C does what is recorded within if a condition holds."""
    return recording().block("if ({})", condition)


def otherwise() -> AbstractContextManager[None]:
    """C does what is recorded within if the condition of the `when` just before does not hold."""
    return recording().block("else")


def stop(condition: Any) -> None:
    """End the innermost loop if a condition holds."""
    recording().line("if ({}) break;", condition)


def pick(condition: Any, a: Any, b: Any) -> Symbol:
    """a if the condition holds, else b; both are whole numbers."""
    whole = recording().whole
    return recording().apply("where", condition, whole(a), whole(b))


def either(condition: Any, a: "Array", b: "Array") -> "Array":
    """The array a if the condition holds, else b; as a flat array, whose size is not known."""
    return Array(recording().apply("where", condition, a.pointer(), b.pointer()), (None,))


def whole(value: Any) -> Symbol:
    """Return a number whose value is whole as a whole number."""
    return recording().given("(long){}", value, kind="long")


def number(index: Any) -> Symbol:
    """Return a whole number as a number that formulas take."""
    return recording().given("(double){}", recording().whole(index))


class variable:
    """A number that changes: its value is read, or stored, at that place of the procedure."""

    def __init__(self, first: Any = 0.0) -> None:
        self._record, self._name = recording(), recording().new("v")
        self._record.line(f"double {self._name} = {{}};", first)

    @property
    def value(self) -> Any:
        return self._record.given(self._name, stores=self._record.stores)

    @value.setter
    def value(self, number: Any) -> None:
        self._record.store(self._name, number)


def column(size: int, array: Any, n: Any, first: Any = 0) -> Any:
    """Return so many numbers array[first + c, n]."""
    return tuple(array[first + c, n] for c in range(size))


def row(size: int, array: Any, n: Any, first: Any = 0) -> Any:
    """Return so many numbers array[n, first + c]."""
    return tuple(array[n, first + c] for c in range(size))


def zeros(shape: Any) -> np.ndarray:
    """Return zeros of this shape, from a multiple of 64 bytes on, as vector loads like it; eight
    numbers before and after them may be read. Each array begins at another place in a page, so that
    what several have of a node does not compete for the same lines of a cache. numpy asks for large
    pages for what it fills, not for np.zeros: steps on large grids take some 4 % less time.
    """
    size = int(np.prod(shape))
    raw = np.full(size + 512, 0.0)
    first = 8 + -(raw.ctypes.data // 8) % 8 + 64 * (next(_arrays) % 7)
    return raw[first : first + size].reshape(shape)


class Array:
    """The stand-in of an array, or of a part of one. base: where the whole array begins. shape:
    (None,) of one whose size is not known. at: terms of the number at which the part begins. steps:
    how far its numbers are apart along each axis, if not as in a whole array.
    """

    def __init__(self, base: Symbol, shape: Sequence[Any], at: Any = (), steps: Any = ()) -> None:
        self._base, self.shape, self._at, self._apart = base, tuple(shape), tuple(at), steps

    @property
    def _steps(self) -> tuple[Any, ...]:
        return self._apart or tuple(accumulate(self.shape[:0:-1], mul, initial=1))[::-1]

    @property
    def size(self) -> Any:
        return prod(self.shape)

    @property
    def T(self) -> "Array":
        return Array(self._base, self.shape[::-1], self._at, self._steps[::-1])

    def reshape(self, *shape: Any) -> "Array":
        """The same numbers, which lie behind one another, in rows of other lengths; -1: all."""
        unknown = [isinstance(length, WHOLE) and length < 0 for length in shape]
        if unknown == [True]:
            shape = (self.size,)
        elif any(unknown):
            raise refuse("-1 is the length of one axis alone: name all lengths")
        whole = Array(self._base, self.shape)
        if any(a is not b for a, b in zip(self._steps, whole._steps, strict=True)):
            raise refuse("the numbers of this part of an array do not lie behind one another")
        return Array(self._base, shape, self._at)

    def _first(self) -> tuple[str, list[Symbol]]:
        """The number at which it begins, as a form with terms: the same for the same terms."""
        known = (term for term in map(recording().whole, self._at) if term.value != 0)
        terms = sorted(known, key=lambda term: term.number)
        return " + ".join(["{}"] * len(terms)) or "0", terms

    def pointer(self) -> Symbol:
        """Where C has the first number."""
        form, terms = self._first()
        return recording().given(f"{{}} + {form}", self._base, *terms, kind=self._base.kind)

    def _part(self, at: Any) -> "Array":
        """The part, of no axes if it is a number, at an index or at several."""
        begin, shape, steps = [*self._at], list[Any](), list[Any]()
        indices = at if isinstance(at, tuple) else (at,)
        every = zip_longest(indices, self.shape, self._steps, fillvalue=slice(None))
        for index, length, step in every:
            is_part = isinstance(index, slice)
            ends = (index.start, index.stop) if is_part else (index, None)
            first, last = (length + n if isinstance(n, WHOLE) and n < 0 else n for n in ends)
            if first is not None:
                begin.append(first * step)
            if is_part:
                last = length if last is None else last
                shape.append(last if first is None else last - first)
                steps.append(step)
        return Array(self._base, shape, begin, tuple(steps))

    def __getitem__(self, at: Any) -> Any:
        part = self._part(at)
        if part.shape:
            return part
        form, terms = part._first()
        record, kind = recording(), self._base.kind.removesuffix(" *")
        return record.given(f"{{}}[{form}]", self._base, *terms, kind=kind, stores=record.stores)

    def __setitem__(self, at: Any, value: Any) -> None:
        """Store a number, a tuple of the numbers of an axis, or the same one everywhere."""
        part = self._part(at)
        if isinstance(value, tuple):
            if isinstance(part.shape[0], WHOLE) and part.shape[0] != len(value):
                raise refuse(f"{len(value)} numbers for {part.shape[0]}")
            for c, one in enumerate(value):
                part[c] = one
        elif part.shape:
            for i in each(part.shape[0], vector=len(part.shape) == 1):
                part[i] = value
        else:
            form, terms = part._first()
            value = recording().constant(value, self._base.kind == "long *")
            recording().store(f"{{}}[{form}]", self._base, *terms, value)
