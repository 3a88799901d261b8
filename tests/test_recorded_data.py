"""Data that depend on time: recorded where they can be, else Python is asked."""

import re
from itertools import pairwise

import numpy as np
import pytest
import timed
from block_ledgers import check_motion, complete
from helpers import REPOSITORY, assert_same_fields, computed, different, message, solve
from mpi4py import MPI

import fsipetsc
from fsipetsc import Fluid, FluidLayer, InputError, Problem, Wall
from fsipetsc.kernels.symbols import Record, derivatives, replay
from fsipetsc.problem import blocks_of_line
from fsipetsc.scheme.face_terms import Faces
from fsipetsc.stepping.block_state import BlockState
from fsipetsc.stepping.notes import BEGIN, Moment, notes

CASE = str(REPOSITORY / "tests" / "timed.py")
USUAL = {option.name: option.default for option in timed.OPTIONS} | timed.DEFAULTS


def state_of(problem):
    return BlockState(MPI.COMM_SELF, problem, {"fsi_order": 2})


def at_wall(x, velocity=None, T=None):
    """Of a gas with a wall that moves, in one dimension."""
    layer = FluidLayer("gas", Fluid(0.01, 0.01, 1.4, 1.0), (0.0, 1.0), lambda X: (1.0, 0.0, 1.0))
    return blocks_of_line(Problem((layer,), Wall(x, T, velocity=velocity), Wall(1.0)), 0.1, 2)


def data_of(state):
    parts = state.parts.values()
    faces = [term for part in parts for term in part.terms if isinstance(term, Faces)]
    records = [vars(of).values() for of in faces]
    faces = [of for record in records for of in record if isinstance(of, np.ndarray)]
    forcing = [part.forcing for part in parts if part.forcing is not None]
    prescribed = state.system.prescribed
    return [*prescribed.data, *faces, *forcing]


def asked_and_recorded(state, t):
    """The data at time t as Python has them, and as they are recorded."""
    assert not state.asked, state.not_recorded
    state.set_initial()
    complete(state, t, state.y)
    recorded = [array.copy() for array in data_of(state)]
    state.system.prescribed.refresh(t)
    for part in state.parts.values():
        part.refresh(t)
    return [array.copy() for array in data_of(state)], recorded


@pytest.mark.parametrize("t", [0.0, 0.3, 1.7])
@pytest.mark.parametrize("kind", ["wall", "ends", "open"])
def test_recorded_data_are_those_of_python(kind, t):
    """But for derivatives of motions that are not given, to a few times round-off."""
    state = state_of(timed.build(USUAL | {"timed_kind": kind}))
    asked, recorded = asked_and_recorded(state, t)
    data = state.system.prescribed.data
    rates = {data._fields.index(name) for name in ("wall", "wall_rate", "clamp_rate")}
    changed = 0
    for number, (one, other) in enumerate(zip(asked, recorded, strict=True)):
        rtol = 1e-3 if number in rates else 1e-15
        size = np.abs(one).max(initial=1.0)  # places are about 1
        np.testing.assert_allclose(other, one, rtol=rtol, atol=rtol * size)
        changed += bool(np.abs(one).max(initial=0.0) > 0.0)
    assert changed > 2


@pytest.mark.parametrize("t", [0.0, 1e-3, 0.4, 2.0])
def test_velocity_and_acceleration_of_a_wall_are_exact_derivatives(t):
    a, w = 0.1, 7.0
    x, v = (lambda t: a * np.sin(w * t)), (lambda t: a * w * np.cos(w * t))
    for velocity in (None, v):
        state = state_of(at_wall(x, velocity, lambda t: 1.0 + 0.1 * t))
        _, _ = asked_and_recorded(state, t)
        complete(state, t, state.y)
        prescribed = state.system.prescribed
        (p,) = np.flatnonzero(state.system.record.facts.moves)
        found = (array[p, 0] for array in prescribed.data[:3])
        wanted = x(t), v(t), -w * w * x(t)
        np.testing.assert_allclose(list(found), wanted, rtol=1e-15, atol=2e-16)
        np.testing.assert_allclose(prescribed.data.T[p], 1.0 + 0.1 * t, rtol=1e-15)


# what cannot be recorded

NOT_RECORDED = {
    "if": (lambda t: 0.1 * t if t > 0.0 else 0.0, "it branches on a value"),
    "float": (lambda t: 0.1 * float(t), "take numpy's functions"),
    "table": (lambda t: np.interp(t, [0.0, 1.0], [0.0, 0.1]), "np.interp cannot be recorded"),
}


