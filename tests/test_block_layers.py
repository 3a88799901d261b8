"""Blocks of flat layers: what meets, what stands at the other faces; cases of one dimension."""

from __future__ import annotations

import numpy as np
import pytest

from fsipetsc import boundaries, problem
from fsipetsc.blockrun.from_layers import blocks_of_line
from fsipetsc.blocks import conditions as new
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.blocks.problem import Meeting
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.materials.solid import ElasticSolid

GAS, SOLID = Fluid(0.1, 0.1, 1.4, 1.0), ElasticSolid(1.0, 1.0, 0.1, 1.0, 1.0)


def gas(across, **more):
    return Layer("gas", GAS, across, lambda *X: (1.0, *[0.0] * len(X), 1.0), **more)


def solid(across, **more):
    return Layer("solid", SOLID, across, lambda *X: (*[0.0] * len(X), 1.0, *X), **more)


def seen(found, k):
    """Of block k: face -> what stands there, (name of the block, axis, side) where it meets one."""
    names = [block.name for block in found.blocks]
    return {
        face: (names[kind.block], kind.axis, kind.side) if isinstance(kind, Meeting) else kind
        for face, kind in found.faces_of(k).items()
    }


# -- layers


@pytest.mark.parametrize("d", [1, 2, 3])
def test_two_layers_that_go_on(d):
    """Periodic along, one interface, the ends below and above."""
    along = ((0.0, 1.0), (-1.0, 1.0))[: d - 1]
    stack = gas((0.0, 0.5), cells=4), solid((0.5, 1.0))
    found = layers(*stack, along=along, h=0.125, lower=new.NoSlip(), upper=new.Free(2.0))
    below, above = found.blocks
    assert below.cells == above.cells == (*(8, 16)[: d - 1], 4)
    assert below.periodic == above.periodic == (True,) * (d - 1) + (False,)
    across = d - 1
    assert seen(found, 0) == {(across, 0): new.NoSlip(), (across, 1): ("solid", across, 0)}
    assert seen(found, 1) == {(across, 0): ("gas", across, 1), (across, 1): new.Free(2.0)}
    low, high = (block.map(tuple(np.array([0.0, 1.0]) for _ in range(d))) for block in found.blocks)
    assert low[-1].tolist() == [0.0, 0.5] and high[-1].tolist() == [0.5, 1.0]


def test_a_panel_in_a_wall():
    """The gas is three blocks, joined; the walls beside the panel are one wall of one name."""
    sides = {(0, 0): new.Slip(), (0, 1): new.Outflow(1.0)}
    found = layers(
        solid((-0.1, 0.0), cells=8, span=[(0.0, 1.0)], sides=new.Clamped()),
        gas((0.0, 0.5), sides=sides, beside=new.Slip()),
        along=((-0.5, 1.5),),
        h=0.125,
        lower=new.Free(1.0),
        upper=new.NoSlip(),
    )
    assert [block.name for block in found.blocks] == ["solid", "gas 1", "gas 2", "gas 3"]
    assert [block.cells for block in found.blocks] == [(8, 8), (4, 4), (8, 4), (4, 4)]
    beside = new.Slip(name="gas lower beside")
    places = (0, 0), (0, 1), (1, 0), (1, 1)
    wanted = (
        (new.Clamped(), new.Clamped(), new.Free(1.0), ("gas 2", 1, 0)),
        (new.Slip(name="gas 0 0"), ("gas 2", 0, 0), beside, new.NoSlip()),
        (("gas 1", 0, 1), ("gas 3", 0, 0), ("solid", 1, 1), new.NoSlip()),
        (("gas 2", 0, 1), new.Outflow(1.0), beside, new.NoSlip()),
    )
    assert [seen(found, k) for k in range(4)] == [dict(zip(places, faces)) for faces in wanted]
    X = [found.places(k, found.face_nodes(k, 1, 0))[:, 0] for k in (1, 2, 3)]
    assert [(x[0], x[-1]) for x in X] == [(-0.5, 0.0), (0.0, 1.0), (1.0, 1.5)]


