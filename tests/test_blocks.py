"""Blocks and problems made of them: maps, which faces meet, nodes at one place, messages."""

from itertools import permutations, product

import numpy as np
import pytest
from block_ledgers import conditions_of

from fsipetsc import Block, Fluid, InputError, Open
from fsipetsc.blocks import maps
from fsipetsc.blocks.block_problem import BlockFace, BlockProblem
from fsipetsc.blocks.conditions import Free, Hinge, NoSlip, Slip
from fsipetsc.materials.solid import ElasticSolid

GAS, SOLID = Fluid(0.0, 0.0, 1.4, 1.0), ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0)


def nothing(*X):
    return X


def box(name, cells, material=GAS, lower=None, axes=None, flips=None):
    """A unit box under a smooth map: logical axis k runs along axes[k], backwards if flips[k]."""
    d = len(cells)
    lower, axes, flips = lower or (0.0,) * d, axes or range(d), flips or (False,) * d

    def places(xi):
        X = [None] * d
        for s, axis, flip in zip(xi, axes, flips):
            X[axis] = lower[axis] + (1.0 - s if flip else s)
        waves = [(1.7 + 0.3 * k) * x for k, x in enumerate(X)]
        return tuple(
            x + 0.1 * np.sin(2 * w - sum(waves) + 2.1 * c) for c, (x, w) in enumerate(zip(X, waves))
        )

    return Block(name, material, places, cells, nothing)


def closed(*blocks):
    """A problem of blocks with walls where no other block is."""
    kinds = {block.name: Free() if block.material is SOLID else NoSlip() for block in blocks}
    return BlockProblem(blocks, conditions_of(blocks, kinds))


def test_maps_take_corners_where_they_belong():
    ends = np.array([0.0, 1.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0, 1.0])
    x, y = maps.corners((0, 0), (2, 0), (0, 1), (3, 4))(ends)
    assert x.tolist() == [0, 2, 0, 3] and y.tolist() == [0, 0, 1, 4]
    x, y = maps.annulus(1.0, 2.0, (0.0, np.pi / 2), (5.0, 6.0))(ends)
    assert np.allclose(x, [6, 7, 5, 5]) and np.allclose(y, [6, 6, 7, 8])
    for wrong in ((2.0, 1.0), (1.0, 2.0, (0.0, 7.0)), (1.0, 2.0, (1.0, 0.0))):
        with pytest.raises(InputError, match="an angle that rises by no more than 2 pi"):
            maps.annulus(*wrong)


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


def right_handed(d):
    for axes, flips in product(permutations(range(d)), product((False, True), repeat=d)):
        parity = sum(a > b for i, a in enumerate(axes) for b in axes[i + 1 :]) + sum(flips)
        if parity % 2 == 0:
            yield axes, flips


def partners(problem):
    """Node of the first of two blocks -> that of the other one which is the same particle."""
    pairs = (dict(members) for members in problem.members if len(members) == 2)
    return {nodes[0]: nodes[1] for nodes in pairs if len(nodes) == 2}


@pytest.mark.parametrize("d", (2, 3))
def test_any_face_meets_any_face_however_it_is_turned(d):
    cells = (4, 5, 6)[:d]
    seen = set()
    for axes, flips in right_handed(d):
        turned = tuple(cells[axis] for axis in axes)
        a, b = box("a", cells), box("b", turned, SOLID, (1.0, 0.0, 0.0)[:d], axes, flips)
        problem = closed(a, b)
        ((face, met),), ((back_face, back),) = (
            [found for found in problem.kinds[k].items() if isinstance(found[1], BlockFace)]
            for k in (0, 1)
        )
        assert face == (0, 1) and (back.block, back.axis, back.side) == (0, 0, 1)
        assert (met.block, met.axis, met.side) == (1, *back_face) and problem.interfaces == [(0, 1)]
        other, mine = partners(problem), problem.blocks[0].face_nodes(0, 1)
        others = [other[n] for n in mine.tolist()]
        assert np.array_equal(problem.places(0, mine), problem.places(1, others))
        assert set(others) == set(problem.blocks[1].face_nodes(*back_face).tolist())
        seen.add((met.axis, met.side))
    assert seen == set(product(range(d), (0, 1)))


