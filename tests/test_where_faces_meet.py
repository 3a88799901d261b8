"""What counts where faces with several conditions meet, and which of them contradict each other."""

import numpy as np
import pytest
from block_ledgers import Steps, check_motion

from fsipetsc import Block, BlockProblem, Fluid, InputError
from fsipetsc.blocks.conditions import Clamped, Free, NoSlip, Roller, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.materials.solid import ElasticSolid
from fsipetsc.particles.members import particles_of

GAS = Fluid(0.02, 0.03, 1.4, 1.0)
SOLID = ElasticSolid(1.0, 2.0, 0.05, 2.0, 1.5, 0.3, "log", "elastic")
SIDES = {"west": (0, 0), "east": (0, 1), "south": (1, 0), "north": (1, 1)}
STILL, RELAXED = lambda X, Y: (1.0, 0.0, 0.0, 1.0), lambda X, Y: (0.0, 0.0, 1.0, X, Y)


def block(kind, lower=0.0):
    material, initial = (GAS, STILL) if kind == "gas" else (SOLID, RELAXED)
    return Block(kind, material, rectangle((0.0, lower), (1.0, lower + 1.0)), (2, 2), initial)


def alone(kind, rest, **faces):
    """A square; rest: the condition of sides that are not named."""
    named = {(kind, *face): faces.get(side, rest) for side, face in SIDES.items()}
    return BlockProblem((block(kind),), named)


def stacked(side, beside):
    """A solid on a gas: conditions at the sides of the gas, of the solid."""
    faces = {("gas", 1, 0): Slip(), ("solid", 1, 1): Free()}
    faces |= {("gas", 0, s): side for s in (0, 1)} | {("solid", 0, s): beside for s in (0, 1)}
    return BlockProblem((block("gas"), block("solid", 1.0)), faces)


def moving(u, v, profile=lambda X: 1.0 + 0.0 * X, kind=NoSlip, **data):
    """A wall that begins to move at t = 0, with this velocity at t = 1."""

    def x(X, Y, t):
        return X + 0.5 * u * t * t * profile(X), Y + 0.5 * v * t * t * profile(X)

    return kind(x=x, **data)


#: problems, and what is said of them at t = 1
REFUSED = {
    "a lid": (
        alone("gas", NoSlip(), north=moving(0, -1)),
        r"NoSlip of 'gas', axis 1, side 1, at t = 1 is \(0, -1\) m/s at \(X, Y\) = \(0, 1\), that "
        r"of NoSlip of 'gas', axis 0, side 0, which meets it there, \(0, 0\) m/s: no grid.*Slip",
    ),
    "clamps": (alone("solid", Clamped(), north=moving(0, 1, kind=Clamped)), "be Slip or Roller"),
    "a wall and a clamp": (stacked(moving(1, 0), Clamped()), "Clamped of .* NoSlip of 'gas'"),
    "a solid that is free": (stacked(NoSlip(), Free()), "NoSlip .* a solid that slides along it"),
}
ACCEPTED = {
    "slip at the sides": alone("gas", Slip(), north=moving(0, -1)),
    "a lid whose ends rest": alone(
        "gas", NoSlip(), north=moving(0, -1, lambda X: np.sin(np.pi * X))
    ),
    "a clamp along rollers": alone("solid", Roller(), north=moving(0, 1, kind=Clamped)),
    "a solid that slides, with drag": stacked(NoSlip(slip_length=1.0), Roller()),
    "a clamped solid": stacked(NoSlip(), Clamped()),
}


@pytest.mark.parametrize("case", REFUSED)
def test_velocities_that_cannot_be_are_refused(case):
    problem, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        check_motion(problem, 1e-3)


@pytest.mark.parametrize("case", ACCEPTED)
def test_what_fits_together_is_accepted(case):
    check_motion(ACCEPTED[case], 1e-3)


