"""Compiled parts of the paper's method made callable, with materials and records to call them."""

from __future__ import annotations

from functools import cache

import numpy as np
from helpers import from_python

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.materials.fluid import Fluid
from fsipetsc.paper import ends, stencils
from fsipetsc.paper.ends import NODES
from fsipetsc.paper.laws import Gas, law_of
from fsipetsc.paper.layout import RECORD

AIR = Fluid(mu=0.5, kappa=0.7, gamma=1.4, R=287.0)
GAS = law_of(AIR)
H, HALO = 0.01, 14
_fill, _seen = from_python(ends.fill_ghost), from_python(ends.gradient_values)
insulated_slopes = from_python(ends.insulated_slopes)
lagrange, dirichlet_ghost, neumann_ghost, extrapolated = map(
    from_python,
    (stencils.lagrange, stencils.dirichlet_ghost, stencils.neumann_ghost, stencils.extrapolated),
)


@cache
def operator_of(order: int, narrow: bool = False) -> np.void:
    """The record that compiled code takes."""
    return stencils.packed(order, narrow)[0]


def gas_record(n: int, lo: int = 0, hi: int | None = None, h: float = H) -> np.void:
    """A gas of n stored points, lo..hi of them active, all on this rank."""
    layer = np.zeros(1, RECORD)[0]
    layer["n"], layer["lo"], layer["hi"], layer["own_hi"] = n, lo, n - 1 if hi is None else hi, n
    layer["h"], layer["s"], layer["halo"], layer["present"] = h, -3.0, HALO, 1
    layer["end_kind"] = INTERFACE_END
    return layer


def conserved(gas: Gas, rho, u, T) -> np.ndarray:
    """(rho, rho u, e) side by side."""
    rho, u, T = np.broadcast_arrays(rho, u, T)
    return np.stack([rho, rho * u, gas.total_energy(rho, u, T)], axis=-1)


def primitive(gas: Gas, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rho, u, T."""
    return q[..., 0], *gas.velocity_and_temperature(*np.moveaxis(q, -1, 0))


def filled(
    gas: Gas,
    layer: np.void,
    side: int,
    delta: float,
    values: np.ndarray,
    new: bool = False,
    order: int = 4,
) -> tuple[np.ndarray, np.ndarray]:
    """((rho, u, T) of the ghost point, (u, T) that the gradients see there).

    values: (3, nodes) of (rho, u, T), the ghost point first; the boundary is delta cells inside of
    it. layer: of at least NODES points more than there are nodes.
    """
    n = min(40, int(layer["n"]))  # those that this rank owns
    layer["own_lo"] = (int(layer["n"]) - n) * side
    layer["own_hi"] = layer["own_lo"] + n
    known = values[:, :NODES]
    nodes = np.pad(known, ((0, 0), (0, max(0, n - known.shape[1]))), mode="edge")[:, :n]
    q = conserved(gas, *(nodes if side == 0 else nodes[:, ::-1]))
    ghost = 0 if side == 0 else n - 1
    if new:
        q[ghost] = np.nan
    layer["x_interface"] = 0.0
    layer["end_x"][side] = (2 * side - 1) * (int(layer["n"]) - 1 - delta) * layer["h"]
    before = q.copy()
    op = operator_of(order)
    _fill(op, gas, layer, q, side, new)
    inside = np.arange(n) != ghost
    assert np.array_equal(q[inside], before[inside]), "nothing else changes"
    seen = (
        np.array(_seen(gas, layer, q, ghost, side)) if layer["end_kind"][side] > 0 else np.zeros(2)
    )
    return np.array([v[ghost] for v in primitive(gas, q)]), seen
