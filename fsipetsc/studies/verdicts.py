"""What `verify` measures, what is expected of it, and verdicts: rows of its table."""

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from math import inf, isclose, log, nan
from typing import Any, NamedTuple

from fsipetsc.checks import Array

#: errors, relative ones, that may be round-off
ROUND_OFF = 1e-12
#: solve(case, order, h, end=None, **options) runs a case, given by its name or as a problem, to its
#: end or to another time, and returns its opened result; collective
Solve = Callable[..., Any]


class Curve(NamedTuple):
    """To be drawn: ours at x, the reference at x_reference. labels: of the axes, with units."""

    labels: tuple[str, str]
    x: Array
    ours: Array
    x_reference: Array
    reference: Array


class Compared(NamedTuple):
    """A number beside its reference. size: what their distance is divided by; None: by the
    reference.
    """

    value: complex
    reference: complex
    size: float | None = None

    @property
    def error(self) -> float:
        """Distance from the reference over the size."""
        size = abs(self.reference) if self.size is None else self.size
        return abs(self.value - self.reference) / size


class Measured(NamedTuple):
    """Of one run. errors: quantity -> an error, or the number that is compared; curve: one of them
    as a picture shows it.
    """

    errors: Mapping[str, float | Compared]
    curve: Curve | None = None


class Bound(NamedTuple):
    """What is expected of a quantity: the order observed between the two finest grids is at least
    `order`, the error on the finest grid at most `error`, and that on a grid of spacing h `at`[h].
    """

    order: float = -inf
    error: float = inf
    at: Mapping[float, float] = {}

    def largest(self, h: float, finest: bool) -> float:
        """The error allowed on a grid."""
        known = [error for spacing, error in self.at.items() if isclose(spacing, h)]
        return min([*known, self.error if finest else inf])


def expect(
    names: Iterable[str], orders: Iterable[int], *bound: float, **more: Any
) -> dict[tuple[str, int], Bound]:
    """One bound for quantities at some orders; bound, more: as of Bound."""
    return dict.fromkeys(product(names, orders), Bound(*bound, **more))


class Row(NamedTuple):
    """A quantity at an order on each grid: errors, or the numbers that are compared."""

    entry: str
    quantity: str
    order: int
    spacings: tuple[float, ...]
    found: tuple[float | Compared, ...]
    bound: Bound

    @property
    def errors(self) -> tuple[float, ...]:
        """On each grid."""
        return tuple(one.error if isinstance(one, Compared) else one for one in self.found)

    @property
    def observed(self) -> tuple[float, ...]:
        """Orders between neighbouring grids; nan where an error is 0, or both are round-off."""
        pairs = zip(self.spacings, self.spacings[1:], self.errors, self.errors[1:])
        return tuple(
            log(a / b) / log(h / k) if min(a, b) > 0.0 and max(a, b) > ROUND_OFF else nan
            for h, k, a, b in pairs
        )

    @property
    def verdict(self) -> str:
        """What falls short, "holds", or "no bound" where nothing is promised."""
        if self.bound == Bound():
            return "no bound"
        short = []
        seen = self.observed[-1] if self.observed else nan
        if self.bound.order > -inf and not seen >= self.bound.order:
            found = f"{self.observed[-1]:.2f}" if self.observed else "unknown"
            short.append(f"order {found} < {self.bound.order:g}")
        for h, error in zip(self.spacings, self.errors):
            largest = self.bound.largest(h, h == self.spacings[-1])
            if not error <= largest:
                short.append(f"error {error:.2e} > {largest:.2e}")
        return "; ".join(short) or "holds"

    @property
    def cells(self) -> tuple[str, ...]:
        """Of a table: quantity, order, spacings, errors, observed orders, verdict."""
        numbers = (self.spacings, ".4g"), (self.errors, ".2e"), (self.observed, ".2f")
        lists = [", ".join(format(v, spec) for v in values) for values, spec in numbers]
        return self.quantity, str(self.order), *lists, self.verdict
