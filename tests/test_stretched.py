"""Layers in one dimension on blocks: what must be exact is, and the rest has its order."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from conftest import ORDERS

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.boundaries import Open, Wall
from fsipetsc.cases import load_case
from fsipetsc.errors import InputError
from fsipetsc.materials.fluid import Fluid
from fsipetsc.options import defaults
from fsipetsc.problem import FluidLayer, Problem
from fsipetsc.scheme.plan import BAD, SAID_STOP, STOP
from fsipetsc.stepping.solve import build_problem, make_state

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)
SOUND = np.sqrt(1.4)
GAS = Fluid(0.0, 0.0, 1.4, 1.0)


class Case:
    """A problem as a case, with some options."""

    def __init__(self, problem: Problem, **options: object) -> None:
        self.problem = problem
        self.options = {**defaults(load_case("box")), "fsi_cfl": 0.7, **options}

    def build(self, opt):
        return self.problem

    def state(self):
        problem = build_problem(self, self.options, MPI.COMM_SELF)
        return make_state(problem, self.options, MPI.COMM_SELF)


def column(left, right, gas=GAS, speed=lambda X: 0 * X):
    """Gas of density and temperature 1 between two walls, at first 1 apart."""

    def initial(X):
        return [1 + 0 * X, speed(X), 1 + 0 * X]

    layer = FluidLayer("gas", gas, (0.0, 1.0), initial)
    return Problem((layer,), left, right, units="none")


def test_a_step_that_ends_badly_leaves_the_state_before_it():
    """Of steps in one call, which also hand on what a rank says of stopping."""
    problem = column(Wall(0.0), Wall(1.0), speed=lambda X: 0.5 * np.sin(2 * np.pi * X))
    with Case(problem, fsi_order=2, fsi_h=1 / 20).state() as state:
        state.set_initial()
        state.finish()
        start = state.y.array.copy()
        assert state._steps(0.0, 0.5) == (False, 0.0, 0.5) and state.results[BAD] == 1.0
        assert np.array_equal(state.y.array, start)
        state.results[SAID_STOP] = 2.0
        assert state._steps(0.0, 1e-3)[0] and state.results[STOP] == 2.0
        assert state.results[BAD] == 0.0 and not np.array_equal(state.y.array, start)


def test_heat_through_walls():
    """The energy grows by the flux; between two temperatures the straight line stays one, but for
    the error of gradients of 1/T. A wall that starts at once does not cool the gas."""
    gas, dt = Fluid(0.1, 1.0, 1.4, 1.0), 1 / 2048
    warm = Wall(0.0, heat_flux=0.3), Wall(1.0, heat_flux=lambda t: 0.2 * t)
    with Case(column(*warm, gas), fsi_h=1 / 20, ts_max_time=1.0).state() as state:
        state.set_initial()
        state.finish()
        before, t = state.latest["energy"].item(), 0.0
        for _ in range(256):
            state.step(t, dt, False)
            t += dt
        put_in = 0.3 * t + 0.1 * t * t
        assert state.latest["energy"].item() - before == pytest.approx(put_in, rel=1e-12)

    def profile(X):
        return [1 / (1 + 0.5 * X), 0 * X, 1 + 0.5 * X]

    layer = FluidLayer("gas", gas, (0.0, 1.0), profile)
    problem = Problem((layer,), Wall(0.0, T=1.0), Wall(1.0, T=lambda t: 1.5), units="none")
    with Case(problem, fsi_h=1 / 20).state() as state:
        state.set_initial()
        for k in range(512):
            state.step(k * dt, dt, False)
        rho, u, T, *_ = state.fields(0).T
        assert np.abs(u).max() < 2e-5
        expected = profile(np.linspace(0, 1, 21))
        np.testing.assert_allclose([rho, T], [expected[0], expected[2]], atol=5e-5)
    walls = Wall(lambda t: 0.5 * t, velocity=lambda t: 0.5), Wall(1.0)
    with Case(column(*walls, speed=lambda X: 0.1 + 0 * X), fsi_h=1 / 20).state() as state:
        state.set_initial()
        state.finish()
        _, u, T, *_ = state.fields(0).T
        assert (u[0], u[1], u[-1]) == (0.5, 0.1, 0.0)
        np.testing.assert_allclose(T, 1.0, rtol=1e-15)


# ends that let gas through, slower and faster than sound


@pytest.mark.parametrize(
    ("amplitude", "mu", "of_open", "mach"),
    [
        (1e-3, 0.0, 1, 0.0),
        (0.1, 0.0, 1, 0.0),
        (1e-3, 1e-3, 1, 0.0),
        (1e-3, 1e-3, 0, 0.0),
        (1e-3, 2e-3, 1, 0.3),
    ],
)
def test_sound_leaves_on_both_sides(amplitude, mu, of_open, mach):
    """What is left of a pulse, of which one half leaves at each end; viscosity is left by order 0
    of the ends (1.2e-3 here), not by order 1. Gas may flow in on the left, out on the right."""
    u = mach * SOUND

    def pulse(X):
        p = 1 + amplitude * np.exp(-(((X - 0.5) / 0.1) ** 2))
        T = p ** (0.4 / 1.4)
        return [p / T, u + 0 * X, T]

    layer = FluidLayer("gas", Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0), (0.0, 1.0), pulse)
    ends = [Open(x, 1.0, 1.0, u, order=of_open) for x in (0.0, 1.0)]
    problem = Problem((layer,), *ends, units="none")
    with Case(problem, fsi_order=6, fsi_h=1 / 160).state() as state:
        state.set_initial()
        state.finish()
        dt = 0.5 / 160 / SOUND
        for k in range(round(320 / (1 - mach))):  # after that only what is reflected is there
            state.step(k * dt, dt, False)
        left = np.abs(state.fields(0)[:, 2:4] - 1)  # T and p
    assert left.max() < (2e-4 if of_open else 1.5e-3) * amplitude
    assert of_open or left.max() > 5e-4 * amplitude


def linearised(order, mach, mu, n):
    """The rates between two open ends about a uniform flow of density, pressure and temperature 1,
    with respect to what is kept of the state.
    """
    u = mach * SOUND
    gas, ends = Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0), [Open(x, 1.0, 1.0, u) for x in (0.0, 1.0)]
    layer = FluidLayer("gas", gas, (0.0, 1.0), lambda X: [1 + 0 * X, u + 0 * X, 1 + 0 * X])
    problem = Problem((layer,), *ends, units="none")
    with Case(problem, fsi_order=order, fsi_h=1 / n).state() as state:
        state.set_initial()
        state.finish()
        start = state.y.array.copy()
        columns = start.size - state.layout.auxiliary
        rates, f = np.zeros((2, columns, columns)), np.zeros_like(start)
        for j in range(columns):
            for k in range(2):
                start[j] += (1e-6, -2e-6)[k]
                state.right_hand_side(start, f)
                rates[k, :, j] = f[:columns]
            start[j] += 1e-6
    return (rates[0] - rates[1]) / 2e-6


@EVERY_ORDER
@pytest.mark.parametrize("mach", [0.0, 0.1, 0.3, 0.9, 1.5])
def test_no_mode_grows_between_open_ends_of_first_order(order, mach):
    """About a uniform flow; at 3 and 10 the viscosity over c h is far beyond what is resolved. A
    layer of heat beside an end, alpha / a wide, is resolved by 128 cells.
    """
    for n, nu in ((32, 0.01), (32, 0.3), (32, 3.0), (32, 10.0), (128, 3.0)):
        rates = linearised(order, mach, 0.75 * nu * SOUND / n, n)
        growing = np.linalg.eigvals(rates).real.max() / (n * SOUND)
        assert growing < 1e-9, (nu, growing)


@pytest.mark.parametrize(
    ("end", "words"),
    [
        (Wall(lambda t: "one"), "x of the right end"),
        (Wall(1.0, T=lambda t: -1.0), "T of the right end"),
        (Wall(lambda t: 1 + sqrt(t)), "x of the right end at t = -"),
    ],
    ids=["no number", "no temperature", "not before 0"],
)
def test_what_cannot_be_is_said(end, words):
    with pytest.raises(InputError) as found:
        with Case(column(Wall(0.0), end), fsi_h=1 / 20).state() as state:
            state.set_initial()
    assert words in str(found.value)
