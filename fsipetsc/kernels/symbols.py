"""Numbers that record what is done with them, so that a scalar formula becomes machine code.

A formula is a Python function of numbers. It runs once on Symbols, and the record of what it did is
printed as C (fsipetsc.kernels.kernel). The formula itself stays as it is: operators and numpy's
functions, as np.sqrt, np.maximum and np.where, take Symbols. The same operation on the same
operands is one Symbol, so what stands twice in a formula is computed once.

What cannot be recorded is refused with the line of the formula: an ``if`` on a value, math.*,
float(), and functions of numpy that are not in OPERATIONS.

Only changes that keep every bit are made: operations on constants are done here, and 1 x, x + 0 and
0 x are x, x and 0 (the last two but for signs of zero, infinity and what is not a number).
"""

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from math import isnan
from numbers import Real
from operator import index
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from fsipetsc.checks import counted
from fsipetsc.errors import InputError

#: numpy's functions that can be recorded, by the names under which they are printed
OPERATIONS: dict[Any, str] = {
    **{np.add: "+", np.subtract: "-", np.multiply: "*", np.true_divide: "/", np.negative: "neg"},
    **{np.sqrt: "sqrt", np.absolute: "abs", np.maximum: "maximum", np.minimum: "minimum"},
    **{np.greater: ">", np.less: "<", np.greater_equal: ">=", np.less_equal: "<="},
    **{np.equal: "==", np.not_equal: "!=", np.sign: "sign", np.power: "pow"},
    **{np.logical_and: "&", np.logical_or: "|", np.logical_not: "not"},
    **{np.bitwise_and: "&", np.bitwise_or: "|", np.invert: "not"},
    **{np.exp: "exp", np.expm1: "expm1", np.log: "log", np.log1p: "log1p"},
    **{np.sin: "sin", np.cos: "cos", np.arctan2: "arctan2", np.tanh: "tanh"},
    **{np.floor_divide: "quotient", np.remainder: "remainder_of"},
}
#: functions that are made of these
MADE: dict[Any, Callable[[Any], Any]] = {
    np.exp2: lambda x: 2.0**x,
    np.log2: lambda x: 1.4426950408889634 * np.log(x),
    np.log10: lambda x: 0.4342944819032518 * np.log(x),
    np.cbrt: lambda x: np.sign(x) * abs(x) ** (1.0 / 3.0),
    np.tan: lambda x: np.sin(x) / np.cos(x),
    np.arctan: lambda x: np.arctan2(x, 1.0),
    np.sinh: lambda x: 0.5 * (np.expm1(x) - np.expm1(-x)),
    np.cosh: lambda x: 0.5 * (np.exp(x) + np.exp(-x)),
}
#: operations whose result is true or false
CONDITIONS = frozenset({">", "<", ">=", "<=", "==", "!=", "&", "|", "not"})
#: operations on whole numbers alone, and all on whole numbers
_ONLY_WHOLE = frozenset({"quotient", "remainder_of", "least", "most"})
_WHOLE = _ONLY_WHOLE | CONDITIONS | {"+", "-", "*", "neg", "where"}
#: the largest exponent for which a power is written as products
MOST_FACTORS = 8


def refuse(what: str) -> InputError:
    """Return the error, with the line of the formula that was running."""
    frame = sys._getframe(1)
    inside = tuple(os.path.dirname(os.path.abspath(file)) for file in (__file__, np.__file__))
    while frame.f_back and os.path.abspath(frame.f_code.co_filename).startswith(inside):
        frame = frame.f_back
    code = frame.f_code
    return InputError(f"{code.co_name}, {code.co_filename}:{frame.f_lineno}: {what}")


def numbers_of(values: Any, count: int = 0) -> Any:
    """What a function returns as formulas take it: a number, or so many in a tuple. InputError."""
    several, kind = isinstance(values, (tuple, list, np.ndarray)), type(values).__name__
    if count and several and len(values) == count:
        return tuple(map(numbers_of, values))
    if count:
        found = kind + (f" of {len(values)}" if several else "")
        raise InputError(f"it returns a {found}: expected {counted(count, 'number')} in a tuple")
    if isinstance(values, Symbol) and values.kind == "double":
        return values
    if not isinstance(values, Real) or isinstance(values, bool) or isnan(values):
        found = "condition" if isinstance(values, Symbol) else kind
        raise InputError(f"it returns a {found}: expected a number")
    return float(values)