def test_rings_meet_wherever_their_angles_begin():
    inner = Block("i", GAS, maps.annulus(0.5, 1.0), (4, 12), nothing, periodic=(False, True))
    ring = maps.annulus(1.0, 1.5, (np.pi / 3, np.pi / 3 + 2 * np.pi))
    outer = Block("o", SOLID, ring, (4, 12), nothing, periodic=(False, True))
    problem = BlockProblem([inner, outer], {("i", 0, 0): Slip(), ("o", 0, 1): Free()})
    mine, others = problem.blocks[0].face_nodes(0, 1), problem.blocks[1].face_nodes(0, 0)
    other = partners(problem)
    assert [other[n] for n in mine.tolist()] == [others[(j - 2) % 12] for j in range(12)]
    ghosted = problem.positions(0, [(4, 5), (-2, 14)])
    assert np.array_equal(ghosted[:, 2:14], problem.places(0, mine).T)
    assert np.array_equal(ghosted[:, :2], ghosted[:, 12:14])
    assert np.array_equal(ghosted[:, 14:], ghosted[:, 2:4])


@pytest.mark.parametrize("kappa", [0.0, 0.1])
def test_the_entropy_of_gases_may_fall_where_solids_take_heat(kappa):
    gas, solid = Fluid(0.0, 0.1, 1.4, 1.0), ElasticSolid(1, 1, kappa, 1, 1, heat="elastic")
    ends = {"a": (gas, maps.rectangle(0.0, 1.0)), "b": (solid, maps.rectangle(1.0, 2.0))}
    blocks = [Block(name, of, place, 8, nothing) for name, (of, place) in ends.items()]
    problem = BlockProblem(blocks, {("a", 0, 0): Slip(), ("b", 0, 1): Free()})
    assert problem.invariants["entropy"] == (kappa == 0.0)


def square(name="a", lower=(0.0, 0.0), upper=(1.0, 1.0), **changed):
    """A block of gas, or one with something else or wrong."""
    given = {"material": GAS, "map": maps.rectangle(lower, upper), "cells": (8, 8)}
    return Block(name, **{**given, "initial": nothing, **changed})


def walls(*names, but=(), condition=NoSlip()):  # noqa: B008
    """A condition at all faces of blocks in 2-D, but for some (name, axis, side)."""
    return {face: condition for face in product(names, (0, 1), (0, 1)) if face not in but}


def two(b, *more):
    """A square, on whose right another block is meant to be."""
    blocks, meeting = [square(), b, *more], [("a", 0, 1), ("b", 0, 0), ("c", 0, 0)]
    return BlockProblem(blocks, walls(*(x.name for x in blocks), but=meeting))


def beside(**more):
    return square("b", (1.0, 0.0), (2.0, 1.0), **more)


def curved(xi):
    return 1.0 + xi[0] - 0.1 * xi[1] * (1 - xi[1]) * (1 - xi[0]), xi[1]


def third():
    return Block("c", GAS, maps.corners((1, 0), (2, -6), (1, 1), (2, -5)), (8, 8), nothing)


WRONG = {
    r"axis 0, side 0\) misses others at \(X, Y\) = \(0, 1\)": lambda: maps.transfinite(
        (lambda s: (0 * s, s), lambda s: (1, s)), (lambda s: (s, 0), lambda s: (s, 2))
    ),
    "expected a Fluid or an ElasticSolid": lambda: square(material="steel"),
    r"map of block 'a': Y = .* at .* = \(0.5, ": lambda: square(
        map=lambda xi: (xi[0], xi[1] / (xi[0] != 0.5))
    ),
    r"J = -0.0156 per piece at .*right-handed": lambda: square(map=lambda xi: (xi[1], xi[0])),
    r"'a', face \(axis 0, side 1\), about .* = \(1, 0.5\)": lambda: BlockProblem(
        [square()], walls("a", but=[("a", 0, 1)])
    ),
    "Open is no condition of a fluid": lambda: BlockProblem(
        [square()], {("a", 0, 0): Open(0, 1, 1)}
    ),
    "type is no condition of a fluid": lambda: BlockProblem([square()], {("a", 0, 0): Slip}),
    "meets it: expected one, or a face with the same 9 nodes": lambda: two(square("b", map=curved)),
    r"not smooth along axis 0, at .* = \(0.29": lambda: square(
        map=lambda xi: (xi[0] + 0.2 * abs(xi[0] - 0.3), xi[1])
    ),
    r"side 1\), .*, meets block 'b'.*: expected no condition, and": lambda: BlockProblem(
        [square(), beside()], walls("a", "b", but=[("b", 0, 0)])
    ),
    r"about .* = \(1, 0.5\), is at one place with .*: expected two": lambda: two(beside(), third()),
    r"block 'a' and block 'b' meet at .* = \(1, 0\), and are gases of different": lambda: two(
        beside(material=Fluid(0.0, 0.0, 1.3, 1.0))
    ),
    r"no node of a face is there; the nearest is at .* = \(1, 0.25\)": lambda: BlockProblem(
        [square(material=SOLID)], walls("a", condition=Free()), points=[("a", (1.0, 0.3), Hinge())]
    ),
}


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_is_told(message):
    with np.errstate(all="ignore"), pytest.raises(InputError, match=message):
        WRONG[message]()
