"""Conditions at faces of blocks, held against what is exact."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from block_ledgers import steps_of

from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Absorbing, Clamped, Free, Hinge, NoSlip, Roller, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid


def rod(heat="elastic", kappa=0.05, p_ref=0.0):
    """K = 8, m0 = 2: waves of speed 2."""
    return ElasticSolid(2.0, 4.0, kappa, 2.0, 1.5, p_ref, "log", heat)


def in_pieces(material, initial, ends, cells, at=(), **options):
    """A slab [0, 1] in one dimension, cut at some places; cells: of all; ends: conditions."""
    places = [0.0, *at, 1.0]
    blocks = [
        Block(f"slab {k}", material, rectangle(a, b), (round((b - a) * cells),), initial, **options)
        for k, (a, b) in enumerate(zip(places, places[1:]))
    ]
    faces = {(blocks[0].name, 0, 0): ends[0], (blocks[-1].name, 0, 1): ends[1]}
    return BlockProblem(tuple(blocks), faces)


def temperatures(run):
    """Of all nodes of solids, block after block."""
    run.y.begin()
    run.y.end()
    d = run.problem.dimension
    parts = run.scheme.parts.items()
    return [part.fields(run.y.ghosted(k))[:, d] for k, part in parts]


def warm(X):
    """A smooth temperature, strained by a half so that W is not small."""
    return 0.0, 1.0 + 0.3 * np.cos(np.pi * X), 1.2 * X


@pytest.mark.parametrize("heat", ["elastic", "coupled"])
def test_heat_passes_a_join(heat):
    """As through the slab that is not cut: the same but for the error of the differences, which a
    join that insulates is far from.
    """
    found = []
    for at in ((), (0.5,)):
        problem = in_pieces(rod(heat, 0.5), warm, (Clamped(x=stretched),) * 2, 32, at)
        with steps_of(problem, order=4) as run:
            run.step(2e-4, 1000)
            found.append(temperatures(run))
    whole, (left, right) = found[0][0], found[1]
    change = np.abs(whole - warm(np.linspace(0, 1, 33))[1]).max()
    assert change > 0.05
    assert abs(left[-1] - right[0]) < 1e-13
    assert np.abs(np.concatenate([left, right[1:]]) - whole).max() < 1e-3 * change


def stretched(X, t):
    return (1.2 * X,)


@pytest.mark.parametrize("side", [0, 1])
def test_a_wave_leaves_through_an_absorbing_end(side):
    """Of small size; what comes back is the error of the differences, of third order: 2e-2, 3e-3,
    4e-4 of the pulse with 64, 128, 256 cells.
    """
    out, size = (1.0 if side else -1.0), 1e-5

    def pulse(X):
        shape = size * np.exp(-(((X - 0.5) / 0.08) ** 2))
        slope = -2.0 * (X - 0.5) / 0.08**2 * shape
        return -2.0 * out * slope, 1.0, X + shape

    ends = [Clamped(), Clamped()]
    ends[side] = Absorbing()
    with steps_of(in_pieces(rod("elastic", 0.0), pulse, ends, 128), order=4) as run:
        before = np.abs(run.y.owned(0)[:, 1]).max()
        run.step(2e-3, 220)
        assert np.abs(run.y.owned(0)[:, 1]).max() < 3e-3 * before
        energy = 2.0 * 2.0**2 * size**2 * np.sqrt(np.pi / 2.0) / 0.08  # m0 c^2 int D_X^2 dX
        assert run.gained()[-1] == pytest.approx(-energy, rel=2e-4)


def test_a_clamp_with_a_velocity_moves_from_where_it_is():
    def initial(X):
        return 0.0, 1.0, 1.1 * X + 0.05

    def velocity(X, t):
        return (0.3 * np.cos(5.0 * t) + 0.0 * X,)

    problem = in_pieces(rod(), initial, (Clamped(velocity=velocity), Free()), 16)
    with steps_of(problem, order=4) as run:
        run.step(2e-3, 100)
        D, v, _ = run.y.owned(0)[0]
        assert D == pytest.approx(0.05 + 0.06 * np.sin(5.0 * run.t), abs=1e-10)
        assert v == pytest.approx(0.3 * np.cos(5.0 * run.t), abs=1e-14)


def square(*conditions, initial, cells=8):
    """A solid square, conditions left, right, below, above."""
    block = Block("solid", rod("elastic", 0.0), rectangle((0, 0), (1, 1)), (cells, cells), initial)
    places = (0, 0), (0, 1), (1, 0), (1, 1)
    faces = {("solid", *at): condition for at, condition in zip(places, conditions, strict=True)}
    return block, faces


def test_a_square_turns_about_its_hinge():
    """The point stays, the rest goes around, and the angular momentum about it is kept."""

    def turning(X, Y):
        return -0.1 * Y, 0.1 * X, 1.0, X, Y

    block, faces = square(Free(), Free(), Free(), Free(), initial=turning)
    problem = BlockProblem((block,), faces, points=(("solid", (0.0, 0.0), Hinge()),))

    def angular(run):
        part = run.layout.parts[0]
        q, X = run.y.owned(0), problem.places(0, part.numbers)
        x = X + q[:, :2]
        return run.scheme.parts[0]._masses @ (x[:, 0] * q[:, 3] - x[:, 1] * q[:, 2])

    with steps_of(problem) as run:
        before = angular(run)
        run.step(5e-3, 100)
        assert np.abs(run.y.owned(0)[0, :4]).max() < 1e-15
        assert np.abs(run.y.owned(0)[-1, :2]).max() > 0.03
        assert angular(run) == pytest.approx(before, rel=1e-6)
        assert np.hypot(*run.gained()[1:3]) > 1e-4


@pytest.mark.parametrize("condition", [Clamped, Free, Roller])
def test_heat_comes_in_through_faces_of_solids(condition):
    """A given flux raises the mean temperature just so; a given temperature is there at once."""

    def at_rest(X, Y):
        return 0.0, 0.0, 1.0, X, Y

    flux = 0.2
    block, faces = square(*(condition(heat_flux=flux),) * 4, initial=at_rest)
    with steps_of(BlockProblem((block,), faces)) as run:
        run.step(1e-3, 10)
        T = temperatures(run)[0]
        weights = run.scheme.parts[0]._masses
        assert weights @ (T - 1.0) * 1.5 == pytest.approx(4 * flux * run.t, rel=1e-12)
    block, faces = square(*(condition(T=1.3),) * 4, initial=at_rest)
    with steps_of(BlockProblem((block,), faces)) as run:
        T = temperatures(run)[0].reshape(9, 9)
        ends = np.concatenate([T[0], T[-1], T[:, 0], T[:, -1]])
        assert np.abs(ends - 1.3).max() < 1e-14 and np.abs(T[1:-1, 1:-1] - 1.0).max() < 1e-14


def wall(phase, size):
    """A wall that wobbles with period 1, and its velocity."""
    turn = 2.0 * np.pi

    def x(X, Y, t):
        wave = size * np.sin(turn * t + phase)
        return X + 0.5 * wave * np.sin(np.pi * X), Y + wave * (1.0 + 0.5 * np.cos(np.pi * X))

    def velocity(X, Y, t):
        wave = turn * size * np.cos(turn * t + phase)
        return 0.5 * wave * np.sin(np.pi * X), wave * (1.0 + 0.5 * np.cos(np.pi * X))

    return {"x": x, "velocity": velocity}


@pytest.mark.parametrize(
    "order", [2, 4, *(pytest.param(k, marks=pytest.mark.long) for k in (6, 8))]
)
def test_volumes_stay_those_of_the_grid(order):
    """100 periods of two walls that wobble leave J = det D x to the error of Runge and Kutta's
    method: in a period that of Simpson's rule for a smooth function, which is none.
    """
    gas, n = Fluid(0.0, 0.0, 1.4, 1.0), {2: 8, 4: 8, 6: 12, 8: 16}[order]

    def cold(X, Y):
        return 1.0, 0.0, 0.0, 1e-3

    block = Block("gas", gas, rectangle((0, 0), (1, 1)), (n, n), cold)
    sides = {("gas", 0, side): Slip() for side in (0, 1)}
    faces = {("gas", 1, 0): NoSlip(**wall(0.0, 0.05)), ("gas", 1, 1): NoSlip(**wall(1.3, 0.07))}
    with steps_of(BlockProblem((block,), sides | faces), order) as run:
        worst = 0.0
        for _ in range(100):
            run.step(1 / 8, 8)
            run.y.begin()
            run.y.end()
            worst = max(worst, run.monitor()[0, 4])
        assert worst < 1e-12
        assert worst > 0.0  # it moves


@pytest.mark.parametrize("side", [0, 1])
def test_a_strained_rod_rests_under_the_stress_beyond_its_end(side):
    law = rod().solid_law
    stress = float(law.stress((0.95,))[0])
    ends = [Clamped(x=lambda X, t: (0.95 * X,)), Clamped(x=lambda X, t: (0.95 * X,))]
    ends[side] = Absorbing(stress)
    with steps_of(in_pieces(rod(), lambda X: (0.0, 1.0, 0.95 * X), ends, 16)) as run:
        run.step(5e-3, 20)
        assert stress < -0.1 and np.abs(run.y.owned(0)[:, 1]).max() < 1e-13


def test_a_wall_that_moves_takes_the_solid_along_that_sticks_to_its_gas():
    """Where an interface ends at it."""

    def moved(X, Y, t):
        return X, Y + 0.3 * t

    gas = Fluid(0.02, 0.03, 1.4, 1.0)
    blocks = (
        Block("gas", gas, rectangle((0, 0), (1, 1)), (8, 8), lambda X, Y: (1.0, 0.0, 0.0, 1.0)),
        Block("solid", rod(), rectangle((0, 1), (1, 2)), (8, 8), lambda X, Y: (0, 0, 1.0, X, Y)),
    )
    faces = {("gas", 0, side): NoSlip(x=moved) for side in (0, 1)}
    faces |= {("solid", 0, side): Free(1.0) for side in (0, 1)}
    faces |= {("gas", 1, 0): NoSlip(x=moved), ("solid", 1, 1): Free(1.0)}
    problem = BlockProblem(blocks, faces)
    with steps_of(problem) as run:
        before = run.integrals()
        run.step(1e-3, 2)
        assert np.allclose(run.y.owned(1)[[0, 8], 2:4], (0.0, 0.3), atol=1e-12)
        change = run.integrals() - before - run.gained()
        assert np.abs(change).max() < 1e-14 * before[-1]
        assert abs(run.gained()[2]) > 1e-6
