"""Steps of blocks without files: how far integrals are from what has come in."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.columns import gained, lossy, slices, step_record
from fsipetsc.blockrun.scheme import Scheme
from fsipetsc.parallel.block_layout import BlockLayout
from fsipetsc.scheme.block_monitor import MONITORED
from fsipetsc.scheme.plan import BATCH, FLAGS, LIMITS

#: what short steps may lose of the energy of solids: this part of all
LOST = 1e-9


def scheme_of(layout, problem, order, form, instant=1e-4, alone=False, pace=1.0):
    """The scheme of a layout, with what it takes of a run; latest: what the monitor found last."""
    blocks, record = len(problem.blocks), step_record(problem)
    own = np.dtype([(name, record[name]) for name in record.names[2:]])
    scheme = Scheme(layout, problem, order, form, lambda: instant, slices(own), [], alone)
    latest = np.zeros(own.itemsize // 8)
    extremes, rates = np.zeros(1 + MONITORED * blocks), np.zeros((blocks, 2))
    buffers = extremes, rates, np.zeros(FLAGS + LIMITS), latest
    buffers += np.zeros((4, 0)), pace, np.zeros(BATCH), np.zeros((1, latest.size + 2))
    scheme.attach(np.zeros(layout.local_size), np.zeros(layout.local_size), *buffers)
    scheme.latest, scheme.extremes = latest.view(own)[0], extremes
    return scheme


class Steps:
    """A problem in time by RK4; y: the solution, completed, at time t."""

    def __init__(self, problem, order=2, comm=MPI.COMM_SELF, form=None, alone=False, pace=1.0):
        self.problem, self.comm = problem, comm
        self.gases = sum(block.kind == "fluid" for block in problem.blocks)
        self.lossy, kind = lossy(problem), gained(problem)
        self.layout = BlockLayout(comm, problem, order, auxiliary=kind.itemsize // 8)
        of_run = form or BlockForm(), 1e-3, alone, pace
        self.scheme = scheme_of(self.layout, problem, order, *of_run)
        self.y, self._stage = self.layout.vector(), self.layout.vector()
        self.t = 0.0
        self.scheme.initial(0.0, self.y)
        self.scheme.stretch(0.0, self.y)
        self.scheme.complete(0.0, self.y)
        self.came, self._at = np.zeros(kind.itemsize // 8), slices(kind)
        self.y.auxiliary[:] = 0.0
        self.integrals()
        self._at_first = self.solid_energy()

    def monitor(self):
        """(blocks, 5) extremes of this rank's nodes: see fsipetsc.scheme.block_monitor."""
        self.y.begin()
        self.y.end()
        self.scheme.monitor(self.y)
        return self.scheme.extremes[1:].reshape(-1, MONITORED)

    def integrals(self):
        """Mass of all gas, momentum, energy."""
        self.monitor()
        found = self.scheme.latest
        names = [f"momentum_{x}" for x in "xyz"[: self.problem.dimension]]
        mass = np.sum(found["mass"]) if self.gases else 0.0
        return self._all(np.array([mass, *(found[name] for name in names), found["energy"]]))

    def solid_energy(self):
        """Kinetic and elastic energy of solids, where its losses are known, when last monitored."""
        return self._all(float(self.scheme.latest["solid_energy"]) if self.lossy else 0.0)

    def lost(self):
        """What steps have lost of it when last monitored: work less what it has gained."""
        work = self._all(self.came[self.gases]) if self.lossy else 0.0
        return work - (self.solid_energy() - self._at_first)

    def _all(self, numbers):
        return self.comm.allreduce(numbers)

    def step(self, dt, steps=1):
        for _ in range(steps):
            self.scheme.step(self.t, dt, self.y, self._stage)
            self.t += dt
            self.came += self.y.auxiliary
            self.y.auxiliary[:] = 0.0

    def gained(self):
        """What has come in: mass of all gas, impulse, energy."""
        impulse = [self._came(f"impulse_{x}")[0] for x in "xyz"[: self.problem.dimension]]
        mass = self._came("mass_in").sum() if self.gases else 0.0
        return np.array([mass, *impulse, self._came("energy_in")[0]])

    def face_energies(self):
        """(faces, 2) energy that has come in through each outer face, in the end by forces, and
        heat among it.
        """
        return np.stack([self._came("energy_face"), self._came("heat_face")], axis=-1)

    def _came(self, name):
        return self._all(self.came[self._at[name]])

    def close(self):
        self.scheme.destroy()
        self._stage.destroy()
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
        assert abs(run.lost()) < LOST * before[-1], run.lost()
        return change / before[-1], came / before[-1]
