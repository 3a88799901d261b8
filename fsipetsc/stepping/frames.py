"""From the solution to what users read: fields on the grid, positions, norms of the error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.problem import FluidLayer
from fsipetsc.process.together import together
from fsipetsc.scheme.fields import SAVED, fields

if TYPE_CHECKING:
    from fsipetsc.stepping.state import State


def layer_fields(state: State) -> list[np.ndarray]:
    """What is saved of this rank's points, (owned points, 5) per layer; see ``fields``."""
    records = state.layout.records
    sizes = SAVED * (records["own_hi"] - records["own_lo"])
    ends = np.cumsum(sizes)
    out = np.empty(ends[-1])
    plan = state.plan
    plan.compiled(fields)(plan.head, plan.layers, plan.memory, out, ends - sizes, SAVED)
    return [part.reshape(-1, SAVED) for part in np.split(out, ends[:-1])]


def errors(state: State, t: float, norm: str = "L2") -> dict[str, dict[str, float]] | None:
    """Errors at time t [s]: kind of layer -> name -> (h sum |difference|^p)^(1/p), and "combined" over the unknowns.

    norm: "L1" or "L2", p = 1 or 2.
    Of the kinds that there are, over the active points without ghosts, all layers of a kind together. None without an exact
    solution. Collective; InputError if the exact solution cannot be had.
    """
    if any(layer.exact is None for layer in state.problem.layers):
        return None
    kinds = {layer.kind for layer in state.problem.layers}
    compared = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
    compared = {kind: names for kind, names in compared.items() if kind in kinds}
    known = together(state.comm, lambda: _exact(state, t))
    power = {"L1": 1, "L2": 2}[norm]
    sums = {kind: np.zeros(len(names)) for kind, names in compared.items()}
    for k, (layer, q) in enumerate(zip(state.problem.layers, layer_fields(state), strict=True)):
        record = state.layout.records[k]
        if not record["present"]:
            continue
        exact = known[k]
        index = np.arange(record["own_lo"], record["own_hi"])
        counted = (index >= record["lo"]) & (index <= record["hi"])
        for side, ghost in ((0, record["lo"]), (1, record["hi"])):
            if isinstance(layer, FluidLayer) and record["end_kind"][side] >= 0 and not record["stretched"]:
                counted &= index != ghost
        for c in range(len(compared[layer.kind])):
            sums[layer.kind][c] += record["h"] * np.sum(np.abs(q[counted, c] - exact[c][counted]) ** power)
    result = {}
    for kind, names in compared.items():
        powers = state.comm.allreduce(sums[kind])
        result[kind] = {name: float(v) for name, v in zip(names, powers ** (1 / power), strict=True)}
        result[kind]["combined"] = float(powers.sum() ** (1 / power))
    return result


def _exact(state: State, t: float) -> dict[int, list[np.ndarray]]:
    """The exact solution at this rank's points, layer by layer."""
    mine = [k for k, record in enumerate(state.layout.records) if record["present"]]
    layers = state.problem.layers
    return {k: given.fields(layers[k], "exact", state.layout.owned_X(k), t, state.active(k)) for k in mine}
