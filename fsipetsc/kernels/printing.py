"""How what is recorded is printed as C: numbers once and in their order, sums fused with products.

Before that powers of two leave the products of a kernel: a mean of means takes one multiplication
by 1/4, not three by 1/2. Each symbol of a record is written as 2^e times another one. Products add
the exponents e, sums of terms with one exponent keep it, and what remains is multiplied at the end,
at best to what all nodes share, before the loop. All of it is exact, but where a number is beyond
the largest or below the least normal one. Sums may be fused with other products than before.
"""

from collections import Counter
from collections.abc import Sequence
from math import frexp
from typing import Any, NamedTuple

from fsipetsc.kernels.symbols import Record, Symbol, needed, uses_of


class Line(NamedTuple):
    """A line of C. form: has {} where values stand."""

    form: str
    values: tuple[Symbol, ...] = ()


#: what an operation is in C, if it is no function; also sums that are fused with a product
_FORMS = {
    **{name: f"{{0}} {name} {{1}}" for name in ("+", "-", "*", "/", *"<>", "<=", ">=", "==", "!=")},
    **{"&": "{0} & {1}", "|": "{0} | {1}", "not": "!{0}"},
    **{"neg": "-{0}", "abs": "fabs({0})", "sqrt": "sqrt({0})", "where": "{0} ? {1} : {2}"},
    **{name: f"{name}({{0}}, {{1}})" for name in ("quotient", "remainder_of", "least", "most")},
    **{"a b + c": "fma({0}, {1}, {2})", "a b - c": "fma({0}, {1}, -{2})"},
    "c - a b": "fma(-{0}, {1}, {2})",
}
#: how C declares a name of a kind
_TYPES = {kind: f"const {kind}" for kind in ("double", "long", "int")}
_TYPES |= {f"{kind} *": f"{kind} *const" for kind in ("double", "long")}


def printed(items: Sequence[Symbol | Line]) -> list[str]:
    """Lines of C: the lines among the items, and each symbol that they need where it stands."""
    uses = uses_of([value for item in items if isinstance(item, Line) for value in item.values])
    symbols = (one for one in items if isinstance(one, Symbol) and one.number in uses)
    sums = (one for one in symbols if one.operation in ("+", "-"))
    fused = {symbol.number: found for symbol in sums if (found := _fused(symbol, uses))}
    left_out = {product.number for product, *_ in fused.values()}
    names, lines, inside = dict[int, str](), list[str](), 1
    for item in items:
        if isinstance(item, Line):
            text = item.form.format(*(names[value.number] for value in item.values))
        elif item.number not in uses or item.number in left_out:
            continue
        elif item.value is not None:
            names[item.number] = _constant(item.value)
            continue
        elif (item.uniform or item.kind != "double") and item.text.isidentifier():
            names[item.number] = item.text
            continue
        else:
            _, operation, operands = fused.get(item.number, (None, item.operation, item.operands))
            given = [names[operand.number] for operand in operands]
            form = item.text or _FORMS.get(operation) or f"{operation}_({', '.join(given)})"
            names[item.number] = name = f"t{item.number}"
            text = f"{_TYPES[item.kind]} {name} = {form.format(*given)};"
        inside -= text.startswith(("}", ")"))
        lines.append("  " * inside + text)
        inside += text.endswith(("{", ","))
    return lines


def _fused(symbol: Symbol, uses: dict[int, int]) -> Any:
    """The product that a sum is fused with, its last operand that nothing else takes, and operation
    and operands of both; None if there is none. What is exact is not fused.
    """
    exact = symbol.record.exact
    if symbol.kind == "long" or symbol.number in exact:
        return None
    first, second = symbol.operands
    for product, other, minus in ((second, first, "c - a b"), (first, second, "a b - c")):
        alone = product.operation == "*" and uses[product.number] == 1
        if alone and not product.uniform and product.number not in exact:
            operation = "a b + c" if symbol.operation == "+" else minus
            return product, operation, (*product.operands, other)
    return None


def _constant(value: float) -> str:
    text = repr(value)
    text = {"inf": "INFINITY", "-inf": "(-INFINITY)", "nan": "NAN"}.get(text, text)
    return f"({text})" if text[0] == "-" else text


class _Rewriting:
    """record: the new one. of: number of an old symbol -> core and exponent; uses: number of a core
    -> how often it is an operand.
    """

    def __init__(self, wanted: Sequence[Symbol]) -> None:
        self.record, uses = Record(), uses_of(wanted)
        self.of, self.uses = dict[int, tuple[Symbol, int]](), Counter[int]()
        for symbol in needed(wanted):
            self.of[symbol.number] = core, _ = self._made(symbol)
            self.uses[core.number] += uses[symbol.number]

    def whole(self, symbol: Symbol) -> Symbol:
        """Return the new symbol of an old one, its power of two included."""
        return self._scaled(*self.of[symbol.number])

    def _scaled(self, x: Symbol, n: int) -> Symbol:
        """2^n x. A product hands it to a factor that all nodes share or, if nothing else takes it,
        to the one that most products have.
        """
        apply = self.record.apply
        if n and x.operation == "*" and not x.uniform:
            first, second = sorted(x.operands, key=lambda f: self.uses[f.number])
            if _has_uniform(x):
                first, second = sorted(x.operands, key=_has_uniform)
                return apply("*", first, self._scaled(second, n))
            if self.uses[x.number] < 2:
                return apply("*", first, apply("*", 2.0**n, second))
        return apply("*", 2.0**n, x) if n else x

    def _made(self, symbol: Symbol) -> tuple[Symbol, int]:
        """A symbol x and n, of which an old symbol is 2^n x: the same operation on the cores of the
        operands, whose powers of two go into n where the operation lets them out.
        """
        operation, apply = symbol.operation, self.record.apply
        if symbol.value is not None:
            return self.record.constant(symbol.value), 0
        if operation == "given":
            return self.record.given(symbol.text, uniform=symbol.uniform), 0
        cores, exponents = zip(*(self.of[o.number] for o in symbol.operands), strict=True)
        a, b, m, n = cores[0], cores[-1], exponents[0], exponents[-1]
        if operation in ("*", "/"):
            part, exponent = frexp(symbol.operands[0].value or 0.0)
            if operation == "*" and part == 0.5:  # it is 2^(exponent - 1)
                return b, n + exponent - 1
            return apply(operation, a, b), m + (n if operation == "*" else -n)
        if operation == "neg":
            return apply(operation, a), m
        if operation in ("+", "-"):  # the term takes the difference for which it costs least
            if _cost(b) < _cost(a):
                return apply(operation, a, self._scaled(b, n - m)), m
            return apply(operation, self._scaled(a, m - n), b), n
        return apply(operation, *map(self.whole, symbol.operands)), 0


def _cost(x: Symbol) -> int:
    """How much a multiplication of a term by a power of two costs: nothing before the loop, or with
    a factor that all nodes share; little where it is fused with the sum.
    """
    return 0 if _has_uniform(x) else 2 if x.operation == "*" else 1


def _has_uniform(x: Symbol) -> bool:
    """Whether all nodes share a number, or a factor of a product."""
    return x.uniform or (x.operation == "*" and any(map(_has_uniform, {*x.operands})))


def without_halves(wanted: Sequence[Symbol]) -> tuple[Record, list[Symbol]]:
    """A record with fewer products that gives what is wanted, and that; nothing in it is exact."""
    made = _Rewriting(wanted)
    return made.record, [made.whole(symbol) for symbol in wanted]
