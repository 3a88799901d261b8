"""Blocks and problems made of them: maps, which faces meet, nodes at one place, and every message.
"""

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
    Given,
    Hinge,
    NoSlip,
    Open,
    Outflow,
    Periodic,
    Roller,
    Slip,
    holds_energy,
    moves,
    steady,
)
from fsipetsc.blocks.overlap import _angles, _boundary
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


def test_a_transfinite_map_has_its_faces_and_is_exact_for_what_is_linear_in_each_coordinate():
    left, right = (lambda s: (-s * (1 - s), s)), (lambda s: (1 + 0.3 * s, 2 * s))
    lower, upper = (lambda s: (s, 0.2 * s * (1 - s))), (lambda s: (1.3 * s, 1 + s))
    grid = maps.transfinite((left, right), (lower, upper))
    s, zero, one = np.linspace(0, 1, 7), np.zeros(7), np.ones(7)
    for found, curve in (
        (grid((zero, s)), left),
        (grid((one, s)), right),
        (grid((s, zero)), lower),
        (grid((s, one)), upper),
    ):
        assert np.allclose(found, curve(s), atol=1e-15)

    def body(a, b, c):
        return 1 + a + a * b + 2 * a * b * c, 2 * b - c * a, c + 0.3 * b

    def face(axis, side):
        return lambda *s: body(*s[:axis], side + 0 * s[0], *s[axis:])

    solid = maps.transfinite(*((face(k, 0), face(k, 1)) for k in range(3)))
    xi = tuple(np.random.default_rng(1).random((3, 5)))
    assert np.allclose(solid(xi), body(*xi), atol=1e-14)


def test_a_grid_of_nodes_is_a_map():
    X = np.array([[(i + 0.1 * j, j) for i in range(5)] for j in range(4)], float)
    block = Block("n", SOLID, maps.nodes(X), (4, 3), nothing)
    assert np.array_equal(block.positions([(0, 5), (0, 4)]), X.reshape(-1, 2).T)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: maps.rectangle((0, 0), (1, 0)), "upper above"),
        (lambda: maps.rectangle((0, "x"), (1, 1)), r"lower\[1\] is 'x'"),
        (lambda: maps.corners((0, 0), (1, 0), (0, 1)), "3 points are given"),
        (lambda: maps.annulus(2.0, 1.0), "radii 2 and 1"),
        (lambda: maps.annulus(1.0, 2.0, (0.0, 7.0)), "no more than 2 pi"),
        (lambda: maps.transfinite((1, 2)), "for each of 2 or 3 axes"),
        (
            lambda: maps.transfinite(
                (lambda s: (0 * s, s), lambda s: (1, s)), (lambda s: (s, 0), lambda s: (s, 2))
            ),
            r"side 0\) and \(axis 1, side 1\) do not meet: \(X, Y\) = \(0, 1\) and \(X, Y\) = \(0, 2\)",
        ),
        (
            lambda: maps.stretched(maps.rectangle(0, 1), lambda s: 2 * s),
            "function 0 takes 0 and 1 to 0 and 2",
        ),
        (
            lambda: maps.stretched(maps.rectangle(0, 1), None, None),
            "2 functions for a map of 1 dimensions",
        ),
        (lambda: maps.nodes(np.zeros((3, 3))), "expected the shape"),
    ],
)
def test_wrong_maps_are_told(make, message):
    with pytest.raises(InputError, match=message):
        make()


# blocks


