"""Small disturbances of blocks at rest in one dimension: the scheme's own rates, linearised.

Every unknown is disturbed by itself. Rates are those of the completed state, so that disturbances
which no particle can have have none; the others are those of what obeys all conditions.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fsipetsc.analysis.spectra import CENTRAL, Complex, Real
from fsipetsc.analysis.wave_modes import AT_REST, scales_of, swinging
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.blockrun.run_problem import RunProblem
from fsipetsc.errors import InputError

#: sizes of disturbances over those of the unknowns
NUDGE = 1e-3


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
        blocks = range(len(state.problem.layers))
        found = [scales_of(state, k, state.y.owned(k)).ravel() for k in blocks]
        scales = np.concatenate(found)
        values, vectors = np.linalg.eig(_linear(state, scales))
        layout = state.layout
        sizes = [(nodes, dof) for (nodes,), dof in zip(layout.shapes, layout.dofs, strict=True)]
        ends = np.cumsum([nodes * dof for nodes, dof in sizes])[:-1]
        parts = zip(np.split(vectors, ends), sizes, strict=True)
        return swinging(values, [part.reshape(*size, -1) for part, size in parts])


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
