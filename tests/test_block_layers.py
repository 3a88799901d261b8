"""Blocks of flat layers: what meets, what stands at the other faces."""

import numpy as np
import pytest

from fsipetsc import Fluid, InputError, Problem, Solid, SolidLayer, free
from fsipetsc.blocks import conditions as new
from fsipetsc.blocks.block_problem import BlockFace
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.problem import blocks_of_line

GAS, SOLID = Fluid(0.1, 0.1, 1.4, 1.0), ElasticSolid(1.0, 1.0, 0.1, 1.0, 1.0)


def gas(across, **more):
    return Layer("gas", GAS, across, lambda *X: (1.0, *[0.0] * len(X), 1.0), **more)


def solid(across, **more):
    return Layer("solid", SOLID, across, lambda *X: (*[0.0] * len(X), 1.0, *X), **more)


def fit(*stack, **more):
    given = {"lower": new.NoSlip(), "upper": new.Free(), "along": ((0.0, 1.0),), "h": 0.125}
    return layers(*stack, **given | more)


def seen(found, k):
    """Of block k: face -> what stands there, (name of the block, axis, side) where it meets one."""
    names = [block.name for block in found.blocks]
    return {
        face: (names[kind.block], kind.axis, kind.side) if isinstance(kind, BlockFace) else kind
        for face, kind in found.kinds[k].items()
    }


def test_a_panel_in_a_wall():
    sides = {(0, 0): new.Slip(), (0, 1): new.Outflow(1.0)}
    panel = solid((-0.1, 0.0), cells=8, span=[(0.0, 1.0)], sides=new.Clamped())
    flow = gas((0.0, 0.5), sides=sides, beside=new.Slip())
    found = fit(panel, flow, along=((-0.5, 1.5),), lower=new.Free(1.0), upper=new.NoSlip())
    assert [block.name for block in found.blocks] == ["solid", "gas 1", "gas 2", "gas 3"]
    assert [block.cells for block in found.blocks] == [(8, 8), (4, 4), (8, 4), (4, 4)]
    places = (0, 0), (0, 1), (1, 0), (1, 1)
    wanted = (
        (new.Clamped(), new.Clamped(), new.Free(1.0), ("gas 2", 1, 0)),
        (new.Slip(), ("gas 2", 0, 0), new.Slip(), new.NoSlip()),
        (("gas 1", 0, 1), ("gas 3", 0, 0), ("solid", 1, 1), new.NoSlip()),
        (("gas 2", 0, 1), new.Outflow(1.0), new.Slip(), new.NoSlip()),
    )
    assert [seen(found, k) for k in range(4)] == [dict(zip(places, faces)) for faces in wanted]


def test_what_layers_cannot_be():
    with pytest.raises(InputError, match=r"ends at 0\.5, 'solid' begins at 0\.6"):
        fit(gas((0.0, 0.5)), solid((0.6, 1.0)))
    with pytest.raises(InputError, match=r"0\.125 apart from 0 to 1"):
        fit(gas((0.0, 0.5)), solid((0.5, 1.0), span=[(0.1, 0.6)]))


def test_initial_stress_that_is_short_against_its_layer():
    """A pulse of stress alone, and one that is all strain: it leaves no prestress."""
    K, X, width = 2e11, np.linspace(0.0, 1.0, 4001), 2e-3
    pulse = lambda X: np.where(abs(X - 0.505) < 0.0045, 1e6, 0.0)  # noqa: E731
    shift = lambda X: 1e-6 * width * np.exp(-(((X - 0.505) / width) ** 2))  # noqa: E731
    slope = lambda X: -2.0 * (X - 0.505) / width**2 * shift(X)  # noqa: E731
    for stress, x, left in (
        (pulse, lambda X: X, pulse(X)),
        (lambda X: K * np.log1p(slope(X)), lambda X: X + shift(X), 0.0 * X),
    ):

        def start(X, stress=stress, x=x):
            return 0 * X, stress(X), 300.0 + 0 * X, x(X)

        rod = SolidLayer("rod", Solid(K, 0.0, 7800.0, 450.0), (0.0, 1.0), start)
        (block,) = blocks_of_line(Problem((rod,), free(), free()), 1 / 4000, 4).blocks
        assert np.abs(block.prestress(X)[0] - left).max() < 10.0