@pytest.mark.parametrize(
    "change, message",
    [
        ({"name": "a|b"}, "Block: name is 'a|b'"),
        (
            {"material": "steel"},
            "block 'a': material is 'steel': expected a Fluid or an ElasticSolid",
        ),
        ({"cells": (8, 0)}, r"cells is \(8, 0\) .*: expected 1, 2 or 3 whole numbers above 0"),
        ({"cells": (8, 8.0)}, "whole numbers"),
        ({"cells": (True, 8)}, "whole numbers"),
        ({"cells": (8, 8, 8)}, "its map has 2 dimensions, cells 3"),
        ({"periodic": (True,)}, "periodic is"),
        ({"periodic": (0, 1)}, "expected True or False for each axis"),
        ({"map": 3}, "map is 3: expected a function"),
        ({"map": lambda xi: (xi[0],)}, "its map gives 1 coordinates: expected 2"),
        ({"map": lambda xi: 1 / 0}, "its map fails: ZeroDivisionError"),
        (
            {"map": lambda xi: (xi[0], xi[1] / (xi[0] != 0.31))},
            r"its map gives .*nan.* at xi = \(0.31, ",
        ),
        ({"map": lambda xi: (xi[1], xi[0])}, r"J = -0.0156 per cell at \(X, Y\) = .*right-handed"),
        ({"map": lambda xi: (xi[0], 0 * xi[1])}, "J = 0 per cell"),
        (
            {"map": lambda xi: (xi[0] + 0.2 * abs(xi[0] - 0.3), xi[1])},
            r"not smooth along axis 0, at \(X, Y\) = \(0.29",
        ),
        ({"map": lambda xi: (xi[0], xi[1] + (xi[1] > 0.5))}, "not smooth along axis 1"),
        (
            {"map": maps.nodes(np.zeros((4, 4, 2)))},
            r"its map has \(3, 3\) cells, the block \(8, 8\)",
        ),
        (
            {"periodic": (True, False), "map": lambda xi: (xi[0], xi[1] * (1 + xi[0]))},
            "axis 0 is periodic, and its map is not",
        ),
        ({"initial": None}, "initial is None"),
        ({"exact": 1}, "exact is 1"),
        ({"forcing": 1}, "forcing is 1"),
    ],
)
def test_wrong_blocks_are_told(change, message):
    given = {
        "name": "a",
        "material": GAS,
        "map": maps.rectangle((0, 0), (1, 1)),
        "cells": (8, 8),
        "initial": nothing,
    }
    with np.errstate(all="ignore"), pytest.raises(InputError, match=message):
        Block(**{**given, **change})


def test_smooth_maps_of_strong_curvature_are_let_pass():
    Block(
        "t",
        GAS,
        maps.stretched(maps.rectangle(0, 1), lambda s: np.tanh(5 * s) / np.tanh(5)),
        8,
        nothing,
    )
    Block("r", GAS, maps.annulus(0.01, 1.0), (4, 12), nothing, periodic=(False, True))


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


def test_what_conditions_say_of_themselves():
    assert moves(NoSlip(x=nothing)) and not moves(Slip()) and moves(Clamped(x=nothing))
    assert (
        steady(Slip(name="a"))
        and not steady(Open(1.0, (lambda *X: 0, 0.0), 1.0))
        and not steady(Free(nothing))
    )
    assert not steady(Given(nothing)) and steady(Outflow(2.0)) and not steady(NoSlip(T=nothing))
    closed_ones = NoSlip(), Slip(), Clamped(), Free(), Roller(), Periodic(1.0)
    assert all(map(holds_energy, closed_ones))
    others = (
        NoSlip(T=1),
        NoSlip(heat_flux=1),
        Free(1.0),
        Open(1, 0, 1),
        Outflow(),
        Given(nothing),
        Slip(x=nothing),
    )
    assert not any(map(holds_energy, others))
    assert Open(1, 2, 3).u == (2.0,) and NoSlip(T=2).T == 2.0


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: NoSlip(T=-1), "NoSlip: T is -1: expected a number above 0"),
        (lambda: NoSlip(T=1, heat_flux=1), "T and heat_flux are both given"),
        (lambda: NoSlip(velocity=nothing), "velocity is given, and x is not"),
        (lambda: Slip(x=1), r"Slip: x is 1: expected a function x\(\*X, t\)"),
        (lambda: Slip(name=1), "Slip: name is 1"),
        (lambda: Open(0, (0, 0), 1), "Open: rho is 0"),
        (lambda: Open(1, (0, "x"), 1), r"Open: u\[1\] is 'x'"),
        (lambda: Outflow(-1), "Outflow: pressure is -1"),
        (lambda: Given(1), "Given: values is 1"),
        (lambda: Clamped(heat_flux="a"), "Clamped: heat_flux is 'a'"),
        (lambda: Free(None), "Free: pressure is None"),
        (lambda: Periodic((1, None)), r"Periodic: shift\[1\] is None"),
    ],
)
def test_wrong_conditions_are_told(make, message):
    with pytest.raises(InputError, match=message):
        make()