def _operators(operation: str) -> tuple[Any, Any]:
    """An operator and its reflection, which need not go through numpy to come to `apply`."""
    return (
        lambda self, other: self.record.apply(operation, self, other),
        lambda self, other: self.record.apply(operation, other, self),
    )


class Symbol(NDArrayOperatorsMixin):
    """A number of a record: what is given, a constant, or what an operation makes of operands.

    kind: its type in C: double, int of a condition, long of a whole number, or a pointer. uniform:
    it depends on constants and parameters alone: all nodes share it. value: of a constant, or None.
    """

    __slots__ = ("kind", "number", "operands", "operation", "record", "text", "uniform", "value")

    def __init__(
        self, record: "Record", operation: str, operands: tuple["Symbol", ...], kind: str
    ) -> None:
        self.record, self.operation, self.operands, self.kind = record, operation, operands, kind
        self.uniform = all([operand.uniform for operand in operands])
        self.text, self.value = "", None
        self.number = len(record.items)

    __add__, __radd__ = _operators("+")
    __sub__, __rsub__ = _operators("-")
    __mul__, __rmul__ = _operators("*")
    __truediv__, __rtruediv__ = _operators("/")

    def __array_ufunc__(self, function: Any, method: str, *given: Any, **more: Any) -> Any:
        more.pop("out", None)  # of a += b: another symbol is what a is then
        if method == "__call__" and not more:
            if function in MADE:
                return MADE[function](*given)
            if function is np.power:
                return _power(self.record, *given)
            if function in OPERATIONS:
                return self.record.apply(OPERATIONS[function], *given)
        raise refuse(f"np.{function.__name__} cannot be recorded")

    def __array_function__(self, function: Any, kinds: Any, given: Any, more: Any) -> Any:
        if function is not np.where or len(given) != 3 or more:
            raise refuse(f"np.{function.__name__} cannot be recorded")
        return self.record.apply("where", *given)

    def __bool__(self) -> bool:
        advice = "write np.where(condition, a, b), np.maximum(a, b), np.minimum(a, b)"
        raise refuse(f"it branches on a value (if, and, or, min, max): {advice}")

    def __float__(self) -> float:
        raise refuse("float() and the functions of math take no symbols: take numpy's functions")

    __int__ = __index__ = __complex__ = __float__  # type: ignore[assignment]

    def __hash__(self) -> int:
        return id(self)


class Record:
    """What formulas make. items: symbols, operands first. exact: numbers of those not fused."""

    def __init__(self) -> None:
        self.items = list[Any]()
        self.exact: set[int] = set()
        self._known: dict[Any, Symbol] = {}

    def constant(self, value: Any, whole: bool = False) -> Symbol:
        """The symbol of a number, perhaps of a whole one; symbols are returned as they are."""
        if isinstance(value, Symbol):
            if whole and value.kind == "double":
                raise refuse("it takes a number for a whole one")
            return value
        try:
            if not isinstance(value, (float, int)) and np.iscomplexobj(value):
                raise TypeError  # of numpy's, float() takes the real part
            number = index(value) if whole else float(value)
        except (TypeError, ValueError):
            raise refuse(f"{value!r} is no {'whole ' * whole}number") from None
        symbol = self._one(repr(number), "constant", (), "long" if whole else "double")
        symbol.uniform, symbol.value = True, number
        return symbol

    def given(
        self,
        text: str,
        *operands: Symbol,
        uniform: bool = False,
        kind: str = "double",
        stores: int = 0,
    ) -> Symbol:
        """A symbol that C has as ``text``, with {} for each operand. uniform: it is the same for
        all. stores: after how many stores it is read.
        """
        key = "given", text, stores, *[operand.number for operand in operands]
        symbol = self._one(key, "given", operands, kind)
        symbol.text, symbol.uniform = text, uniform
        return symbol

    def apply(self, operation: str, *given: Any) -> Symbol:
        """What an operation makes of symbols or numbers."""
        kinds = [getattr(one, "kind", "") for one in given]
        whole = "long" in kinds
        if whole:
            operation = {"minimum": "least", "maximum": "most"}.get(operation, operation)
        if "double" in kinds or operation not in _WHOLE if whole else operation in _ONLY_WHOLE:
            raise refuse(f"{operation} of {'' if whole else 'no '}whole numbers cannot be recorded")
        operands = tuple([one if k else self.constant(one, whole) for one, k in zip(given, kinds)])
        if operation in ("&", "|", "not") and not all(o.operation in CONDITIONS for o in operands):
            raise refuse("&, | and ~ are of conditions, as a > b, alone")
        if operation in ("+", "-", "neg") and all(o.kind == "int" for o in operands):
            raise refuse("conditions have no sums: write np.where(a > b, 1.0, 0.0)")
        simpler = _simplified(self, operation, operands)
        if simpler is not None:
            return simpler
        numbers = tuple([operand.number for operand in operands])
        ordered = tuple(sorted(numbers)) if operation in "+*" else numbers
        kind = operands[-1].kind if operands[-1].kind != "int" else "double"
        kind = "int" if operation in CONDITIONS else kind
        return self._one((operation, ordered), operation, operands, kind)

    def _one(self, key: Any, operation: str, operands: tuple[Symbol, ...], kind: str) -> Symbol:
        """The only symbol of this key."""
        if (known := self._known.get(key)) is None:
            self._known[key] = known = Symbol(self, operation, operands, kind)
            self.items.append(known)
        return known


