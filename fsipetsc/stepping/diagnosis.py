"""Where and how a state became unphysical, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsipetsc.problem import FluidLayer

if TYPE_CHECKING:
    from fsipetsc.stepping.state import State


def describe_failure(state: State, t: float, step: int) -> str:
    """Field, layer, position, time and step of the first unphysical point, from the work arrays. Collective."""
    found, m, s = None, state.problem.unit("m"), state.problem.unit("s")
    for k, layer in enumerate(state.problem.layers):
        if state.layout.records[k]["present"]:
            found = found or _first_bad(state, k, layer)
    found = min((f for f in state.comm.allgather(found) if f), default=None)
    if found is None:
        return f"the time step is not a number at t = {t:.6g}{s}, step {step}"
    k, _, x, X, what = found
    name = state.problem.layers[k].name
    return f"{what} in layer '{name}' at x = {x:.6g}{m} (X = {X:.6g}{m}), t = {t:.6g}{s}, step {step}"


def _first_bad(state: State, k: int, layer: object) -> tuple[int, int, float, float, str] | None:
    """(layer, point, x, X, what) of the first unphysical point on this rank."""
    record = state.layout.records[k]
    fluid = isinstance(layer, FluidLayer)
    work = state.plan.work(k)
    first = int(record["own_lo"] - record["halo_lo"])
    own = np.arange(max(record["own_lo"], record["lo"]), min(record["own_hi"], record["hi"] + 1))
    q = work[own - first]
    X = state.layout.grids[k].X()[own]
    with np.errstate(all="ignore"):
        if fluid:
            rho, u, T, _ = layer.material.primitive(q / record["J"])
            x = X - state.layout.grids[k].anchor + record["x_interface"]
            if record["stretched"]:
                x = record["end_x"][0] + own * (record["h"] * record["J"])
            checks = (("rho", rho), ("T", T), ("u", np.where(np.isfinite(u), 1.0, np.nan)))
        else:
            right = np.minimum(own + 1, record["n"] - 1) - first
            x_X = np.where(own < record["n"] - 1, (work[right, 3] - q[:, 3]) / state.h, 1.0)
            x, u = q[:, 3], q[:, 0]
            checks = (("x_X", x_X), ("T", q[:, 2]), ("u", np.where(np.isfinite(u), 1.0, np.nan)))
        bad = [(int(np.argmin(v > 0)), name, v) for name, v in checks if not np.all(v > 0)]
    if not bad:
        return None
    i, name, values = min(bad, key=lambda b: b[0])
    what = f"{name} = {values[i]:.6g}" if np.isfinite(values[i]) else f"{name} is not a finite number"
    return k, int(own[i]), float(x[i]), float(X[i]), what