SPAN = {"span": [(0.25, 0.5)]}
WRONG = {
    "one or more of Layer": ((), {}),
    "ends at 0.5, 'solid' begins at 0.6": ((gas((0.0, 0.5)), solid((0.6, 1.0))), {}),
    "neither cells nor h": ((gas((0.0, 0.5)),), {"h": None}),
    "one for each of along": ((gas((0.0, 0.5)),), {"h": None, "cells": (8, 8)}),
    "0.125 apart from 0 to 1": ((gas((0.0, 0.5)), solid((0.5, 1.0), span=[(0.1, 0.6)])), {}),
    "span: expected": ((gas((0.0, 0.5)), solid((0.5, 1.0), span=[(0.25, 0.5)] * 2)), {}),
    "span: sides: nothing": ((gas((0, 0.5), beside=new.Slip()), solid((0.5, 1), **SPAN)), {}),
    "'solid' does not reach over all of it: expected beside": (
        *((gas((0.0, 0.5)), solid((0.5, 1.0), **SPAN, sides=new.Clamped())), {}),
    ),
}


@pytest.mark.parametrize("words", WRONG)
def test_layers_that_do_not_fit(words):
    stack, more = WRONG[words]
    given = {"lower": new.NoSlip(), "upper": new.Free(), "along": ((0.0, 1.0),), "h": 0.125}
    with pytest.raises(InputError, match=words):
        layers(*stack, **given | more)


# -- one dimension


def line(*stack, left=None, right=None, **more):
    """A Problem; ends: walls at the ends of gases, clamps of solids."""
    ends = []
    for end, layer, side in ((left, stack[0], 0), (right, stack[-1], 1)):
        usual = boundaries.Wall(layer.X[side]) if layer.kind == "fluid" else boundaries.clamped()
        ends.append(usual if end is None else end)
    return problem.Problem(stack, *ends, **more)


def line_gas(X, **more):
    name = more.pop("name", "gas")
    fluid = Fluid(0.1, 0.1, 1.4, 2.0)
    return problem.FluidLayer(name, fluid, X, lambda X: (1.0 + X, 0.0, 1.0), **more)


def line_solid(X, initial=lambda X: (0.0, -1.0 + 0.0 * X, 1.0, X), **more):
    return problem.SolidLayer("solid", Solid(4.0, 0.1, 1.0, 1.0), X, initial, **more)


CONVERTED = {
    "heated wall": ("left", boundaries.Wall(0.0, heat_flux=2.0), new.NoSlip(heat_flux=2.0)),
    "open": ("left", boundaries.Open(0.0, 3.0, 1.5, 0.25), new.Open(1.0, (0.25,), 1.5, 1)),
    "clamped": ("right", boundaries.clamped(), new.Clamped()),
    "heated clamp": ("right", boundaries.clamped(heat_flux=1.0), new.Clamped(heat_flux=1.0)),
    "free": ("right", boundaries.free(-2.0, T=3.0), new.Free(2.0, T=3.0)),
    "absorbing": ("right", boundaries.absorbing(-2.0), new.Absorbing(-2.0)),
}


def at_end(side, end):
    """What stands at the left or right end of a gas beside a solid."""
    old = line(line_gas((0.0, 1.0)), line_solid((1.0, 2.0)), **{side: end})
    k = 0 if side == "left" else 1
    return blocks_of_line(old, 0.125, 2).faces_of(k)[0, k]


@pytest.mark.parametrize("name", CONVERTED)
def test_ends_of_one_dimension(name):
    side, end, wanted = CONVERTED[name]
    assert at_end(side, end) == wanted


