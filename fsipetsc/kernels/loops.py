"""Loops over nodes, faces and members that are recorded, for procedures
(fsipetsc.kernels.procedure).

Numbers that differ from node to node are Symbols (fsipetsc.kernels.symbols), and formulas of them
are recorded as in a kernel. Whole numbers that are known only later, as sizes and places in
arrays, are an Index. Bools, None and the lengths of tuples are known when a procedure is
recorded: ``if`` and ``range`` of them are plain Python, and decide what is printed. So it is with
dataclasses, which hold facts: their numbers become constants of the text.
"""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import reduce
from itertools import accumulate, zip_longest
from typing import Any

import numpy as np

from fsipetsc.kernels.printing import Line
from fsipetsc.kernels.symbols import Record, Symbol, refuse

#: of whole numbers that are known; to ask for numbers.Integral takes 20 times as long
WHOLE = int, np.integer


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
        return _made({np.minimum: "least({}, {})", np.maximum: "most({}, {})"}[function], *given)

    def __bool__(self) -> bool:
        raise refuse("it branches on a number that is not known yet: write `with when(condition):`")


def is_whole(value: Any, number: int | None) -> bool:
    """Whether a value is this whole number, which is known when it is recorded."""
    return isinstance(value, WHOLE) and int(value) == number


def index_of(value: Any) -> Index:
    """Return a whole number, or where an array begins, as C has it."""
    value = value.pointer() if isinstance(value, Array) else value
    if isinstance(value, Index):
        return value
    if isinstance(value, bool) or not isinstance(value, WHOLE):
        raise refuse(f"{value!r} is no whole number")
    return Index(str(int(value)) if value >= 0 else f"({int(value)})")


def _made(form: str, *given: Any) -> Index:
    return Index(form.format(*map(index_of, given)))


class Recording(Record):
    """The symbols and lines of a procedure; a symbol is known between the braces where it was made.

    items: Symbols and Lines in their order. stores: how many there were, as what is read after one
    may be another number.
    """

    def __init__(self) -> None:
        super().__init__()
        self.items, self._within = list[Symbol | Line](), [list[Any]()]
        self.stores, self.count = 0, 0

    def __enter__(self) -> "Recording":
        _recordings.append(self)
        return self

    def __exit__(self, *error: object) -> None:
        _recordings.pop()

    def _keep(self, key: Any, made: Symbol) -> None:
        super()._keep(key, made)
        self.items.append(made)
        self._within[-1].append(key)

    def read(self, place: str, is_whole: bool = False) -> Any:
        """The number, or whole number, that C has at a place: it is read once between stores."""
        if not is_whole:
            return self.given(place, stores=self.stores)
        key = "read", place, self.stores
        if key not in self._known:
            self._known[key] = self.whole(place)
            self._within[-1].append(key)
        return self._known[key]

    def line(self, form: str, *values: Any) -> None:
        """Record a line with numbers and whole numbers."""
        known = (v if isinstance(v, Index) else self.constant(v) for v in values)
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

    @contextmanager
    def block(self, head: str, *values: Any) -> Iterator[None]:
        """What is recorded within stands between braces, and is known there alone."""
        self.line(f"{head} {{{{", *values)
        self._within.append([])
        yield
        self.line("}}")
        self.stores += 1  # what was stored within may be read after it
        for key in self._within.pop():
            del self._known[key]


_recordings: list[Recording] = []


def recording() -> Recording:
    """The recording of the procedure that runs."""
    return _recordings[-1]


#: of arrays: what a number is in C
KINDS = {"f": "double", "i": "long"}


def each(*ends: Any, vector: bool = False) -> Iterator[Index]:
    """A loop whose number goes from 0, or from the first of two ends, to below the last end. It
    ends by `stop`, not by break. vector: its passes do not depend on one another.
    """
    record = recording()
    first, last = map(index_of, ends if len(ends) == 2 else (0, *ends))
    i = record.new("i")
    if vector:
        record.line("#pragma omp simd")
    record.stores += 1  # what is read in the first pass may be stored before the next one
    with record.block(f"for (long {i} = {first}; {i} < {last}; ++{i})"):
        yield Index(i)


def when(condition: Any) -> AbstractContextManager[None]:
    """C does what is recorded within if a condition holds."""
    return recording().block("if ({})", condition)


def otherwise() -> AbstractContextManager[None]:
    """C does what is recorded within if the condition of the `when` just before does not hold."""
    return recording().block("else")


def stop(condition: Any) -> None:
    """End the innermost loop if a condition holds."""
    recording().line("if ({}) break;", condition)


