"""Stages of a run, for PETSc's -log_view."""

from contextlib import AbstractContextManager, nullcontext
from typing import Any

from petsc4py import PETSc

SET_UP, LOOP, OUTPUT = "set-up", "time loop", "output"


def stage(name: str) -> AbstractContextManager[Any]:
    """What is done within belongs to a stage; one within another interrupts it."""
    return PETSc.Log.Stage(name) if PETSc.Log.isActive() else nullcontext()