# problems


def right_handed(d):
    for axes in permutations(range(d)):
        for flips in product((False, True), repeat=d):
            parity = sum(a > b for i, a in enumerate(axes) for b in axes[i + 1 :]) + sum(flips)
            if parity % 2 == 0:
                yield axes, flips


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
        mine, others = problem.face_nodes(0, 0, 1), problem.face_nodes(1, *back_face)
        X = problem.places(0, mine)
        assert np.array_equal(X, problem.places(1, others[met.order]))
        assert np.array_equal(met.order[back.order], np.arange(len(mine)))
        assert met.axes == tuple(axes.index(k) for k in range(1, d))
        assert met.flips == tuple(flips[axes.index(k)] for k in range(1, d))
        seen.add((met.axis, met.side))
    assert seen == set(product(range(d), (0, 1)))


def test_members_of_a_disk_of_five_blocks():
    """A square in the middle and four blocks around it: three blocks meet at each of its corners.
    """
    disk = five_blocks()
    problem = BlockProblem(disk, {(f"o{k}", 0, 1): Free() for k in range(4)})
    assert [(m.block, m.axis, m.side) for _, m in joins(problem, 0)] == [
        (2, 0, 0),
        (4, 0, 0),
        (3, 0, 0),
        (1, 0, 0),
    ]
    particle, block, node = problem.members
    assert np.bincount(np.bincount(particle)).tolist() == [0, 28, 52, 4]
    assert np.array_equal(np.lexsort((node, block, particle)), np.arange(len(node)))
    assert len(set(zip(block.tolist(), node.tolist()))) == len(node)
    firsts = [(block[i], node[i]) for i in np.unique(particle, return_index=True)[1]]
    assert firsts == sorted(firsts) and problem.joined
    X = np.array([problem.places(k, [n])[0] for k, n in zip(block, node)])
    for number in range(particle.max() + 1):
        assert len(np.unique(X[particle == number], axis=0)) == 1


def five_blocks():
    half, corner = (
        0.4,
        lambda k: np.array([np.cos(np.pi / 4 + k * np.pi / 2), np.sin(np.pi / 4 + k * np.pi / 2)]),
    )

    def line(a, b):
        return lambda s: tuple((1 - s) * x + s * y for x, y in zip(a, b))

    def outer(k):
        def arc(s):
            return np.cos(np.pi / 4 + (k + s) * np.pi / 2), np.sin(np.pi / 4 + (k + s) * np.pi / 2)

        inner = [half * np.sqrt(2) * corner(k), half * np.sqrt(2) * corner(k + 1)]
        spokes = line(inner[0], corner(k)), line(inner[1], corner(k + 1))
        return Block(f"o{k}", SOLID, maps.transfinite((line(*inner), arc), spokes), (6, 8), nothing)

    return [
        square("centre", (-half, -half), (half, half), material=SOLID),
        *(outer(k) for k in range(4)),
    ]


