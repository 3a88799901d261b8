"""Steps of blocks without files: how far integrals are from what has come in."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm, make_scheme
from fsipetsc.blockrun.columns import gained
from fsipetsc.blockrun.fused import FusedRK4
from fsipetsc.parallel.block_layout import BlockLayout


def scheme_of(layout, problem, order, form, instant=1e-4):
    """The scheme of a layout, whose record of steps nobody reads."""
    scheme = make_scheme(layout, problem, order, form, lambda: instant)
    names = "mass", "momentum_x", "energy", "entropy"
    scheme.attach({name: slice(0, 1) for name in names}, [], False)
    return scheme


class Steps:
    """A problem in time by RK4; y: the solution, completed, at time t."""

    def __init__(self, problem, order=2, comm=MPI.COMM_SELF, form=None):
        self.problem, self.comm = problem, comm
        self.gases = sum(block.kind == "fluid" for block in problem.blocks)
        behind = gained(self.gases, problem.dimension).itemsize // 8
        self.layout = BlockLayout(comm, problem, order, behind=behind)
        self.scheme = scheme_of(self.layout, problem, order, form or BlockForm(), 1e-3)
        self.y, stage = self.layout.vector(), self.layout.vector()
        self._stepper = FusedRK4(self.layout, self.scheme, stage)
        self.t = 0.0
        self.scheme.initial(0.0, self.y)
        self.scheme.stretch(0.0, self.y)
        self.scheme.complete(0.0, self.y)
        self.came = np.zeros(behind)
        self.y.behind[:] = 0.0

    def integrals(self):
        """Mass of all gas, momentum, energy."""
        self.y.begin()
        self.y.end()
        self.scheme.bounds(self.t, self.y)
        found = self.scheme.integrals(self.t, self.y)
        names = [f"momentum_{x}" for x in "xyz"[: self.problem.dimension]]
        mass = np.sum(found.get("mass", 0.0))
        return self._all(np.array([mass, *(found[name] for name in names), found["energy"]]))

    def _all(self, numbers):
        return self.comm.allreduce(numbers)

    def step(self, dt, steps=1):
        for _ in range(steps):
            self._stepper.step(self.t, dt, self.y)
            self.t += dt
            self.came += self.y.behind
            self.y.behind[:] = 0.0

    def gained(self):
        """What has come in: mass of all gas, impulse, energy."""
        came = self._all(self.came)
        return np.array([came[: self.gases].sum(), *came[self.gases :]])

    def close(self):
        self.scheme.destroy()
        self.y.destroy()


@contextmanager
def steps_of(problem, *arguments, **options):
    """Steps of a problem, closed in the end."""
    steps = Steps(problem, *arguments, **options)
    try:
        yield steps
    finally:
        steps.close()


def unbooked(problem, dt=1e-3, steps=3, order=2, comm=MPI.COMM_SELF):
    """(what is in no ledger, what has come in), mass, momentum, energy, over the energy."""
    with steps_of(problem, order, comm) as run:
        before = run.integrals()
        run.step(dt, steps)
        came = run.gained()
        change = run.integrals() - before - came
        return change / before[-1], came / before[-1]
