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

ACROSS = 0.6  # cells across the thickness are this over h


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
    with BlockState(MPI.COMM_SELF, problem, order) as state:
        state.set_initial()
        rest, owned, size = state.y.array.copy(), state.layout.owned, 1e-3
        f, nodes = np.empty_like(rest), len(owned(0, rest))
        K = np.empty((2 * nodes, 2 * nodes))
        for i in range(2 * nodes):
            y = rest.copy()
            owned(0, y)[i // 2, i % 2] += size  # of displacements, velocities, energy
            state.project(y)
            state.right_hand_side(y, f)  # linear, and 0 at rest
            K[:, i] = -owned(0, f)[:, 2:4].ravel() / size
    squares = np.linalg.eigvals(K).real
    # displacements that the conditions forbid do nothing: zeros
    return float(np.sqrt(squares[squares > 1e-11 * squares.max()].min()))


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