def test_rings_meet_wherever_their_angles_begin():
    inner = Block("i", GAS, maps.annulus(0.5, 1.0), (4, 12), nothing, periodic=(False, True))
    angles = np.pi / 3, np.pi / 3 + 2 * np.pi
    outer = Block(
        "o", SOLID, maps.annulus(1.0, 1.5, angles), (4, 12), nothing, periodic=(False, True)
    )
    problem = BlockProblem([inner, outer], {("i", 0, 0): Slip(), ("o", 0, 1): Free()})
    met = problem.faces_of(0)[0, 1]
    assert met.order.tolist() == [(j - 2) % 12 for j in range(12)] and not problem.joined
    ghosted = problem.positions(0, [(4, 5), (-2, 14)])
    assert np.array_equal(ghosted[:, 2:14], problem.places(0, problem.face_nodes(0, 0, 1)).T)
    assert np.array_equal(ghosted[:, :2], ghosted[:, 12:14]) and np.array_equal(
        ghosted[:, 14:], ghosted[:, 2:4]
    )


def test_blocks_in_a_row_are_periodic_together():
    a, b = square("a"), square("b", (1.0, 0.0), (2.0, 1.0))
    faces = walls("a", "b", but=[("a", 0, 1), ("b", 0, 0)])
    faces |= {("a", 0, 0): Periodic((2.0, 0.0)), ("b", 0, 1): Periodic((-2.0, 0.0))}
    problem = BlockProblem([a, b], faces)
    met = problem.faces_of(0)[0, 0]
    assert (met.block, met.axis, met.side, met.shift) == (1, 0, 1, (2.0, 0.0))
    assert np.bincount(np.bincount(problem.members.particle)).tolist() == [0, 28, 18]


def test_blocks_that_touch_at_a_vertex_share_a_particle():
    problem = BlockProblem([square("a"), square("b", (1.0, 1.0), (2.0, 2.0))], walls("a", "b"))
    particle, block, node = problem.members
    assert np.bincount(particle).max() == 2 and not problem.joined
    shared = particle == np.argmax(np.bincount(particle))
    assert block[shared].tolist() == [0, 1] and node[shared].tolist() == [80, 0]


def test_a_problem_without_faces():
    problem = BlockProblem([square(periodic=(True, True))], {})
    assert len(problem.members.node) == 0 and problem.faces_of(0) == {}


def test_in_one_dimension_faces_are_points():
    gas = Block("g", GAS, maps.rectangle(0, 1), 8, nothing)
    solid = Block("s", SOLID, lambda xi: (1 + xi[0],), 4, nothing)
    problem = BlockProblem([gas, solid], {("g", 0, 0): NoSlip(), ("s", 0, 1): Free()})
    assert problem.members.particle.tolist() == [0, 1, 1, 2] and problem.members.node.tolist() == [
        0,
        8,
        0,
        4,
    ]
    assert problem.is_interface(1, 0, 0) and problem.face_nodes(0, 0, 1).tolist() == [8]
    normal, place, within = problem.face_normal(0, 0, 0, 0)
    assert (normal, place, within) == ([-1.0], [0.0], [1.0])


def test_normals_of_faces_point_outwards():
    problem = BlockProblem([square(lower=(0, 0), upper=(2, 1))], walls("a"))
    normal, place, mean = problem.face_normal(0, 3, 1, 0)
    assert (
        np.allclose(normal, (0, -1))
        and np.allclose(place, (0.75, 0))
        and np.allclose(mean, (0.75, 0))
    )
    normal, place, mean = problem.face_normal(0, 8, 0, 1)
    assert (
        np.allclose(normal, (1, 0)) and np.allclose(place, (2, 0)) and np.allclose(mean, (2, 0.125))
    )


def test_points_are_held_at_nodes():
    solid = square("s", material=SOLID)
    problem = BlockProblem(
        [solid], walls("s", condition=Free()), points=[("s", (1.0, 0.5), Hinge())]
    )
    assert (
        problem.held == ((0, 44, Hinge()),)
        and problem.hinged([(1, 3), (0, 44)])
        and not problem.hinged([(0, 43)])
    )


def test_too_few_nodes_are_told_by_block_and_axis():
    problem = BlockProblem([square(cells=(8, 6))], walls("a"))
    problem.check(2)
    with pytest.raises(
        InputError, match=r"block 'a', axis 1: the 4/2 operator needs at least 8 points, not 7"
    ):
        problem.check(4)


