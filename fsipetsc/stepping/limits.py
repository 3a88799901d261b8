"""What bounds the time step: how fast each layer's waves and its friction and conduction are, in words and over the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fsipetsc.stepping.state import State

#: by kind of layer: what convection is there, and what diffusion is
_NAMES = {"fluid": ("sound", "friction and conduction"), "solid": ("waves", "conduction")}


def limiting(state: State) -> str:
    """What is fastest of all layers, and bounds the step: as "sound in below"; "" where nothing is known of it."""
    rates = state.rates
    if not np.isfinite(rates).all() or not rates.any():
        return ""
    k, which = np.unravel_index(np.argmax(rates), rates.shape)
    layer = state.problem.layers[k]
    return f"{_NAMES[layer.kind][which]} in {layer.name}"


def reason(state: State, opt: Mapping[str, Any]) -> str:
    """Why a step that has just been made was not longer."""
    return "-ts_dt" if opt["ts_dt"] else limiting(state)


class Limits:
    """What bounded the steps, noted at the saved times: ``changes`` is [time, what] for each time it is another thing."""

    def __init__(self, opt: Mapping[str, Any]) -> None:
        self._opt = opt
        self.changes: list[list[Any]] = []

    def note(self, state: State, t: float) -> None:
        """As it is at time t [s]."""
        found = reason(state, self._opt)
        if found and (not self.changes or self.changes[-1][1] != found):
            self.changes.append([t, found])


def shares(changes: Sequence[Sequence[Any]], end: float) -> list[tuple[str, float]]:
    """(what, part of the time until ``end`` in which it bounded the steps), from `Limits.changes`, the largest first."""
    parts: dict[str, float] = {}
    times = [*(t for t, _ in changes), end]
    for (_, what), begin, until in zip(changes, times, times[1:], strict=False):
        parts[what] = parts.get(what, 0.0) + until - begin
    whole = sum(parts.values())
    return sorted(((what, part / whole if whole > 0 else 1.0) for what, part in parts.items()), key=lambda item: -item[1])
