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
from collections.abc import Callable
from dataclasses import is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from fsipetsc.kernels.kernel import fused_products, line_of
from fsipetsc.kernels.loops import KINDS, Array
from fsipetsc.kernels.recording import Block, Index, Line, Recording, recorded
from fsipetsc.kernels.symbols import CONDITIONS, Symbol, uses_of

#: where a procedure takes fewer than two world vectors
_NONE = np.zeros(0)


class Procedure:
    """A recorded procedure, which can be called once its code is loaded. text: the C function."""

    def __init__(self, name: str, function: Callable[..., None], *records: Any) -> None:
        self.name, self._values = name, dict[str, Any]()
        self._kinds: dict[str, str] = {}
        parameters = list(inspect.signature(function).parameters)
        names, vectors = parameters[: len(records)], parameters[len(records) :]
        with recorded() as record:
            pairs = zip(names, records, strict=True)
            given = [self._stand_in(name, value, record) for name, value in pairs]
            record.blocks.append(top := Block(""))
            worlds = [Array(v, np.dtype(float), (Index(f"{v}_size"),)) for v in vectors]
            function(*given, *worlds)
        if record.blocks[-1] is not top:
            raise ValueError(f"{name}: break or return within a loop of each(n): write stop(c)")
        self.vectors = vectors
        self.text = self._text(function, record, top)
        self._structure: Any = None
        self._function: Any = None

    def _stand_in(self, name: str, value: Any, record: Recording) -> Any:
        """What stands for a record, or a part of one, while the procedure is recorded."""
        if value is None or isinstance(value, (bool, str, Symbol)) or callable(value):
            return value
        if is_dataclass(value):  # facts, which are known
            return value
        if isinstance(value, np.ndarray):
            if not value.flags.c_contiguous:
                raise ValueError(f"{name} is not contiguous")
            of = value.dtype
            kind = "char" if of.names else KINDS.get(of.kind)
            if kind is None or (kind != "char" and of.itemsize != 8):
                raise TypeError(f"{name} is of {of}: arrays are of float64 and int64")
            base = self._field(name, f"{kind} *", value)
            shape = [
                Index(self._field(f"{name}_n{k}", "long ", length))
                for k, length in enumerate(value.shape)
            ]
            return Array(base, value.dtype, shape)
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
            pairs = vars(value).items()
            return SimpleNamespace(
                **{n: self._stand_in(f"{name}_{n}", one, record) for n, one in pairs}
            )
        raise TypeError(f"{name} is {type(value).__name__}: a record has arrays and numbers")

    def _field(self, name: str, kind: str, value: Any) -> str:
        while name in self._values:
            name += "_"
        self._values[name], self._kinds[name] = value, kind
        return name

    def _text(self, function: Any, record: Recording, top: Block) -> str:
        lines, wanted = [], []
        _find_wanted(top, wanted)
        uses = uses_of(wanted)
        fused = fused_products(record, uses)
        names = {s.number: s.text for s in record.symbols if s.operation == "given" and s.uniform}
        _print(top, lines, "  ", uses, fused, names)
        found = set(re.findall(r"\w+", "\n".join(lines)))
        self._used = [name for name in self._values if name in found]
        members = [f"  {self._kinds[name]}{name};" for name in self._used]
        locals_ = [f"  {self._kinds[name]}const {name} = s->{name};" for name in self._used]
        names = [*self.vectors, "unused", "unused_too"][:2]
        vectors = "".join(f", double *{v}, long {v}_size" for v in names)
        says = (function.__doc__ or "").strip().splitlines() or [""]
        return "\n".join(
            [
                f"/* {says[0]} */",
                f"struct {self.name}_in {{",
                *(members or ["  long nothing;"]),
                "};",
                f"void {self.name}(const struct {self.name}_in *s{vectors}) {{",
                *locals_,
                *lines,
                "}",
                "",
            ]
        )

    def load(self, library: ctypes.CDLL) -> None:
        """Take the compiled function, and fill the struct with what the records have."""
        kinds = {"double ": ctypes.c_double, "long ": ctypes.c_long}
        fields = [(name, kinds.get(self._kinds[name], ctypes.c_void_p)) for name in self._used]
        made = type("Structure", (ctypes.Structure,), {"_fields_": fields})
        values = [self._values[name] for name in self._used]
        self._structure = made(*(v.ctypes.data if isinstance(v, np.ndarray) else v for v in values))
        self._function = getattr(library, self.name)
        self.address = ctypes.cast(self._function, ctypes.c_void_p).value
        self.structure = ctypes.addressof(self._structure)
        nothing = ctypes.c_void_p(None), ctypes.c_long(0)
        self._alone = ctypes.c_void_p(self.structure), *nothing, *nothing

    def __call__(self, *vectors: np.ndarray) -> None:
        """Run the function in C; vectors: at most two flat arrays of doubles."""
        if not vectors:
            self._function(*self._alone)
            return
        given = [ctypes.c_void_p(self.structure)]
        for vector in (*vectors, *[_NONE] * (2 - len(vectors))):
            given += [ctypes.c_void_p(vector.ctypes.data), ctypes.c_long(vector.size)]
        self._function(*given)


def _find_wanted(block: Block, wanted: list[Symbol]) -> None:
    """Add the symbols that lines of a block need, and of the blocks within it."""
    for item in block.items:
        if isinstance(item, Line):
            wanted += [*item.values, *item.needs]
        elif isinstance(item, Block):
            wanted += item.needs
            _find_wanted(item, wanted)


def _print(
    block: Block,
    lines: list[str],
    indent: str,
    uses: dict[int, int],
    fused: dict[int, int],
    names: dict[int, str],
) -> None:
    """Lines of a block: symbols where they were made, if somebody needs them."""
    products = set(fused.values())
    for item in block.items:
        if isinstance(item, Line):
            values = [_named(value, names) for value in item.values]
            lines.append(indent + item.form.format(*values))
        elif isinstance(item, Block):
            lines.append(f"{indent}{item.head} {{")
            _print(item, lines, indent + "  ", uses, fused, names)
            lines.append(f"{indent}}}")
        elif item.number in uses and item.number not in products and item.number not in names:
            for operand in item.operands:
                for one in operand.operands if operand.number in products else (operand,):
                    _named(one, names)
            if item.operation != "constant":
                kind = "int" if item.operation in CONDITIONS else "double"
                text = line_of(item, fused, names)
                names[item.number] = f"t{item.number}"
                lines.append(f"{indent}const {kind} t{item.number} = {text};")


def _named(symbol: Symbol, names: dict[int, str]) -> str:
    """Return the name of a symbol in C; constants have theirs everywhere."""
    if symbol.number not in names:
        if symbol.operation != "constant":
            raise AssertionError(f"{symbol.operation} is not known here")
        names[symbol.number] = line_of(symbol, {}, names)
    return names[symbol.number]


class Code:
    """The procedures of one translation unit, which begins with a text that they need."""

    def __init__(self, text: str) -> None:
        self._text, self.procedures = text, list[Procedure]()
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
