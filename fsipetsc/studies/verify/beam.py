"""Free vibration of a clamped and of a hinged beam in vacuum."""

import numpy as np
from mpi4py import MPI

from fsipetsc import Block, BlockProblem
from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.conditions import Clamped, Free, Hinge
from fsipetsc.blocks.maps import rectangle
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.studies.verdicts import Compared, Expected, Measured, Solve, closures
from fsipetsc.studies.verify.data import reference
from fsipetsc.studies.wave_modes import modes_near

ACROSS = 0.6  # cells across the thickness are this over h
#: frequencies of thin beams, over sqrt(D/m)
THIN = {"clamped": 22.37, "hinged": np.pi**2}


def first_frequency(order: int, h: float, thickness: float, hinged: bool) -> float:
    """omega [1/s] of the slowest motion that bends the beam. InputError."""
    beam = ElasticSolid(1.0, 0.0, 0.0, 1.0, 1.0, law="linear", heat="elastic")
    where = rectangle((0.0, -0.5 * thickness), (1.0, 0.5 * thickness))
    cells = round(1 / h), round(ACROSS / h)
    block = Block("beam", beam, where, cells, lambda X, Y: (0, 0, 1, X, Y))
    ends = Free() if hinged else Clamped()
    faces = {("beam", axis, side): Free() if axis else ends for axis in (0, 1) for side in (0, 1)}
    points = tuple(("beam", (x, 0.0), Hinge()) for x in (0.0, 1.0)) if hinged else ()
    problem = BlockProblem((block,), faces, points=points)
    thin = THIN["hinged" if hinged else "clamped"] * np.sqrt(thickness**2 / 6.0)
    with BlockState(MPI.COMM_SELF, problem, order) as state:
        # 2/1 has a second mode near it, which alternates from node to node
        return float(modes_near(state, 0.9j * thin)[0].imag)


def measure(solve: Solve, order: int, h: float) -> Measured:
    table, errors = reference("beam"), {}
    for ends, thickness in (("clamped", 0.05), ("hinged", 0.02)):
        found = first_frequency(order, h, thickness, ends == "hinged") / np.sqrt(thickness**2 / 6.0)
        row = np.argmin(np.abs(table["d"] - thickness))
        errors[f"{ends}, d = {thickness:g}"] = Compared(found, table[ends][row])
    return Measured(errors)


SOURCE = "verify/beams.py (Timoshenko; Euler and Bernoulli in the thin limit)"
QUICK = {4: (1 / 20, 1 / 30)}
FULL = dict.fromkeys((2, 4, 6), (1 / 20, 1 / 40))
WHY = "order s + 1; errors: what the theory leaves open, a shear coefficient of 5/6 or π²/12"


def expected(quantity: str, order: int, h: float) -> Expected:
    table, (ends, thickness) = reference("beam"), quantity.split(", d = ")
    row = np.argmin(np.abs(table["d"] - float(thickness)))
    return Expected(closures(order), abs(1.0 - table[f"{ends} pi^2/12"][row] / table[ends][row]))
