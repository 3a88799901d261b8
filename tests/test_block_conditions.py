"""Conditions at faces of blocks, held against what is exact."""

import numpy as np
import pytest
from block_ledgers import Steps, problem_of, slab
from block_shapes import box
from conftest import ORDERS

from fsipetsc import Block, BlockProblem, Fluid, InputError
from fsipetsc.blocks import conditions
from fsipetsc.blocks.conditions import Clamped, Free, Given, NoSlip, Open, Roller, Slip
from fsipetsc.blocks.maps import rectangle
from fsipetsc.materials.own import solid_law
from fsipetsc.materials.solid import ElasticSolid

SOUND = np.sqrt(1.4)


def rod(kappa=0.05):
    """K = 8, m0 = 2: waves of speed 2."""
    return ElasticSolid(2.0, 4.0, kappa, 2.0, 1.5, 0.0, "log", "elastic")


@pytest.mark.parametrize(("kind", "speed", "side"), [("shear", 1.0, 0), ("pressure", 2.0, 1)])
def test_waves_of_both_kinds_leave_through_an_absorbing_face(kind, speed, side):
    """Along the normal; a face that resists along it alone gives all of a wave of shear back. Their
    energy, m0 c^2 int D_Y^2 dY per width, goes out."""
    size, along, out = 1e-6, int(kind == "pressure"), 2.0 * side - 1.0

    def pulse(X, Y):
        shape = size * np.exp(-(((Y - 0.5) / 0.08) ** 2))
        slope = -2.0 * (Y - 0.5) / 0.08**2 * shape
        x, v = [X, Y], [0.0 * X, 0.0 * X]
        x[along], v[along] = x[along] + shape, -out * speed * slope
        return *v, 1.0 + 0.0 * X, *x

    strip = rectangle((0.0, 0.0), (0.1, 1.0))
    block = Block("slab", rod(0.0), strip, (8, 128), pulse, periodic=(True, False))
    faces = {("slab", 1, 1 - side): Clamped(), ("slab", 1, side): conditions.Absorbing()}
    with Steps(BlockProblem((block,), faces), order=4) as run:
        before = np.abs(run.owned(0)[:, 2:4]).max()
        run.step(0.4 / 128 / 2.0, round(0.9 / speed / (0.4 / 128 / 2.0)))
        assert np.abs(run.owned(0)[:, 2:4]).max() < 3e-3 * before
        energy = 0.1 * 2.0 * speed**2 * size**2 * np.sqrt(np.pi / 2.0) / 0.08
        assert run.gained()[-1] == pytest.approx(-energy, rel=2e-4)


@pytest.mark.parametrize("symmetry", [0, 1])
def test_a_law_of_a_case_has_its_reference_pressure(symmetry):
    """It is at rest between a gas and a free face of this pressure."""
    named = ElasticSolid(2.0, 4.0, 0.0, 2.0, 1.5).solid_law
    law = solid_law(stress=lambda F: named.stress(F), energy=lambda F: named.energy(F))
    solid = ElasticSolid(2.0, 4.0, 0.0, 2.0, 1.5, p_ref=0.3, law=law, heat="elastic")
    gas = Fluid(0.0, 0.0, 1.4, 1.0)
    blocks = (
        Block("gas", gas, rectangle(1.0, 2.0), (8,), lambda X: (1.0, 0.0, 0.3)),
        Block("solid", solid, rectangle(2.0, 3.0), (8,), lambda X: (0.0, 0.3, X)),
    )
    faces = {("gas", 0, 0): Slip(), ("solid", 0, 1): Free(0.3)}
    with Steps(BlockProblem(blocks, faces, symmetry=symmetry), order=4) as run:
        run.step(0.01, 20)
        assert np.abs(run.owned(1)[:, :2]).max() < 1e-14


