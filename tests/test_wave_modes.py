"""Modes of a gas over an elastic layer: the spectral solution, the linear scheme, and runs."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.blockrun.block_state import BlockState
from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.studies.linear import column_modes, step_limit

#: a gas of height 1 over an elastic layer of depth 1/2, wave number 2 pi: by a spectral method
KNOWN = (-0.367881432498 + 4.726877249787j, -0.433440151802 + 10.993326674370j)
MU, GAMMA = 0.01, 1.4
STONE = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, heat="elastic")


def stack(gas, solid, n, columns, depth=1.0, length=1.0):
    """Gas at rest over a clamped solid, n cells in each; so many columns in a length."""
    solid = replace(solid, p_ref=gas.R)
    members = (
        Layer("solid", solid, (-depth, 0.0), lambda X, Y: (0.0, 0.0, 1.0, X, Y), cells=n[0]),
        Layer("gas", gas, (0.0, 1.0), lambda X, Y: (1.0, 0.0, 0.0, 1.0), cells=n[1]),
    )
    ends = {"lower": Clamped(), "upper": NoSlip() if gas.mu > 0 else Slip()}
    return layers(*members, **ends, along=((0.0, length),), cells=(columns,))


def modes_of(problem, order):
    """Eigenvalues of what has one wave along the layers."""
    with BlockState(MPI.COMM_SELF, problem, order) as state:
        return column_modes(state, 0, 1)[0]


def test_normal_modes():
    """4/2 with 32 cells, and 6/3 with 36."""

    def distances(order, n):
        gas = Fluid(MU, MU * 3.5 / 0.72, GAMMA, 1.0)
        values = modes_of(stack(gas, STONE, (n // 2, n), n, depth=0.5), order)
        return np.array([np.abs(values - s).min() / abs(s) for s in KNOWN])

    four, coarse = distances(4, 32), distances(4, 16)
    assert (four < (7e-4, 4e-5)).all() and (np.log2(coarse / four) > 3.8).all()
    assert (distances(6, 36) < (1.4e-4, 1.8e-5)).all()


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_nothing_grows_and_the_step_is_kept(order):
    """Waves of 6 columns and more; 0.8 of the step of the faster one of sound and P waves."""
    n = {2: 12, 4: 12, 6: 12, 8: 16}[order]
    for density, stiffness, columns in ((1e-3, 1.0, n), (1.0, 100.0, 2 * n), (1e3, 1e-2, n)):
        moduli = stiffness / 4, stiffness / 2
        solid = ElasticSolid(*moduli, 0.0, density, 1.0 / density, heat="elastic")
        gas = Fluid(0.0, 0.0, GAMMA, 1.0)
        values = modes_of(stack(gas, solid, (n, n), columns, length=columns / n), order)
        assert values.real.max() < 1e-11 * np.abs(values).max()
        fastest = max((stiffness / density) ** 0.5, GAMMA**0.5)
        assert step_limit(values) * fastest * n > 0.8
