"""Where the time of a run goes: seconds per phase for the summary, stages and events for PETSc's -log_view.

A phase that begins within another one interrupts it, here as in PETSc's log: the seconds of all phases add up to the
time since the first began. Compiled code makes a whole time step at once and is one event; what is inside of it is
told apart by the command ``bench`` (fsipetsc.bench.command).
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np
from petsc4py import PETSc

from fsipetsc.scheme.burst import MADE
from fsipetsc.scheme.runge_kutta import STAGES
from fsipetsc.stepping.counts import Traffic, completion_traffic, flops, path_traffic, stage_traffic
from fsipetsc.stepping.state import State

Result = TypeVar("Result")

SET_UP, LOOP, OUTPUT = "set-up", "time loop", "output"


class Phases:
    """Wall time [s] of the phases of a run, exclusive of each other; with -log_view also stages of PETSc's log."""

    def __init__(self) -> None:
        self.seconds = {SET_UP: 0.0, LOOP: 0.0, OUTPUT: 0.0}
        self._open: list[str] = []
        self._since = 0.0
        self._stages = {name: PETSc.Log.Stage(name) for name in self.seconds} if PETSc.Log.isActive() else {}

    @contextmanager
    def __call__(self, name: str, event: str | None = None) -> Iterator[None]:
        """Spend the time within on a phase; event: its name among the events of the phase."""
        stage, detail = self._stages.get(name), (PETSc.Log.Event(event) if self._stages and event else None)
        self._book()
        self._open.append(name)
        if stage:
            stage.push()
        if detail:
            detail.begin()
        try:
            yield
        finally:
            if detail:
                detail.end()
            if stage:
                stage.pop()
            self._book()
            self._open.pop()

    def total(self) -> float:
        """Of all of them so far [s]."""
        self._book()
        return sum(self.seconds.values())

    def _book(self) -> None:
        """The time since the last change belongs to the innermost open phase."""
        now = time.perf_counter()
        if self._open:
            self.seconds[self._open[-1]] += now - self._since
        self._since = now


def logged(name: str, function: Callable[..., Result]) -> Callable[..., Result]:
    """The function as an event of PETSc's log; the function itself if nothing is logged."""
    if not PETSc.Log.isActive():
        return function
    event = PETSc.Log.Event(name)

    def call(*arguments: Any) -> Result:
        event.begin()
        try:
            return function(*arguments)
        finally:
            event.end()

    return call


class LoggedState(State):
    """A state whose work appears in PETSc's log: time, floating-point operations, messages, reductions.

    MPI is called by compiled code, past PETSc's counters; so these are moved on by what the plan says a call sends.
    """

    def __init__(self, *arguments: Any) -> None:
        names = ("step", "rates", "complete", "grow", "initial")
        self._events = {name: PETSc.Log.Event(f"fsi {name}") for name in names}
        self._counters = {name: _counter(name) for name in ("isend", "irecv", "allreduce")}
        super().__init__(*arguments)
        self._measure()

    def _measure(self) -> None:
        self._stage, self._completion = stage_traffic(self.plan), completion_traffic(self.plan)
        rows = path_traffic(self.layout, self.plan)
        self._rows = Traffic(rows.rows, rows.row_bytes, 0, 0)
        self._flops = flops(self.plan)

    def step(self, t: float, dt: float, steady: bool) -> None:
        with self._events["step"]:
            super().step(t, dt, steady)
            made = max(1, int(self.burst[MADE]))
            self._count(self._stage, made * (STAGES - 1))
            self._count(self._completion, made)
            PETSc.Log.logFlops(made * STAGES * self._flops)

    def right_hand_side(self, y: np.ndarray, f: np.ndarray) -> None:
        with self._events["rates"]:
            super().right_hand_side(y, f)
            self._count(self._rows, 1)  # PETSc counts what its own exchanges send
            PETSc.Log.logFlops(self._flops)

    def finish(self) -> None:
        with self._events["complete"]:
            super().finish()
            self._count(self._completion, 1)

    def grow(self, noted: int = 0) -> None:
        with self._events["grow"]:
            super().grow(noted)
            self._measure()

    def restore(self, arrays: Mapping[str, np.ndarray], t: float) -> np.ndarray | None:
        rates = super().restore(arrays, t)
        self._measure()
        return rates

    def set_initial(self) -> None:
        with self._events["initial"]:
            super().set_initial()

    def _count(self, traffic: Traffic, times: int) -> None:
        """Move PETSc's counters on."""
        for name, number, size in (
            ("isend", traffic.sends, traffic.sent_bytes),
            ("irecv", traffic.sends, traffic.sent_bytes),
            ("allreduce", traffic.reductions, 0),
        ):
            count, length = self._counters[name]
            count.value += times * number
            length.value += times * size


def _counter(name: str) -> tuple[ctypes.c_double, ctypes.c_double]:
    """PETSc's counters of messages of a kind and of their bytes; ones that nobody reads where there are none."""
    library = ctypes.CDLL(PETSc.__file__)
    found = []
    for suffix in ("ct", "len"):
        try:
            found.append(ctypes.c_double.in_dll(library, f"petsc_{name}_{suffix}"))
        except ValueError:
            found.append(ctypes.c_double())
    return found[0], found[1]