@pytest.mark.parametrize("name", NOT_RECORDED)
def test_python_is_asked_for_other_functions(name):
    """The wall goes where it should, and a note says why they are asked for."""
    x, why = NOT_RECORDED[name]
    state = state_of(at_wall(x, T=lambda t: 1.0))
    assert state.asked and why in state.not_recorded[0]
    state.set_initial()
    state.finish()
    said = notes(BEGIN, Moment(state, {"ts_dt": 1.0, "fsi_cfl": 1.0}, 0.0, set()))[0]
    assert "in each stage" in said and why in said
    complete(state, 0.3, state.y)
    found = state.system.record
    assert found.data.place[found.facts.moves == 1, 0] == x(0.3)


# runs


@pytest.mark.parametrize(
    "line", ["-timed_kind wall", "-timed_kind lid", "-timed_kind open", "-timed_how table"]
)
def test_batches_ranks_and_restarts_do_not_change_bits(line, tmp_path):
    """Steps in one call of C, those that are calls of their own, and stages that are."""
    words = CASE, *line.split(), "-ts_dt", 2e-3
    whole = computed(tmp_path, "whole.h5", *words)
    for more in (("-ts_monitor", "ascii:a.txt"), ("-fsi_probes", "0.5,0.5")):
        other = computed(tmp_path, "other.h5", *words, *more)
        assert_same_fields(whole, other)
        assert np.array_equal(whole.series["energy"], other.series["energy"])
    computed(tmp_path, "three.h5", *words, ranks=3)
    assert different(whole.path, tmp_path / "three.h5", same_ranks=False) == []
    computed(tmp_path, "cut.h5", *words, "-ts_max_steps", 17, "-fsi_checkpoint_steps", 17)
    restart = "-fsi_restart", "cut.checkpoint.h5", "-ts_max_steps", 1000000
    computed(tmp_path, "cut.h5", CASE, *restart)
    assert different(whole.path, tmp_path / "cut.h5", same_ranks=True) == []


@pytest.mark.parametrize(
    ("kind", "said"), [("wall", "T = nan at (X, Y) = "), ("open", "expected a number above 0")]
)
def test_bad_data_end_the_run_with_what_is_bad(kind, said, tmp_path):
    """As where Python is asked: file, line, which datum, when."""
    words = "-timed_kind", kind, "-timed_how", "bad", "-ts_dt", 2e-3
    done = solve(CASE, *words, "-fsi_output", "run.h5", cwd=tmp_path, ranks=2)
    error = message(done, 2, "timed.py, line ", said)
    assert re.search(r"at t = 0\.02\d*", error)
    with fsipetsc.open_run(tmp_path / "run.h5") as run:
        assert 9 <= len(run.series["t"]) <= 11
        assert all(a < b for a, b in pairwise(run.series["t"]))


def test_second_derivatives_are_right_where_numbers_rest():
    """Also at t = 0, where t² rests; what is constant there has none, though a root is steep."""
    t = (record := Record()).given("t")
    for f, at, right in (
        (lambda t: t * t / (1 + t * t), 0.0, 2.0),
        (lambda t: np.sqrt(1 + t * t) + np.log1p(t * t) + np.cos(t) ** 0.3, 0.0, 2.7),
        (lambda t: np.sqrt(np.maximum(t, 0.0)) / np.maximum(t, 0.0), -1.0, 0.0),
    ):
        (second,) = derivatives(derivatives((f(t),), t, still=True), t, still=True)
        assert replay([record.constant(second)])({t: at})[0] == pytest.approx(right, rel=1e-14)


#: place and velocity of walls that are as they should be
RIGHT = {
    "swings": (lambda t: 0.1 * np.sin(7 * t), lambda t: 0.7 * np.cos(7 * t)),
    "kink": (lambda t: np.maximum(0.0, t - 0.3), lambda t: np.where(t > 0.3, 1.0, 0.0)),
    "far": (lambda t: 1e3 + 1e-3 * t, lambda t: 1e-3),
    "rest": (lambda t: 0.2, lambda t: 0.0),
    "unrecorded": (lambda t: max(0.0, t - 0.3), lambda t: float(t > 0.3)),
}


@pytest.mark.parametrize("name", RIGHT)
def test_the_velocity_of_a_wall_is_the_derivative_of_its_place(name):
    x, v = RIGHT[name]
    check_motion(at_wall(x, v), 1 / 256)
    if name != "rest":
        for wrong in (lambda t: 1.05 * v(t), lambda t: v(t) * (1.0 if t < 0.7 else 2.0)):
            with pytest.raises(InputError, match=r"line \d+: velocity of NoSlip at t = .*x alone"):
                check_motion(at_wall(x, wrong), 1 / 256)
