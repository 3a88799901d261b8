"""What comes in through faces and by forces is booked where and as it comes."""

import block_shapes as shapes
import numpy as np
import pytest
from block_ledgers import CLOSED, N, Steps, bent, gas, moved, problem_of, solid

from fsipetsc.blocks import conditions
from fsipetsc.blocks.conditions import Clamped, Free, Given, NoSlip, Open, Roller, Slip

MASS, X, Y, ENERGY = range(4)
#: heat of the solid, viscosity of the gas
BOTH = ("elastic", 0.0), ("coupled", 0.02)
DT, STEPS = 1e-3, 3


def check(problem, *entries, least=1e-7):
    """All is booked, and of these entries there is something: (came over energy, by faces)."""
    with Steps(problem) as run:
        before = run.integrals()
        run.step(DT, STEPS)
        change, came, faces = run.integrals() - before, run.gained(), run.face_energies()
        energy = before[-1]
        assert abs(run.lost()) < 1e-9 * energy
    assert np.abs(change - came).max() < 1e-13 * energy, change - came
    assert abs(sum(one for one, _ in faces.values()) - came[-1]) < 1e-14 * energy
    assert all(abs(came[entry]) > least * energy for entry in entries), came
    return came / energy, faces


def test_an_open_tube():
    ends = {("gas", 0, 0): Open(0.9, (0.5, -0.2), 1.1), ("gas", 0, 1): conditions.Outflow(0.8)}
    shape = {"gas": shapes.box((0, 0), (1, 1), N + 1, N + 1)}
    check(problem_of(shapes.warped(shape), CLOSED | ends, gas(), None), MASS, X, Y, ENERGY)


GAS_GIVEN = Given(lambda X, Y, t: (1.0 + 0.1 * np.sin(t + X), 0.1, 0.2 * t, 1.0 + 0.0 * Y))
RISING_CLAMP = Clamped(velocity=lambda X, Y, t: (0.0 * X, 0.2))
RISING_GIVEN = Given(lambda X, Y, t: (0.0 * X, 0.2, 1.1, X, Y + 0.2 * t))
SOLID_GIVEN = Given(lambda X, Y, t: (0.1, 0.2 * t, 1.1 + t + 0.0 * X, X + 0.1 * t, Y + 0.1 * t**2))
#: conditions below and above; which of the energies there are heat, alone or also; what comes in
CONDITIONS = {
    "heat through walls": (NoSlip(heat_flux=0.4), Clamped(heat_flux=0.3), "all all", (ENERGY,)),
    "temperatures": (NoSlip(T=1.3), Clamped(T=1.4), "all all", (ENERGY,)),
    "walls and clamps that move": (NoSlip(x=moved), Clamped(x=moved), "no no", (X, Y, ENERGY)),
    "slip walls that move": (Slip(x=moved), Roller(heat_flux=0.2), "no all", (X, Y, ENERGY)),
    "free, heated": (NoSlip(), Free(0.4, heat_flux=0.2), "- some", (X, Y, ENERGY)),
    "free, warm": (NoSlip(), Free(0.4, T=1.2), "- some", (X, Y, ENERGY)),
    "absorbing": (Slip(), conditions.Absorbing(-0.2, heat_flux=0.1), "- some", (X, Y, ENERGY)),
    "given": (GAS_GIVEN, SOLID_GIVEN, "no no", (MASS, X, Y, ENERGY)),
    "sides move": (GAS_GIVEN, RISING_CLAMP, "no no", (MASS, Y, ENERGY)),
    "sides are given": (GAS_GIVEN, RISING_GIVEN, "no no", (MASS, Y, ENERGY)),
}


@pytest.mark.parametrize(
    ("case", "heat", "mu"),
    [
        *((case, *BOTH[1]) for case in CONDITIONS),
        *((case, *BOTH[0]) for case in CONDITIONS if "move" in case or case == "given"),
    ],
)
def test_conditions(case, heat, mu):
    """At both ends of gas | solid with slip walls and rollers beside, or also at its sides."""
    below, above, kinds, entries = CONDITIONS[case]
    sides = case.startswith("sides")
    faces = CLOSED | {("gas", 1, 0): below, ("solid", 1, 1): above}
    if sides:
        faces["solid"] = above
    shape = shapes.layers(N + 1, False)
    _, found = check(problem_of(shape, faces, gas(mu=mu), solid(heat=heat)), *entries)
    ends = ("gas, axis 1, side 0", below), ("solid, axis 1, side 1", above)
    for (face, condition), kind in zip(ends, kinds.split()):
        energy, warmth = found.pop(face)
        assert (energy == 0.0) == (kind == "-") and (warmth == 0.0) == (kind in ("-", "no"))
        assert (warmth == energy) == (kind in ("-", "all"))
        if flux := getattr(condition, "heat_flux", 0.0):
            assert warmth == pytest.approx(flux * DT * STEPS, rel=1e-12)
    for face, (energy, warmth) in found.items():
        works = sides and face.startswith("solid")
        assert abs(energy) > 1e-5 if works else abs(energy) < 1e-12, face
        assert warmth == 0.0 or not works


