"""What comes in through faces and by forces is booked as it comes: the integrals change by just
that.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("petsc4py")

import block_shapes as shapes
from block_grids import conditions_of
from block_ledgers import steps_of, unbooked
from helpers import REPOSITORY, mpirun

from fsipetsc.blockrun.face_terms import weights_of
from fsipetsc.blocks.block import Block
from fsipetsc.blocks.conditions import (
    Absorbing,
    Clamped,
    Free,
    Given,
    Hinge,
    NoSlip,
    Open,
    Outflow,
    Roller,
    Slip,
)
from fsipetsc.blocks.maps import nodes, rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.operators.narrow import STIFFNESS_OF_WIDE
from fsipetsc.stepping.ledgers import Ledgers
from fsipetsc.stepping.report import about_losses, about_volumes

MASS, X, Y, ENERGY = range(4)
#: cells along an axis
N = 7
#: heat of the solid, viscosity of the gas
BOTH = ("elastic", 0.0), ("coupled", 0.02)


def gas(d=2, mu=0.0, force=0.0):
    return Fluid(mu, 0.03, 1.4, 1.0, force=(force,) * d if d > 1 else force)


def solid(d=2, heat="elastic", force=0.0, kappa=0.05):
    force = (force,) * d if d > 1 else force
    return ElasticSolid(1.0, 2.0, kappa, 2.0, 1.5, 0.3, "log", heat, force=force)


def swirling(*X):
    d = len(X)
    wave = [0.2 * np.sin(3.0 * X[c] + 2.0 * X[-1] + c) for c in range(d)]
    return [1.0 + 0.2 * np.cos(2.0 * sum(X)), *wave, 1.0 + 0.1 * np.sin(3.0 * X[0] + 1.0)]


def bent(*X):
    d = len(X)
    v = [0.1 * np.cos(2.0 * X[0] + 3.0 * X[-1] + c) for c in range(d)]
    x = [X[c] + 0.02 * np.sin(2.0 * X[c - 1] + c) for c in range(d)]
    return [*v, 1.1 + 0.1 * np.sin(2.0 * X[0] + X[-1]), *x]


def block(name, X, material, **options):
    """A block on an array of nodes, as in block_shapes."""
    cells, d = tuple(n - 1 for n in X.shape[1:]), len(X)
    initial = options.pop("initial", swirling if material.kind == "fluid" else bent)
    return Block(name, material, nodes(X.transpose(*range(d, 0, -1), 0)), cells, initial, **options)


def straight(X, Y):
    return [*bent(X, Y)[:3], X, Y]


def problem_of(shape, faces, fluid, plate, points=(), **options):
    """A problem on a shape; faces: (name, axis, side) -> condition of those that meet nothing."""
    blocks = []
    for name, (X, _) in shape.items():
        material = fluid if name.startswith("gas") else plate
        blocks.append(block(name, X, material, **dict(options.get(name.split()[0], {}))))
    found = conditions_of(blocks, faces)
    return BlockProblem(tuple(blocks), found, options.get("jumps"), points=points)


def closed(name, axis, side):
    """Slip walls and rollers."""
    return Slip() if name.startswith("gas") else Roller()


def check(problem, *, only=(), least=1e-7, most=1e-13, **options):
    """All is booked, and of these entries there is something to book."""
    left, came = unbooked(problem, **options)
    assert np.abs(left).max() < most, left
    for entry in only:
        assert abs(came[entry]) > least, came
    return came


def test_an_open_tube():
    def faces(name, axis, side):
        if axis == 1:
            return Slip()
        return Outflow(0.8) if side else Open(0.9, (0.5, -0.2), 1.1)

    shape = {"gas": shapes.box((0, 0), (1, 1), N + 1, N + 1)}
    check(problem_of(shapes.warped(shape), faces, gas(), None), only=(MASS, X, Y, ENERGY))


def moved(*X_and_t):
    *X, t = X_and_t
    return [x + 0.1 * np.sin(3.0 * t + c) * (1.0 + X[0]) for c, x in enumerate(X)]


def blown(X, t):
    return (0.3 * np.sin(2.0 * t) + 0.2 + 0.0 * X,)


CONDITIONS = {
    "heat through walls": (NoSlip(heat_flux=0.4), Clamped(heat_flux=0.3), (ENERGY,)),
    "temperatures": (NoSlip(T=1.3), Clamped(T=1.4), (ENERGY,)),
    "walls and clamps that move": (NoSlip(x=moved), Clamped(x=moved), (X, Y, ENERGY)),
    "slip walls that move": (Slip(x=moved), Roller(heat_flux=0.2), (X, Y, ENERGY)),
    "free, warm": (NoSlip(), Free(0.4, T=1.2), (X, Y, ENERGY)),
    "absorbing": (Slip(), Absorbing(-0.2, heat_flux=0.1), (X, Y, ENERGY)),
    "given": (
        Given(lambda X, Y, t: (1.0 + 0.1 * np.sin(t + X), 0.1, 0.2 * t, 1.0 + 0.0 * Y)),
        Given(lambda X, Y, t: (0.1, 0.2 * t, 1.1 + 0.0 * X, X + 0.1 * t, Y + 0.1 * t**2)),
        (MASS, X, Y, ENERGY),
    ),
}


@pytest.mark.parametrize(("heat", "mu"), BOTH)
@pytest.mark.parametrize("name", CONDITIONS)
def test_conditions(name, heat, mu):
    """At the lower and upper ends of gas | solid with slip walls and rollers beside."""
    below, above, only = CONDITIONS[name]

    def faces(name, axis, side):
        if axis == 0:
            return closed(name, axis, side)
        return below if name == "gas" else above

    shape = shapes.layers(N + 1, False)
    check(problem_of(shape, faces, gas(mu=mu), solid(heat=heat)), only=only)


@pytest.mark.parametrize("heat", ["elastic", "coupled"])
def test_forces_in_the_volume(heat):
    """Body forces, forcing, what interfaces supply; a point that is held."""

    def forced(X, Y, t):
        return 0.1 + 0.0 * X, 0.2 * Y, 0.3 * X, 0.4 + t + 0.0 * X

    def forced_solid(X, Y, t):
        return 0.2 * Y, 0.1 * X, 0.3 + 0.0 * X, 0.01 * Y, 0.02 * X

    def supplied(X, Y, t):
        return 0.3 + X, 0.2 * X, 0.1 + t + 0.0 * X

    options = {"gas": {"forcing": forced}, "solid": {"forcing": forced_solid}, "jumps": supplied}

    def faces(name, axis, side):
        return Slip() if name == "gas" else Free()

    shape, points = shapes.layers(N + 1, False), (("solid", (4.0 / N, 1.6), Hinge()),)
    fluid, plate = gas(force=0.3), solid(heat=heat, force=-0.2)
    came = check(problem_of(shape, faces, fluid, plate, **options), only=(MASS, X, Y, ENERGY))
    held = check(problem_of(shape, faces, fluid, plate, points, **options))
    assert abs(held[Y] - came[Y]) > 1e-6


@pytest.mark.parametrize("mu", [0.0, 0.02])
def test_one_dimension(mu):
    """A pushed layer that pushes another on."""
    shape = {
        "solid": shapes.box((0.0,), (0.4,), 9),
        "gas": shapes.box((0.4,), (1.0,), 9),
        "solid beyond": shapes.box((1.0,), (1.4,), 9),
    }

    def faces(name, axis, side):
        return Absorbing(-0.3) if side else Clamped(velocity=blown)

    check(problem_of(shape, faces, gas(1, mu, 0.2), solid(1, force=0.3)), only=(X, 2))


def all_kinds(name, axis, side):
    """Given data, walls of both kinds, clamps."""
    if name == "gas 20" and axis == 1:
        return Given(lambda X, Y, t: (1.1, 0.2, 0.1, 1.2 + 0.0 * X))
    if name.startswith("gas"):
        return NoSlip(T=1.3) if (axis, side) == (1, 1) else Slip(x=moved)
    return Clamped(velocity=lambda X, Y, t: (0.3, 0.2 + 0.0 * X))


def taken_along(name, axis, side):
    """A solid that is free beside moving walls, to which its gas sticks."""
    if name.startswith("gas"):
        wall = NoSlip(x=lambda X, Y, t: (X + 0.2 * t, Y + 0.3 * t))
        return Open(0.9, (0.5, -0.2), 1.1) if axis == 1 else wall
    return Free()


@pytest.mark.parametrize(("heat", "mu"), BOTH)
@pytest.mark.parametrize("faces", [all_kinds, taken_along])
def test_what_completion_takes(faces, mu, heat):
    """From a state that obeys nothing: what walls, clamps and data add is booked, and nothing else
    changes.
    """
    panel = faces is all_kinds
    shape = shapes.panel(N + 1) if panel else shapes.layers(N + 1, False)
    options = {} if panel else {"solid": {"initial": straight}}
    with steps_of(problem_of(shape, faces, gas(mu=mu), solid(heat=heat), **options)) as run:
        rng = np.random.default_rng(1)
        for k, block in enumerate(run.problem.blocks):
            q, d = run.y.owned(k), 2
            if block.kind == "fluid":
                q[:, 2:4] += q[:, :1] * rng.uniform(-0.3, 0.3, (len(q), d))
                q[:, 1] *= rng.uniform(0.9, 1.1, len(q))
            else:
                q[:, d : 2 * d] += rng.uniform(-0.3, 0.3, (len(q), d))
        before = run.integrals()
        run.scheme.complete(0.0, run.y)
        run.came += run.y.behind
        change, came = run.integrals() - before, run.gained()
        assert np.abs(change - came).max() < 1e-14 * before[-1], change - came
        assert np.abs(came[1:3]).min() > 1e-5 and (not panel or np.abs(came).min() > 1e-5)


def test_three_dimensions():
    """Where p_ref of the solid acts on its faces, and does work there."""
    zero = (0.0,) * 3
    fluid = Fluid(0.02, 0.03, 1.4, 1.0, force=zero)
    plate = ElasticSolid(1.0, 2.0, 0.05, 2.0, 1.5, 0.3, "log", "coupled", force=zero)

    def faces(name, axis, side):
        if name == "solid":
            return Free(0.2)
        return Slip(x=lambda X, Y, Z, t: (X, Y, Z + 0.1 * t * X)) if axis == 2 else Slip()

    problem = problem_of(shapes.three(4), faces, fluid, plate)
    check(problem, only=(X, Y, 3, 4), least=1e-9)


def records(run, steps, dt, lose=None):
    """What a run records of steps; after some, momentum along x is lost."""
    names = ("t", "dt", "mass", "mass_in", "energy", "energy_in")
    names += "momentum_x", "momentum_y", "impulse_x", "impulse_y"
    kind = np.dtype([(n, "f8", (1,)) if n.startswith("mass") else (n, "f8") for n in names])
    found = np.zeros(steps, kind)
    for i in range(steps):
        if i == lose:
            q = run.y.owned(0)
            q[:, 4] -= 0.5 * q[:, 2] ** 2 / q[:, 1]
            q[:, 2] = 0.0
        before = run.gained()
        run.step(dt)
        mass, *momentum, energy = run.integrals()
        into, *impulse, heat = run.gained() - before
        found[i] = (run.t, dt, mass, into, energy, heat, *momentum, *impulse)
    return found


@pytest.mark.parametrize("lose", [None, 3])
def test_the_watch_sees_the_loss_of_a_small_wave(lose):
    """The momentum of a wave of 1e-5 between walls, whose impulses come from the constraints."""

    def wave(X, Y):
        u = 1e-5 * np.exp(-(((X - 0.5) / 0.15) ** 2))
        return 1.0 + u / np.sqrt(1.4), u, 0.0 * X, 1.0 + 0.4 * u / np.sqrt(1.4)

    one = Block("gas", gas(), rectangle((0, 0), (1, 1)), (16, N), wave)
    walls = {("gas", axis, side): Slip() for axis in (0, 1) for side in (0, 1)}
    problem = BlockProblem((one,), walls)
    with steps_of(problem) as run:
        mass, x, y, energy = run.integrals()
        initial = {"mass": [mass], "momentum_x": x, "momentum_y": y, "energy": energy}
        initial["entropy"] = 0.0
        invariants = {**problem.invariants, "entropy": False}
        ledgers = Ledgers(invariants, 1e-9)
        ledgers.begin(initial)
        ledgers.add(records(run, 10, 0.02, lose))
    assert (ledgers.fault or "")[:16] == ("momentum along x" if lose else "")


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
        looked = run.look().copy()
        for k in range(2):
            np.testing.assert_allclose(looked[k, 1:3], bounds_of(run, k), rtol=1e-12)
            assert looked[k, 0] == 0.0 and looked[k, 2] > 0.0
        moving = run.scheme.parts[0].metrics[4:6]
        assert np.abs(moving).max() > 0.01
        run.y.owned(0)[5] *= 0.9  # its J departs from the grid, its density does not
        assert run.look()[0, 4] == pytest.approx(0.1, rel=1e-6)
    with steps_of(problem, pace=2.0) as run:  # as much faster are waves where shocks are damped
        run.step(2e-3, 2)
        np.testing.assert_allclose(run.look()[:, 1:3], looked[:, 1:3] * [2.0, 1.0], rtol=1e-12)


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
        total += np.cross(x, momentum, axis=0).sum(axis=-1)
    return total


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
        first, energy = run.held(), run.integrals()[-1]
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


@pytest.mark.mpi
def test_on_two_ranks():
    """The same bits, all booked, and no rank waits for one whose data are wrong."""
    done = mpirun(2, "-m", "mpi4py", REPOSITORY / "tests" / "block_scheme_program.py")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    for different, through in (said["panel"], said["slipping"]):
        assert different == 0 and through < 1e-13
    assert said["unbooked"] < 1e-13
    wrong = [fault for fault in said["faults"] if fault]
    assert len(wrong) == 1 and "T of NoSlip at t = 0.0015" in wrong[0] and "T = -1" in wrong[0]