def pick(condition: Any, a: Any, b: Any) -> Index:
    """a if the condition holds, else b; both are whole numbers."""
    return recording().whole("{} ? {} : {}", condition, index_of(a), index_of(b))


def either(condition: Any, a: "Array", b: "Array") -> "Array":
    """The array a if the condition holds, else b; as a flat array, whose size is not known."""
    name = recording().new("p")
    text = f"double *const {name} = {{}} ? {{}} : {{}};"
    recording().line(text, condition, index_of(a), index_of(b))
    return Array(name, a.dtype, (None,))


def named(index: Any) -> Index:
    """The same whole number, which C computes once and keeps under a name."""
    return recording().whole("{}", index_of(index))


def whole(value: Any) -> Index:
    """Return a number whose value is whole as an Index."""
    return recording().whole("(long){}", value)


def number(index: Any) -> Any:
    """Return a whole number as a number that formulas take."""
    return recording().given(f"(double){index_of(index)}")


class variable:
    """A number that changes, at first ``first``. Reading value gives the number at that place of
    the procedure; setting it stores.
    """

    def __init__(self, first: Any = 0.0) -> None:
        self._record, self._name = recording(), recording().new("v")
        self._record.line(f"double {self._name} = {{}};", first)

    @property
    def value(self) -> Any:
        return self._record.read(self._name)

    @value.setter
    def value(self, number: Any) -> None:
        self._record.store(self._name, number)


class Array:
    """The stand-in of an array, or of a part of one. shape: (None,) of one whose size is not known.
    at: terms of the number at which it begins. steps: how far its numbers are apart along each
    axis, if not as in a whole array.
    """

    def __init__(
        self, base: str, dtype: Any, shape: Sequence[Any], at: Sequence[Any] = (), steps: Any = ()
    ) -> None:
        self._base, self.dtype, self.shape, self._at = base, dtype, tuple(shape), tuple(at)
        behind = accumulate(self.shape[:0:-1], lambda step, length: length * step, initial=1)
        self._steps = tuple(steps or tuple(behind)[::-1])

    @property
    def size(self) -> Any:
        """How many numbers the array has."""
        return reduce(lambda size, length: length * size, self.shape, 1)

    @property
    def T(self) -> "Array":
        """The transpose."""
        return Array(self._base, self.dtype, self.shape[::-1], self._at, self._steps[::-1])

    def reshape(self, *shape: Any) -> "Array":
        """The same numbers, which lie behind one another, in rows of other lengths; -1 alone: as
        many as there are.
        """
        shape = (self.size,) if len(shape) == 1 and is_whole(shape[0], -1) else shape
        if any(is_whole(length, -1) for length in shape):
            raise refuse("-1 is the length of one axis alone: name all lengths")
        if str(self._steps) != str(Array(self._base, self.dtype, self.shape)._steps):
            raise refuse("the numbers of this part of an array do not lie behind one another")
        return Array(self._base, self.dtype, shape, self._at)

    def _first(self) -> str:
        """The number at which it begins: the same text for the same terms."""
        terms = sorted(str(index_of(term)) for term in self._at if not is_whole(term, 0))
        return " + ".join(terms) or "0"

    def pointer(self) -> Index:
        """Where C has the first number."""
        return Index(f"{self._base} + {self._first()}")

    def _part(self, at: Any) -> "Array":
        """The part, of no axes if it is a number, at an index or at several."""
        begin, shape, steps = [*self._at], list[Any](), list[Any]()
        indices = at if isinstance(at, tuple) else (at,)
        every = zip_longest(indices, self.shape, self._steps, fillvalue=slice(None))
        for index, length, step in every:
            ends = (index.start, index.stop) if isinstance(index, slice) else (index, None)
            first, last = (length + n if isinstance(n, WHOLE) and n < 0 else n for n in ends)
            begin.append(0 if first is None else first * step)
            if isinstance(index, slice):
                last = length if last is None else last
                shape.append(last if first is None else last - first)
                steps.append(step)
        return Array(self._base, self.dtype, shape, begin, steps)

    def __getitem__(self, at: Any) -> Any:
        part = self._part(at)
        if part.shape:
            return part
        return recording().read(f"{self._base}[{part._first()}]", self.dtype.kind == "i")

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
            value = index_of(value) if self.dtype.kind == "i" else value
            recording().store(f"{self._base}[{part._first()}]", value)


def invoke(name: str, address: Any, *arrays: Array) -> None:
    """Call a function in C of the same translation unit with an address, a whole number, and the
    pointers to the first numbers of arrays.
    """
    values = [index_of(value) for value in (address, *arrays)]
    recording().line(f"{name}((void *){', '.join(['{}'] * len(values))});", *values)
    recording().stores += 1
