"""Blocks and problems made of them: maps, which faces meet, nodes at one place, messages."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest
from block_grids import GAS, SOLID, box, closed, joins, nothing

from fsipetsc.blocks import maps
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import (
    Clamped,
    Free,
    Hinge,
    NoSlip,
    Open,
    Periodic,
    Slip,
)
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.errors import InputError


def square(name="a", lower=(0.0, 0.0), upper=(1.0, 1.0), cells=(8, 8), material=GAS, **more):
    return Block(name, material, maps.rectangle(lower, upper), cells, nothing, **more)


STILL = NoSlip()


def walls(*names, but=(), condition=STILL):
    """A condition at all faces of blocks in 2-D, but for some (name, axis, side)."""
    return {
        (n, k, s): condition for n in names for k in (0, 1) for s in (0, 1) if (n, k, s) not in but
    }


# maps


def test_maps_take_corners_where_they_belong():
    ends = np.array([0.0, 1.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0, 1.0])
    x, y = maps.rectangle((1.0, 2.0), (3.0, 5.0))(ends)
    assert x.tolist() == [1, 3, 1, 3] and y.tolist() == [2, 2, 5, 5]
    x, y = maps.corners((0, 0), (2, 0), (0, 1), (3, 4))(ends)
    assert x.tolist() == [0, 2, 0, 3] and y.tolist() == [0, 0, 1, 4]
    x, y = maps.annulus(1.0, 2.0, (0.0, np.pi / 2), (5.0, 6.0))(ends)
    assert np.allclose(x, [6, 7, 5, 5]) and np.allclose(y, [6, 6, 7, 8])
    (x,) = maps.rectangle(-1.0, 4.0)((np.array([0.0, 0.5, 1.0]),))
    assert x.tolist() == [-1.0, 1.5, 4.0]
    grid = maps.stretched(maps.rectangle((0, 0), (2, 1)), lambda s: s**2, None)
    x, y = grid((np.array([0.5]), np.array([0.25])))
    assert (x[0], y[0]) == (0.5, 0.25)


@pytest.mark.parametrize("d", (2, 3))
def test_a_transfinite_map_is_exact_for_what_is_linear_in_each_coordinate(d):
    def body(*s):
        a, b, c = (*s, 0.3)[:3]
        return (1 + a + a * b + 2 * a * b * c, 2 * b - c * a, c + 0.3 * b)[:d]

    def face(axis, side):
        return lambda *s: body(*s[:axis], side + 0 * s[0], *s[axis:])

    grid = maps.transfinite(*((face(k, 0), face(k, 1)) for k in range(d)))
    xi = tuple(np.random.default_rng(1).random((d, 5)))
    assert np.allclose(grid(xi), body(*xi), atol=1e-14)


def square_of_faces():
    """Two faces of it do not meet."""
    left, right = (lambda s: (0 * s, s)), (lambda s: (1, s))
    return maps.transfinite((left, right), (lambda s: (s, 0), lambda s: (s, 2)))


WRONG_MAPS = {
    "upper above": lambda: maps.rectangle((0, 0), (1, 0)),
    "no more than 2 pi": lambda: maps.annulus(1.0, 2.0, (0.0, 7.0)),
    r"side 0\) and \(axis 1, side 1\) do not meet: \(X, Y\) = \(0, 1\)": square_of_faces,
    "takes 0 and 1 to 0 and 2": lambda: maps.stretched(maps.rectangle(0, 1), lambda s: 2 * s),
    "expected the shape": lambda: maps.nodes(np.zeros((3, 3))),
}


@pytest.mark.parametrize("message", WRONG_MAPS)
def test_wrong_maps_are_told(message):
    with pytest.raises(InputError, match=message):
        WRONG_MAPS[message]()


# blocks


WRONG_BLOCKS = {
    "Block: name is 'a|b'": {"name": "a|b"},
    "material is 'steel': expected a Fluid or an ElasticSolid": {"material": "steel"},
    r"cells is \(8, 0\) .*: expected 1, 2 or 3 whole numbers above 0": {"cells": (8, 0)},
    "its map has 2 dimensions, cells 3": {"cells": (8, 8, 8)},
    "map is 3: expected a function": {"map": 3},
    "its map gives 1 coordinates: expected 2": {"map": lambda xi: (xi[0],)},
    "its map fails: ZeroDivisionError": {"map": lambda xi: 1 / 0},
    r"gives .*nan.* at xi = \(0.31, ": {"map": lambda xi: (xi[0], xi[1] / (xi[0] != 0.31))},
    r"J = -0.0156 per cell at \(X, Y\) = .*right-handed": {"map": lambda xi: (xi[1], xi[0])},
    r"not smooth along axis 0, at \(X, Y\) = \(0.29": {
        "map": lambda xi: (xi[0] + 0.2 * abs(xi[0] - 0.3), xi[1])
    },
    r"its map has \(3, 3\) cells, the block \(8, 8\)": {"map": maps.nodes(np.zeros((4, 4, 2)))},
    "axis 0 is periodic, and its map is not": {
        "periodic": (True, False),
        "map": lambda xi: (xi[0], xi[1] * (1 + xi[0])),
    },
    "initial is None": {"initial": None},
}


@pytest.mark.parametrize("message", WRONG_BLOCKS)
def test_wrong_blocks_are_told(message):
    given = {"name": "a", "material": GAS, "map": maps.rectangle((0, 0), (1, 1)), "cells": (8, 8)}
    with np.errstate(all="ignore"), pytest.raises(InputError, match=message):
        Block(**{**given, "initial": nothing, **WRONG_BLOCKS[message]})


def test_nodes_count_from_axis_0_and_go_on_beyond_periodic_ends():
    block = square(cells=(4, 5), periodic=(True, False))
    assert (block.kind, block.dimension, block.shape) == ("fluid", 2, (4, 6))
    X = block.positions([(-1, 6), (0, 2)]).reshape(2, 2, 7)
    assert np.allclose(X[0, 0], np.arange(-1, 6) / 4) and np.allclose(X[1, :, 0], [0.0, 0.2])
    assert block.periods[0].tolist() == [1.0, 0.0]
    problem = BlockProblem([block], {("a", 1, 0): Slip(), ("a", 1, 1): Slip()})
    assert np.array_equal(problem.positions(0, [(-1, 6), (0, 6)])[:, :14], X.reshape(2, -1))
    assert np.array_equal(block.face_positions(1, 1), np.array([np.arange(4) / 4, np.ones(4)]))


# conditions


# problems


def right_handed(d):
    for axes in permutations(range(d)):
        for flips in product((False, True), repeat=d):
            parity = sum(a > b for i, a in enumerate(axes) for b in axes[i + 1 :]) + sum(flips)
            if parity % 2 == 0:
                yield axes, flips


def partners(problem, k):
    """Node of block k -> that of the other one of two blocks which is the same particle."""
    found = {}
    for particle, block, node in zip(*(array.tolist() for array in problem.members)):
        found.setdefault(particle, {})[block] = node
    return {nodes[k]: nodes[1 - k] for nodes in found.values() if len(nodes) == 2}


@pytest.mark.parametrize("d", (2, 3))
def test_any_face_meets_any_face_however_it_is_turned(d):
    cells = (4, 5, 6)[:d]
    seen = set()
    for axes, flips in right_handed(d):
        turned = tuple(cells[axis] for axis in axes)
        a, b = box("a", cells), box("b", turned, SOLID, (1.0, 0.0, 0.0)[:d], axes, flips)
        problem = closed(a, b)
        ((face, met),), ((back_face, back),) = joins(problem, 0), joins(problem, 1)
        assert face == (0, 1) and (back.block, back.axis, back.side) == (0, 0, 1)
        assert (met.block, met.axis, met.side) == (1, *back_face) and problem.is_interface(0, 0, 1)
        other = partners(problem, 0)
        mine, others = problem.face_nodes(0, 0, 1), problem.face_nodes(1, *back_face)
        X = problem.places(0, mine)
        assert np.array_equal(X, problem.places(1, [other[n] for n in mine.tolist()]))
        assert {other[n] for n in mine.tolist()} == set(others.tolist())
        seen.add((met.axis, met.side))
    assert seen == set(product(range(d), (0, 1)))


def test_members_of_a_disk_of_five_blocks():
    """A square in the middle and four blocks around it: three meet at each of its corners."""
    disk = five_blocks()
    problem = BlockProblem(disk, {(f"o{k}", 0, 1): Free() for k in range(4)})
    assert [m.block for _, m in joins(problem, 0)] == [2, 4, 3, 1]
    particle, block, node = problem.members
    assert np.bincount(np.bincount(particle)).tolist() == [0, 28, 52, 4]
    assert np.array_equal(np.lexsort((node, block, particle)), np.arange(len(node)))
    assert len(set(zip(block.tolist(), node.tolist()))) == len(node)
    firsts = [(block[i], node[i]) for i in np.unique(particle, return_index=True)[1]]
    assert firsts == sorted(firsts) and problem.joined
    X = np.array([problem.places(k, [n])[0] for k, n in zip(block, node)])
    for number in range(particle.max() + 1):
        assert len(np.unique(X[particle == number], axis=0)) == 1


def test_five_blocks_meet_at_one_vertex():
    """Sectors of a disk, each a square between its middle and two radii, turned differently."""

    def sector(k):
        a, b = (np.array([np.cos(w), np.sin(w)]) for w in np.pi * np.array([2 * k, 2 * k + 2]) / 5)
        points = [(0.0, 0.0), a, b, a + b]
        turned = [points, [points[i] for i in (1, 3, 0, 2)], [points[i] for i in (3, 2, 1, 0)]]
        return Block(f"s{k}", GAS, maps.corners(*turned[k % 3]), (8, 8), nothing)

    blocks = [sector(k) for k in range(5)]
    faces = [(b, axis, side) for b in blocks for axis in (0, 1) for side in (0, 1)]
    middles = {(b.name, axis, side): b.face_positions(axis, side)[:, 4] for b, axis, side in faces}
    outer = {name: STILL for name, X in middles.items() if np.hypot(*X) > 0.6}
    problem = BlockProblem(blocks, outer)
    assert len(outer) == 10
    assert np.bincount(np.bincount(problem.members.particle))[5] == 1


def five_blocks():
    half = 0.4

    def corner(k):
        return np.array([np.cos(np.pi / 4 + k * np.pi / 2), np.sin(np.pi / 4 + k * np.pi / 2)])

    def line(a, b):
        return lambda s: tuple((1 - s) * x + s * y for x, y in zip(a, b))

    def outer(k):
        def arc(s):
            return np.cos(np.pi / 4 + (k + s) * np.pi / 2), np.sin(np.pi / 4 + (k + s) * np.pi / 2)

        inner = [half * np.sqrt(2) * corner(k), half * np.sqrt(2) * corner(k + 1)]
        spokes = line(inner[0], corner(k)), line(inner[1], corner(k + 1))
        return Block(f"o{k}", SOLID, maps.transfinite((line(*inner), arc), spokes), (6, 8), nothing)

    centre = square("centre", (-half, -half), (half, half), material=SOLID)
    return [centre, *(outer(k) for k in range(4))]


def test_rings_meet_wherever_their_angles_begin():
    inner = Block("i", GAS, maps.annulus(0.5, 1.0), (4, 12), nothing, periodic=(False, True))
    angles = np.pi / 3, np.pi / 3 + 2 * np.pi
    ring = maps.annulus(1.0, 1.5, angles)
    outer = Block("o", SOLID, ring, (4, 12), nothing, periodic=(False, True))
    problem = BlockProblem([inner, outer], {("i", 0, 0): Slip(), ("o", 0, 1): Free()})
    mine, others = problem.face_nodes(0, 0, 1), problem.face_nodes(1, 0, 0)
    other = partners(problem, 0)
    assert [other[n] for n in mine.tolist()] == [others[(j - 2) % 12] for j in range(12)]
    assert not problem.joined
    ghosted = problem.positions(0, [(4, 5), (-2, 14)])
    assert np.array_equal(ghosted[:, 2:14], problem.places(0, problem.face_nodes(0, 0, 1)).T)
    assert np.array_equal(ghosted[:, :2], ghosted[:, 12:14])
    assert np.array_equal(ghosted[:, 14:], ghosted[:, 2:4])


def test_the_size_of_cells_is_that_of_the_nodes():
    """Of a map that is known at nodes only, and around a ring."""
    places = np.stack(np.meshgrid(np.linspace(0, 2, 9), np.linspace(0, 1, 5)), axis=-1)
    given = Block("a", GAS, maps.nodes(places), (8, 4), nothing)
    assert BlockProblem([given], walls("a")).spacing == pytest.approx(0.25)
    ring = Block("a", GAS, maps.annulus(1.0, 2.0), (32, 64), nothing, periodic=(False, True))
    problem = BlockProblem([ring], {("a", 0, 0): STILL, ("a", 0, 1): STILL})
    assert problem.spacing == pytest.approx(np.sqrt(3 * np.pi / 2048), rel=5e-3)


def test_in_one_dimension_faces_are_points():
    gas = Block("g", GAS, maps.rectangle(0, 1), 8, nothing)
    solid = Block("s", SOLID, lambda xi: (1 + xi[0],), 4, nothing)
    problem = BlockProblem([gas, solid], {("g", 0, 0): NoSlip(), ("s", 0, 1): Free()})
    assert problem.members.particle.tolist() == [0, 1, 1, 2]
    assert problem.members.node.tolist() == [0, 8, 0, 4]
    assert problem.is_interface(1, 0, 0) and problem.face_nodes(0, 0, 1).tolist() == [8]
    normal, place, within = problem.face_normal(0, 0, 0, 0)
    assert (normal, place, within) == ([-1.0], [0.0], [1.0])


FREE = walls("s", condition=Free())
WRONG_POINTS = {
    r"no node of a face is there; the nearest is at \(X, Y\) = \(1, 0.25\)": (1.0, 0.3),
    "expected .name of a solid, 2 coordinates, Hinge": (1.0,),
}


@pytest.mark.parametrize("message", WRONG_POINTS)
def test_wrong_points_are_told(message):
    points = [("s", WRONG_POINTS[message], Hinge())]
    with pytest.raises(InputError, match=message):
        BlockProblem([square("s", material=SOLID)], FREE, points=points)


A, B = ("a", 0, 1), ("b", 0, 0)


def beside(lower=(1.0, 0.0), upper=(2.0, 1.0), **more):
    return [square("a"), square("b", lower, upper, **more)]


def curved(xi):
    return 1.0 + xi[0] - 0.1 * xi[1] * (1 - xi[1]) * (1 - xi[0]), xi[1]


def three_at_one_place():
    """A third square whose left face is that of 'b'; no volumes overlap where they are sampled."""
    tent = maps.corners((1.0, 0.0), (2.0, -6.0), (1.0, 1.0), (2.0, -5.0))
    return [*beside(), Block("c", GAS, tent, (8, 8), nothing)]


def far(**more):
    return Block("b", GAS, maps.rectangle(5, 6), 8, nothing, **more)


def periodic_at_a_solid():
    b = square("b", (3.0, 0.0), (4.0, 1.0), material=SOLID)
    faces = walls("a") | walls("b", condition=Free())
    faces |= {("a", 0, 0): Periodic((4.0, 0.0)), ("b", 0, 1): Periodic((-4.0, 0.0))}
    return [square("a"), b], faces


def ring_that_is_not_closed():
    """Eight nodes around, in a ring and in one that lacks its last cell."""
    ring = Block("a", GAS, maps.annulus(1.0, 2.0), (8, 8), nothing, periodic=(False, True))
    part = maps.annulus(2.0, 3.0, (0.0, 1.75 * np.pi))
    faces = {("a", 0, 0): STILL} | walls("b", but=[("b", 0, 0)])
    return [ring, Block("b", GAS, part, (8, 7), nothing)], faces


JOINED = walls("a", "b", but=[A, B])
NO_PARTNER = walls("a") | {("a", 0, 0): Periodic((1.0, 0.0))}
THREE = walls("a", "b", "c", but=[A, B, ("c", 0, 0)])
OPEN, OPEN_1D = Open(1, (0, 0), 1), Open(1, 0, 1)
NO_FLUID, NO_SOLID = "Clamped is no condition of a fluid", "Open is no condition of a solid"
PROBLEMS = {
    "two blocks are named 'a'": lambda: ([square(), square()], {}),
    "block 'b' has 1 dimensions, block 'a' 2": lambda: ([square(), far()], {}),
    r"block 'a', face \(axis 0, side 1\), about \(X, Y\) = \(1, 0.5\)": lambda: (
        *([square()], walls("a", but=[A])),
    ),
    r"nearest is block 'b', face \(axis 0, side 0\), 0.01 away": lambda: (
        *(beside((1.01, 0.0)), JOINED),
    ),
    r"block 'a' and block 'b' overlap at \(X, Y\) = \(0.": lambda: (beside((0.8, 0.0)), JOINED),
    r"side 1\) has 9 nodes, block 'b', face \(axis 0, side 0\) that it meets has 10": lambda: (
        *(beside(cells=(8, 9)), JOINED),
    ),
    r"block 'b', face \(axis 0, side 0\) do not conform at \(X, Y\) = \(1, 0.125\)": lambda: (
        *([square(), Block("b", GAS, curved, (8, 8), nothing)], JOINED),
    ),
    r"side 1\) meets block 'b', .* and is named NoSlip\(…\), too": lambda: (
        *(beside(), walls("a", "b", but=[B])),
    ),
    r"are at one place, \(X, Y\) = \(1, 0.5\): expected two": lambda: (three_at_one_place(), THREE),
    r"face \(axis 0, side 0\) is named twice": lambda: (
        *([square()], list(walls("a").items()) * 2),
    ),
    "there is no block 'x': expected one of 'a'": lambda: ([square()], walls("x")),
    "expected an axis from 0 to 1 and side 0 or 1": lambda: ([square()], {("a", 2, 0): STILL}),
    r"'a': expected \(block name, axis, side\)": lambda: ([square()], {"a": STILL}),
    "a periodic axis has no faces": lambda: ([square(periodic=(True, False))], walls("a")),
    NO_FLUID: lambda: ([square()], walls("a", condition=Clamped())),
    NO_SOLID: lambda: ([square(material=SOLID)], walls("a", condition=OPEN)),
    "Open: u has 1 numbers: expected 2": lambda: ([square()], walls("a", condition=OPEN_1D)),
    "is Periodic, and no Periodic face is at": lambda: ([square()], NO_PARTNER),
    r"goes on at block 'b'.*: expected gas and gas": periodic_at_a_solid,
    "have the same nodes, but one of them is periodic and the other ends": ring_that_is_not_closed,
}


@pytest.mark.parametrize("message", PROBLEMS)
def test_wrong_problems_are_told(message):
    with pytest.raises(InputError, match=message):
        BlockProblem(*PROBLEMS[message]())