@pytest.mark.parametrize("mu", [0.0, 0.01])
@pytest.mark.parametrize("side", [Clamped(), Roller()])
def test_a_gas_that_is_given_keeps_its_values_at_a_solid(mu, side):
    """Where both conduct, the solid has its temperature; if it can move, its velocity, too."""

    def values(X, Y, t):
        return 1.0 + 0.0 * X, 0.0 * X, 0.02 * np.sin(3.0 * t) + 0.0 * X, 1.0 + 0.2 * t + 0.0 * X

    both = Fluid(mu, 0.05, 1.4, 1.0), ElasticSolid(2.0, 4.0, 0.05, 2.0, 1.5, p_ref=1.0)
    shape = {"gas": box((0, 0), (1, 1), 9, 9), "solid": box((0, 1), (1, 2), 9, 9)}
    rest = {"gas": lambda X, Y: (1.0, 0.0, 0.0, 1.0), "solid": lambda X, Y: (0.0, 0.0, 1.0, X, Y)}
    faces = {("gas", 0, 0): Given(values), "gas": Slip(), ("solid", 0): side, "solid": Clamped()}
    initial = {kind: {"initial": state} for kind, state in rest.items()}
    with Steps(problem_of(shape, faces, *both, **initial), order=4) as run:
        run.step(0.005, 40)
        (J, rho, _, rho_v, e), (_, _, _, v, e_s) = run.owned(0)[72], run.owned(1)[0]
        moved, T = 0.02 * np.sin(3.0 * run.t), 1.0 + 0.2 * run.t
        found = rho / J, rho_v / rho, 0.4 * (e / rho - 0.5 * moved**2), (e_s - 0.5 * v**2) / 1.5
        assert found == pytest.approx((1.0, moved, T, T), abs=1e-13)
        assert v == pytest.approx(moved if side == Roller() else 0.0, abs=1e-13)


def test_a_clamp_with_a_velocity_moves_from_where_it_is():
    clamp = Clamped(velocity=lambda X, t: (0.3 * np.cos(5.0 * t) + 0.0 * X,))
    with Steps(slab(rod(), lambda X: (0.0, 1.0, 1.1 * X + 0.05), (clamp, Free()), 16), 4) as run:
        assert run.saved(0)[:, 1] == pytest.approx(1.0, abs=1e-13)  # T, though the rod rests
        run.step(2e-3, 100)
        D, v, _ = run.owned(0)[0]
        assert D == pytest.approx(0.05 + 0.06 * np.sin(5.0 * run.t), abs=1e-10)
        assert v == pytest.approx(0.3 * np.cos(5.0 * run.t), abs=1e-14)


def test_a_square_turns_about_its_hinge():
    """The point stays, the rest goes around, and the angular momentum about it is kept."""

    def turning(X, Y):
        return -0.1 * Y, 0.1 * X, 1.0, X, Y

    block = Block("solid", rod(0.0), rectangle((0, 0), (1, 1)), (8, 8), turning)
    faces = {("solid", axis, side): Free() for axis in (0, 1) for side in (0, 1)}
    problem = BlockProblem((block,), faces, points=(("solid", (0.0, 0.0), conditions.Hinge()),))
    with Steps(problem) as run:
        before = float(run.latest["angular_momentum"])
        run.step(5e-3, 100)
        assert np.abs(run.owned(0)[0, :4]).max() < 1e-15
        assert np.abs(run.owned(0)[-1, :2]).max() > 0.03
        assert run.latest["angular_momentum"] == pytest.approx(before, rel=1e-6)
        assert np.hypot(*run.gained()[1:3]) > 1e-4


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


def test_volumes_stay_those_of_the_grid():
    """Over 100 periods of walls that wobble: Simpson's error for a periodic function is none."""
    gas, square, cells = Fluid(0.0, 0.0, 1.4, 1.0), rectangle((0, 0), (1, 1)), (8, 8)
    block = Block("gas", gas, square, cells, lambda X, Y: (1.0, 0.0, 0.0, 1e-3))  # cold
    sides = {("gas", 0, side): Slip() for side in (0, 1)}
    faces = {("gas", 1, 0): NoSlip(**wall(0.0, 0.05)), ("gas", 1, 1): Slip(**wall(1.3, 0.07))}
    with Steps(BlockProblem((block,), sides | faces), 4) as run:
        assert run.saved(0)[:, 3] == pytest.approx(1e-3, abs=1e-15)  # T, though the gas rests
        worst = 0.0
        for n in range(800):
            run.step(1 / 8)  # also where T is below 0
            if n % 8 == 7:
                run.finish()
                worst = max(worst, *run.latest["J_error"])
    assert 0.0 < worst < 1e-12


