"""Stretched gas layers and the conservative coupling: what must be exact is, and the rest has its order."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from conftest import ORDERS
from helpers import compute

import fsipetsc

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.boundaries import Wall, clamped, free
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid
from fsipetsc.options import defaults
from fsipetsc.problem import FluidLayer, Problem, SolidLayer
from fsipetsc.stepping.solve import make_state, solve

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)
BOX = "-fsi_mapping stretched -fsi_coupling conservative"


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """box(name): the result of a run of the closed box."""
    folder = tmp_path_factory.mktemp("box")
    runs = {f"{q}": ("box", f"-fsi_order {q} -fsi_h 0.025 -fsi_cfl 0.2 -ts_max_time 2 {BOX}") for q in ORDERS}
    runs |= {f"cfl_{c}": ("box", f"-fsi_h 0.05 -fsi_cfl {c} -ts_max_time 2 {BOX}") for c in (0.8, 0.4)}
    runs |= {
        f"{mapping} {coupling}": ("box", f"-fsi_h 0.025 -fsi_mapping {mapping} -fsi_coupling {coupling} -ts_max_time 2")
        for mapping in ("rigid", "stretched")
        for coupling in ("projection", "energy", "traditional", "conservative")
    }
    jumping = "-fsi_coupling conservative -fsi_output_dt 1"
    runs |= {f"mms {q} {h}": ("mms", f"-fsi_order {q} -fsi_h {h} {jumping}") for q in ORDERS for h in (0.025, 0.0125)}
    runs["reference"] = ("box", f"-fsi_order 8 -fsi_h 0.0125 -ts_max_time 2 {BOX}")
    compute(1, folder, runs)
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


def drifts(run) -> tuple[float, float, float]:
    """Largest changes of mass and energy relative to these, of the momentum to the impulse that has passed."""
    series, start = run.series, run.summary
    mass = np.abs(series["mass"] / np.array(start["initial_mass"]) - 1).max()
    energy = np.abs(series["energy"] / start["initial_energy"] - 1).max()
    force = np.concatenate([[start["initial_force"]], series["force"]])
    given = 0.5 * series["dt"] * (force[1:] + force[:-1]) + series["impulse"]
    change = series["momentum"] - start["initial_momentum"] - np.cumsum(given)
    return mass, energy, np.abs(change).max() / np.abs(given).sum()


@EVERY_ORDER
def test_a_closed_box_keeps_mass_momentum_and_energy(box, order):
    """To round-off, but for what the Runge-Kutta method leaves of the energy, u^2/2 within the solid; measured 6e-15."""
    mass, energy, momentum = drifts(box(f"{order}"))
    assert mass < 1e-14
    assert momentum < 1e-14
    assert energy < 1e-13


def test_what_is_left_of_the_energy_is_the_time_steps(box):
    coarse, fine = (drifts(box(f"cfl_{c}"))[1] for c in (0.8, 0.4))
    assert coarse > 20 * fine > 0, "of order dt^5 over the whole time"


def test_every_coupling_on_either_grid(box):
    """All lead to the same positions; the conservative one on a stretched grid is the one that keeps all."""
    reference = box("reference").series["x_interface"][-1]
    for mapping in ("rigid", "stretched"):
        for coupling in ("projection", "energy", "traditional", "conservative"):
            run = box(f"{mapping} {coupling}")
            assert np.abs(run.series["x_interface"][-1] - reference).max() < 2e-5, (mapping, coupling)
            assert drifts(run)[1] < 3e-6, (mapping, coupling)
            exact = (mapping, coupling) == ("stretched", "conservative")
            assert (max(drifts(run)) < 1e-10) == exact


def test_positions_are_no_worse_than_those_of_the_paper(box):
    reference = box("reference").series["x_interface"][-1]
    new, paper = (
        np.abs(box(name).series["x_interface"][-1] - reference).max() for name in ("stretched conservative", "rigid projection")
    )
    assert new < paper


@EVERY_ORDER
def test_a_manufactured_solution_with_jumps(box, order):
    """Velocity, stress, temperature and heat flux jump at the interfaces, and change in time."""
    for kind, largest in (("fluid", {2: 5e-4, 4: 3e-5, 6: 5e-7, 8: 3e-7}), ("solid", {2: 4e-4, 4: 1e-4, 6: 1e-6, 8: 1e-6})):
        coarse, fine = (box(f"mms {order} {h}").errors[kind]["combined"] for h in (0.025, 0.0125))
        assert fine < largest[order], (kind, fine)
        assert np.log2(coarse / fine) > {2: 1.8, 4: 2.7, 6: 3.7, 8: 4.2}[order], (kind, coarse, fine)


GAS = Fluid(0.0, 0.0, 1.4, 1.0)


class Case:
    """A problem as a case, with some options."""

    def __init__(self, problem: Problem, **options: object) -> None:
        self.problem, self.options = problem, {**defaults(load_case("box")), "fsi_cfl": 0.7, **options}

    def build(self, opt):
        return self.problem

    def run(self):
        return solve(self, self.options, MPI.COMM_SELF)

    def state(self):
        return make_state(self.problem, self.options, MPI.COMM_SELF)


def column(left: Wall, right: Wall, gas: Fluid = GAS, speed=lambda X: 0 * X, **more) -> Problem:
    """Gas of density and temperature 1 between two walls, at first 1 apart."""
    layer = FluidLayer("gas", gas, (0.0, 1.0), lambda X: [1 + 0 * X, speed(X), 1 + 0 * X], **more)
    return Problem((layer,), left, right, units="none")


@EVERY_ORDER
def test_a_free_stream_on_a_grid_that_is_stretched(order):
    """Away from the walls, which do not let it pass, the rates of J (rho, rho u, e) are J_t/J times these."""
    walls = Wall(lambda t: -0.4 * t, velocity=lambda t: -0.4), Wall(lambda t: 1 + 0.7 * t, velocity=lambda t: 0.7)
    case = Case(column(*walls, speed=lambda X: 0.3 + 0 * X), fsi_order=order, fsi_h=1 / 64)
    with case.state() as state:
        state.set_initial()
        y = state.solution.getArray().copy()
        f = np.empty_like(y)
        state.right_hand_side(y, f)
        inner = slice(16, -16)
        q, rates = (state.layout.local(0, v)[inner] for v in (y, f))
        np.testing.assert_allclose(rates, 1.1 * q, rtol=0, atol=2e-13 * 64)


@EVERY_ORDER
def test_a_column_is_compressed_uniformly(order):
    """u = x V/L, and T, rho as of L alone: exact in space, and the Runge-Kutta method's in time."""
    gas = Fluid(0.05, 0.1, 1.4, 1.0)
    length = lambda t: 1 - 0.5 * t  # noqa: E731

    def exact(X, t):
        L = length(t)  # cv T_t = -p L_t/L/rho + mu' (L_t/L)^2/rho with rho = 1/L: (T L^(gamma-1))_t = ...
        g, mu, cv = gas.gamma - 1, 4 / 3 * gas.mu, gas.cv
        heated = mu / cv * 0.25 / (-0.5) * (L ** (g) - 1) / g
        return [1 / L + 0 * X, -0.5 * X, (1 + heated) / L**g + 0 * X]

    problem = column(Wall(0.0), Wall(length), gas, lambda X: -0.5 * X, exact=exact)
    errors = [
        Case(problem, fsi_order=order, fsi_h=1 / 20, fsi_cfl=c, ts_max_time=0.8).run().errors["fluid"]["combined"]
        for c in (0.8, 0.4)
    ]
    assert errors[0] < 1e-5
    assert errors[0] > 14 * errors[1], "fourth order in time"


