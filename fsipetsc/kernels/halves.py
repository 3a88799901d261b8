"""Powers of two leave products: a mean of means takes one multiplication by 1/4, not three by 1/2.

Each symbol of a record is written as 2^e times another one. Products add the exponents e, sums of
terms with one exponent keep it, and what remains is multiplied at the end, at best to what all
nodes share, before the loop. All of it is exact, but where a number is beyond the largest or below
the least normal one. Sums may be fused with other products than those of the record.
"""

from collections.abc import Sequence
from math import frexp
from typing import Any

from fsipetsc.kernels.symbols import Record, Symbol, uses_of

#: operations of which 2^e a and 2^e b make 2^e times what they make of a and b
_COMMON = frozenset({"+", "-", "maximum", "minimum"})


def exponent_of(value: float | None) -> int | None:
    """n of a number 2^n, else None."""
    part, exponent = frexp(value or 0.0)
    return exponent - 1 if part == 0.5 else None


class _Rewriting:
    """record: the new one. of: number of an old symbol -> core and exponent; uses: number of a core
    -> how often it is an operand; with_uniform: number of a symbol -> what `_has_uniform` says.
    """

    def __init__(self, record: Record, wanted: Sequence[Symbol]) -> None:
        self.record, uses = Record(), uses_of(wanted)
        self.of: dict[int, tuple[Symbol, int]] = {}
        self.uses: dict[int, int] = {}
        self.with_uniform: dict[int, bool] = {}
        for symbol in record.symbols:
            if symbol.number in uses:
                self.of[symbol.number] = core, _ = self._made(symbol)
                self.uses[core.number] = self.uses.get(core.number, 0) + uses[symbol.number]

    def whole(self, symbol: Symbol) -> Symbol:
        """Return the new symbol of an old one, its power of two included."""
        return self.scaled(*self.of[symbol.number])

    def scaled(self, x: Symbol, n: int) -> Symbol:
        """2^n x. A product hands it to a factor that all nodes share or, if nothing else takes it,
        to the one that most products have.
        """
        if n and x.operation == "*" and not x.uniform:
            first, second = sorted(x.operands, key=lambda f: self.uses.get(f.number, 0))
            if self._has_uniform(x):
                first, second = sorted(x.operands, key=self._has_uniform)
                return self.record.apply("*", first, self.scaled(second, n))
            if self.uses.get(x.number, 0) < 2:
                return self.record.apply("*", first, self.record.apply("*", 2.0**n, second))
        return self.record.apply("*", 2.0**n, x) if n else x

    def _made(self, symbol: Symbol) -> tuple[Symbol, int]:
        operation, apply = symbol.operation, self.record.apply
        if symbol.value is not None:
            return self.record.constant(symbol.value), 0
        if operation == "given":
            return self.record.given(symbol.text, symbol.uniform), 0
        cores, exponents = zip(*(self.of[o.number] for o in symbol.operands), strict=True)
        powers = [exponent_of(operand.value) for operand in symbol.operands]
        if operation == "*":
            for n, other in ((powers[0], 1), (powers[1], 0)):
                if n is not None:
                    return cores[other], exponents[other] + n
            return apply("*", *cores), sum(exponents)
        if operation == "/":
            if powers[1] is not None:
                return cores[0], exponents[0] - powers[1]
            return apply("/", *cores), exponents[0] - exponents[1]
        if operation in ("neg", "abs"):
            return apply(operation, *cores), exponents[0]
        if operation == "where":
            condition = self.whole(symbol.operands[0])
            of = [e for x, e in zip(cores[1:], exponents[1:], strict=True) if x.value != 0.0]
            if len({*of}) == 1:
                return apply("where", condition, *cores[1:]), of[0]
        elif operation in _COMMON and exponents[0] == exponents[1]:
            return apply(operation, *cores), exponents[0]
        elif operation in ("+", "-"):
            return self._sum(operation, cores, exponents)
        return apply(operation, *map(self.whole, symbol.operands)), 0

    def _sum(self, operation: str, cores: Any, exponents: Any) -> tuple[Symbol, int]:
        """A sum of terms with different exponents: that term takes the difference for which it
        costs least.
        """
        k = int(self._costs(cores[1]) < self._costs(cores[0]))
        terms = [*cores]
        terms[k] = self.scaled(cores[k], exponents[k] - exponents[1 - k])
        return self.record.apply(operation, *terms), exponents[1 - k]

    def _costs(self, x: Symbol) -> int:
        """How much a multiplication of a term by a power of two costs: nothing before the loop, or
        with a factor that all nodes share; little where it is fused with the sum.
        """
        return 0 if self._has_uniform(x) else 2 if x.operation == "*" else 1

    def _has_uniform(self, x: Symbol) -> bool:
        """Whether all nodes share a number, or a factor of a product."""
        known = self.with_uniform
        if x.number not in known:
            product = x.operation == "*"
            known[x.number] = x.uniform or (product and any(map(self._has_uniform, x.operands)))
        return known[x.number]


def without_halves(record: Record, wanted: Sequence[Symbol]) -> tuple[Record, list[Symbol]]:
    """A record with fewer products that gives the same, and what is wanted of it. Nothing may be
    exact, as in procedures.
    """
    assert not record.exact, "fused products may change"
    made = _Rewriting(record, wanted)
    return made.record, [made.whole(symbol) for symbol in wanted]
