"""What is noted of a completed step: the solution, what layers have gained, extremes and integrals of all layers. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.coupling.plane import KINETIC
from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.physics.layer import FLUID
from fsipetsc.physics.plane.layer import DOF, GAINED
from fsipetsc.scheme.plan import BAD as NOT_PHYSICAL
from fsipetsc.scheme.plan import RATE, STOP
from fsipetsc.scheme.plane.look import (
    BAD,
    CONVECTION,
    DIFFUSION,
    ENERGY,
    ENTROPY,
    LEAST_J,
    MASS,
    MOMENTUM_X,
    MOMENTUM_Y,
    WORDS,
)

#: numbers in an account beside two for each gas: energy, momentum, entropy, what came in of momentum and energy
OF_ALL = 7


@njit(**OPTIONS)
def put_away(layers, memory, begin, starts, solution):
    """The points of a completed step, from the area that begins with ``memory``, to this rank's part of the solution.

    begin: where layers begin there; starts: where their points stand in the solution.
    """
    for k in range(layers.size):
        layer = layers[k]
        if layer.width == 0:
            continue
        columns = (layer.own_x[1] - layer.own_x[0]) * DOF
        for j in range(layer.own_y[0], layer.own_y[1]):
            source = begin[k] + (j * layer.width + layer.own_x[0]) * DOF
            to = starts[k] + (j - layer.own_y[0]) * columns
            for i in range(columns):
                solution[U64(to + i)] = memory[U64(source + i)]


@njit(**OPTIONS)
def put_away_behind(layers, gains, sums, points, ends, state, solution):
    """Likewise what stands behind the layers.

    gains: where what layers gain stands in the solution. sums: (layers, 3, GAINED), of edges before, between and after what
    interfaces and edges do to them; ends: (n, 2), where the kinetic energy of a point of an interface goes, its number. state:
    the part of the solution before that.
    """
    for k in range(layers.size):
        if layers[k].width == 0:
            continue
        for c in range(GAINED):
            # gas and solid give each other momentum, and energy, where they meet
            before = sums[k, 0, c] if c == 1 or c == 2 else sums[k, 1, c]
            solution[U64(gains[k] + c)] = state[U64(gains[k] + c)] + (sums[k, 2, c] - before)
    for n in range(ends.shape[0]):
        solution[U64(ends[n, 0])] = points[U64(ends[n, 1]), KINETIC]


@njit(**OPTIONS)
def give_account(layers, words, gains, solution, extremes, rates, account):
    """Put what is known of all layers on this rank together; the solution forgets what they have gained.

    words: (layers, WORDS) of those that it has a part of; extremes: BAD, and -J of each layer; rates: (layers, 2), of
    convection and diffusion. account: mass of each gas, what of it came in, OF_ALL numbers.
    """
    fluids = (account.size - OF_ALL) // 2
    extremes[0], account[:], fluid = 0.0, 0.0, -1
    for k in range(layers.size):
        layer, w = layers[k], words[k]
        fluid += layer.kind == FLUID
        extremes[1 + k], rates[k, 0], rates[k, 1] = -np.inf, 0.0, 0.0
        if layer.width == 0:
            continue
        came = solution[U64(gains[k]) : U64(gains[k] + GAINED)]
        for c in range(WORDS):
            if not abs(w[c]) < np.inf:
                extremes[0] = 1.0
        extremes[0], extremes[1 + k] = max(extremes[0], w[BAD]), -w[LEAST_J]
        rates[k, 0], rates[k, 1] = w[CONVECTION], w[DIFFUSION]
        if layer.kind == FLUID:
            account[fluid], account[fluids + fluid] = w[MASS], came[0]
        of_all = account[2 * fluids :]
        of_all[0] += w[ENERGY]
        of_all[1] += w[MOMENTUM_X]
        of_all[2] += w[MOMENTUM_Y]
        of_all[3] += w[ENTROPY]
        for c in range(1, GAINED):
            of_all[3 + c] += came[c]
        came[:] = 0.0


@njit(**OPTIONS)
def give_bounds(extremes, layers, results, least_J):
    """Put what is known of all ranks, the largest of each, into results: STOP, BAD, and RATE = 1/dt at Courant number 1.

    extremes: STOP, BAD, -J of each of so many layers, their rates of convection and diffusion.
    """
    results[STOP], results[NOT_PHYSICAL], convection, diffusion = extremes[0], extremes[1], 0.0, 0.0
    for k in range(layers):
        least_J[k] = -extremes[2 + k]
        rates = 2 + layers + 2 * k
        convection, diffusion = max(convection, extremes[rates]), max(diffusion, extremes[rates + 1])
    convection, diffusion = convection * convection, diffusion * diffusion
    results[RATE] = np.sqrt(np.sqrt(convection * convection + diffusion * diffusion))
