"""What is saved of a state, its errors, and what is wrong with one that is not physical."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from fsipetsc import given
from fsipetsc.paper.parts import Layer
from fsipetsc.paper.steps import stretch
from fsipetsc.process.together import together
from fsipetsc.stepping.verdicts import Seen

if TYPE_CHECKING:
    from fsipetsc.paper.state import PaperState

Array = np.ndarray
#: kind of layer -> unknowns whose errors are told
UNKNOWNS = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
#: norm -> its power
POWERS = {"L1": 1, "L2": 2}


@np.errstate(all="ignore")
def saved(part: Layer) -> Array:
    """Of this rank's points, (owned points, 5): of a gas rho, u, T, p, x, NaN where inactive; of a
    solid u, sigma, T, x, p."""
    record, own = part.record, np.arange(part.record["own_lo"], part.record["own_hi"])
    out = np.empty((len(own), 5))
    if not part.is_gas:
        x_X = np.empty(len(part.local))
        stretch(part.box, x_X)
        x_X = x_X[record["halo_lo"] :][: len(own)] / record["h"]
        out[:, :4], out[:, 4] = part.owned, part.law.pressure(part.owned[:, 2], x_X)
        return out
    u, T = part.law.velocity_and_temperature(*part.owned.T)
    out[:, 0], out[:, 1], out[:, 2] = part.owned[:, 0], u, T
    out[:, 3] = part.law.law.pressure(part.owned[:, 0], T)
    interface = record["lo"] if record["end_kind"][1] >= 0 else record["hi"]
    out[:, 4] = (own - interface) * record["h"] + record["x_interface"]
    out[(own < record["lo"]) | (own > record["hi"])] = np.nan
    return out


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

    def exact() -> list[list[Array]]:
        return [given.fields(p.layer, "exact", p.X, t, p.active) for p in state.here]

    kinds = {layer.kind for layer in layers}
    totals = {kind: np.zeros(len(UNKNOWNS[kind])) for kind in UNKNOWNS if kind in kinds}
    wanted = together(state.comm, exact)
    for part, values in zip(state.here, wanted, strict=True):
        record, found = part.record, saved(part)
        ghosts = part.is_gas * (record["end_kind"] >= 0)
        index = np.arange(record["own_lo"], record["own_hi"])
        counted = (index >= record["lo"] + ghosts[0]) & (index <= record["hi"] - ghosts[1])
        for c, value in enumerate(values):
            difference = np.abs(found[counted, c] - value[counted])
            totals[part.layer.kind][c] += state.h * np.sum(difference**power)
    return state._norms(totals, UNKNOWNS, power)


def seen(state: PaperState) -> Iterable[Seen]:
    """Values at this rank's active points."""
    for part in state.here:
        record, active = part.record, part.active
        own = np.arange(record["own_lo"], record["own_hi"])[active]
        X, y = part.X[active], part.owned[active].T
        if part.is_gas:
            u, T = part.law.velocity_and_temperature(*y)
            x, values = X - record["anchor"] + record["x_interface"], {"rho": y[0], "u": u, "T": T}
        else:
            u, sigma, T, x = y
            after = np.minimum(own + 1, record["n"] - 1) - record["own_lo"] + record["halo_lo"]
            x_X = np.where(own < record["n"] - 1, (part.local[after, 3] - x) / state.h, 1.0)
            values = {"x": x, "x_X": x_X, "u": u, "sigma": sigma, "T": T}
        yield Seen(part.number, own, values, x[:, None], X[:, None])
