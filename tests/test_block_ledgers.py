"""What comes in through faces and by forces is booked as it comes: the integrals change by just
that.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("petsc4py")

import block_shapes as shapes
from block_ledgers import steps_of, unbooked
from helpers import REPOSITORY, mpirun
from ledger_problems import N, closed, gas, moved, problem_of, solid, straight

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
from fsipetsc.blocks.maps import rectangle
from fsipetsc.blocks.problem import BlockProblem
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.stepping.ledgers import Ledgers

MASS, X, Y, ENERGY = range(4)
#: heat of the solid, viscosity of the gas
BOTH = ("elastic", 0.0), ("coupled", 0.02)


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
    hinged = check(problem_of(shape, faces, fluid, plate, points, **options))
    assert abs(hinged[Y] - came[Y]) > 1e-6


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
        run.came += run.y.auxiliary
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


@pytest.mark.mpi
def test_on_two_ranks():
    """The same bits, all booked, and no rank waits for one whose data are wrong."""
    done = mpirun(2, "-m", "mpi4py", REPOSITORY / "tests" / "block_scheme_program.py")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    for different, energies in (said["panel"], said["slipping"]):
        assert different == 0 and energies < 1e-13
    assert said["unbooked"] < 1e-13
    wrong = [fault for fault in said["faults"] if fault]
    assert len(wrong) == 1 and "T of NoSlip at t = 0.0015" in wrong[0] and "T = -1" in wrong[0]
