"""Procedures: functions whose loops are recorded, and printed as C.

A procedure is a Python function of records (tuples and namespaces of arrays and numbers) and of
world vectors. It runs once, on stand-ins of what the records have, and what it does is printed:

    def heat(part, gain, y, f):
        for i in each(part.at.shape[0]):
            with when(part.opens[i] == 1):
                f[part.at[i]] += part.weight[i] * np.sqrt(y[part.at[i]])

    code = Code()
    call = code.procedure("heat", heat, part, gain)     then   code.load(library),  call(y, f)

What it can do is in fsipetsc.kernels.loops. The text depends on kinds alone, not on sizes or
values: arrays and numbers of the records, but for `Known` ones, are in a struct that C gets.
"""

import ctypes
import inspect
import struct
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.kernels.loops import Array, Known, Recording, recording
from fsipetsc.kernels.printing import printed
from fsipetsc.kernels.symbols import Symbol

_POINTER, _ZERO = ctypes.c_void_p, np.zeros(1)


class Called:
    """What C calls as a procedure, by its name. structure: the address of its struct in C. vectors:
    names of the world vectors, flat arrays of doubles, at most two, that it takes.
    """

    name: str
    structure: int
    vectors: Sequence[str] = ()

    def load(self, library: ctypes.CDLL) -> None:
        self._function = getattr(library, self.name)
        self._function.argtypes = _POINTER, _POINTER, _POINTER
        self.address = ctypes.cast(self._function, _POINTER).value

    def __call__(self, *vectors: np.ndarray) -> None:
        self._function(self.structure, *_pointers(vectors))


def _pointers(vectors: Sequence[np.ndarray]) -> tuple[int, int]:
    y, f = (*(vector.ctypes.data for vector in vectors), 0, 0)[:2]
    return y, f


class Procedure(Called):
    """A recorded procedure. text: the C function; kernels: the texts of those that it calls."""

    def __init__(self, name: str, function: Callable[..., None], *records: Any) -> None:
        self.name, self._values = name, dict[str, Any]()
        parameters = list(inspect.signature(function).parameters)
        names, self.vectors = parameters[: len(records)], parameters[len(records) :]
        record = Recording()
        given = [self._stand_in(*pair) for pair in zip(names, records, strict=True)]
        worlds = (record.given(v, kind="double *") for v in self.vectors)
        function(*given, *(Array(world, (None,)) for world in worlds))
        says = getattr(function, "func", function).__doc__ or ""  # of what is a partial
        self.text, self.kernels = self._text(says, record), record.kernels

    def _stand_in(self, name: str, value: Any) -> Any:
        """What stands for a record, or a part of one, while the procedure is recorded: arrays and
        numbers get names in C; what is no such thing is a fact.
        """
        if isinstance(value, np.ndarray) and not value.dtype.names:
            known = value.dtype.kind in "fi" and value.itemsize == 8
            if not (known and value.flags.c_contiguous):
                raise TypeError(f"{name} is of {value.dtype}: expected contiguous float64 or int64")
            sizes = (self._given(f"{name}_n{k}", n) for k, n in enumerate(value.shape))
            return Array(self._given(name, value), tuple(sizes))
        if isinstance(value, float):
            return self._given(name, value)
        if isinstance(value, (int, np.integer)) and not isinstance(value, (bool, Known)):
            return self._given(name, int(value))
        if isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            parts = [self._stand_in(f"{name}_{n}", one) for n, one in zip(names, value)]
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        if isinstance(value, SimpleNamespace):
            made = _lazy(type(value))()
            made._parts = vars(value), lambda n, one: self._stand_in(f"{name}_{n}", one)
            return made
        return value

    def _given(self, name: str, value: Any) -> Symbol:
        while name in self._values:
            name += "_"
        self._values[name] = value
        return recording().given(name, uniform=isinstance(value, float), kind=_kind(value))

    def _text(self, says: str, record: Recording) -> str:
        kinds = {name: _kind(value) for name, value in self._values.items()}
        y, f = (*self.vectors, "unused", "unused_too")[:2]
        fields = (f"  {kind} {name};" for name, kind in kinds.items())
        taken = (f"  {kind} const {name} = s->{name};" for name, kind in kinds.items())
        head = f"/* {says.strip().partition(chr(10))[0]} */", f"struct {self.name}_in {{"
        of = f"void {self.name}(const struct {self.name}_in *s, double *{y}, double *{f}) {{"
        return "\n".join([*head, *fields, "};", of, *taken, *printed(record.items), "}\n"])

    def load(self, library: ctypes.CDLL) -> None:
        """Take the compiled function, and fill the struct with what the records have."""
        super().load(library)
        values = self._values.values()
        numbers = (v.ctypes.data if isinstance(v, np.ndarray) else v for v in values)
        kinds = "".join("d" if isinstance(v, float) else "q" for v in values)
        self._memory = ctypes.create_string_buffer(struct.pack(kinds, *numbers))
        self.structure = ctypes.addressof(self._memory)


def _kind(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return "long *" if value.dtype.kind == "i" else "double *"
    return "double" if isinstance(value, float) else "long"


@cache
def _lazy(kind: type) -> Any:
    """The class of stand-ins of namespaces of a kind: a part is made when it is asked for."""

    def part(self: Any, name: str) -> Any:
        parts, stand_in = object.__getattribute__(self, "_parts")
        if name not in parts:
            raise AttributeError(name)
        setattr(self, name, found := stand_in(name, parts[name]))
        return found

    parts = property(lambda self: {name: getattr(self, name) for name in self._parts[0]})
    new = {"__init__": object.__init__, "__getattr__": part, "__dict__": parts}
    return type(kind.__name__, (kind,), new)


def unit(*texts: str) -> str:
    """Return the text of a translation unit."""
    return "\n".join([Path(__file__).with_name("prelude.h").read_text("utf-8"), *texts])


class Code:
    """The procedures of one translation unit, the kernels that they call, and more text in C."""

    def __init__(self, text: str = "") -> None:
        self._text, self.procedures = text, list[Procedure]()

    def procedure(self, name: str, function: Callable[..., None], *records: Any) -> Procedure:
        self.procedures.append(found := Procedure(name, function, *records))
        return found

    @property
    def text(self) -> str:
        kernels = dict.fromkeys(text for one in self.procedures for text in one.kernels)
        return unit(self._text, *kernels, *(one.text for one in self.procedures))

    def load(self, library: ctypes.CDLL) -> None:
        self.library = library
        for procedure in self.procedures:
            procedure.load(library)


class Calls:
    """Calls of loaded procedures, each with up to two world vectors; library: of any code."""

    def __init__(self, library: Any, calls: Sequence[tuple[Called, Any]]) -> None:
        self._library, self._kept = library, calls
        rows = [(one.address, one.structure, *_pointers(vectors)) for one, vectors in calls]
        self._calls = np.array(rows, np.int64).reshape(-1, 4)

    def __call__(self, bad: np.ndarray = _ZERO, allowed: np.ndarray = _ZERO) -> None:
        """Make all calls, once, and again while the number ``bad`` is 0 and ``allowed`` is not."""
        calls, *ends = (_POINTER(array.ctypes.data) for array in (self._calls, bad, allowed))
        self._library.run_calls(calls, ctypes.c_long(len(self._calls)), *ends)
