"""What is seen of blocks after a step: bounds on the next one, angular momentum, what steps lose of
the energy of solids, and which of it is told.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("petsc4py")

import block_shapes as shapes
from block_ledgers import steps_of
from ledger_problems import N, closed, gas, problem_of, solid

from fsipetsc.blockrun.block_state import BlockForm
from fsipetsc.blockrun.face_terms import weights_of
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import Free
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.stepping.ledgers import Ledgers
from fsipetsc.stepping.report import about_losses, about_volumes


def bounds_of(run, k):
    """The largest rates of convection and diffusion of a block, by formulas on whole arrays."""
    part, q, d = run.scheme.parts[k], run.y.owned(k), run.problem.dimension
    metrics, equations, cells = part.metrics[:, part.owned], part.equations, part.block.cells
    areas = metrics[: d * d].reshape(d, d, -1) * np.reshape(cells, (d, 1, 1))
    squares = (areas**2).sum(axis=1)
    if run.problem.blocks[k].kind == "solid":
        F, v = tuple(part._F), tuple(q[:, d : 2 * d].T)
        T = equations.temperature(v, q[:, 2 * d], F)
        nodes = zip(zip(*F), T, strict=True)
        c2 = np.array([equations.wave_modulus_at(*node) for node in nodes]) / equations.m0
        spread = squares.sum(axis=0) / metrics[d * d] ** 2
        nu = equations.kappa / (equations.m0 * equations.alpha)
        return np.sqrt((c2 * spread).max()), STIFFNESS_OF_WIDE * nu * spread.max()
    w, J = equations.primitive(tuple(q.T)), q[:, 0]
    relative = np.array(equations.velocity(w)) - metrics[d * d : d * d + d]
    across = np.abs((areas * relative).sum(axis=1))
    waves = (across + equations.speed_of_sound(w) * np.sqrt(squares)).sum(axis=0) / J
    nu = 4.0 / 3.0 * equations.mu / w[0], equations.kappa / equations.law.heat_capacity(w[0], w[2])
    nu = np.maximum(nu[0], nu[1] / w[0])
    return waves.max(), (STIFFNESS_OF_WIDE * nu * squares.sum(axis=0) / J**2).max()


def test_what_bounds_a_step():
    """Of gas on a grid that moves and a solid that conducts, on a shape that is warped."""
    shape = shapes.warped(shapes.layers(N + 1, False), 0.03)
    problem = problem_of(shape, closed, gas(mu=0.02), solid(heat="coupled"))
    with steps_of(problem) as run:
        run.step(2e-3, 2)
        found = run.monitor().copy()
        for k in range(2):
            np.testing.assert_allclose(found[k, 1:3], bounds_of(run, k), rtol=1e-12)
            assert found[k, 0] == 0.0 and found[k, 2] > 0.0
        moving = run.scheme.parts[0].metrics[4:6]
        assert np.abs(moving).max() > 0.01
        run.y.owned(0)[5] *= 0.9  # its J departs from the grid, its density does not
        assert run.monitor()[0, 4] == pytest.approx(0.1, rel=1e-6)
    with steps_of(problem, pace=2.0) as run:  # as much faster are waves where shocks are damped
        run.step(2e-3, 2)
        np.testing.assert_allclose(run.monitor()[:, 1:3], found[:, 1:3] * [2.0, 1.0], rtol=1e-12)


def spin_of(run):
    """Angular momentum about the origin, from the unknowns and where nodes are."""
    total = 0.0
    for k, part in run.scheme.parts.items():
        q, d = run.y.owned(k), run.problem.dimension
        H = weights_of(part.part, part.owned)
        if run.problem.blocks[k].kind == "fluid":
            x, momentum = part.grid.positions()[:, part.owned], H * q[:, 2 : 2 + d].T
        else:
            x = part.X[:, part.owned] + q[:, :d].T
            momentum = H * part.inertia[part.owned] * q[:, d : 2 * d].T
        pad = (0, 3 - d), (0, 0)
        total += np.cross(np.pad(x, pad), np.pad(momentum, pad), axis=0).sum(axis=-1)
    return total if run.problem.dimension == 3 else total[2]


@pytest.mark.parametrize("d", [2, 3])
def test_angular_momentum(d):
    """Of gas whose grid has moved and of a solid; nothing turns a solid that nothing holds."""
    shape = shapes.layers(N + 1, False) if d == 2 else shapes.three(4)
    problem = problem_of(shape, closed, gas(d), solid(d, heat="elastic"))
    names = ["angular_momentum"] if d == 2 else [f"angular_momentum_{x}" for x in "xyz"]
    with steps_of(problem) as run:
        run.step(2e-3, 2)
        run.integrals()
        found = [float(run.scheme.latest[name]) for name in names]
        np.testing.assert_allclose(found, spin_of(run), rtol=1e-13, atol=1e-15)
        assert np.abs(found).min() > 1e-3
    block = problem.blocks[-1]
    if d == 3:  # where p_ref is a traction along discrete normals, whose torque is not 0
        block = replace(block, material=replace(block.material, p_ref=0.0))
    alone = BlockProblem((block,), {("solid", k, s): Free() for k in range(d) for s in (0, 1)})
    with steps_of(alone) as run:
        before = [float(run.scheme.latest[name]) for name in names]
        run.step(2e-3, 5)
        run.integrals()
        after = [float(run.scheme.latest[name]) for name in names]
        np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-11)
        assert np.abs(before).min() > 1e-3


def swung(cells, dt, t, order=4):
    """A solid that swings freely: its kinetic and elastic energy at first, and what is lost of it,
    as the series of a run has it; change of all energy.
    """
    rubber = ElasticSolid(1.0, 2.0, 0.0, 2.0, 1.5, 0.0, "log", "elastic")

    def swinging(X, Y):
        return [0.1 * np.sin(np.pi * X), 0.1 * np.cos(np.pi * Y) * X, 1.0 + 0.0 * X, X, Y]

    one = Block("solid", rubber, rectangle((0, 0), (1, 1)), (cells, cells), swinging)
    faces = {("solid", axis, side): Free() for axis in (0, 1) for side in (0, 1)}
    with steps_of(BlockProblem((one,), faces), order) as run:
        first, energy = run.solid_energy(), run.integrals()[-1]
        run.step(dt, round(t / dt))
        change = run.integrals()[-1] - energy
        return first, run.lost(), change / energy


def test_what_steps_lose_falls_with_their_order():
    """Runge-Kutta loses kinetic and elastic energy by the fifth power of the step; all of the
    energy stays.
    """
    first, coarse, change = swung(10, 0.01, 1.0)
    _, fine, _ = swung(10, 0.005, 1.0)
    assert abs(change) < 1e-14 and 1e-10 * first < fine < coarse
    assert 4.5 < np.log2(coarse / fine) < 5.5


def test_much_that_is_lost_is_told():
    """From a thousandth on, over the largest energy; it is remembered over a restart."""
    steps = np.zeros(4, [("t", "f8"), ("dt", "f8"), ("lost_energy", "f8"), ("solid_energy", "f8")])
    steps["solid_energy"] = 2.0, 1.0, 0.5, 0.0
    steps["lost_energy"] = 0.001, 0.002, 0.003, -0.001
    ledgers = Ledgers({"masses": [], "energy": False})
    ledgers.begin({"mass": []})
    ledgers.add(steps[:2])
    again = Ledgers({})
    again.recall(ledgers.memory(), {})
    again.add(steps[2:])
    assert again.lost == pytest.approx(0.003)
    assert "lost 0.3 %" in about_losses({"lost_energy": again.lost})[0]
    assert about_losses({"lost_energy": 0.0009}) == [] and about_losses({}) == []


def test_a_departure_of_volumes_is_told():
    """From 1 % on; what is no number, too. It is remembered over a restart."""
    steps = np.zeros(3, [("t", "f8"), ("dt", "f8"), ("J_error", "f8", (2,))])
    steps["J_error"][1] = 0.001, 0.03
    ledgers = Ledgers({})
    for step in range(3):
        ledgers.add(steps[step : step + 1])
    assert ledgers.J_error == 0.03
    assert "J has departed by 3 %" in about_volumes(ledgers.J_error)[0]
    assert about_volumes(0.0099) == [] and len(about_volumes(np.nan)) == 1
    known, again = Ledgers({"masses": [], "energy": False}), Ledgers({})
    known.begin({"mass": []})
    known.add(steps)
    again.recall(known.memory(), {})
    assert again.J_error == 0.03


@pytest.mark.parametrize("viscosity", [0.0, 0.02])
def test_a_bad_state_leaves_nothing_behind(viscosity):
    """A step that fails is made anew: the rates then have the bits that they had before."""
    shape = shapes.warped(shapes.layers(N + 1, False), 0.03)
    problem = problem_of(shape, closed, gas(mu=viscosity), solid(heat="coupled"))
    with steps_of(problem, form=BlockForm(dissipation=1.0, shock=1.0)) as run:
        good, rates = run.y.array.copy(), np.zeros((2, run.y.array.size))
        for f in rates:
            run.y.array[:] = good
            run.scheme.complete(0.0, run.y)
            run.scheme.rates(0.0, run.y, f)
            run.y.array[:] = np.nan
            run.scheme.complete(0.0, run.y)
            run.scheme.rates(0.0, run.y, np.zeros_like(f))
            run.scheme.forget()
    np.testing.assert_array_equal(*rates)
    assert np.isfinite(rates).all() and rates.any()
