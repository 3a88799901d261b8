"""Functions of place and time that a case brings, recorded before a procedure takes them.

The numbers in them become arguments: another amplitude or frequency compiles nothing. Sums and
products are rounded one by one, as numpy does it.
"""

from collections.abc import Callable, Sequence
from math import isnan
from typing import Any

import numpy as np

from fsipetsc.checks import counted
from fsipetsc.kernels.symbols import CONDITIONS, NotRecorded, Record, Symbol, needed, replay

#: a function of more operations is left to Python: the compiler takes 2 to 3 s for so many
MOST = 500


class Formula:
    """A recorded function of place and time. NotRecorded, or what the function raises on symbols.

    function: of (x, t), a tuple of d symbols [m] and one [s]; it returns a tuple of numbers, or of
    tuples of these. numbers: the constants in it. in_time: whether it depends on time.
    """

    def __init__(self, function: Callable[[Any, Any], Sequence[Any]], d: int) -> None:
        record = Record()
        self._t, self._x = record.given("t"), [record.given(f"x{c}") for c in range(d)]
        found = function(tuple(self._x), self._t)
        self._shape = [len(one) if isinstance(one, tuple) else 0 for one in found]
        each = [n for one in found for n in (one if isinstance(one, tuple) else (one,))]
        self._wanted = [record.constant(one) for one in each]
        every = needed(self._wanted)
        self._constants = [symbol for symbol in every if symbol.value is not None]
        count = len(every) - len(self._constants)
        if count > MOST:
            raise NotRecorded(f"it has {count} operations: expected {MOST} at most")
        self.numbers = np.array([symbol.value for symbol in self._constants], float)
        self.in_time = self._t in set(every)
        of_place = {symbol.number for symbol in self._x}
        for symbol in every:
            if any(operand.number in of_place for operand in symbol.operands):
                of_place.add(symbol.number)
        self._early = [symbol for symbol in every if symbol.number not in of_place]

    def __call__(self, numbers: Any, t: Any) -> Callable[[Any], list[Any]]:
        """The function of place alone, within a procedure; numbers: an array of the constants."""
        known = {self._t: t, **{one: numbers[k] for k, one in enumerate(self._constants)}}
        early = dict(zip(self._early, self._replayed(self._early, known, t), strict=True))

        def of_place(x: Sequence[Any]) -> list[Any]:
            known = {**early, **dict(zip(self._x, x, strict=True))}
            values = iter(self._replayed(self._wanted, known, t))
            return [
                tuple(next(values) for _ in range(n)) if n else next(values) for n in self._shape
            ]

        return of_place

    def _replayed(self, wanted: Sequence[Symbol], known: Any, t: Symbol) -> list[Any]:
        """Symbols in the procedure's record, none of them fused."""
        record, first = t.record, len(t.record.symbols)
        found = replay(wanted, known)
        record.exact.update(range(first, len(record.symbols)))
        return found


def number_of(value: Any) -> Any:
    """A number that a function returns, as formulas take it. NotRecorded."""
    if isinstance(value, Symbol) and value.operation not in CONDITIONS:
        return value
    real = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not real or isnan(value):
        found = "condition" if isinstance(value, Symbol) else type(value).__name__
        raise NotRecorded(f"it returns a {found}: expected a number")
    return float(value)


def numbers_of(values: Any, count: int) -> tuple[Any, ...]:
    """So many numbers that a function returns. NotRecorded."""
    several = isinstance(values, (tuple, list, np.ndarray))
    if not several or len(values) != count:
        found = type(values).__name__ + (f" of {len(values)}" if several else "")
        raise NotRecorded(f"it returns a {found}: expected {counted(count, 'number')} in a tuple")
    return tuple(map(number_of, values))
