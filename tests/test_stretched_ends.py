"""Gas alone between ends that let it through, on a grid between them: Open and Dirichlet, slower and faster than sound."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS

pytest.importorskip("petsc4py")

from test_stretched import Case

from fsipetsc.boundaries import Dirichlet, Open
from fsipetsc.materials.fluid import Fluid
from fsipetsc.problem import FluidLayer, Problem

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)
SOUND = np.sqrt(1.4)


def carried(mach: float, right) -> Problem:
    """A wave of density that a flow of pressure 1 carries through the gas, from data on the left."""
    speed = mach * SOUND

    def exact(X, t):
        rho = 1 + 0.3 * np.sin(5 * (X - speed * t))
        return [rho, speed + 0 * X, 1 / rho]

    def data(X):
        return Dirichlet(X, lambda t: [float(v) for v in exact(np.array(X), t)])

    layer = FluidLayer("gas", Fluid(0.0, 0.0, 1.4, 1.0), (0.0, 1.0), lambda X: exact(X, 0.0), exact=exact)
    ends = {"open": Open(1.0, 1.0, 1.0, u0=speed), "data": data(1.0)}
    return Problem((layer,), data(0.0), ends[right], units="none")


@EVERY_ORDER
@pytest.mark.parametrize(("mach", "right"), [(0.4, "open"), (0.4, "data"), (1.5, "open"), (1.5, "data")])
def test_a_wave_is_carried_through(order, mach, right):
    runs = [Case(carried(mach, right), fsi_order=order, fsi_h=h, ts_max_time=1.0).run() for h in (1 / 32, 1 / 64)]
    coarse, fine = (run.errors["fluid"]["combined"] for run in runs)
    assert np.log2(coarse / fine) > {2: 1.8, 4: 2.8, 6: 3.6, 8: 3.6}[order], (coarse, fine)
    assert fine < {2: 1e-2, 4: 1e-3, 6: 1e-4, 8: 1e-4}[order]


@pytest.mark.parametrize(("amplitude", "mu"), [(1e-3, 0.0), (0.1, 0.0), (1e-3, 1e-3)])
def test_sound_leaves_on_both_sides(amplitude, mu):
    """What is left of a pulse, of which one half leaves at each end; viscosity counts at first order (1.2e-3 here)."""

    def pulse(X):
        p = 1 + amplitude * np.exp(-(((X - 0.5) / 0.1) ** 2))
        T = p ** (0.4 / 1.4)
        return [p / T, 0 * X, T]

    layer = FluidLayer("gas", Fluid(mu, mu * 3.5 / 0.72, 1.4, 1.0), (0.0, 1.0), pulse)
    case = Case(Problem((layer,), Open(0.0, 1.0, 1.0), Open(1.0, 1.0, 1.0), units="none"), fsi_order=6, fsi_h=1 / 160)
    with case.state() as state:
        state.set_initial()
        state.finish()
        dt = 0.5 / 160 / SOUND
        for k in range(320):  # for 1 / SOUND, after which nothing of it is there but what is reflected
            state.step(k * dt, dt, False)
        left = np.abs(state.fields(0)[:, 3] - 1)
    assert left.max() < (1.5e-3 if mu else 2e-4) * amplitude
