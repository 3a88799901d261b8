"""The energy of a solid, kept by a Runge-Kutta step to round-off. Compiled.

The right-hand side keeps sum_i H_i m0 (u^2/2 + alpha T), but u^2 is not linear, and a Runge-Kutta method does not keep it: its
error is of the fifth order in the step where the grid resolves the motion, and at a shock it does not. So what is integrated of
a point is T + u^2/(2 alpha), in the sum over the stages alone; at the end u^2/(2 alpha) of the new u is taken away again:

    sum = T + u^2/(2 alpha) + dt sum_k b_k (T_t + u u_t / alpha)_k,        T = sum - u^2/(2 alpha)

The stages themselves are those without. Nothing else changes: what the step makes of the kinetic energy, T gives or takes.

Not at end points that are given a velocity, or that an interface shares: the conservative coupling integrates the kinetic
energy of its point itself (fsipetsc.coupling.conservative).
"""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import ABSORBING, FREE
from fsipetsc.operators.kernels import OPTIONS, store_lanes
from fsipetsc.operators.memory import load
from fsipetsc.operators.vectors import LANES, fma
from fsipetsc.physics.layer import LOADED

#: number of the temperature among the unknowns
_T = 2


@njit(**OPTIONS)
def leave_energy(layer, s, w, target, i0, i1):
    """Of laws with which the time step has the errors that it has."""


@njit(**OPTIONS)
def keep_energy(layer, s, w, target, i0, i1):
    """After all rates of the points i0 .. i1-1 of a solid have been sent on; s, w: as of fsipetsc.scheme.sweep.

    The first stage of a step has another base than the sum, the last one no sum; mere rates have that for their source where
    they go, and are left alone.
    """
    if target.sum < 0 and target.source == target.next:
        return
    first = i0 if i0 > layer.lo or moves_freely(layer, 0) else i0 + 1
    end = i1 if i1 <= layer.hi or moves_freely(layer, 1) else i1 - 1
    part, T = 0.5 / layer.alpha, _T * target.stride
    for i in range(first, end, LANES):
        u, k = load(s, w + i), load(s, target.next + i) - load(s, target.source + i)
        if target.sum >= 0:
            gain = (2.0 * part * target.b / target.a) * (u * k)
            if target.base != target.sum:
                gain = fma(part * u, u, gain)
            to = target.sum + T + i
        else:
            after = load(s, target.next + i)
            gain = part * (2.0 * (u * k) - after * after)
            to = target.next + T + i
        store_lanes(s, to, load(s, to) + gain, 0, min(LANES, end - i))


@njit(**OPTIONS)
def moves_freely(layer, side):
    """Whether the velocity of an end point is what its rate makes of it."""
    return layer.unloaded[side] != LOADED and (layer.end_kind[side] == FREE or layer.end_kind[side] == ABSORBING)
