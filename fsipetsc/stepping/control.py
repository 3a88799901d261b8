"""Step-size control by an embedded Runge-Kutta pair, on the solution as the interfaces and boundaries see it.

PETSc's own controllers compare the two solutions of a pair before they are projected, where ghost points and
interface values have drifted off. Here both are projected first; the rest is PETSc's basic controller: the step is
accepted if the weighted norm of the difference is at most one, and the next one is changed by
safety * norm^(-1/order), within the clip.
"""

from __future__ import annotations

import ctypes

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.stepping.state import State

SAFETY, REJECT_SAFETY, CLIP = 0.9, 0.5, (0.1, 10.0)


class ErrorControl:
    """Accepts or rejects steps of ``ts`` and proposes the next one. All methods are collective.

    order: of the method; atol, rtol: tolerances as in TSSetTolerances.
    """

    def __init__(self, ts: PETSc.TS, state: State, order: int, atol: float, rtol: float) -> None:
        self._ts, self._state = ts, state
        self._order, self._atol, self._rtol = order, atol, rtol
        self._embedded = state.solution.duplicate()
        self._before = state.solution.duplicate()
        self._library = ctypes.CDLL(PETSc.__file__)
        self.rejections = 0

    def begin(self) -> None:
        """Keep the solution before a step: a rejected one goes back to it."""
        self._state.solution.copy(self._before)

    def embedded(self) -> None:
        """Take the pair's second solution; before the first one is completed."""
        code = self._library.TSEvaluateStep(
            ctypes.c_void_p(self._ts.handle),
            ctypes.c_int(self._order - 1),
            ctypes.c_void_p(self._embedded.handle),
            None,
        )
        if code:
            raise PETSc.Error(code)

    def norm(self) -> float:
        """Weighted root mean square of the difference of the two solutions, projected, over the active unknowns.

        To be asked before the step is completed: the boundaries must not have moved over the grid.
        """
        state = self._state
        first, y = state.solution.getArray(readonly=True).copy(), self._embedded.getArray()
        state.project(first)
        state.project(y)
        parts = []
        for k, record in enumerate(state.layout.records):
            if record["present"]:
                own = np.arange(record["own_lo"], record["own_hi"])
                active = (own >= record["lo"]) & (own <= record["hi"])
                a, b = state.layout.local(k, first)[active], state.layout.local(k, y)[active]
                scale = self._atol + self._rtol * np.maximum(np.abs(a), np.abs(b))
                parts.append((((a - b) / scale) ** 2).ravel())
        return float(np.sqrt(mean(state.comm, np.concatenate(parts))))

    def decide(self, dt: float, norm: float) -> tuple[bool, float]:
        """(accepted, proposal for the next step) after a step dt whose error has the norm."""
        if not np.isfinite(norm):  # the step made no sense
            return False, dt * CLIP[0]
        accepted = norm <= 1.0
        safety = SAFETY if accepted else SAFETY * REJECT_SAFETY
        factor = CLIP[1] if norm == 0 else safety * norm ** (-1.0 / self._order)
        return accepted, dt * min(max(factor, CLIP[0]), CLIP[1] if accepted else 1.0)

    def reject(self) -> None:
        """Undo the step."""
        self._ts.rollBack()
        self._before.copy(self._state.solution)
        self.rejections += 1

    def destroy(self) -> None:
        """Destroy the vectors."""
        self._embedded.destroy()
        self._before.destroy()


def mean(comm: MPI.Comm, values: np.ndarray) -> float:
    """Mean of values not below zero on all ranks, the same for any distribution; inf if one is not finite. Collective.

    In whole numbers of 2^-32 of the largest value, whose sum does not depend on the order.
    """
    largest = np.max(values, initial=0.0)
    largest = comm.allreduce(largest if np.isfinite(largest) else np.inf, MPI.MAX)
    if largest == 0.0 or largest == np.inf:
        return largest
    units = np.rint(values / largest * 2.0**32).astype(np.int64)
    total, count = comm.allreduce(np.array([units.sum(), units.size]), MPI.SUM)
    return float(total / count * (largest / 2.0**32))