def between_walls(lid, cells):
    """Couette's flow: u = U Y, and T is a parabola; the walls have the temperature 1."""
    mu, U = 0.05, 0.5
    gas, strip = Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0 / 1.4), rectangle((0, 0), (1, 1))

    def flow(X, Y):
        T = 1.0 + 0.5 * gas.mu * U**2 / gas.kappa * Y * (1.0 - Y)
        return 1.0 / T, U * Y, 0.0 * Y, T

    block = Block("gas", gas, strip, (8, cells), flow, periodic=(True, False))
    walls = {("gas", 1, 0): NoSlip(T=1.0), ("gas", 1, 1): NoSlip(T=1.0, velocity=lid)}
    return BlockProblem((block,), walls)


def test_a_wall_that_slides_along_itself_drags_gas():
    """Couette's flow stays, and the work of the wall leaves as heat through both."""
    left = []
    for cells in (16, 32):
        with Steps(between_walls(lambda X, Y, t: (0.5, 0.0), cells), order=4) as run:
            exact = run.owned(0).copy()
            run.step(0.1 / cells**2, 2 * cells**2)
            left.append(np.abs(run.owned(0) - exact).max())
    assert left[1] < 1e-6
    assert left[0] / left[1] > 2**2.2  # the boundary rows of 4/2 have order 2


def test_a_wall_at_rest_has_no_velocity_across_itself():
    with Steps(between_walls(lambda X, Y, t: (0.5, 0.2 * X), 8), order=4) as run:
        with pytest.raises(InputError, match=r"velocity of NoSlip .* across the wall"):
            run.system.prescribed.check_motion(1.0)
    with pytest.raises(InputError, match="velocity is given, and x is not"):
        NoSlip(velocity=lambda X, Y, t: (0.5, 0.0), slip_length=1.0)


@pytest.mark.parametrize(
    ("amplitude", "mu", "of_open", "mach"),
    [(0.1, 0.0, 1, 0.0), (1e-3, 1e-3, 0, 0.0), (1e-3, 2e-3, 1, 0.3)],
)
def test_sound_leaves_on_both_sides(amplitude, mu, of_open, mach):
    """Viscosity is left by order 0 of the ends, not by order 1; gas may flow through."""
    u = mach * SOUND

    def pulse(X):
        p = 1 + amplitude * np.exp(-(((X - 0.5) / 0.1) ** 2))
        T = p ** (0.4 / 1.4)
        return [p / T, u + 0 * X, T]

    ends = (Open(1.0, (u,), 1.0, of_open),) * 2
    with Steps(slab(Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0), pulse, ends, 160), order=6) as run:
        # after that only what is reflected is there
        run.step(0.5 / 160 / SOUND, round(320 / (1 - mach)))
        left = np.abs(run.saved(0)[:, 2:4] - 1)  # T and p
    assert left.max() < (2e-4 if of_open else 1.5e-3) * amplitude
    assert of_open or left.max() > 5e-4 * amplitude


def linearised(order, mach, mu):
    """The rates between two open ends about a uniform flow, with respect to the state."""
    u = mach * SOUND
    gas, ends = Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0), (Open(1.0, (u,), 1.0, 1),) * 2
    with Steps(slab(gas, lambda X: [1 + 0 * X, u + 0 * X, 1 + 0 * X], ends, 32), order) as run:
        start, columns = run.y.copy(), run.y.size - run.layout.auxiliary
        f = np.zeros((2, columns, start.size))
        for k, step in enumerate(1e-6 * np.eye(columns, start.size)):
            run.right_hand_side(start - step, f[0, k])
            run.right_hand_side(start + step, f[1, k])
        return (f[1] - f[0])[:, :columns].T / 2e-6


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("mach", [0.0, 0.3, 1.5])
def test_no_mode_grows_between_open_ends_of_first_order(order, mach):
    """At 3 and 10 the viscosity is far beyond what is resolved."""
    for nu in (0.01, 3.0, 10.0):
        rates = linearised(order, mach, 0.75 * nu * SOUND / 32)
        growing = np.linalg.eigvals(rates).real.max() / (32 * SOUND)
        assert growing < 1e-9, (nu, growing)