def test_forces_in_the_volume(heat="coupled"):
    """Body forces, forcing, what interfaces supply; a point that is held."""
    options = {
        "gas": {"forcing": lambda X, Y, t: (0.1 + 0.0 * X, 0.2 * Y, 0.3 * X, 0.4 + t + 0.0 * X)},
        "solid": {"forcing": lambda X, Y, t: (0.2 * Y, 0.1 * X, 0.3, 0.01 * Y, 0.02 * X)},
        "jumps": lambda X, Y, t: (0.3 + X, 0.2 * X, 0.1 + t + 0.0 * X),
    }
    faces = {"gas": Slip(), "solid": Free()}
    shape, points = shapes.layers(N + 1, False), (("solid", (4.0 / N, 1.6), conditions.Hinge()),)
    materials = gas(force=0.3), solid(heat=heat, force=-0.2)
    came, found = check(problem_of(shape, faces, *materials, **options), MASS, X, Y, ENERGY)
    came_in = [face for face, (energy, _) in found.items() if abs(energy) > 1e-12]
    assert came_in == ["through no face"]
    hinged, _ = check(problem_of(shape, faces, *materials, points, **options))
    assert abs(hinged[Y] - came[Y]) > 1e-6


def test_one_dimension(mu=0.02):
    ends = {"solid": (0.0, 0.4), "gas": (0.4, 1.0), "solid beyond": (1.0, 1.4)}
    shape = {name: shapes.box((a,), (b,), 9) for name, (a, b) in ends.items()}
    blown = Clamped(velocity=lambda X, t: (0.3 * np.sin(2.0 * t) + 0.2 + 0.0 * X,))
    faces = {("solid", 0, 0): blown, ("solid beyond", 0, 1): conditions.Absorbing(-0.3)}
    check(problem_of(shape, faces, gas(1, mu, 0.2), solid(1, force=0.3)), X, 2)


def test_three_dimensions():
    """Where p_ref of the solid acts on its faces, and does work there."""
    lifted = Slip(x=lambda X, Y, Z, t: (X, Y, Z + 0.1 * t * X))
    faces = {("gas", 2): lifted, "gas": Slip(), "solid": Free(0.2)}
    plate = solid(3, heat="coupled")
    check(problem_of(shapes.three(4), faces, gas(3, 0.02), plate), X, Y, 3, 4, least=1e-9)


def speed(X, Y, t):
    return [0.3 * np.cos(3.0 * t + c) * (1.0 + X) for c in (0, 1)]


#: given data, walls of both kinds, clamps
ALL_KINDS = {
    ("gas 20", 1, 0): Given(lambda X, Y, t: (1.1, 0.2, 0.1, 1.2 + 0.0 * X)),
    ("gas", 1, 1): NoSlip(T=1.3, x=moved),
    "gas": Slip(x=moved),
    "solid": Clamped(velocity=speed),
}
#: a solid that slides on rollers beside walls, with a gas that sticks to it
SLIDING = {"gas": NoSlip(slip_length=1.0), "solid": Roller()}
SLIDING |= {("gas", 1): Open(0.9, (0.5, -0.2), 1.1)}


@pytest.mark.parametrize(
    ("faces", "heat", "mu"), [*((ALL_KINDS, *both) for both in BOTH), (SLIDING, *BOTH[1])]
)
def test_what_completion_takes(faces, heat, mu):
    """From a state that obeys nothing, what walls, clamps and data add is booked."""
    panel = faces is ALL_KINDS
    shape = shapes.panel(N + 1) if panel else shapes.layers(N + 1, False)
    straight = {"initial": lambda X, Y: [*bent(X, Y)[:3], X, Y]}
    with Steps(problem_of(shape, faces, gas(mu=mu), solid(heat=heat), solid=straight)) as run:
        rng = np.random.default_rng(1)
        for k, block in enumerate(run.problem.blocks):
            q = run.owned(k)
            if block.kind == "fluid":
                q[:, 1] *= rng.uniform(0.9, 1.1, len(q))
            size = q[:, :1] if block.kind == "fluid" else 1.0
            q[:, 2:4] += size * rng.uniform(-0.3, 0.3, (len(q), 2))
        run.complete()
        before = run.integrals()
        run.finish()
        run.came += run.latest_numbers[-run.came.size :]
        change, came = run.integrals() - before, run.gained()
        assert np.abs(change - came).max() < 1e-14 * before[-1], change - came
        # walls across themselves, clamps, rollers, data
        assert np.abs(came if panel else came[1:3]).min() > 1e-5
        if not panel:  # at the ends of the interface
            u, v = run.owned(1)[[0, N], 2:4].T
            assert np.allclose(u, 0.0, atol=1e-12) and np.abs(v).min() > 1e-3
