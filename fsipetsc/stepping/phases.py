"""Where the time of a run goes: seconds per phase for the summary, stages for PETSc's -log_view."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any, TypeVar

from petsc4py import PETSc

Result = TypeVar("Result")

SET_UP, LOOP, OUTPUT = "set-up", "time loop", "output"


class Phases:
    """Wall time [s] of the phases of a run: one within another interrupts it, as in PETSc's log."""

    def __init__(self) -> None:
        self.seconds = {SET_UP: 0.0, LOOP: 0.0, OUTPUT: 0.0}
        logs = PETSc.Log.isActive()
        self._stages = {name: PETSc.Log.Stage(name) for name in self.seconds if logs}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Spend the time within on a phase, less that of phases within."""
        begun, others = time.perf_counter(), sum(self.seconds.values())
        try:
            with self._stages.get(name, nullcontext()):
                yield
        finally:
            within = sum(self.seconds.values()) - others
            self.seconds[name] += time.perf_counter() - begun - within


def logged(name: str, function: Callable[..., Result]) -> Callable[..., Result]:
    """The function as an event of PETSc's log; the function itself if nothing is logged."""
    if not PETSc.Log.isActive():
        return function
    event = PETSc.Log.Event(name)

    def call(*arguments: Any) -> Result:
        with event:
            return function(*arguments)

    return call
