"""A rank's part of a solid block: initial data and what is saved, with a prestress; halos."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.solid_part import SolidPart
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Free
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.blocks.values import prestress_of
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.parallel.block_layout import BlockLayout, halos_of
from fsipetsc.scheme.block_monitor import monitor_end

NUMBERS = {"mu_e": 1.3, "lambda_e": 2.1, "kappa_e": 0.1, "m0": 1.7, "alpha": 0.6}


def stretched(X, Y):
    """At velocity (0.1, -0.2), of temperature 1.5, stretched by 1.1 and 0.9, so that J = 0.99."""
    return 0.1, -0.2, 1.5 + 0.0 * X, 1.1 * X, 0.9 * Y


def prestress(X, Y):
    return 0.3 * X, 0.1, -0.2 * Y, 0.4


def block(heat="elastic", stress=prestress, **more):
    material = ElasticSolid(**NUMBERS, law="log", heat=heat)
    return Block(
        "plate",
        material,
        rectangle((0.0, 0.0), (1.0, 2.0)),
        (8, 9),
        stretched,
        prestress=stress,
        **more,
    )


def part_of(made):
    faces = {(made.name, axis, side): Free(0.0) for axis in (0, 1) for side in (0, 1)}
    layout = BlockLayout(MPI.COMM_SELF, BlockProblem((made,), faces), 4)
    return layout, SolidPart(layout, layout.parts[0], 4, BlockForm())


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_initial_data_come_back(heat):
    """v, T and x; the stress is (P + S) F^T / J; e has the energy of both with heat 'elastic'."""
    made = block(heat)
    layout, part = part_of(made)
    y = layout.vector()
    part.initial(0.0, y.owned(0))
    found = part.fields(y.owned(0))
    X, Y = part.X
    assert np.abs(found[:, :3] - [0.1, -0.2, 1.5]).max() < 1e-12
    assert np.abs(found[:, -2:] - np.array([1.1 * X, 0.9 * Y]).T).max() < 1e-13
    F, S = np.diag([1.1, 0.9]), np.array([[0.3 * X, 0.1 + 0 * X], [-0.2 * Y, 0.4 + 0 * X]])
    law = made.material.solid_law
    P = np.array(law.stress(tuple(F.ravel()))).reshape(2, 2, 1) + S
    cauchy = np.einsum("ijn,kj->ikn", P, F) / 0.99
    wanted = np.array([cauchy[0, 0], cauchy[0, 1], cauchy[1, 1]]).T
    assert np.abs(found[:, 3:6] - wanted).max() < 1e-12
    stored = (law.energy(tuple(F.ravel())) + np.einsum("ijn,ij->n", S, F - np.eye(2))) / 1.7
    e = 0.6 * 1.5 + 0.5 * 0.05 + (stored if heat == "elastic" else 0.0)
    assert np.abs(y.owned(0)[:, 4] - e).max() < 1e-12
    seen, sums = part.monitor(y.owned(0))
    assert seen[0] == 0.0 and sums[2] == pytest.approx((y.owned(0)[:, 4] * part._masses).sum())
    mechanical = ((0.025 + stored) * part._masses).sum() if heat == "elastic" else 0.0
    assert sums[-2] == pytest.approx(mechanical, rel=1e-12) and sums[-1] == -sums[-2]


@pytest.mark.parametrize("heat", ["coupled", "elastic"])
def test_what_is_recorded_of_an_end_in_one_dimension(heat):
    """D, v, the stress of the law with the prestress S, and T, as S (F - 1) is energy, too."""
    solid, S = ElasticSolid(**NUMBERS, law="log", heat=heat).equations(1), 0.3
    stored = (solid.law.energy((1.1,)) + S * 0.1) / 1.7 if heat == "elastic" else 0.0
    q, found = np.array([[0.05, 0.2, 0.6 * 1.5 + 0.02 + stored]]), np.zeros(4)
    monitor_end(solid, q, np.array([[1.1]]), 0, S, found)
    np.testing.assert_allclose(found, [0.05, 0.2, solid.law.stress((1.1,))[0] + S, 1.5], rtol=1e-13)


def test_a_state_whose_heat_is_gone_is_bad():
    """By the energy of the prestress, which T is found without."""
    layout, part = part_of(block(stress=lambda X, Y: (30.0, 0.0, 0.0, 0.0)))
    y = layout.vector()
    part.initial(0.0, y.owned(0))
    y.owned(0)[:, 4] -= 1.0
    assert y.owned(0)[:, 4].min() > 0.0 and part.monitor(y.owned(0))[0][0] == 1.0


def test_wrong_prestresses():
    with pytest.raises(InputError, match="prestress is 3"):
        block(stress=3)
    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    with pytest.raises(InputError, match="prestress is given: expected none, as it is a gas"):
        Block("gas", gas, rectangle(0.0, 1.0), (8,), lambda X: (1, 0, 1), prestress=lambda X: (1,))
    X = np.zeros((2, 3))
    with pytest.raises(
        InputError, match=r"returns 2 values: expected 4 values \(S_xx, S_xy, S_yx, S_yy\)"
    ):
        prestress_of(block(stress=lambda X, Y: (1.0, 2.0)), X)
    assert prestress_of(block(stress=None), X).shape == (4, 0)


def test_halos_of_solids():
    """Three reaches where temperatures follow from strains and are conducted."""

    def halo(**more):
        material = ElasticSolid(**{**NUMBERS, **more})
        made = SimpleNamespace(kind="solid", material=material)
        return halos_of(SimpleNamespace(blocks=[made], symmetry=0), 6)[0]

    assert halo(heat="elastic") == (9, True)
    assert halo(heat="coupled") == halo(heat="elastic", kappa_e=0.0) == (6, True)
