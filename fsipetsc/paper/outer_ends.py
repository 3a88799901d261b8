"""The outer ends of layers: ghost points at embedded boundaries of gases, which move over the grid,
and the end nodes of solids. The formulas of gases are those of fsipetsc.paper.gas_ends. A part is a
fsipetsc.paper.steps.Part.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fsipetsc.boundaries import Boundary, absorbing, clamped, free
from fsipetsc.kernels.loops import each, named, number, pick, stop, when, whole
from fsipetsc.paper import gas_ends
from fsipetsc.problem import Problem
from fsipetsc.scheme.plan import EXHAUSTED


@dataclass(frozen=True)
class Ends:
    """What a case says of the ends of a layer, left and right: facts of a procedure.

    kind: the class of what stands there, None at an interface. degree: of the formulas of an
    embedded boundary. heated: "T" or "heat_flux" where that is given, else "".
    """

    kind: tuple[type[Boundary] | None, ...]
    degree: tuple[int, ...]
    heated: tuple[str, ...]


def ends_of(problem: Problem, k: int, order: int) -> Ends:
    """The ends of layer k, with the operator of this interior order."""
    found = [problem.end(k, side) for side in (0, 1)]
    return Ends(
        tuple(None if end is None else type(end) for end in found),
        tuple(0 if end is None else end.degree or order // 2 + 1 for end in found),
        tuple("" if end is None else end.heated for end in found),
    )


def outer_side(ends: Ends) -> int:
    """Where the embedded boundary of a gas stands: 0 left, 1 right."""
    return 1 if ends.kind[0] is None else 0


def fill_ghost(part, side, new=False):
    """Give the ghost point its values, where a rank has the points that this takes: all who need it
    do. new: it has no values yet.
    """
    layer, n = part.layers[0], part.local.shape[1]
    ghost = named((layer.hi if side else layer.lo) - (layer.own_lo - layer.halo_lo))
    last = ghost + (1 - 2 * side) * gas_ends.depth_of(part.op)
    with when((0 <= ghost) & (ghost < n) & (0 <= last) & (last < n)):
        rho, u, T = ghost_values(part, layer, ghost, side, new)
        q, energy = part.local, part.law.total_energy(rho, u, T)
        q[0, ghost], q[1, ghost], q[2, ghost] = rho, rho * u, energy


def ghost_values(part, layer, ghost, side, new):
    """(rho, u, T) of the ghost point."""
    kind, nodes = part.ends.kind[side], gas_ends.fetch(part, ghost, side)
    if new:
        for values in nodes:  # without data the highest difference is left, which vanishes
            values[0] = gas_ends.dirichlet_ghost(
                0.0, values, [0.0] * gas_ends.NODES, gas_ends.NEW[kind] + 1, 1.0
            )
    return gas_ends.GHOSTS[kind](part, layer, side, 2.0 * side - 1.0, nodes)


def gradient_values(part, ghost, side):
    """(u, T) for the gradients in viscous stress and conduction at a ghost point that is filled."""
    find = gas_ends.GRADIENTS[part.ends.kind[side]]
    return find(part, part.layers[0], side, 2.0 * side - 1.0, gas_ends.fetch(part, ghost, side))


def move_boundary(part, side, results):
    """Let the ghost point be the first one at or beyond the boundary; results[EXHAUSTED]: 1 + the
    number of the layer if no point is left.

    A point that comes in is extrapolated and becomes the ghost point, the old one keeps its value;
    where the boundary moves inwards the last interior point becomes the ghost point. All ranks of a
    layer decide alike. Where the cells are not a number, the bounds on the step will tell.
    """
    layer = part.layers[0]
    cells = gas_ends.distance(layer, side) - 1e-9
    with when(cells < 1e15):
        below = whole(cells)
        target = below + pick(number(below) < cells, 1, 0)
        for _ in each(layer.n):
            stop(layer.hi - layer.lo >= target)
            exhausted = layer.hi == layer.n - 1 if side else layer.lo == 0
            with when(exhausted):
                results[EXHAUSTED] = 1.0 + number(layer.number)
            stop(exhausted)
            if side:
                layer.hi = layer.hi + 1
            else:
                layer.lo = layer.lo - 1
            fill_ghost(part, side, new=True)
        with when((layer.hi - layer.lo > target) & (target >= layer.least - 1)):
            if side:
                layer.hi = layer.lo + target
            else:
                layer.lo = layer.hi - target
            fill_ghost(part, side)


def close_solid(part):
    """Apply the conditions at the outer ends of a solid that this rank owns."""
    layer = part.layers[0]
    for side in range(2):
        if part.ends.kind[side] is not None:
            end = layer.hi if side else layer.lo
            with when((layer.own_lo <= end) & (end < layer.own_hi)):
                close_end(part, layer, side, named(end - (layer.own_lo - layer.halo_lo)))


def close_end(part, layer, side, i):
    """The same of the end that is point i of this rank."""
    solid, q, heated = part.law, part.local, part.ends.heated[side]
    step, n, beta = 1 - 2 * side, 2.0 * side - 1.0, part.op.closure[0]
    heat, d = layer.end_heat[side], -n / layer.h
    x_X = sum(d * v * q[3, i + step * j] for j, v in enumerate(beta))
    rest = sum(v * q[2, i + step * j] for j, v in enumerate(beta) if j > 0)
    slope = n * heat * x_X / (solid.kappa_e * d) if heated == "heat_flux" else 0.0
    imposed = heat if heated == "T" else (slope - rest) / beta[0]
    T = np.where(solid.kappa_e > 0.0, imposed, q[2, i])
    at_end = AtEnd(q[0, i], q[1, i], solid.pressure(T, x_X), T, x_X, layer.end_data[side, 0])
    q[2, i] = T
    q[0, i], q[1, i] = OF_SOLID[part.ends.kind[side]](solid, at_end, n)


class AtEnd(NamedTuple):
    """What is known of the end of a solid: velocity, sigma, p, temperature, x_X; what is given."""

    u: float
    sigma: float
    p: float
    T: float
    x_X: float
    given: float


def clamped_end(solid, end, n):
    """(u, sigma) where u is given."""
    return end.given, end.sigma


def free_end(solid, end, n):
    """(u, sigma) where sigma - p is given."""
    return end.u, end.given + end.p


def absorbing_end(solid, end, n):
    """(u, sigma) where sigma - p is given of the solid at rest beyond the end: the characteristic
    that leaves, sigma - p - n Z u, Z = m0 c, keeps its value.
    """
    u, sigma, p, T, x_X, given = end
    Z = np.sqrt(solid.wave_modulus(T, p, given + p, x_X) * solid.m0)
    w_o = sigma - p - given - n * Z * u
    return -n * 0.5 * w_o / Z, given + p + 0.5 * w_o


#: what a case says of an end of a solid -> its formula
OF_SOLID = {clamped: clamped_end, free: free_end, absorbing: absorbing_end}
