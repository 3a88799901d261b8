"""Powers of two leave products: a mean of means takes one multiplication by 1/4, not three by 1/2.

Each symbol of a record is written as 2^e times another one. Products add the exponents e, sums of
terms with one exponent keep it, and what remains is multiplied at the end, at best to what all
nodes share, before the loop. All of it is exact, but where a number is beyond the largest or below
the least normal one. Sums may be fused with other products than those of the record.
"""

from collections import Counter
from collections.abc import Sequence
from math import frexp

from fsipetsc.kernels.symbols import Record, Symbol, needed, uses_of


def _power_of(value: float | None) -> int | None:
    """n of a number 2^n, else None."""
    part, exponent = frexp(value or 0.0)
    return exponent - 1 if part == 0.5 else None


class _Rewriting:
    """record: the new one. of: number of an old symbol -> core and exponent; uses: number of a core
    -> how often it is an operand; with_uniform: number of a symbol -> what `_has_uniform` says.
    """

    def __init__(self, wanted: Sequence[Symbol]) -> None:
        self.record, uses = Record(), uses_of(wanted)
        self.of, self.uses = dict[int, tuple[Symbol, int]](), Counter[int]()
        self.with_uniform: dict[int, bool] = {}
        for symbol in needed(wanted):
            self.of[symbol.number] = core, _ = self._made(symbol)
            self.uses[core.number] += uses[symbol.number]

    def whole(self, symbol: Symbol) -> Symbol:
        """Return the new symbol of an old one, its power of two included."""
        return self.scaled(*self.of[symbol.number])

    def scaled(self, x: Symbol, n: int) -> Symbol:
        """2^n x. A product hands it to a factor that all nodes share or, if nothing else takes it,
        to the one that most products have.
        """
        apply = self.record.apply
        if n and x.operation == "*" and not x.uniform:
            first, second = sorted(x.operands, key=lambda f: self.uses[f.number])
            if self._has_uniform(x):
                first, second = sorted(x.operands, key=self._has_uniform)
                return apply("*", first, self.scaled(second, n))
            if self.uses[x.number] < 2:
                return apply("*", first, apply("*", 2.0**n, second))
        return apply("*", 2.0**n, x) if n else x

    def _made(self, symbol: Symbol) -> tuple[Symbol, int]:
        operation, apply = symbol.operation, self.record.apply
        if symbol.value is not None:
            return self.record.constant(symbol.value), 0
        if operation == "given":
            return self.record.given(symbol.text, symbol.uniform), 0
        cores, exponents = zip(*(self.of[o.number] for o in symbol.operands), strict=True)
        a, b, m, n = cores[0], cores[-1], exponents[0], exponents[-1]
        if operation in ("*", "/"):
            sign = 1 if operation == "*" else -1
            first, second = (_power_of(operand.value) for operand in symbol.operands)
            if operation == "*" and first is not None:
                return b, n + first
            core = a if second is not None else apply(operation, a, b)
            return core, m + sign * (n if second is None else second)
        if operation in ("neg", "abs"):
            return apply(operation, a), m
        if operation == "where":
            condition = self.whole(symbol.operands[0])
            of = [e for x, e in zip(cores[1:], exponents[1:], strict=True) if x.value != 0.0]
            if len({*of}) == 1:
                return apply("where", condition, *cores[1:]), of[0]
        elif operation in ("+", "-", "maximum", "minimum") and m == n:
            return apply(operation, a, b), m
        elif operation in ("+", "-"):  # the term takes the difference for which it costs least
            if self._costs(b) < self._costs(a):
                return apply(operation, a, self.scaled(b, n - m)), m
            return apply(operation, self.scaled(a, m - n), b), n
        return apply(operation, *map(self.whole, symbol.operands)), 0

    def _costs(self, x: Symbol) -> int:
        """How much a multiplication of a term by a power of two costs: nothing before the loop, or
        with a factor that all nodes share; little where it is fused with the sum.
        """
        return 0 if self._has_uniform(x) else 2 if x.operation == "*" else 1

    def _has_uniform(self, x: Symbol) -> bool:
        """Whether all nodes share a number, or a factor of a product."""
        if x.number not in self.with_uniform:
            shared = x.uniform or (x.operation == "*" and any(map(self._has_uniform, x.operands)))
            self.with_uniform[x.number] = shared
        return self.with_uniform[x.number]


def without_halves(wanted: Sequence[Symbol]) -> tuple[Record, list[Symbol]]:
    """A record with fewer products that gives the same, and what is wanted of it. Nothing may be
    exact, as in procedures.
    """
    assert not wanted[0].record.exact, "fused products may change"
    made = _Rewriting(wanted)
    return made.record, [made.whole(symbol) for symbol in wanted]
