"""What is saved of a state, its errors, and what is wrong with one that is not physical."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fsipetsc import given
from fsipetsc.paper import entries
from fsipetsc.process.together import together
from fsipetsc.stepping.diagnosis import Seen

if TYPE_CHECKING:
    from fsipetsc.paper.parts import LayerPart
    from fsipetsc.paper.state import PaperState

Array = np.ndarray
#: kind of layer -> unknowns whose errors are told
UNKNOWNS = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
#: norm -> its power
POWERS = {"L1": 1, "L2": 2}


def fields(state: PaperState) -> dict[int, Array]:
    """What is saved of this rank's points, (owned points, 5) by layer."""
    found = {}
    for part in state.path.layers:
        out = found[part.number] = np.empty((len(part.owned), 5))
        if part.is_gas:
            entries.gas_fields(part.law, part.record, part.local, out)
        else:
            entries.solid_fields(part.op, part.law, part.record, part.local, out)
    return found


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
    kinds = {layer.kind for layer in layers}
    totals = {kind: np.zeros(len(UNKNOWNS[kind])) for kind in UNKNOWNS if kind in kinds}
    found = fields(state)

    def exact() -> dict[int, list[Array]]:
        X = state.layout.owned_X
        return {k: given.fields(layers[k], "exact", X(k), t, state.active(k)) for k in found}

    for k, values in together(state.comm, exact).items():
        counted, h = _counted(state, k), state.layout.records[k]["h"]
        for c, value in enumerate(values):
            difference = np.abs(found[k][counted, c] - value[counted])
            totals[layers[k].kind][c] += h * np.sum(difference**power)
    result = {}
    for kind, total in totals.items():
        sums = state.comm.allreduce(total)
        of_each = (sums ** (1 / power)).tolist()
        result[kind] = dict(zip(UNKNOWNS[kind], of_each, strict=True))
        result[kind]["combined"] = float(sums.sum() ** (1 / power))
    return result


def _counted(state: PaperState, k: int) -> Array:
    """Whether each of this rank's points of layer k is active and no ghost point."""
    record = state.layout.records[k]
    lo, hi = int(record["lo"]), int(record["hi"])
    if state.problem.layers[k].kind == "fluid":  # at its embedded boundary
        lo, hi = lo + (record["end_kind"][0] >= 0), hi - (record["end_kind"][1] >= 0)
    index = np.arange(record["own_lo"], record["own_hi"])
    return (index >= lo) & (index <= hi)


class _Place(NamedTuple):
    """Says where point i is: at x in space, X in the layer."""

    x: Array
    X: Array
    unit: str

    def __call__(self, i: int) -> str:
        return f"x = {self.x[i]:.6g}{self.unit} (X = {self.X[i]:.6g}{self.unit})"


def seen(state: PaperState) -> Iterable[Seen]:
    """Values at this rank's active points, and which of them must be positive."""
    for part in state.path.layers:
        active = state.active(part.number)
        own = np.arange(part.record["own_lo"][0], part.record["own_hi"][0])[active]
        X = state.layout.grids[part.number].X()[own]
        x, values = (_gas_values if part.is_gas else _solid_values)(state, part, active, own, X)
        positive = frozenset({"rho", "T", "x_X"} & values.keys())
        yield Seen(part.number, own, values, positive, _Place(x, X, state.problem.unit("m")))


def _gas_values(
    state: PaperState, part: LayerPart, active: slice, own: Array, X: Array
) -> tuple[Array, dict[str, Array]]:
    rho, m, e = part.owned[active].T
    u, T = part.law.velocity_and_temperature(rho, m, e)
    anchor = state.layout.grids[part.number].anchor
    return X - anchor + part.record["x_interface"][0], {"rho": rho, "u": u, "T": T}


def _solid_values(
    state: PaperState, part: LayerPart, active: slice, own: Array, X: Array
) -> tuple[Array, dict[str, Array]]:
    record = part.record[0]
    u, sigma, T, x = part.owned[active].T
    next_one = np.minimum(own + 1, record["n"] - 1) - record["own_lo"] + record["halo_lo"]
    slope = (part.local[next_one, 3] - x) / state.h
    x_X = np.where(own < record["n"] - 1, slope, 1.0)
    return x, {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T}
