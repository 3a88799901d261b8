"""What a completed step, the error control and the phases make of a state and of time, asked for directly."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from mpi4py import MPI

from fsipetsc.cases import rod
from fsipetsc.options import PETSC_OPTIONS, defaults
from fsipetsc.parallel.completion import RATE
from fsipetsc.stepping import phases
from fsipetsc.stepping.control import ErrorControl
from fsipetsc.stepping.state import State

H, T0 = 0.1, 300.0


def at_rest(**options: float) -> State:
    """The initial state of the rod's case, without gravity."""
    opt = {**defaults(rod), "rod_gravity": 0.0, **options}
    state = State(MPI.COMM_SELF, rod.build(opt), 4, H, "projection", "auto", 16)
    state.set_initial()
    return state


def test_the_rate_is_the_4_norm_of_convection_and_diffusion():
    """Where both are about equal, at a gas's wall, the larger one alone would let a step be a fifth too long."""
    with at_rest() as state:
        gas = state.problem.layers[0].material
        rho, sound = state.layout.local(0, state.solution.getArray(readonly=True))[-1, 0], np.sqrt(gas.gamma * gas.R * T0)
    convection = sound / H
    for share in (0.1, 1.0, 3.0):
        mu = 0.75 * share * convection * rho * H**2 / 2
        with at_rest(fluid_mu=mu) as state:
            diffusion = 2 * (4 / 3 * mu) / rho / H**2
            assert diffusion == pytest.approx(share * convection)
            assert state.results[RATE] == pytest.approx((convection**4 + diffusion**4) ** 0.25, rel=1e-9)


def test_the_error_control_compares_what_interfaces_and_boundaries_have_corrected():
    """A point at one of them that has drifted off says little of the error of a step: both solutions are projected first."""
    with at_rest() as state:
        values = {option.name: option.default for option in PETSC_OPTIONS}
        control = ErrorControl(None, state, 3, {**values, "ts_atol": 1e-6, "ts_rtol": 1e-6})
        state.solution.copy(control._embedded)
        y, embedded = state.solution.getArray(), control._embedded.getArray()
        for layer, point in ((0, -1), (2, 0)):
            state.layout.local(layer, y)[point, 1] += 5.0
        y[:] *= 1.0 + 1e-6 * np.random.default_rng(0).random(y.size)
        drifted = control.norm()
        state.project(y)
        state.project(embedded)
        assert control.norm() == pytest.approx(drifted, rel=1e-6)
        state.layout.local(0, y)[int(state.layout.records[0]["lo"]) + 8, 1] += 50.0
        assert control.norm() > 10 * drifted, "a difference elsewhere counts"
        control.destroy()


def test_a_phase_within_another_one_interrupts_it(monkeypatch):
    """Each second belongs to one phase only, and to the right one, also when an error ends it."""
    now = [100.0]
    monkeypatch.setattr(phases.time, "perf_counter", lambda: now[0])
    log = phases.Phases()

    def spend(seconds: float) -> None:
        now[0] += seconds

    with log(phases.SET_UP):
        spend(1)
    spend(64)
    with pytest.raises(ValueError), log(phases.LOOP):
        spend(2)
        with log(phases.OUTPUT):
            spend(4)
        spend(8)
        with log(phases.OUTPUT):
            spend(16)
            raise ValueError
    assert log.seconds == {phases.SET_UP: 1.0, phases.LOOP: 10.0, phases.OUTPUT: 20.0}
