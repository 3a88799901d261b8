"""Compiled parts of the paper's method made callable, with materials and records to call them."""

from __future__ import annotations

from functools import cache

import numpy as np
from helpers import from_python

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.operators import OPERATORS
from fsipetsc.paper import ends, rates, stencils
from fsipetsc.paper.ends import NODES
from fsipetsc.paper.laws import Gas, law_of
from fsipetsc.paper.layout import RECORD

AIR = Fluid(mu=0.5, kappa=0.7, gamma=1.4, R=287.0)
ROD = Solid(K=1e5, kappa_e=0.5, m0=2700.0, alpha=1.0, force=-10.0)
GAS, STEEL = law_of(AIR), law_of(ROD)
H, HALO = 0.01, 14
_fill, _seen = from_python(ends.fill_ghost), from_python(ends.gradient_values)
close_solid, insulated_slopes = from_python(ends.close_solid), from_python(ends.insulated_slopes)
gas_rates, elastic_rates = from_python(rates.gas_rates), from_python(rates.elastic_rates)
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


def solid_record(n: int) -> np.void:
    """A solid of n points, all on this rank."""
    return gas_record(n)


def conserved(gas: Gas, rho, u, T) -> np.ndarray:
    """(rho, rho u, e) side by side."""
    rho, u, T = np.broadcast_arrays(rho, u, T)
    return np.stack([rho, rho * u, gas.total_energy(rho, u, T)], axis=-1)


def primitive(gas: Gas, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rho, u, T."""
    return q[..., 0], *gas.velocity_and_temperature(*np.moveaxis(q, -1, 0))


def gas_state(n: int) -> np.ndarray:
    """(n, 3) conserved variables, smooth with some noise."""
    X, noise = np.linspace(0, 3, n), 1e-3 * np.random.default_rng(n).uniform(-1, 1, (3, n))
    rho, u, T = 1.2 + 0.2 * np.sin(X), 20 * np.cos(2 * X), 300 + 30 * np.sin(3 * X)
    return conserved(GAS, rho + noise[0], u + noise[1], T + noise[2])


def solid_state(n: int) -> np.ndarray:
    """(n, 4) of u, sigma, T, x, smooth with some noise."""
    X, noise = H * np.arange(n), np.random.default_rng(n).uniform(-1, 1, (4, n))
    smooth = (
        np.cos(2 * X),
        -1e5 + 1e4 * np.sin(3 * X),
        300 + 30 * np.sin(X),
        X + 0.1 * np.sin(2 * X),
    )
    noise = noise * np.array([1e-3, 1.0, 1e-3, 1e-5])[:, None]
    return np.stack([values + some for values, some in zip(smooth, noise, strict=True)], axis=-1)


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


def closure(order: int) -> np.ndarray:
    """The first row of D for h = 1, of the points that it reaches."""
    return np.array([float(w) for w in OPERATORS[order].closure[0]])[: operator_of(order)["n"]]
