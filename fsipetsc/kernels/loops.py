"""Loops over nodes, faces and members that are recorded, for procedures
(fsipetsc.kernels.procedure).

Numbers that differ from node to node are Symbols (fsipetsc.kernels.symbols), and formulas of them
are recorded as in a kernel. Whole numbers that are known only later, as sizes and places in
arrays, are an Index. Bools, None and the lengths of tuples are known when a procedure is
recorded: ``if`` and ``range`` of them are plain Python, and decide what is printed. So it is with
dataclasses, which hold facts: their numbers become constants of the text.

    each(n), each(a, b)     a loop; vector=True: its passes do not depend on one another
    when(c), otherwise()    what is done if a condition holds, and else
    stop(c)                 ends the innermost loop
    variable(0.0)           a number that changes: its ``value`` is read and set
    pick(c, a, b)           one of two whole numbers; either(c, a, b): one of two arrays
    named(i)                a whole number, computed once
    invoke("name", address, …) calls a function in C
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from fsipetsc.kernels.recording import Index, index_of, recording
from fsipetsc.kernels.symbols import refuse

#: of arrays: what a number is in C
KINDS = {"f": "double", "i": "long"}


def each(*ends: Any, vector: bool = False) -> Iterator[Index]:
    """A loop whose number goes from 0, or from the first of two ends, to below the last end."""
    record = recording()
    first, last = map(index_of, ends if len(ends) == 2 else (0, *ends))
    i = record.new("i")
    if vector:
        record.line("#pragma omp simd")
    record.stores += 1  # what is read in the first pass may be stored before the next one
    record.open(f"for (long {i} = {first}; {i} < {last}; ++{i})")
    yield Index(i)
    record.close()


@contextmanager
def when(condition: Any) -> Iterator[None]:
    """C does what is recorded within if a condition holds."""
    record = recording()
    if isinstance(condition, (bool, np.bool_)):
        raise refuse("the condition is known when it is recorded: write `if`")
    name = record.new("c")
    record.line(f"const int {name} = {{0}};", (condition,))
    record.open(f"if ({name})")
    yield
    record.close()


@contextmanager
def otherwise() -> Iterator[None]:
    """C does what is recorded within if the condition of the `when` just before does not hold."""
    recording().open("else")
    yield
    recording().close()


def stop(condition: Any) -> None:
    """End the innermost loop if a condition holds."""
    recording().line("if ({0}) break;", (condition,))


def pick(condition: Any, a: Any, b: Any) -> Index:
    """a if the condition holds, else b; both are whole numbers."""
    return recording().whole(f"{{0}} ? {index_of(a)} : {index_of(b)}", condition)


def either(condition: Any, a: "Array", b: "Array") -> "Array":
    """The array a if the condition holds, else b; as a flat array."""
    name = recording().new("p")
    text = f"double *const {name} = {{0}} ? {a.pointer()} : {b.pointer()};"
    recording().line(text, (condition,))
    return Array(name, a.dtype, (pick(condition, a.size, b.size),))


def named(index: Any) -> Index:
    """The same whole number, which C computes once and keeps under a name."""
    return recording().whole(f"{index_of(index)}")


def whole(value: Any) -> Index:
    """Return a number whose value is whole as an Index."""
    return recording().whole("(long){0}", value)


def number(index: Any) -> Any:
    """Return a whole number as a number that formulas take."""
    text = f"(double){index_of(index)}"
    return recording().symbol(("number", text), text)


class variable:
    """A number that changes, at first ``first``. Reading value gives the number at that place of
    the procedure; setting it stores.
    """

    def __init__(self, first: Any = 0.0) -> None:
        self._record, self._name = recording(), recording().new("v")
        self._record.line(f"double {self._name} = {{0}};", (first,))

    @property
    def value(self) -> Any:
        key = "variable", self._name, self._record.stores
        return self._record.symbol(key, self._name)

    @value.setter
    def value(self, number: Any) -> None:
        self._record.line(f"{self._name} = {{0}};", (number,))
        self._record.stores += 1


class Array(NDArrayOperatorsMixin):
    """The stand-in of an array, or of a part of one: numbers that lie behind one another."""

    def __init__(self, base: str, dtype: Any, shape: Sequence[Any], offset: Any = 0) -> None:
        self._base, self.dtype, self._offset = base, dtype, offset
        self.shape = tuple(shape)

    @property
    def size(self) -> Any:
        """How many numbers the array has."""
        total: Any = 1
        for length in self.shape:
            total = length * total
        return total

    def __len__(self) -> int:
        if isinstance(self.shape[0], int):
            return self.shape[0]
        raise refuse("the length of an array is not known yet: write its shape[0]")

    def reshape(self, *shape: Any) -> "Array":
        """The same numbers in rows of other lengths; -1: as many as there are."""
        shape = tuple(shape[0]) if len(shape) == 1 and isinstance(shape[0], tuple) else shape
        if -1 in [s for s in shape if isinstance(s, int)]:
            if len(shape) > 1:
                raise refuse("reshape knows -1 alone")
            shape = (self.size,)
        return Array(self._base, self.dtype, shape, self._offset)

    def pointer(self) -> Index:
        """Where C has the first number."""
        return Index(f"{self._base} + {index_of(self._offset)}")

    def turned(self) -> "Array":
        """The transpose of an array of two axes."""
        return _Turned(self)

    def _place(self, at: Any) -> tuple[Any, tuple[Any, ...]]:
        """Offset and shape of the number, or the part, at an index or at several."""
        at = at if isinstance(at, tuple) else (at,)
        offset, shape = self._offset, list(self.shape)
        if len(at) > len(shape):
            raise refuse(f"{len(at)} numbers for an array of {len(shape)} axes")
        steps: list[Any] = [1]
        for length in reversed(shape[1:]):
            steps.insert(0, length * steps[0])
        for k, one in enumerate(at):
            if isinstance(one, slice):
                if k != len(at) - 1 or one.step is not None:
                    raise refuse("a part of an array is a range of its last index that is given")
                first = self._from_end(k, 0 if one.start is None else one.start)
                last = self._from_end(k, self.shape[k] if one.stop is None else one.stop)
                return first * steps[k] + offset, (last - first, *self.shape[k + 1 :])
            offset = self._from_end(k, one) * steps[k] + offset
        return offset, self.shape[len(at) :]

    def _from_end(self, k: int, at: Any) -> Any:
        """An index of axis k; one below 0 counts from the end."""
        return self.shape[k] + at if isinstance(at, (int, np.integer)) and at < 0 else at

    def __getitem__(self, at: Any) -> Any:
        offset, shape = self._place(at)
        if shape:
            return Array(self._base, self.dtype, shape, offset)
        if self.dtype.names:
            return _Fields(self._base, self.dtype, offset)
        record, place = recording(), f"{self._base}[{index_of(offset)}]"
        key = "read", place, record.stores
        if KINDS[self.dtype.kind] == "double":
            return record.symbol(key, place)
        if record.known(key) is None:
            record.scopes[-1][key] = record.whole(place)
        return record.known(key)

    def __setitem__(self, at: Any, value: Any) -> None:
        offset, shape = self._place(at)
        if shape:
            part = Array(self._base, self.dtype, shape, offset)
            for i in each(part.size, vector=True):
                part.reshape(-1)[i] = value
            return
        place, kind = f"{self._base}[{index_of(offset)}]", KINDS[self.dtype.kind]
        if kind == "long":
            recording().line(f"{place} = {index_of(value)};")
        else:
            recording().line(f"{place} = {{0}};", (value,))
        recording().stores += 1

    def __array_ufunc__(self, function: Any, method: str, *given: Any, **more: Any) -> Any:
        raise refuse("an operation on a whole array: write a loop, `for i in each(n):`")

    __hash__ = None  # type: ignore[assignment]


class _Turned(Array):
    """The transpose of an array."""

    def __init__(self, of: Array) -> None:
        super().__init__(of._base, of.dtype, of.shape[::-1], of._offset)
        self._of = of

    def _place(self, at: Any) -> tuple[Any, tuple[Any, ...]]:
        if not isinstance(at, tuple) or len(at) != 2:
            raise refuse("a transpose takes two numbers")
        return self._of._place(at[::-1])

    def reshape(self, *shape: Any) -> Array:
        raise refuse("a transpose has no other shape")


class _Fields:
    """One row of an array of records: its fields by their names; those of several numbers are
    arrays.
    """

    def __init__(self, base: str, dtype: Any, row: Any) -> None:
        vars(self).update(_base=base, _dtype=dtype, _row=index_of(row))

    def _array(self, name: str) -> Array:
        kind, first = self._dtype.fields[name][:2]
        number, shape = kind.subdtype or (kind, (1,))
        start = f"{self._base} + {self._dtype.itemsize} * {self._row} + {first}"
        return Array(f"(({KINDS[number.kind]} *)({start}))", number, shape)

    def __getattr__(self, name: str) -> Any:
        found = self._array(name)
        return found if self._dtype.fields[name][0].subdtype else found[0]

    def __setattr__(self, name: str, value: Any) -> None:
        self._array(name)[0] = value


def invoke(name: str, address: Any, *arrays: Array) -> None:
    """Call a function in C of the same translation unit with an address, a whole number, and the
    pointers to the first numbers of arrays.
    """
    pointers = "".join(f", {array.pointer()}" for array in arrays)
    recording().line(f"{name}((void *){index_of(address)}{pointers});")
    recording().stores += 1
