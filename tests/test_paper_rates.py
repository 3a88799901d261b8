"""The paper's method, fsipetsc.paper: rates, projections, integrals and bounds at random states, as
they were when two programs, written apart, agreed on them to 1e-12; the file was frozen anew since,
without a difference.

`python tests/test_paper_rates.py` freezes them anew, which is for a change of the method alone."""

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from fsipetsc.boundaries import Dirichlet, Open, absorbing, clamped, free
from fsipetsc.cases import load_case
from fsipetsc.options import defaults
from fsipetsc.paper.paper_state import PaperState
from fsipetsc.scheme.plan import DT, RATE, TIME

FROZEN = Path(__file__).with_name("paper_rates.json")
ENDS = {
    "clamped": (clamped(0.3, T=310.0), None),
    "free": (free(-9e4, heat_flux=1e3), None),
    "absorbing": (absorbing(-9e4), None),
    "open": (None, Open(1.5, 1e5, 300.0, 0.0)),
    "open0": (None, Open(1.5, 1e5, 300.0, 5.0, order=0)),
    "inflow": (None, Dirichlet(1.5, lambda t: (1.2, -30.0, 305.0))),
    "outflow": (None, Dirichlet(1.5, lambda t: (1.1, 20.0, 295.0))),
    "supersonic": (None, Dirichlet(1.5, lambda t: (1.2, -500.0, 300.0))),
}
object.__setattr__(ENDS["inflow"][1], "degree", 3)  # less than its order asks for
_VISCOUS = {"fluid_mu": 0.5, "fluid_kappa": 0.7, "solid_kappa": 0.5}


def state_of(name, ends=None, **changed):
    """A state of a case, with other ends."""
    case = load_case(name)
    opt = {**defaults(case), "fsi_h": 0.05, **changed}
    problem = case.build(opt)
    left, right = ENDS.get(ends, (None, None))
    problem = replace(problem, left=left or problem.left, right=right or problem.right)
    return PaperState(MPI.COMM_SELF, problem, opt, print)


def runs():
    """name -> what is asked of ``state_of``."""
    found = {}
    for c, coupling in enumerate(("projection", "energy", "traditional")):
        for name, k in product(("rod", "mms"), range(4)):
            if (k // 2 + c + (name == "mms")) % 2:
                continue
            order, viscous = 2 * k + 2, ("wide", "narrow")[(k + (name == "mms")) % 2]
            asked = {"fsi_order": order, "fsi_coupling": coupling, "fsi_viscous": viscous}
            found[f"{name} {coupling} {order} {viscous}"] = {"name": name, **asked}
        for heat in ("both", "none", "gas", "solid")[: 4 if coupling == "projection" else 2]:
            numbers = {
                "fluid_kappa": 0.7 * (heat in ("both", "gas")),
                "solid_kappa": 0.5 * (heat in ("both", "solid")),
                "solid_gruneisen": 0.3,
            }
            asked = {"name": "pulse", **_VISCOUS, **numbers, "fsi_coupling": coupling}
            found[f"heat in {heat} {coupling}"] = asked
    for k, end in enumerate(ENDS):
        asked = {"name": "pulse", "ends": end, **_VISCOUS, "fsi_order": (6, 2, 8)[k % 3]}
        found[end] = {**asked, "solid_gruneisen": 0.2 * (k < 3)}
    found["open, inviscid"] = {"name": "pulse", "ends": "open", "pulse_amplitude": 100.0}
    return found


RUNS = runs()


def disturbed(state):
    """A state of random numbers about the first one."""
    state.set_initial()
    rng, y = np.random.default_rng(1), state.solution.getArray().copy()
    for k, layer in enumerate(state.problem.layers):
        part = state.layers[k].of(y).T[state.layers[k].mine]
        size = np.abs(part).max(axis=0)
        if layer.kind == "fluid":
            sound = layer.material.sound_speed(part[0, 2] / part[0, 0] / layer.material.cv)
            size[1] = part[:, 0].max() * float(sound)
        else:
            size[0], size[3] = layer.material.sound_speed(), 0.1 * state.h
        part += 0.02 * size * rng.uniform(-1, 1, part.shape)
    return y


def measured(state):
    """Numbers of a state: pairs of a number and the size that its error is compared with."""
    with state:
        stage = disturbed(state)
        state.set_data(0.01)
        kept, rates = stage.copy(), np.full_like(stage, np.nan)
        state.right_hand_side(stage, rates)
        assert np.array_equal(stage, kept), "the stage is PETSc's"
        state.solution.getArray()[:] = stage
        state.finish()
        columns = [
            column
            for layer in state.layers
            for y in (rates, state.solution.getArray())
            for column in layer.of(y)[:, layer.mine]
        ]
        columns += [np.array([v]) for v in (state.results[RATE], state.latest["energy"])]
        means = [float(np.mean(np.cos(0.7 * np.arange(len(c))) * c)) for c in columns]
        return [[m, float(np.abs(c).max())] for m, c in zip(means, columns, strict=True)]


def test_rates_are_the_frozen_ones():
    frozen = json.loads(FROZEN.read_text())
    assert frozen.keys() == RUNS.keys()
    for name, asked in RUNS.items():
        state = state_of(**asked)
        assert not state.asked, "data that depend on time are recorded"
        found, expected = np.array(measured(state)), np.array(frozen[name])
        assert found.shape == expected.shape and (expected[:, 1] > 0).sum() > 15
        assert (np.abs(found - expected)[:, 0] <= 2e-11 * expected[:, 1]).all(), name


@pytest.mark.parametrize("name", ["rod energy 8 narrow", "mms projection 6 narrow", "open"])
def test_rates_and_steps_do_not_depend_on_what_memory_had(name):
    found = []
    for had in (0.0, np.nan):
        with state_of(**RUNS[name]) as state:
            stage = disturbed(state)
            state.set_data(0.01)
            for layer in state.layers:
                layer.scratch[:] = had
            found.append(np.full_like(stage, np.nan))
            state.right_hand_side(stage, found[-1])
            state.solution.getArray()[:] = stage
            state.finish()
            state.batch[[TIME, DT]] = 0.01, 1e-7
            state.step()
            found[-1] = np.append(found[-1], state.y)
    assert np.isfinite(found[0]).all() and np.array_equal(*found)


@pytest.mark.parametrize(
    ("coupling", "heat"), [name[8:].split(" ")[::-1] for name in RUNS if name.startswith("heat")]
)
def test_the_conditions_hold_to_round_off_and_a_second_time_changes_nothing(coupling, heat):
    with state_of(**RUNS[f"heat in {heat} {coupling}"]) as state:
        y = state.solution.getArray()
        y[:] = disturbed(state)
        state.finish()
        found = [abs(state.latest[f"residual_{name}"][0]) for name in ("u", "stress", "T", "flux")]
        off = np.array(found) / [347.0, 1e5, 300.0, 0.7 * 300.0 / state.h]
        kept = [True, True, heat == "both", heat != "none"]
        assert (off[kept] < 1e-14).all() and kept[2] == (off[2] < 1e-4)
        once = y.copy()
        state.finish()
        np.testing.assert_allclose(y, once, rtol=1e-12, atol=1e-11)


if __name__ == "__main__":
    lines = [f"{json.dumps(name)}: {json.dumps(measured(state_of(**RUNS[name])))}" for name in RUNS]
    FROZEN.write_text("{\n" + ",\n".join(lines) + "\n}\n")
