"""A rank's part of a solid block: initial data and what is saved, with a prestress."""

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.block_problem import BlockProblem
from fsipetsc.blocks.conditions import Free
from fsipetsc.blocks.maps import rectangle
from fsipetsc.materials.solid import ElasticSolid

BOX = rectangle((0.0, 0.0), (1.0, 2.0))
NUMBERS = {"mu_e": 1.3, "lambda_e": 2.1, "kappa_e": 0.1, "m0": 1.7, "alpha": 0.6}


def prestress(X, Y):
    return 0.3 * X, 0.1, -0.2 * Y, 0.4


def plate(heat="elastic", stress=prestress, cells=(8, 9), places=BOX):
    """At velocity (0.1, -0.2), of temperature 1.5, stretched by 1.1 and 0.9, so that J = 0.99."""
    material = ElasticSolid(**NUMBERS, law="log", heat=heat)
    initial = lambda X, Y: (0.1, -0.2, 1.5 + 0.0 * X, 1.1 * X, 0.9 * Y)  # noqa: E731
    return Block("plate", material, places, cells, initial, prestress=stress)


def problem_of(block):
    return BlockProblem((block,), {("plate", k, s): Free() for k in (0, 1) for s in (0, 1)})


def part_of(block):
    state = BlockState(MPI.COMM_SELF, problem_of(block), 4)
    part, q = state.parts[0], state.y.owned(0)
    part.initial(0.0, q)
    return part, q


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_initial_data_come_back(heat):
    """v, T and x; the stress is (P + S) F^T / J; e has the energy of both with heat 'elastic'."""
    made = plate(heat)
    part, q = part_of(made)
    found, (X, Y) = part.fields(q), part.X
    assert np.abs(found[:, :3] - [0.1, -0.2, 1.5]).max() < 1e-12
    assert np.abs(found[:, -2:] - np.array([1.1 * X, 0.9 * Y]).T).max() < 1e-13
    F, S = np.diag([1.1, 0.9]), np.array([[0.3 * X, 0.1 + 0 * X], [-0.2 * Y, 0.4 + 0 * X]])
    law = made.material.solid_law
    P = np.array(law.stress(tuple(F.ravel()))).reshape(2, 2, 1) + S
    cauchy = np.einsum("ijn,kj->ikn", P, F) / 0.99
    assert np.abs(found[:, 3:6].T - [*cauchy[0], cauchy[1, 1]]).max() < 1e-12
    stored = law.energy(tuple(F.ravel())) + np.einsum("ijn,ij->n", S, F - np.eye(2))
    mechanical = 0.025 + stored / 1.7 if heat == "elastic" else 0.025 + 0.0 * X
    assert np.abs(q[:, 4] - 0.9 - mechanical).max() < 1e-12
    (seen, sums), masses = part.monitor(q), part.weights * part.inertia[part.owned]
    assert seen[0] == 0.0 and sums[2] == pytest.approx(q[:, 4] @ masses)
    recorded = mechanical @ masses if heat == "elastic" else 0.0
    assert sums[-2] == pytest.approx(recorded, rel=1e-12) and sums[-1] == -sums[-2]
