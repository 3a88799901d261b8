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
values: arrays and numbers of the records are pointers and numbers in a struct that C gets.
"""

import ctypes
import inspect
import re
from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.kernels.kernel import c_source, unit
from fsipetsc.kernels.loops import KINDS, Array
from fsipetsc.kernels.recording import Index, Recording, printed, recorded
from fsipetsc.kernels.symbols import Symbol

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_long


class Procedure:
    """A recorded procedure, which can be called once its code is loaded. text: the C function."""

    def __init__(self, name: str, function: Callable[..., None], *records: Any) -> None:
        self.name, self._values, self._kinds = name, dict[str, Any](), dict[str, str]()
        parameters = list(inspect.signature(function).parameters)
        names, vectors = parameters[: len(records)], parameters[len(records) :]
        with recorded() as record:
            pairs = zip(names, records, strict=True)
            given = [self._stand_in(name, value, record) for name, value in pairs]
            worlds = [Array(v, np.dtype(float), (Index(f"{v}_size"),)) for v in vectors]
            function(*given, *worlds)
        if len(record.scopes) > 1:
            raise ValueError(f"{name}: break or return within a loop of each(n): write stop(c)")
        self.vectors, self.text = vectors, self._text(function, vectors, record)
        self._structure: Any = None
        self._function: Any = None

    def _stand_in(self, name: str, value: Any, record: Recording) -> Any:
        """What stands for a record, or a part of one, while the procedure is recorded."""
        known = value is None or isinstance(value, (bool, str, Symbol)) or callable(value)
        if known or is_dataclass(value):  # facts
            return value
        if isinstance(value, np.ndarray):
            if not value.flags.c_contiguous:
                raise ValueError(f"{name} is not contiguous")
            of = value.dtype
            kind = "char" if of.names else KINDS.get(of.kind)
            if kind is None or (kind != "char" and of.itemsize != 8):
                raise TypeError(f"{name} is of {of}: arrays are of float64 and int64")
            base = self._field(name, f"{kind} *", value)
            sizes = (self._field(f"{name}_n{k}", "long ", n) for k, n in enumerate(value.shape))
            return Array(base, of, [*map(Index, sizes)])
        if isinstance(value, (float, np.floating)):
            return record.given(self._field(name, "double ", float(value)), uniform=True)
        if isinstance(value, (int, np.integer)):
            return Index(self._field(name, "long ", int(value)))
        if isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            pairs = zip(names, value, strict=True)
            made = [self._stand_in(f"{name}_{n}", one, record) for n, one in pairs]
            return type(value)(*made) if hasattr(value, "_fields") else tuple(made)
        if isinstance(value, SimpleNamespace):
            made = type(value).__new__(type(value))
            for n, one in vars(value).items():
                setattr(made, n, self._stand_in(f"{name}_{n}", one, record))
            return made
        raise TypeError(f"{name} is {type(value).__name__}: a record has arrays and numbers")

    def _field(self, name: str, kind: str, value: Any) -> str:
        while name in self._values:
            name += "_"
        self._values[name], self._kinds[name] = value, kind
        return name

    def _text(self, function: Any, vectors: list[str], record: Recording) -> str:
        named = (s for s in record.symbols if s.operation == "given" and s.uniform)
        lines = printed(record, record.items, record.wanted, named)
        found = set(re.findall(r"\w+", "\n".join(lines)))
        self._used = [name for name in self._values if name in found]
        names = [*vectors, "unused", "unused_too"][:2]
        given = "".join(f", double *{v}, long {v}_size" for v in names)
        says = (function.__doc__ or "").strip().splitlines() or [""]
        return "\n".join(
            [
                f"/* {says[0]} */",
                f"struct {self.name}_in {{",
                *(f"  {self._kinds[name]}{name};" for name in self._used),
                *["  long nothing;"] * (not self._used),
                "};",
                f"void {self.name}(const struct {self.name}_in *s{given}) {{",
                *(f"  {self._kinds[name]}const {name} = s->{name};" for name in self._used),
                *lines,
                "}\n",
            ]
        )

    def load(self, library: ctypes.CDLL) -> None:
        """Take the compiled function, and fill the struct with what the records have."""
        kinds = {"double ": ctypes.c_double, "long ": _NUMBER}
        fields = [(name, kinds.get(self._kinds[name], _POINTER)) for name in self._used]
        made = type("Structure", (ctypes.Structure,), {"_fields_": fields})
        values = [self._values[name] for name in self._used]
        self._structure = made(*(v.ctypes.data if isinstance(v, np.ndarray) else v for v in values))
        self._function = getattr(library, self.name)
        self._function.argtypes = _POINTER, _POINTER, _NUMBER, _POINTER, _NUMBER
        self.address = ctypes.cast(self._function, _POINTER).value
        self.structure = ctypes.addressof(self._structure)

    def __call__(self, *vectors: np.ndarray) -> None:
        """Run the function in C; vectors: at most two flat arrays of doubles."""
        given = [number for vector in vectors for number in (vector.ctypes.data, vector.size)]
        self._function(self.structure, *given, *(None, 0) * (2 - len(vectors)))


class Code:
    """The procedures of one translation unit, which begins with a text that they need."""

    def __init__(self, text: str = "") -> None:
        self._text, self.procedures = text or unit(), list[Procedure]()
        self.library: ctypes.CDLL | None = None

    def procedure(self, name: str, function: Callable[..., None], *records: Any) -> Procedure:
        """Record a function of these records."""
        self.procedures.append(found := Procedure(name, function, *records))
        return found

    @property
    def text(self) -> str:
        return "\n".join([self._text, *(procedure.text for procedure in self.procedures)])

    def load(self, library: ctypes.CDLL) -> None:
        """Take the functions from the compiled text."""
        self.library = library
        for procedure in self.procedures:
            procedure.load(library)


# lists of calls that C makes one after the other


def calling_code(*texts: str) -> Code:
    """Code with the functions of calls.c, whose library `Calls` needs; procedures can be added."""
    return Code(unit(c_source("fsipetsc.kernels", "calls.c"), *texts))


class _Call(ctypes.Structure):
    _fields_ = [
        *((name, _POINTER) for name in ("procedure", "of", "y")),
        *(("y_size", _NUMBER), ("f", _POINTER), ("f_size", _NUMBER)),
    ]


class Calls:
    """Calls of procedures that are loaded, each with up to two world vectors; library: that of
    ``calling_code``.
    """

    def __init__(self, library: Any, calls: Sequence[tuple[Procedure, Any]]) -> None:
        self._library, self._calls, self._count = library, (_Call * len(calls))(), len(calls)
        self._kept = calls
        for one, (procedure, vectors) in zip(self._calls, calls, strict=True):
            one.procedure, one.of = procedure.address, procedure.structure
            for name, vector in zip(("y", "f"), vectors):
                setattr(one, name, vector.ctypes.data)
                setattr(one, f"{name}_size", vector.size)

    def __call__(self) -> None:
        """Make all calls."""
        self._library.run_calls(self._calls, _NUMBER(self._count))

    def batch(self, bad: np.ndarray, allowed: np.ndarray) -> None:
        """Make all calls, once, and again while the number ``bad`` is 0 and ``allowed`` is not."""
        numbers = (_POINTER(number.ctypes.data) for number in (bad, allowed))
        self._library.run_batch(self._calls, _NUMBER(self._count), *numbers)
