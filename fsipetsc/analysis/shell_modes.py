"""Small disturbances of blocks at rest in one dimension: the scheme's own rates, linearised.

Every unknown is disturbed by itself. Rates are those of the completed state, so that disturbances
which no particle can have have none; the others are those of what obeys all conditions.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fsipetsc.analysis.spectra import CENTRAL, Complex, Real
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.errors import InputError

#: how much a mode swings at least, over the largest |lambda|, and how rough it may be: see
#: fsipetsc.analysis.ring_modes
SWINGING, ROUGH = 1e-6, 1.0
#: sizes of disturbances over those of the unknowns
NUDGE = 1e-3
#: rates at rest, over the largest |lambda|
AT_REST = 1e-9


def shell_modes(
    problem: RunProblem,
    order: int,
    form: BlockForm = BlockForm(),  # noqa: B008
) -> Complex:
    """Angular frequencies omega [1/s] of the modes that swing, as exp(-i omega t), and are not
    rough, the slowest first. InputError where the initial data are not at rest.
    """
    with BlockState(MPI.COMM_SELF, problem, order, form) as state:
        state.compile(lambda text: None)
        state.set_initial()
        scales = _scales(state)
        values, vectors = np.linalg.eig(_linear(state, scales))
        swinging = values.imag < -SWINGING * np.abs(values).max()
        omega = 1j * values[swinging & (_roughness(state, vectors) < ROUGH)]
    return omega[np.argsort(omega.real)]


def _linear(state: BlockState, scales: Real) -> Real:
    """The matrix of rates over unknowns, both over their scales."""
    start = state.y.array.copy()
    f, size = np.zeros_like(start), scales.size
    found = np.zeros((size, size))

    def rates(i: int, change: float) -> Real:
        y = start.copy()
        y[i] += change * scales[i]
        state.right_hand_side(y, f)
        return f[:size] / scales

    at_rest = rates(0, 0.0)
    for i in range(size):
        for steps, weight in enumerate(CENTRAL, 1):
            apart = rates(i, steps * NUDGE) - rates(i, -steps * NUDGE)
            found[:, i] += weight / NUDGE * apart
    if np.abs(at_rest).max() > AT_REST * np.abs(found).max():
        raise InputError("the blocks are not at rest at first")
    return found


def _scales(state: BlockState) -> Real:
    """Of all unknowns: those at rest of a gas, and with its speed of sound."""
    found = []
    for k, block in enumerate(state.problem.layers):
        q, material = state.y.owned(k), block.material
        if block.kind == "fluid":
            w, mass = material.equations(1).primitive(tuple(q.T)), q[:, 1]
            c = np.sqrt(material.gas_law.sound_speed_squared(w[0], w[2]))
            rows = [q[:, 0], mass, mass * c, mass * c**2]
        else:
            c, one = np.sqrt(material.K / material.m0), np.ones(len(q))
            rows = [state.h * one, c * one, np.abs(q[:, 2]) + c**2]
        found.append(np.stack(rows, axis=1).ravel())
    return np.concatenate(found)


def _roughness(state: BlockState, vectors: Complex) -> NDArray[np.float64]:
    """Squares of differences of neighbours in a block over those of values, (modes,)."""
    squares, first = np.zeros((2, vectors.shape[1])), 0
    for (nodes,), dof in zip(state.layout.shapes, state.layout.dofs, strict=True):
        part = vectors[first : first + nodes * dof].reshape(nodes, dof, -1)
        first += nodes * dof
        squares += [(np.abs(a) ** 2).sum(axis=(0, 1)) for a in (np.diff(part, axis=0), part)]
    ratio: NDArray[np.float64] = squares[0] / squares[1]
    return ratio