def exact(x: Any) -> Any:
    """x, a number or a tuple of numbers, without fused operations: each product and each sum of
    which it is made is rounded. So a sum that is its own mirror image has the bits of its image.
    """
    if isinstance(x, tuple):
        return tuple(map(exact, x))
    fusible = isinstance(x, Symbol) and x.operation in ("+", "-", "*", "neg")
    if fusible and x.number not in x.record.exact:
        x.record.exact.add(x.number)
        exact(x.operands)
    return x


def _simplified(record: Record, operation: str, operands: tuple[Symbol, ...]) -> Symbol | None:
    """Return what the operation gives without being recorded, as x + 0 is x, or None."""
    values = [operand.value for operand in operands]
    first, last = operands[0], operands[-1]
    if values == [None, None]:
        return None
    of_first, of_last = (operation, first.value), (operation, last.value)
    if of_last == ("/", 0.0):
        raise refuse("it divides by a constant 0")
    whole = last.kind == "long"
    if operation in ("+", "-", "*", "/", "neg", "abs") and None not in values:
        with np.errstate(all="ignore"):
            return record.constant(_FUNCTIONS[operation](*values), whole)
    if of_first in (("+", 0.0), ("*", 1.0)):
        return last
    if of_last in (("+", 0.0), ("-", 0.0), ("*", 1.0), ("/", 1.0), ("quotient", 1.0)):
        return first
    if of_first in (("*", 0.0), ("/", 0.0)) or of_last == ("*", 0.0):
        return record.constant(0, whole)
    if of_first == ("-", 0.0):
        return record.apply("neg", last)
    return last if operation == "where" and operands[1] is last else None


def _power(record: Record, base: Any, exponent: Any) -> Any:
    """base ** exponent: products for small whole exponents, roots, else the function."""
    base, n = record.constant(base), record.constant(exponent).value
    if n is None or not abs(n) <= MOST_FACTORS or (n != int(n) and abs(n) != 0.5):
        return record.apply("pow", base, exponent)
    found = base if n else record.constant(1.0)
    for bit in f"{int(abs(n)):b}"[1:]:
        found = found * found * base if bit == "1" else found * found
    found = record.apply("sqrt", base) if abs(n) == 0.5 else found
    return found if n >= 0.0 else record.apply("/", 1.0, found)


#: changes of functions of one number a, or two a, b, with the value y; da, db: their changes
_CHANGES: dict[str, Callable[..., Any]] = {
    "neg": lambda a, y, da: da * -1.0,
    "abs": lambda a, y, da: da * np.sign(a),
    "sqrt": lambda a, y, da: da * (0.5 / y),
    "exp": lambda a, y, da: da * y,
    "expm1": lambda a, y, da: da * (y + 1.0),
    "log": lambda a, y, da: da * (1.0 / a),
    "log1p": lambda a, y, da: da * (1.0 / (1.0 + a)),
    "sin": lambda a, y, da: da * np.cos(a),
    "cos": lambda a, y, da: da * -np.sin(a),
    "tanh": lambda a, y, da: da * (1.0 - y * y),
    "sign": lambda a, y, da: 0.0,
    "+": lambda a, b, y, da, db: da + db,
    "-": lambda a, b, y, da, db: da - db,
    "*": lambda a, b, y, da, db: da * b + a * db,
    "/": lambda a, b, y, da, db: (da - y * db) / b,
    "maximum": lambda a, b, y, da, db: np.where(a > b, da, db),
    "minimum": lambda a, b, y, da, db: np.where(a < b, da, db),
    "where": lambda a, b, c, y, da, db, dc: np.where(a, db, dc),
    "pow": lambda a, b, y, da, db: (
        da * (b * a ** (b - 1.0)) + (0.0 if db.value == 0.0 else y * np.log(a) * db)
    ),
    "arctan2": lambda a, b, y, da, db: (da * b - a * db) / (a * a + b * b),
}
#: operations whose slopes may be infinite
_STEEP = frozenset({"/", "sqrt", "log", "log1p", "pow", "arctan2"})


