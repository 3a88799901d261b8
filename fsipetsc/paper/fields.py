"""Errors of a state, and what is wrong with one that is not physical."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.process.together import together
from fsipetsc.stepping.diagnosis import Seen

if TYPE_CHECKING:
    from fsipetsc.paper.state import PaperState

Array = np.ndarray
#: kind of layer -> unknowns whose errors are told
UNKNOWNS = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
#: norm -> its power
POWERS = {"L1": 1, "L2": 2}


def errors(state: PaperState, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
    """Errors at time t [s]: kind of layer -> name -> (h sum |difference|^p)^(1/p), and
    "combined" over the unknowns.

    norm: "L1" or "L2", p = 1 or 2. Over the active points without ghosts, all layers of a kind
    together. None without an exact solution. Collective; InputError if the exact solution
    cannot be had.
    """
    layers, power = state.problem.layers, POWERS[norm]
    if any(layer.exact is None for layer in layers):
        return None

    def exact() -> dict[int, list[Array]]:
        X = state.layout.owned_X
        numbers = [part.number for part in state.here]
        return {k: given.fields(layers[k], "exact", X(k), t, state.active(k)) for k in numbers}

    kinds = {layer.kind for layer in layers}
    totals = {kind: np.zeros(len(UNKNOWNS[kind])) for kind in UNKNOWNS if kind in kinds}
    wanted = together(state.comm, exact)
    for part in state.here:
        counted, found = _counted(part), part.fields()
        for c, value in enumerate(wanted[part.number]):
            difference = np.abs(found[counted, c] - value[counted])
            totals[layers[part.number].kind][c] += state.h * np.sum(difference**power)
    result = {}
    for kind, total in totals.items():
        sums = state.comm.allreduce(total)
        of_each = (sums ** (1 / power)).tolist()
        result[kind] = dict(zip(UNKNOWNS[kind], of_each, strict=True))
        result[kind]["combined"] = float(sums.sum() ** (1 / power))
    return result


def _counted(part) -> Array:
    """Whether each of this rank's points of a layer is active and no ghost point."""
    record = part.record
    lo, hi = int(record["lo"]), int(record["hi"])
    if part.is_gas:  # at its embedded boundary
        lo, hi = lo + (record["end_kind"][0] >= 0), hi - (record["end_kind"][1] >= 0)
    index = np.arange(record["own_lo"], record["own_hi"])
    return (index >= lo) & (index <= hi)


def seen(state: PaperState) -> Iterable[Seen]:
    """Values at this rank's active points, and which of them must be positive."""
    for part in state.here:
        k, record = part.number, part.record
        active, grid = state.active(k), state.layout.grids[k]
        own = np.arange(record["own_lo"], record["own_hi"])[active]
        X, y = grid.X()[own], part.owned[active].T
        if part.is_gas:
            u, T = part.law.velocity_and_temperature(*y)
            x, values = X - grid.anchor + record["x_interface"], {"rho": y[0], "u": u, "T": T}
        else:
            u, sigma, T, x = y
            after = np.minimum(own + 1, record["n"] - 1) - record["own_lo"] + record["halo_lo"]
            x_X = np.where(own < record["n"] - 1, (part.local[after, 3] - x) / state.h, 1.0)
            values = {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T}

        def place(i: int, x: Array = x, X: Array = X, m: str = state.problem.unit("m")) -> str:
            return f"x = {x[i]:.6g}{m} (X = {X[i]:.6g}{m})"

        yield Seen(k, own, values, frozenset({"rho", "T", "x_X"} & values.keys()), place)
