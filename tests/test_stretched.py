"""Layers in one dimension on blocks: what must be exact is, and the rest has its order."""

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
from fsipetsc.stepping.solve import build_problem, make_state, solve

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """box(name): the result of a run of the closed box."""
    folder = tmp_path_factory.mktemp("box")
    couplings = ("projection", "energy", "conservative")
    runs = {f"{q}": ("box", f"-fsi_order {q} -fsi_h 0.025 -fsi_cfl 0.2 -ts_max_time 2") for q in ORDERS}
    runs |= {c: ("box", f"-fsi_h 0.025 -fsi_coupling {c} -ts_max_time 2") for c in couplings}
    runs["reference"] = ("box", "-fsi_order 8 -fsi_h 0.0125 -ts_max_time 2")
    compute(1, folder, runs)
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


@EVERY_ORDER
def test_a_closed_box_keeps_mass_momentum_and_energy(box, order):
    """To round-off, whatever the step; measured 1e-14 of momentum, 3e-15 of energy."""
    drifts = box(f"{order}").summary["departures"]
    assert len(drifts) == 4 and max(drifts.values()) < 1e-13, drifts


def test_positions_are_no_worse_than_those_of_the_paper(box):
    """All couplings lead to the same positions."""
    reference = box("reference").series["x_interface"][-1]
    ends = {c: box(c).series["x_interface"][-1] for c in ("projection", "energy", "conservative")}
    away = {c: np.abs(end - reference).max() for c, end in ends.items()}
    assert max(away.values()) < 2e-5 and away["conservative"] < away["projection"]


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
        return make_state(build_problem(self, self.options, MPI.COMM_SELF), self.options, MPI.COMM_SELF)


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
        q, rates = (state.layout.owned(0, v)[16:-16, 1:] for v in (y, f))
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
        state.finish()
        _, u, T, *_ = state.fields(0).T
        assert (u[0], u[1], u[-1]) == (0.5, 0.1, 0.0)
        np.testing.assert_allclose(T, 1.0, rtol=1e-15)


def test_heat_through_walls():
    """The energy grows by the flux; between two temperatures the straight line stays one, but for the error of gradients of
    1/T.
    """
    gas = Fluid(0.1, 1.0, 1.4, 1.0)
    warmed = Case(column(Wall(0.0, heat_flux=0.3), Wall(1.0, heat_flux=lambda t: 0.2 * t), gas), fsi_h=1 / 20, ts_max_time=1.0)
    with warmed.state() as state:
        state.set_initial()
        state.finish()
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
        rho, u, T, *_ = state.fields(0).T
        assert np.abs(u).max() < 2e-5
        np.testing.assert_allclose([rho, T], np.array(profile(np.linspace(0, 1, 21)))[[0, 2]], atol=5e-5)


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
        state.finish()
        energy, t, dt, impulse = state.latest["energy"].item(), 0.0, 1 / 512, 0.0
        for _ in range(256):
            state.step(t, dt, False)
            t += dt
            impulse += state.latest["impulse_x"].item()
        assert state.latest["momentum_x"].item() == pytest.approx(impulse, rel=1e-11)
        assert state.latest["energy"].item() - energy == pytest.approx(0.25 * t, rel=1e-4)
        assert state.fields(0)[0, 0] == pytest.approx(1e-3 * np.sin(t), rel=1e-15)


@pytest.mark.parametrize(
    ("end", "more", "words"),
    [
        (Wall(-1.0), {}, ["would begin at x = 0 and end at -1"]),
        (Wall(1.0), {"mapping": "rigid"}, ["mapping='rigid'", "'stretched' or None"]),
        (Wall(1.0), {"mapping": "elastic"}, ["mapping is 'elastic'"]),
        (Wall(lambda t: "one"), {}, ["x of the right end", "'one'"]),
        (Wall(1.0, T=lambda t: -1.0), {}, ["T of the right end", "above 0"]),
        (Wall(lambda t: 1 + sqrt(t)), {}, ["x of the right end at t = -"]),
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
