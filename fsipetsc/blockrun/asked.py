"""What functions of a case return for an instant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsipetsc.blocks.values import block_values, checked, checked_one
from fsipetsc.errors import InputError

Array = NDArray[Any]


class Asked:
    """Data of the last instant, which several stages have in common.

    fault: the first InputError of a function. The rank goes on with the data before it, so that
    others do not wait for its messages; all end after the step.
    """

    def __init__(self) -> None:
        self.fault: InputError | None = None
        self._known: dict[Any, tuple[Any, Any]] = {}

    def __call__(self, key: Any, instant: Any, make: Callable[[], Any]) -> Any:
        """make(), called once for an instant; InputError if the first call fails."""
        known = self._known.get(key)
        if known is None or known[0] != instant:
            try:
                known = self._known[key] = instant, make()
            except InputError as error:
                if known is None:
                    raise
                self.fault = self.fault or error
        return known[1]


class Forced:
    """What parts of gas and solid blocks have in common: their case's forcing.

    It takes ``block``, ``part``, ``faces``, ``X`` and the owned nodes from the part.
    """

    block: Any
    part: Any
    faces: Any
    X: Array
    _owned: Array
    _asked: Asked

    @property
    def timed(self) -> bool:
        """Data of faces or forcing depend on time."""
        return self.faces.timed or self.block.forcing is not None

    def ask(self, t: float) -> list[Array]:
        """The case's forcing at time t [s]; nothing if there is none. InputError the first time."""
        if self.block.forcing is None:
            return []
        X, key = self.X[:, self._owned], ("forcing", self.part.k)
        return self._asked(key, t, lambda: block_values(self.block, "forcing", X, t))

    def supplied(self, rows: int) -> Array:
        """(rows, M) memory for the forcing, which `refresh` fills; (rows, 0) if there is none."""
        nodes = 0 if self.block.forcing is None else self._owned.size
        self._forcing = np.zeros((rows, nodes))
        return self._forcing

    def refresh(self, t: float) -> None:
        """Data of faces and of the forcing at time t [s]."""
        self.faces.refresh(t)
        for row, values in zip(self._forcing, self.ask(t), strict=False):
            row[:] = values

    def try_exact(self, t: float) -> None:
        """InputError if the case's exact solution has no values at time t [s]."""
        if self.block.exact is not None:
            block_values(self.block, "exact", self.X[:, self._owned], t)


def datum(condition: Any, name: str, X: Array, t: float) -> Array:
    """(n,) a datum of a condition, a number or a function of (*X, t); X: (n, d). InputError."""
    of = getattr(condition, name)
    if not callable(of):
        return np.full(len(X), float(of))
    if hasattr(of, "of_time"):  # of an end in one dimension
        return np.full(len(X), of.of_time(t))
    where = f"{name} of {type(condition).__name__} at t = {t:.6g}"
    return checked_one(of, (*X.T, t), X.T, name, where)


def data(condition: Any, name: str, X: Array, t: float, names: Sequence[str]) -> Array:
    """(n, len(names)) what a condition's function of (*X, t) returns. InputError."""
    of = getattr(condition, name)
    if hasattr(of, "of_time"):
        return np.full((len(X), len(names)), of.of_time(t))
    where = f"{name} of {type(condition).__name__} at t = {t:.6g}"
    return np.stack(checked(of, (*X.T, t), X.T, names, where), axis=-1)
