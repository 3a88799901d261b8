"""Steps of blocks on all ranks against those on one, and an error that one rank meets: says, as
JSON, how many bits differ, what is in no ledger, and what the ranks know of the error.
"""

from __future__ import annotations

import json
import sys

import block_shapes as shapes
import numpy as np
from block_ledgers import steps_of, unbooked
from ledger_problems import N, closed, gas, moved, problem_of, solid
from mpi4py import MPI

from fsipetsc.blocks.conditions import Clamped, Free, NoSlip, Slip

WORLD = MPI.COMM_WORLD


def panel(name, axis, side):
    return closed(name, axis, side) if name.startswith("gas") else Clamped()


def moving(name, axis, side):
    if axis == 0:
        return closed(name, axis, side)
    return Slip(x=moved) if name == "gas" else Free(0.4, T=1.2)


def differences(problem):
    """Numbers of this rank's part that are not those of one rank alone; and the difference of what
    came in through faces.
    """
    with steps_of(problem, alone=True) as alone, steps_of(problem, comm=WORLD) as shared:
        alone.step(1e-3, 2)
        shared.step(1e-3, 2)
        found = 0
        for part in shared.layout.parts:
            whole = alone.y.owned(part.k)[part.numbers]
            found += int((shared.y.owned(part.k) != whole).sum())
        size = np.abs(alone.face_energies()).max() or 1.0  # nothing comes into the panel
        energies = np.abs(shared.face_energies() - alone.face_energies()).max() / size
        return WORLD.allreduce(found), float(energies)


def warm(X, Y, t):
    """Wrong after a while at a place that one rank has."""
    return np.where((X > 0.9) & (t > 1e-3), -1.0, 1.2)


def faults():
    """What each rank knows after steps with a wrong wall."""

    def faces(name, axis, side):
        return NoSlip(T=warm) if (name, axis, side) == ("gas", 1, 0) else closed(name, axis, side)

    problem = problem_of(shapes.layers(N + 1, False), faces, gas(), solid())
    with steps_of(problem, comm=WORLD) as run:
        run.step(1e-3, 3)
        return WORLD.allgather(str(run.scheme.fault or ""))


def main():
    problems = {
        "panel": problem_of(shapes.panel(N + 1), panel, gas(mu=0.02), solid()),
        "slipping": problem_of(shapes.layers(N + 1, False), moving, gas(), solid()),
    }
    said = {name: differences(problem) for name, problem in problems.items()}
    said["unbooked"] = float(np.abs(unbooked(problems["slipping"], comm=WORLD)[0]).max())
    said["faults"] = faults()
    if WORLD.rank == 0:
        print(json.dumps(said))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
