"""Step-size control by an embedded Runge-Kutta pair, on the solution as the interfaces and boundaries see it.

PETSc's own controllers compare the two solutions of a pair before they are projected, where ghost points and
interface values have drifted off. Here both are projected first; the rest is PETSc's basic controller: the step is
accepted if the weighted norm of the difference is at most one, and the next one is changed by
safety * norm^(-1/order), within the clip.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fsipetsc.stepping.state import State


class ErrorControl:
    """Accepts or rejects steps of ``ts`` and proposes the next one. All methods are collective.

    order: of the method; opt: options in force, of which it follows -ts_atol, -ts_rtol and -ts_adapt_….
    """

    def __init__(self, ts: PETSc.TS, state: State, order: int, opt: Mapping[str, Any]) -> None:
        self._ts, self._state = ts, state
        self._order, self._atol, self._rtol = order, opt["ts_atol"], opt["ts_rtol"]
        self._safety, self._clip = opt["ts_adapt_safety"], opt["ts_adapt_clip"]
        self._reject_safety = opt["ts_adapt_reject_safety"]
        self.shortest, self.longest = opt["ts_adapt_dt_min"] or 0.0, opt["ts_adapt_dt_max"] or np.inf
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
        with np.errstate(all="ignore"):  # a step that makes no sense has a norm that is none
            for a, b in zip(state.unknowns(first), state.unknowns(y), strict=True):
                scale = self._atol + self._rtol * np.maximum(np.abs(a), np.abs(b))
                parts.append((((a - b) / scale) ** 2).ravel())
        return float(np.sqrt(mean(state.comm, np.concatenate(parts))))

    def decide(self, dt: float, norm: float) -> tuple[bool, float]:
        """(accepted, proposal for the next step) after a step dt whose error has the norm.

        Only the proposal after a refused step may be below ``shortest``: that step cannot be made.
        """
        least, most = self._clip
        if not np.isfinite(norm):  # the step made no sense
            return False, dt * least
        accepted = norm <= 1.0
        safety = self._safety if accepted else self._safety * self._reject_safety
        factor = most if norm == 0 else safety * norm ** (-1.0 / self._order)
        proposal = min(dt * min(max(factor, least), most if accepted else 1.0), self.longest)
        return accepted, max(proposal, self.shortest) if accepted else proposal

    def reject(self) -> None:
        """Undo the step."""
        self._ts.rollBack()
        self._before.copy(self._state.solution)
        self.rejections += 1

    def destroy(self) -> None:
        """Destroy the vectors."""
        self._embedded.destroy()
        self._before.destroy()


def begins_with_last_rates(ts: PETSc.TS) -> bool:
    """Whether the steps of a Runge-Kutta method of PETSc's begin with the last rates of the step before (FSAL)."""
    pointers, answer = [ctypes.c_void_p() for _ in range(5)], ctypes.c_int()
    stages, order = ctypes.c_int64(), ctypes.c_int64()  # PETSc's integers may have 32 bits
    A, b, c, embedded, interpolation = map(ctypes.byref, pointers)
    found = ctypes.byref(stages), A, b, c, embedded, ctypes.byref(order), interpolation, ctypes.byref(answer)
    code = ctypes.CDLL(PETSc.__file__).TSRKGetTableau(ctypes.c_void_p(ts.handle), *found)
    if code:
        raise PETSc.Error(code)
    return bool(answer.value)


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