A, B = ("a", 0, 1), ("b", 0, 0)


def beside(lower=(1.0, 0.0), upper=(2.0, 1.0), **more):
    return [square("a"), square("b", lower, upper, **more)]


def curved(xi):
    return 1.0 + xi[0] - 0.1 * xi[1] * (1 - xi[1]) * (1 - xi[0]), xi[1]


def three_at_one_place():
    """A third square whose left face is that of 'b'; volumes do not overlap where it is looked."""
    tent = maps.corners((1.0, 0.0), (2.0, -6.0), (1.0, 1.0), (2.0, -5.0))
    return [*beside(), Block("c", GAS, tent, (8, 8), nothing)]


PROBLEMS = [
    (lambda: ([], {}), "expected one or more Blocks"),
    (lambda: ([square(), square()], {}), "two blocks are named 'a'"),
    (
        lambda: ([square(), Block("b", GAS, maps.rectangle(5, 6), 8, nothing)], {}),
        "block 'b' has 1 dimensions, block 'a' 2",
    ),
    (
        lambda: ([square()], walls("a", but=[A])),
        r"block 'a', face \(axis 0, side 1\), about \(X, Y\) = \(1, 0.5\)",
    ),
    (
        lambda: (beside((1.01, 0.0)), walls("a", "b", but=[A, B])),
        r"nearest is block 'b', face \(axis 0, side 0\), 0.01 away",
    ),
    (
        lambda: (beside((0.8, 0.0)), walls("a", "b", but=[A, B])),
        r"block 'a' and block 'b' overlap at \(X, Y\) = \(0.",
    ),
    (
        lambda: (beside((-0.5, -0.5), (1.5, 1.5)), walls("a", "b")),
        "block 'a' and block 'b' overlap",
    ),
    (
        lambda: (beside((0.3, 0.3), (0.45, 0.45)), walls("a", "b")),
        "block 'a' and block 'b' overlap",
    ),
    (
        lambda: (beside(cells=(8, 9)), walls("a", "b", but=[A, B])),
        r"side 1\) has 9 nodes, block 'b', face \(axis 0, side 0\) that it meets has 10",
    ),
    (
        lambda: ([square(), Block("b", GAS, curved, (8, 8), nothing)], walls("a", "b", but=[A, B])),
        r"side 1\) and block 'b', face \(axis 0, side 0\) do not conform at \(X, Y\) = \(1, 0.125\)",
    ),
    (
        lambda: (beside(), walls("a", "b", but=[B])),
        r"side 1\) meets block 'b', .* and is named NoSlip\(…\), too",
    ),
    (
        lambda: (three_at_one_place(), walls("a", "b", "c", but=[A, B, ("c", 0, 0)])),
        "are at one place: expected two",
    ),
    (lambda: ([square()], list(walls("a").items()) * 2), r"face \(axis 0, side 0\) is named twice"),
    (lambda: ([square()], walls("x")), "there is no block 'x': expected one of 'a'"),
    (
        lambda: ([square()], {("a", 2, 0): NoSlip()}),
        r"\(axis 2, side 0\): expected an axis from 0 to 1 and side 0 or 1",
    ),
    (lambda: ([square()], {"a": NoSlip()}), r"'a': expected \(block name, axis, side\)"),
    (lambda: ([square(periodic=(True, False))], walls("a")), "a periodic axis has no faces"),
    (lambda: ([square()], walls("a", condition=Clamped())), "Clamped is no condition of a fluid"),
    (
        lambda: ([square(material=SOLID)], walls("a", condition=Open(1, (0, 0), 1))),
        "Open is no condition of a solid",
    ),
    (
        lambda: ([square()], walls("a", condition=Open(1, 0, 1))),
        "Open: u has 1 numbers: expected 2",
    ),
    (lambda: ([square()], walls("a", condition=3)), "3: expected a condition"),
    (lambda: ([square(material=SOLID)], walls("a", condition=Hinge())), "expected a condition"),
    (
        lambda: ([square()], walls("a") | {("a", 0, 0): Periodic((1.0, 0.0))}),
        "is Periodic, and no Periodic face is at",
    ),
    (
        lambda: ([square()], walls("a") | {("a", 0, 0): Periodic(1.0)}),
        "shift has 1 numbers: expected 2",
    ),
]


