"""The fused Runge-Kutta method as a TS type: PETSc asks for a step, compiled code makes it whole, and more of them.

What is one step for TS is a burst of them where nobody looks at single ones (-fsi_burst); the hook after the step
gives TS the time and the number of steps.
"""

from __future__ import annotations

from petsc4py import PETSc

from fsipetsc.stepping.state import State

#: the value of -ts_type that stands for it
NAME = "fused"


class FusedRK4:
    """Context of a TS of type python: the classical Runge-Kutta method of fourth order.

    Monitors, options and hooks stay TS's. The step starts from the completed solution and completes the new one.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._steady = state.problem.steady_data

    def step(self, ts: PETSc.TS) -> None:
        """A step of the length that is set, and those that follow in the same burst. Collective."""
        t, dt = ts.getTime(), ts.getTimeStep()
        self._state.step(t, dt, self._steady)
        self._state.solution.stateIncrease()
        ts.setTime(t + dt)
