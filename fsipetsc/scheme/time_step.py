"""Where the length of a step comes from: the rates of all layers, their 4-norm, and the next time that must be hit.

``bound_step`` is compiled, and collective on all ranks; the rest is for Python and for compiled code.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.formulas import with_chosen
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.scheme.extremes_and_sums import SIZE
from fsipetsc.scheme.laws import LAWS, of_layer
from fsipetsc.scheme.plan import BAD, RATE, SAID_STOP, STOP
from fsipetsc.scheme.reduction import reduce_extremes

#: a step may be longer than its bound by this fraction, so that round-off costs no extra step
SLACK = 1e-9


def longest_step(courant, fixed, rate):
    """Bound on a step [s]: the one that is given (-ts_dt), or 0 and then the Courant number times 1/``rate``."""
    return fixed if fixed != 0.0 else courant / rate


def next_step(t, target, bound):
    """(step, time after it) [s]: at most ``bound``; with less than two steps to the target they are equal."""
    left = target - t
    if left <= bound * (1 + SLACK):
        return left, target
    step = left / 2 if left < 2 * bound else bound
    return step, t + step


@njit(**OPTIONS)
def bound_step(head, layers, memory):
    """Bounds on the time step: RATE = 1/dt at Courant number 1, BAD > 0 where the state is unphysical anywhere.

    STOP is the largest SAID_STOP of all ranks. 1/dt is the 4-norm of the largest rates of convection, (|u-w| + c)/(J h)
    in fluids and c_s/h in solids, and of diffusion, z max(mu'/rho, kappa/(rho cv))/(J h)^2 and z kappa_e/(alpha m0 x_X h^2),
    z the stiffness of the second derivative: 2 for D twice, more for narrow ones (fsipetsc.operators.narrow).
    Convection counts more where shocks are spread over many points (``pace`` of fsipetsc.operators.sbp).
    The smaller of the two steps alone is too long where they are about equal: at a wall, where both act on the ghost
    point, the rod then fails for orders above 2 at Courant numbers above 0.7.
    """
    convection, diffusion, bad = fastest(head, layers, memory, head.extremes)
    stop = memory[U64(head.results + SAID_STOP)]
    if head.world.size > 1:
        bad, stop = reduce_extremes(head, layers, memory, bad, stop)
        convection, diffusion, _ = fastest(head, layers, memory, head.everywhere)
    squares = convection**2, diffusion**2
    memory[U64(head.results + RATE)] = np.sqrt(np.sqrt(squares[0] * squares[0] + squares[1] * squares[1]))
    memory[U64(head.results + BAD)], memory[U64(head.results + STOP)] = bad, stop


@njit(**OPTIONS)
def fastest(head, layers, memory, extremes):
    """Largest rates of convection and of diffusion [1/s], and 1 if a state is unphysical, from extremes of the layers."""
    convection, diffusion, bad, stiffness = 0.0, 0.0, 0.0, head.op.stiffness
    for k in range(layers.size):
        layer = layers[k]
        if layer.present == 0 and extremes == head.extremes:
            continue
        good, speed, spread = with_chosen(of_layer.speeds, LAWS, layer.law, layer, memory, extremes + SIZE * k)
        if good:
            spacing = layer.h * layer.J
            convection = max(convection, head.op.pace * speed / spacing)
            diffusion = max(diffusion, stiffness * spread / (spacing * spacing))
        else:
            bad = 1.0
    return convection, diffusion, bad