@pytest.mark.parametrize("make, message", PROBLEMS)
def test_wrong_problems_are_told(make, message):
    with pytest.raises(InputError, match=message):
        BlockProblem(*make())


def test_faces_that_go_on_at_another_material_are_told():
    a, b = square("a"), square("b", (3.0, 0.0), (4.0, 1.0), material=SOLID)
    faces = walls("a") | walls("b", condition=Free())
    faces |= {("a", 0, 0): Periodic((4.0, 0.0)), ("b", 0, 1): Periodic((-4.0, 0.0))}
    with pytest.raises(InputError, match=r"goes on at block 'b'.*: expected gas and gas"):
        BlockProblem([a, b], faces)


def test_nodes_in_another_order_are_told():
    """Eight places of two faces are the same, their neighbours are not."""
    X = np.array([[(i, j) for i in range(3)] for j in range(4)], float)
    Y = X + np.array([2.0, 0.0])
    Y[1:3, 0] = Y[2:0:-1, 0]
    Y[:, 1:, 0] += 5.0
    Y[1:3, 0, 1] = X[2:0:-1, 2, 1]
    a, b = (object.__new__(Block) for _ in "ab")
    for block, places in ((a, X), (b, Y)):
        for name, value in {
            "material": GAS,
            "map": maps.nodes(places),
            "cells": (2, 3),
            "periodic": (False, False),
        }.items():
            object.__setattr__(block, name, value)
    object.__setattr__(a, "name", "a")
    object.__setattr__(b, "name", "b")
    with pytest.raises(InputError, match="have the same nodes in another order"):
        BlockProblem([a, b], walls("a", "b", but=[A, B]))


@pytest.mark.parametrize(
    "point, message",
    [
        (
            ("s", (1.0, 0.3), Hinge()),
            r"no node of a face is there; the nearest is at \(X, Y\) = \(1, 0.25\)",
        ),
        (("s", (0.5, 0.5), Hinge()), "no node of a face is there"),
        (("s", (1.0,), Hinge()), "expected .name of a solid, 2 coordinates, Hinge"),
        (("s", (1.0, 0.5), Clamped()), "expected .name of a solid"),
        (("g", (1.0, 0.5), Hinge()), "there is no block 'g'"),
    ],
)
def test_wrong_points_are_told(point, message):
    with pytest.raises(InputError, match=message):
        BlockProblem([square("s", material=SOLID)], walls("s", condition=Free()), points=[point])


@pytest.mark.parametrize("d", (1, 2, 3))
def test_what_bounds_a_block_goes_once_around_what_is_inside(d):
    turned = box("a", (5,) * d, axes=range(d)[::-1], flips=(d > 1, False, False)[:d])
    for block in (box("a", (5,) * d), turned):
        for X, turns in ((0.4, 1.0), (0.7, 1.0), (-0.4, 0.0), (1.5, 0.0)):
            bound = np.moveaxis(_boundary(block) - np.full(d, X), 0, -1)
            assert abs(abs(_angles(bound).sum()) - turns) <= 1e-12


@pytest.mark.parametrize("d", (1, 2, 3))
def test_blocks_that_overlap_are_told_in_all_dimensions(d):
    one, other = box("a", (6,) * d), box("b", (6,) * d, lower=(0.4,) * d)
    with pytest.raises(InputError, match="block 'a' and block 'b' overlap at"):
        closed(one, other)


def test_wrong_jumps_are_told():
    with pytest.raises(InputError, match="jumps is 1"):
        BlockProblem([square()], walls("a"), jumps=1)
