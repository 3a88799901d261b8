"""What comes in through each face, and what of it is heat: their sum is all that comes in."""

from __future__ import annotations

import block_shapes as shapes
import pytest

pytest.importorskip("petsc4py")

from block_ledgers import steps_of
from ledger_problems import N, gas, problem_of, solid

from fsipetsc.blocks.conditions import Clamped, Free, Given, NoSlip, Open, Roller, Slip
from fsipetsc.scheme.particle_records import MOVES_GAS

DT, STEPS = 1e-3, 5


def pushed(*X_and_t):
    """A wall that moves along the first axis."""
    *X, t = X_and_t
    return [X[0] + 0.2 * t + 0.5 * t * t, *X[1:]]


def energies(problem):
    """name of a face -> (energy, heat) that came in; change of the energy; the run."""
    with steps_of(problem) as run:
        before = run.integrals()[-1]
        run.step(DT, STEPS)
        change, found, total = run.integrals()[-1] - before, run.face_energies(), run.gained()[-1]
        assert abs(found[:, 0].sum() - total) < 1e-14 * before
        assert abs(change - total) < 1e-13 * before
        return dict(zip(problem.face_names, found, strict=True)), change, before, run


def test_a_piston():
    """Work of the wall that moves, heat of the other one: just its flux times the time."""
    ends = {0: NoSlip(x=pushed), 1: NoSlip(heat_flux=0.3)}
    shape = {"gas": shapes.box((0.0,), (1.0,), N + 1)}
    found, change, energy, _ = energies(problem_of(shape, lambda n, a, s: ends[s], gas(1), None))
    (work, none), (heated, heat) = found["gas, axis 0, side 0"], found["gas, axis 0, side 1"]
    assert heat == heated == pytest.approx(0.3 * DT * STEPS, rel=1e-13)
    assert none == 0.0 and work == pytest.approx(change - heat, abs=1e-13 * energy)
    assert work > 1e-4 and not found["through no face"].any()


def test_a_box_with_a_moving_and_two_warm_walls():
    """One of a temperature, one of a flux, which bears on a side that moves along itself only."""
    walls = {(0, 0): NoSlip(x=pushed), (1, 0): NoSlip(T=1.3), (0, 1): NoSlip(heat_flux=0.4)}
    shape = {"gas": shapes.box((0.0, 0.0), (1.0, 1.0), N + 1, N + 1)}

    def faces(name, axis, side):
        return walls.get((axis, side), Slip())

    found, *_ = energies(problem_of(shape, faces, gas(mu=0.02), None))
    work, heat = (found[f"gas, axis {axis}, side 0"] for axis in (0, 1))
    flux = found["gas, axis 0, side 1"]
    assert abs(work[0]) > 1e-4 and work[1] == 0.0
    assert heat[0] == heat[1] and abs(heat[0]) > 1e-4
    assert flux[0] == flux[1] == pytest.approx(0.4 * DT * STEPS, rel=1e-12)
    assert not found["gas, axis 1, side 1"].any() and not found["through no face"].any()


def test_a_pressure_on_a_solid():
    """Its work is the pressure times the way of the face; a clamp is warm, forces have no face."""
    ends = {0: Clamped(T=1.4), 1: Free(0.4, heat_flux=0.2)}
    shape = {"solid": shapes.box((0.0,), (1.0,), N + 1)}
    problem = problem_of(shape, lambda n, a, s: ends[s], None, solid(1, force=0.3))
    with steps_of(problem) as run:
        place = run.y.owned(0)[-1, 0]
        run.step(DT, STEPS)
        way, found = run.y.owned(0)[-1, 0] - place, run.face_energies()
    clamp, free, forces = found
    assert free[1] == pytest.approx(0.2 * DT * STEPS, rel=1e-12)
    assert free[0] - free[1] == pytest.approx(-0.4 * way, rel=1e-12)
    assert clamp[0] == clamp[1] != 0.0 and forces[0] != 0.0 and forces[1] == 0.0


def test_uniform_flow():
    """Through one open face comes what leaves through the other: (E + p) u."""
    u, (rho, T) = 0.5, (1.2, 0.9)

    def uniform(X):
        return [rho + 0.0 * X, u, T]

    shape = {"gas": shapes.box((0.0,), (1.0,), N + 1)}
    options = {"gas": {"initial": uniform}}
    problem = problem_of(shape, lambda n, a, s: Open(rho, (u,), T), gas(1), None, **options)
    found, _, _, _ = energies(problem)
    power = (rho * T / 0.4 + 0.5 * rho * u * u + rho * T) * u
    (one, heat), (other, _), _ = found.values()
    assert one == pytest.approx(power * DT * STEPS, rel=1e-12) and heat == 0.0
    assert other == pytest.approx(-one, rel=1e-12)


def test_a_slip_wall_that_moves_beside_walls_at_rest():
    """The node in the corner is moved by it; what is at rest does no work."""

    def faces(name, axis, side):
        return Slip(x=pushed) if (axis, side) == (0, 0) else NoSlip()

    shape = {"gas": shapes.box((0, 0), (1, 1), N + 1, N + 1)}
    found, *_ = energies(problem_of(shape, faces, gas(mu=0.02), None))
    assert abs(found.pop("gas, axis 0, side 0")[0]) > 1e-4
    assert max(abs(energy) for energy, _ in found.values()) < 1e-12


MOVING = {
    "clamped": Clamped(velocity=lambda X, Y, t: (0.0 * X, 0.2)),
    "given": Given(lambda X, Y, t: (0.0 * X, 0.2, 1.1, X, Y + 0.2 * t)),
}


@pytest.mark.parametrize("sticks", [False, True])
@pytest.mark.parametrize("how", MOVING)
def test_gas_beside_a_solid_whose_ends_move(how, sticks):
    """The work is that of these ends, which are at the ends of the interface, too, and of what is
    given; not of the slip walls beside.
    """

    def faces(name, axis, side):
        if name == "solid":
            return MOVING[how]
        return Given(values) if axis else Slip()

    def values(X, Y, t):
        return 1.0 + 0.1 * X, 0.1, 0.2 * t, 1.0 + 0.0 * Y

    fluid = gas(mu=0.02 if sticks else 0.0)
    problem = problem_of(shapes.layers(N + 1, False), faces, fluid, solid())
    found, _, _, run = energies(problem)
    given = found.pop("gas, axis 1, side 0")
    sides = "axis 0, side 0", "axis 0, side 1", "axis 1, side 1"
    clamps = [found.pop(f"solid, {side}") for side in sides]
    for energy, heat in (given, *clamps):
        assert abs(energy) > 1e-5 and heat == 0.0
    assert max(abs(energy) for energy, _ in found.values()) < 1e-12
    none = len(problem.outer_faces)  # the column of particles that no face moves
    assert run.scheme.particles.table.faces[:, MOVES_GAS].max() == none


def test_a_solid_whose_unknowns_are_given():
    """None of that is said to be heat."""
    given = Given(lambda X, Y, t: (0.1, 0.2 * t, 1.1 + t + 0.0 * X, X + 0.1 * t, Y + 0.1 * t * t))

    def faces(name, axis, side):
        return Slip() if name == "gas" else given if axis else Roller()

    found, *_ = energies(problem_of(shapes.layers(N + 1, False), faces, gas(), solid()))
    energy, heat = found["solid, axis 1, side 1"]
    assert abs(energy) > 1e-4 and heat == 0.0