def test_shear_beside_a_wall_along_which_the_gas_slips():
    """u = 1 - (1 - y)/(1 + l) rests under a wall of velocity 1, with the drag of the lower."""
    length = 0.4
    slope = 1.0 / (1.0 + length)
    flow = lambda X, Y: (1.0, slope * (Y + length), 0.0, 1.0)  # noqa: E731
    box, cells = rectangle((0.0, 0.0), (1.0, 1.0)), (4, 8)
    layer = Block("gas", GAS, box, cells, flow, periodic=(True, False))
    upper = NoSlip(x=lambda X, Y, t: (X + t, Y), velocity=lambda X, Y, t: (1.0 + 0.0 * X, 0.0))
    faces = {("gas", 1, 0): NoSlip(slip_length=length), ("gas", 1, 1): upper}
    with Steps(BlockProblem((layer,), faces)) as run:
        f = np.zeros_like(run.y)
        run.right_hand_side(run.y.copy(), f)
        rates = f[: f.size - run.layout.auxiliary].reshape(5, -1).T
        assert np.abs(rates[:, 2]).max() < 1e-13
        run.step(1e-3, 3)
        came = run.gained()
        work = {face: energy for face, (energy, _) in run.face_energies().items()}
    assert abs(came[1]) < 1e-9  # both push alike
    assert work["gas, axis 1, side 0"] == 0.0
    assert work["gas, axis 1, side 1"] == pytest.approx(GAS.mu * slope * 3e-3, rel=1e-6)


def walls(lengths, turn=1):
    """A box (0, 1, 1) … and a duct that ends in it: place in these lengths -> its slip walls."""
    gas, blocks = Fluid(0.0, 0.0, 1.4, 1.0), []
    for low in [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 0, 0)][::turn]:
        box = rectangle(lengths * low, lengths * np.add(low, 1))
        blocks.append(Block(str(low), gas, box, (2, 2, 2), lambda *X: (1.0, 0.0, 0.0, 0.0, 1.0)))
    sides = {
        (b.name, *face): b.face_positions(*face).mean(axis=1) for b in blocks for face in b.faces
    }
    alone = [one for one in sides if sum(np.allclose(sides[one], x) for x in sides.values()) == 1]
    problem = BlockProblem(blocks, dict.fromkeys(alone, Slip()))
    found = {}
    for one in particles_of(problem):
        place = problem.places(one.members[0][0], np.array([one.members[0][1]]))[0] / lengths
        names = [{(blocks[f.block].name, f.axis) for f in faces} for _, faces in one.constraints]
        found[tuple(place.round(9).tolist())] = sorted(map(sorted, names))
    return found


@pytest.mark.parametrize("lengths", [(1.0, 1.0, 1.0), (1.0, 0.2, 3.0)])
def test_slip_walls_in_three_dimensions(lengths):
    """Those that meet at right angles in the gas are two, whatever the cells are; what is one does
    not depend on the order of blocks."""
    found = walls(np.array(lengths))
    assert found == walls(np.array(lengths), -1)
    assert [len(found[place]) for place in ((0, 0, 0), (0, 0, 0.5), (0.5, 2, 2))] == [3, 2, 2]
    assert [len(found[place]) for place in ((1, 1, 0.5), (1.5, 1, 1), (1, 1.5, 1.5))] == [1, 2, 1]
    assert len(found[1, 1, 1]) >= 3


@pytest.mark.parametrize(("flow", "closed"), [(0.5, False), (0.0, True)])
def test_a_gas_without_viscosity_slips_along_any_wall(flow, closed):
    """A lid over it moves nothing."""
    gas, box = Fluid(0.0, 0.0, 1.4, 1.0), rectangle((0.0, 0.0), (1.0, 1.0))
    start = lambda X, Y: (1.0, flow, 0.0, 1.0)  # noqa: E731
    layer = Block("gas", gas, box, (4, 8), start, periodic=(not closed, False))
    faces = {("gas", axis, 0): NoSlip() for axis in (0, 1)[not closed :]}
    faces |= {("gas", 0, 1): NoSlip(T=1.0)} if closed else {}
    faces["gas", 1, 1] = NoSlip(velocity=lambda X, Y, t: (0.3 + 0.0 * X, 0.0 * X))
    with Steps(BlockProblem((layer,), faces)) as run:
        run.step(1e-2, 5)
        assert np.abs(run.saved(0)[:, 1] - flow).max() < 1e-14