def derivatives(values: Sequence[Any], by: Symbol, still: bool = False) -> tuple[Any, ...]:
    """The derivative of each symbol (or number) of ``values`` by one symbol, by forward mode.

    still: where its slope is infinite, what is made of numbers that do not change does not change
    either, as the root of np.maximum(t, 0) before t = 0. There 0 times infinity is no number.
    """
    record = by.record
    one, nothing = record.constant(1.0), record.constant(0.0)
    found: dict[int, Symbol] = {by.number: one}
    for symbol in needed(map(record.constant, values)):
        changes = [found.get(operand.number, nothing) for operand in symbol.operands]
        if symbol is by or symbol.operation in CONDITIONS or {*changes} <= {nothing}:
            continue
        change = record.constant(_CHANGES[symbol.operation](*symbol.operands, symbol, *changes))
        moving = [part for part in changes if part is not nothing]
        if still and symbol.operation in _STEEP and all(part.value is None for part in moving):
            rests = reduce(np.logical_and, [part == 0.0 for part in moving])
            change = record.constant(np.where(rests & (change != change), 0.0, change))
        if change is not nothing:
            found[symbol.number] = change
    return tuple(found.get(record.constant(value).number, nothing) for value in values)


def needed(wanted: Iterable[Symbol]) -> list[Symbol]:
    """Return these symbols and all that they are made of, each after its operands."""
    found, left = dict[int, Symbol](), list(wanted)
    while left:
        symbol = left.pop()
        if symbol.number not in found:
            found[symbol.number] = symbol
            left.extend(symbol.operands)
    return [found[number] for number in sorted(found)]


def uses_of(wanted: Sequence[Symbol]) -> Counter[int]:
    """How often each symbol is an operand, of those that are needed."""
    operands = (operand for symbol in needed(wanted) for operand in symbol.operands)
    return Counter(symbol.number for symbol in (*wanted, *operands))


def replay(wanted: Sequence[Symbol]) -> Callable[..., list[Any]]:
    """Return the function of what is known that gives the symbols ``wanted``. It takes a number, an
    array, or a symbol by each symbol that is given and, as keywords, what to take of some
    operations instead of numpy's functions.
    """
    order = needed(wanted)
    last = {one.number: k for k, symbol in enumerate(order) for one in symbol.operands}
    done: list[list[int]] = [[] for _ in order]  # of each operation what nothing else takes
    for number in last.keys() - {symbol.number for symbol in wanted}:
        done[last[number]].append(number)

    def found(known: Mapping[Symbol, Any], **functions: Callable[..., Any]) -> list[Any]:
        of = {**_FUNCTIONS, **functions}
        values = {symbol.number: value for symbol, value in known.items()}
        with np.errstate(all="ignore"):
            for symbol, numbers in zip(order, done):
                if symbol.operands:
                    operands = [values[operand.number] for operand in symbol.operands]
                    values[symbol.number] = of[symbol.operation](*operands)
                else:  # what is not known stays
                    value = symbol if symbol.value is None else symbol.value
                    values.setdefault(symbol.number, value)
                for number in numbers:
                    del values[number]  # arrays of many nodes take memory
        return [values[symbol.number] for symbol in wanted]

    return found


def derivative(formula: Callable[..., Any], numbers: Sequence[Any], along: Sequence[Any]) -> Any:
    """The derivative of formula(*numbers) along a direction, exactly: the formula is recorded, and
    its derivative follows from that. Numbers of the direction that are floats become constants.
    """
    record = next((x.record for x in numbers if isinstance(x, Symbol)), None) or Record()
    known = dict[Symbol, Any]()

    def given(value: Any) -> Symbol:
        known[symbol := record.given(f"given {len(record.items)}")] = value
        return symbol

    step = given(0.0)
    ways = (n if isinstance(n, float) else given(n) for n in along)
    found = formula(*(given(x) + step * way for x, way in zip(numbers, ways, strict=True)))
    several = isinstance(found, (tuple, list, np.ndarray))
    slopes = replay(derivatives(found if several else (found,), step, still=True))(known)
    return tuple(slopes) if several else slopes[0]


#: numpy's function of an operation
_FUNCTIONS = {name: of for of, name in reversed(OPERATIONS.items())} | {"where": np.where}
