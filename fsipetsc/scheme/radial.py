"""What a gas around an axis (kappa = 1) or a centre (2) has beside its fluxes. Compiled.

Fluxes through the areas A = |r|^kappa do not know that pressure and viscous stress act around the
axis, too. With S = D A (fsipetsc.blocks.radial_grid), the momentum gets

    (p - tau_o) S,    tau_o = mu (2 e/kappa - 2/3 (u_r + e)),    e = u S/J

with e the rates of all hoops together, u_r = A/J D u by entropy variables; the flux of the
momentum gets -2/3 mu e A, which e is in the divergence, that of the energy u times as much. Energy
has no source. p S is D(A p) of a uniform p, so that rest is kept, and what it does to the entropy
is what D A leaves of the fluxes; viscosity makes entropy at each node.
Source: SCHEME-BLOCKS.md, section 6.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from fsipetsc.operators.loops import INNER_CALL, node
from fsipetsc.scheme.normals import derivative
from fsipetsc.scheme.rows import Array


class Straight(NamedTuple):
    """Neither axis nor centre."""

    kind: int = 0

    def add(self, part, q, rates):
        """Nothing."""
        return None

    def bounds(self, metrics):
        """The metrics by which steps are bounded."""
        return metrics


class Radial(NamedTuple):
    """grid: fsipetsc.blocks.radial_grid. room: (3, N) for u/T, -1/T, the flux of hoops."""

    grid: Any
    room: Array

    def add(self, part, q, rates):
        """See the head of this file; q: (N, 4) ghosted, rates: (M, 4)."""
        add_pressure(part.laws, self.grid.source, q, part.patch, rates)
        if part.laws.mu > 0.0:
            of_axis = part.S[0], part.weight[0], part.patch.first[0]
            add_viscous(part.laws, self.grid, q, part.metrics, *of_axis, self.room, rates)

    def bounds(self, metrics):
        return self.grid.bounds


@njit(**INNER_CALL)
def add_pressure(gas, source, q, patch, rates):
    """p S."""
    first = patch.first[0]
    for i in range(rates.shape[0]):
        w = gas.primitive(node((0.0, 0.0, 0.0, 0.0), q, first + i))
        rates[i, 2] += w[1] * source[first + i]


@njit(**INNER_CALL)
def add_viscous(gas, grid, q, metrics, S, weight, first, room, rates):
    """What viscous stresses around the axis do."""
    source, kappa = grid.source, len(grid.hoops)
    scaled, inverse, flux = room
    for i in range(flux.size):
        w = gas.primitive(node((0.0, 0.0, 0.0, 0.0), q, i))
        scaled[i], inverse[i] = w[3] * w[5], -w[5]
        mu = gas.mu * gas.transport.viscosity(w[2])
        flux[i] = -2.0 / 3.0 * mu * w[3] * source[i] / q[i, 0] * metrics[0, i]
    for n in range(rates.shape[0]):
        i = first + n
        w = gas.primitive(node((0.0, 0.0, 0.0, 0.0), q, i))
        per_J, u, T = 1.0 / q[i, 0], w[3], w[2]
        out = metrics[0, i] * per_J * derivative(S, weight[i], 1, inverse, i, i)
        along = T * (metrics[0, i] * per_J * derivative(S, weight[i], 1, scaled, i, i) + u * out)
        e, mu = u * source[i] * per_J, gas.mu * gas.transport.viscosity(T)
        hoop = mu * (2.0 * e / kappa - 2.0 / 3.0 * (along + e))
        push, power = 0.0, 0.0
        for k in range(1, S.shape[0]):
            for sign in (1, -1):
                pair = i if sign > 0 else i - k
                if pair >= 0 and pair + k < S.shape[1] and S[k, pair] != 0.0:
                    j = i + sign * k
                    s = sign * 0.5 * S[k, pair] / weight[i]
                    push += s * (flux[j] + flux[i])
                    power += s * (flux[j] * q[j, 2] / q[j, 1] + flux[i] * u)
        rates[n, 2] += push - hoop * source[i]
        rates[n, 3] += power