def test_ends_of_one_dimension_that_change_in_time():
    wall = boundaries.Wall(lambda t: 0.1 * t, T=lambda t: 1.0 + t, velocity=lambda t: 0.1)
    end, X = at_end("left", wall), np.zeros(1)
    found = [float(np.ravel(f(X, 2.0))[0]) for f in (end.x, end.velocity, end.T)]
    assert found == [0.2, 0.1, 3.0]
    given = at_end("left", boundaries.Dirichlet(0.0, lambda t: (1.0, t, 2.0)))
    assert [float(v) for v in np.ravel(given.values(X, 3.0))] == [1.0, 3.0, 2.0]
    assert at_end("right", boundaries.free(lambda t: -t)).pressure(X, 3.0) == 3.0
    assert at_end("right", boundaries.clamped(lambda t: 2.0 * t)).velocity(X, 3.0) == [6.0]
    assert at_end("right", boundaries.clamped(0.5)).velocity(X, 3.0) == (0.5,)


def test_a_wall_that_is_not_at_the_end_of_its_layer():
    """The gas reaches to it, with the data of the layer's points; a note says so."""
    old = line(line_gas((0.0, 1.0)), line_solid((1.0, 2.0)), left=boundaries.Wall(-1.0))
    found = blocks_of_line(old, 0.125, 2)
    X = found.places(0, np.arange(9))[:, 0]
    assert np.allclose(X, np.linspace(-1.0, 1.0, 9)) and found.faces_of(0)[0, 0] == new.NoSlip()
    assert np.allclose(found.blocks[0].initial(X)[0], np.linspace(1.0, 2.0, 9))
    assert len(found.notes) == 1 and "x = -1" in found.notes[0] and "'gas'" in found.notes[0]
    for wrong in (boundaries.Wall(1.0), boundaries.Wall(3.0)):
        old = line(line_gas((0.0, 1.0)), line_solid((1.0, 2.0)), left=wrong)
        with pytest.raises(InputError, match="in the order of X"):
            blocks_of_line(old, 0.125, 2)


def test_stress_that_follows_from_strain_is_no_prestress():
    """sigma = K ln x_X - p, whatever x: p_ref is p."""

    def strained(X):
        x = X + 0.1 * np.sin(3.0 * X)
        return 0.0, 4.0 * np.log(1.0 + 0.3 * np.cos(3.0 * X)) - 0.5, 1.0, x

    found = blocks_of_line(line(line_gas((0.0, 1.0)), line_solid((1.0, 2.0), strained)), 0.125, 2)
    assert found.blocks[1].material.p_ref == pytest.approx(0.5, abs=1e-9)


def test_jumps_in_one_dimension():
    """Seen from the solid: on either side, traction and heat that it gets from outside."""
    jumps = lambda k, t: (0.0, 2.0 + k, 0.0, 5.0 + t)  # noqa: E731
    stack = line_gas((0.0, 1.0)), line_solid((1.0, 2.0)), line_gas((2.0, 3.0), name="high")
    old = line(*stack, jumps=jumps)
    found = np.array(blocks_of_line(old, 0.125, 2).jumps(np.array([1.0, 2.0]), 1.0))
    assert found.tolist() == [[-2.0, 3.0], [-6.0, 6.0]]
    old = line(*stack, jumps=lambda k, t: (1.0, 0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="g_u = 1"):
        blocks_of_line(old, 0.125, 2).jumps(np.array([1.0]), 0.0)


def test_what_a_line_cannot_be():
    """A spacing that misses an interface; forcing of a stress that follows from x."""
    old = line(line_gas((0.0, 1.0)), line_solid((1.0, 2.0)))
    with pytest.raises(InputError, match=r"-fsi_h 0\.3 misses an interface"):
        blocks_of_line(old, 0.3, 2)
    forced = line_solid((1.0, 2.0), forcing=lambda X, t: (1.0, t, 2.0, 0.0))
    block = blocks_of_line(line(line_gas((0.0, 1.0)), forced), 0.125, 2).blocks[1]
    assert block.forcing(np.ones(1), 0.0) == (1.0, 2.0, 0.0)
    with pytest.raises(InputError, match="sigma has a right-hand side"):
        block.forcing(np.ones(1), 1.0)
