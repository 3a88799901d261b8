"""From the solution to what users read: fields on the grid, positions, norms of the error."""

from __future__ import annotations

import numpy as np

from fsipetsc.operators.kernels import MARGIN, derivative
from fsipetsc.parallel.plan import WORK
from fsipetsc.physics.fluid import fluid_fields
from fsipetsc.problem import FluidLayer
from fsipetsc.stepping.state import State


def fields(state: State, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Fields (owned points, nfields) and Eulerian positions (owned points,) [m] of layer k; NaN where inactive.

    Fluid rho, u, T, p; solid u, sigma, T, x, p. From the work arrays, which a completed step leaves up to date.
    """
    layer, record = state.problem.layers[k], state.layout.records[k]
    own_lo, own_hi = int(record["own_lo"]), int(record["own_hi"])
    halo = int(record["halo_lo"])
    if isinstance(layer, FluidLayer):
        values, x = np.empty((own_hi - own_lo, 4)), np.empty(own_hi - own_lo)
        at = int(state.plan.head["area"][0, WORK] + record["work"]) - own_lo + halo
        fluid_fields(record, state.plan.memory, at, state.layout.grids[k].anchor_index, values, x)
        return values, x
    work, values = state.plan.work(k), np.zeros((own_hi - own_lo, 5))
    values[:, :4] = work[halo : halo + own_hi - own_lo]
    if layer.material.gruneisen != 0.0:
        x_X = strain(state, work[:, 3], own_lo - halo, own_lo, own_hi, int(record["n"]))
        values[:, 4] = layer.material.pressure(values[:, 2], x_X)
    return values, values[:, 3].copy()


def strain(state: State, x: np.ndarray, first: int, begin: int, end: int, n: int) -> np.ndarray:
    """x_X at the points begin .. end-1 of a solid of n points, from the positions x of the points from ``first`` on."""
    rows = np.zeros(2 * (x.size + 2 * MARGIN))
    rows[MARGIN : MARGIN + x.size] = x
    out = x.size + 3 * MARGIN
    derivative(state.plan.head[0]["op"], rows, MARGIN, first, out, begin, begin, end, 0, n - 1, 1 / state.h)
    return rows[out : out + end - begin]


def active_points(state: State) -> int:
    """Active points of all layers."""
    return sum(int(r["hi"] - r["lo"]) + 1 for r in state.layout.records)


def errors(state: State, t: float) -> dict[str, dict[str, float]] | None:
    """L2 errors at time t [s]: kind of layer -> name -> sqrt(h sum (difference)^2), and "combined" over the unknowns.

    Over the active points without ghosts, all layers of a kind together. None without an exact solution. Collective.
    """
    if any(layer.exact is None for layer in state.problem.layers):
        return None
    compared = {"fluid": ("rho", "u", "T"), "solid": ("u", "sigma", "T", "x")}
    sums = {kind: np.zeros(len(names)) for kind, names in compared.items()}
    for k, layer in enumerate(state.problem.layers):
        record = state.layout.records[k]
        if not record["present"]:
            continue
        q, _ = fields(state, k)
        exact = layer.exact(state.layout.owned_X(k), t)
        index = np.arange(record["own_lo"], record["own_hi"])
        counted = (index >= record["lo"]) & (index <= record["hi"])
        for side, ghost in ((0, record["lo"]), (1, record["hi"])):
            if isinstance(layer, FluidLayer) and record["end_kind"][side] >= 0:
                counted &= index != ghost
        for c in range(len(compared[layer.kind])):
            sums[layer.kind][c] += state.h * np.sum((q[counted, c] - np.broadcast_to(exact[c], index.shape)[counted]) ** 2)
    result = {}
    for kind, names in compared.items():
        squares = state.comm.allreduce(sums[kind])
        result[kind] = {name: float(v) for name, v in zip(names, np.sqrt(squares), strict=True)}
        result[kind]["combined"] = float(np.sqrt(squares.sum()))
    return result
