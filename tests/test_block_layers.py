"""Blocks of flat layers: what meets, what stands at the other faces."""

import pytest

from fsipetsc import Fluid, InputError
from fsipetsc.blocks import conditions as new
from fsipetsc.blocks.block_problem import BlockFace
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid

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