def test_a_wall_that_starts_at_once_does_not_cool_the_gas():
    """The gas at a wall has the wall's velocity from the beginning, and the T that is given: its energy is that of both."""
    walls = Wall(lambda t: 0.5 * t, velocity=lambda t: 0.5), Wall(1.0)
    with Case(column(*walls, speed=lambda X: 0.1 + 0 * X), fsi_h=1 / 20).state() as state:
        state.set_initial()
        _, u, T, _ = GAS.primitive(state.plan.owned(0))
        assert (u[0], u[1], u[-1]) == (0.5, 0.1, 0.0)
        np.testing.assert_allclose(T, 1.0, rtol=1e-15)


def test_heat_through_walls():
    """The energy grows by the flux; between two temperatures the straight line stays one."""
    gas = Fluid(0.1, 1.0, 1.4, 1.0)
    warmed = Case(column(Wall(0.0, heat_flux=0.3), Wall(1.0, heat_flux=lambda t: 0.2 * t), gas), fsi_h=1 / 20, ts_max_time=1.0)
    with warmed.state() as state:
        state.set_initial()
        before = state.latest["energy"].item()
        t, dt = 0.0, 1 / 2048
        for _ in range(256):
            state.step(t, dt, False)
            t += dt
        assert state.latest["energy"].item() - before == pytest.approx(0.3 * t + 0.1 * t * t, rel=1e-12)

    profile = lambda X: [1 / (1 + 0.5 * X), 0 * X, 1 + 0.5 * X]  # noqa: E731
    layer = FluidLayer("gas", gas, (0.0, 1.0), profile)
    case = Case(Problem((layer,), Wall(0.0, T=1.0), Wall(1.0, T=lambda t: 1.5), units="none"), fsi_h=1 / 20)
    with case.state() as state:
        state.set_initial()
        for k in range(512):
            state.step(k * dt, dt, False)
        rho, u, T, _ = gas.primitive(state.plan.owned(0))
        assert np.abs(u).max() < 1e-12
        np.testing.assert_allclose([rho, T], np.array(profile(np.linspace(0, 1, 21)))[[0, 2]], atol=1e-12)


def bar(solid: Solid, **more) -> SolidLayer:
    return SolidLayer("bar", solid, (0.0, 1.0), lambda X: [0 * X, 0 * X, 1 + 0 * X, X], **more)


@EVERY_ORDER
def test_a_solid_alone(order):
    """Small standing wave between a clamped and a free end, which keeps its energy; the error has the order."""
    solid, amplitude = Solid(1.0, 0.0, 1.0, 1e6), 1e-8
    k = np.pi / 2

    def exact(X, t):
        return [
            amplitude * np.sin(k * X) * np.cos(k * t),
            amplitude * np.cos(k * X) * np.sin(k * t),
            1 + 0 * X,
            X + amplitude * np.sin(k * X) * np.sin(k * t) / k,
        ]

    layer = replace(bar(solid, exact=exact), initial=lambda X: exact(X, 0.0))
    problem = Problem((layer,), clamped(), free(), units="none")
    runs = [Case(problem, fsi_order=order, fsi_h=h, ts_max_time=1.0).run() for h in (1 / 20, 1 / 40)]
    found = [run.errors["solid"]["u"] for run in runs]
    assert found[0] < amplitude * {2: 2e-3, 4: 1e-4, 6: 1e-4, 8: 1e-4}[order]
    assert np.log2(found[0] / found[1]) > {2: 1.8, 4: 2.8, 6: 3.6, 8: 3.6}[order]


def test_ends_of_a_solid_that_change_in_time():
    """Driven at one end, warmed at the other: momentum and heat are what has been put in."""
    solid = Solid(4.0, 0.5, 1.0, 2.0)
    ends = clamped(lambda t: 1e-3 * np.sin(t)), free(lambda t: -1e-3 * t, heat_flux=0.25)
    case = Case(Problem((bar(solid),), *ends, units="none"), fsi_h=1 / 20)
    with case.state() as state:
        state.set_initial()
        energy, t, dt, impulse = state.latest["energy"].item(), 0.0, 1 / 512, 0.0
        for _ in range(256):
            state.step(t, dt, False)
            t += dt
            impulse += state.latest["impulse"].item() - 1e-3 * (t - dt / 2) * dt
        assert state.latest["momentum"].item() == pytest.approx(impulse, rel=1e-11)
        assert state.latest["energy"].item() - energy == pytest.approx(0.25 * t, rel=1e-4)
        assert state.plan.owned(0)[0, 0] == 1e-3 * np.sin(t)


@pytest.mark.parametrize(
    ("end", "more", "words"),
    [
        (Wall(-1.0), {}, ["begins at x = 0", "ends at x = -1"]),
        (Wall(1.0), {"mapping": "rigid"}, ["mapping='rigid'", "'stretched' or None"]),
        (Wall(1.0), {"mapping": "elastic"}, ["mapping is 'elastic'"]),
        (Wall(lambda t: "one"), {}, ["x of the right end", "'one'"]),
        (Wall(1.0, T=lambda t: -1.0), {}, ["T of the right end", "above 0"]),
        (Wall(lambda t: 1 + t**4, velocity=lambda t: 8 * t**3), {}, ["velocity of the right end: ", "expected the rate of x"]),
        (Wall(lambda t: 1 + 0.2 * t, velocity=lambda t: 0.9), {}, ["0.9 on average", "rises by 0.2 a second"]),
        (Wall(lambda t: 1 + sqrt(t)), {}, ["x of the right end at t = -", "because no velocity is given"]),
    ],
    ids=["inside out", "rigid", "no mapping", "no number", "no temperature", "twice as fast", "another speed", "not before 0"],
)
def test_what_cannot_be_is_said(end, more, words):
    with pytest.raises(InputError) as found:
        with Case(column(Wall(0.0), end, **more), fsi_h=1 / 20).state() as state:
            state.set_initial()
    for word in words:
        assert word in str(found.value)


def test_an_end_says_what_it_cannot_be():
    for make, word in (
        (lambda: Wall(0.0, T=1.0, heat_flux=1.0), "expected one of them"),
        (lambda: Wall(0.0, velocity=lambda t: 1.0), "x is a number"),
        (lambda: Wall("a"), "'a'"),
        (lambda: clamped("fast"), "clamped: velocity is 'fast'"),
        (lambda: free(0.0, T=-1.0), "free: T is -1"),
    ):
        with pytest.raises(InputError, match=word):
            make()
