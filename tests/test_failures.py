"""Runs that cannot start or go on: exit status, one message that helps, what is left on disk."""

import sys

import pytest
from helpers import REPOSITORY, assert_readable, launch, message, solve, well

import fsipetsc


def test_what_can_hardly_be_meant_is_questioned_at_the_start(tmp_path):
    line = "rod -fsi_cfl 4 -fsi_h 0.1 -ts_max_steps 1"
    done = solve(*line.split(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("note: ") == 1
    assert "note: -fsi_cfl 4 is 4 times the bound on the step at t = 0 s" in done.stdout


def test_a_layer_that_becomes_too_short(tmp_path):
    """With a wall close under the rod there is soon no room for 16 points of the 8/4 operator."""
    line = (
        "rod -fsi_coupling projection -fsi_h 0.0125 -fsi_order 8 -rod_wall 0.81 -rod_top 3".split()
    )
    words = "'below'", "too short", "t = ", ", step ", "x = ", "needs 16 points"
    message(solve(*line, cwd=tmp_path, ranks=2), 3, *words)
    assert_readable(tmp_path / "rod.h5", "failed", 0.5)


def test_a_failure_within_a_batch_loses_nothing(tmp_path):
    """Neither steps of the series nor of the summary, as if they had been made one by one."""
    line = "rod -fsi_coupling projection -fsi_h 0.025 -ts_max_time 0.5 -ts_dt 3e-4"
    found, words = [], ["in layer '", "at x = ", "(X = ", "t = ", ", step ", "computed before"]
    for watch in ((), ("-ts_monitor",)):  # which makes batches of one step
        done = solve(*line.split(), *watch, cwd=tmp_path)
        message(done, 3, *words, "shorter steps (-fsi_cfl or -ts_dt)")
        assert_readable(tmp_path / "rod.h5", "failed", 0.5)
        with fsipetsc.open_run(tmp_path / "rod.h5") as result:
            series = [result.series[name].tolist() for name in ("t", "dt", "x_interface", "mass")]
            names = "steps", "rhs_evaluations", "message"
            found.append((series, [result.summary[name] for name in names]))
    assert len(found[0][0][0]) > 2 and found[0] == found[1]
    seen = [int(line.split()[0]) for line in done.stdout.splitlines() if " TS dt " in line]
    assert seen == list(range(found[1][1][0] + 1)), "a line for each step, and for the start"


CASE = REPOSITORY / "tests" / "going_wrong.py"
#: layers, number of the driven one, its unknown, its rate, words of the message
DRIVEN = [
    ("gsg", 0, "e", -1e6, "T = -"),
    ("gsg", 1, "y", -1e6, "J = -"),
    ("sgs", 2, "T", -1e6, "T = -"),
    ("gsg", 2, "e", 1e308, "T = 6.66667e+303, too large to go on with,"),
    ("gsg", 0, "place", 2000, "T = -"),  # it takes all heat of the gas beside it
]


@pytest.mark.parametrize(("layers", "number", "field", "rate", "said"), DRIVEN)
def test_what_went_wrong_is_named_and_what_helps(layers, number, field, rate, said, tmp_path):
    """Field, layer, place, time and step, the same on any number of ranks; the result opens."""
    time, texts = 0.0101 if field == "place" else 0.01, []
    line = f"-mad_layers {layers} -mad_layer {number} -mad_rate {rate}"
    words = [CASE, *line.split(), "-mad_field", field, "-mad_time", time, "-fsi_quiet"]
    layer = f"layer '{'gas' if layers[number] == 'g' else 'bar'} {number}'"
    where = layer, " at x = ", ", t = 0.01", ", step 1", "what usually helps: "
    for ranks in (2, 3):
        done = solve(*words, "-fsi_output", "mad.h5", cwd=tmp_path, ranks=ranks)
        texts.append(message(done, 3, f"error: {said}", *where))
        with fsipetsc.open_run(tmp_path / "mad.h5") as result:
            assert result.summary["status"] == "failed" and result.summary["steps"] >= 10
    assert texts[0] == texts[1]


@pytest.mark.parametrize("name", ["edge", "initial", "forcing", "jumps"])
def test_an_error_of_a_function_ends_all_with_its_place(name, tmp_path):
    """On all ranks, or on one alone: the initial data of the last one."""
    rank, layers = 2 if name == "initial" else -1, "sg" if name == "edge" else "gsg"
    line = f"-mad_function {name} -mad_rank {rank} -mad_time 0.0105 -mad_layers {layers}"
    more = "-ts_max_steps", 20, "-fsi_output", "mad.h5"
    done = solve(CASE, *line.split(), *more, "-fsi_quiet", cwd=tmp_path, ranks=3)
    message(done, 2, "going_wrong.py, line ", "ValueError: nothing is known")
    if name != "initial":
        with fsipetsc.open_run(tmp_path / "mad.h5") as result:
            steps = result.summary["steps"]
            assert result.summary["status"] == "failed"
            assert result.series["t"].size == steps, "no step that was good is lost"
            assert steps >= 10, "no function is asked for times that are still to come"


PROGRAM = f"{sys.executable} -m fsipetsc"
#: prints far more than what one who leaves after a line has read, in many writes
COMPUTES = f"{PROGRAM} rod -fsi_h 0.1 -ts_max_steps 300 -ts_monitor"


@pytest.mark.parametrize("into", [">/dev/full", "| head -n 0; exit ${PIPESTATUS[0]}"])
def test_a_run_goes_on_where_nothing_can_be_printed(into, tmp_path):
    done = launch(["bash", "-c", f"{COMPUTES} {into}"], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["steps"] == 300


# notes on initial data that may not be meant, and on what the grid does not resolve


#: the piston with one thing changed
CHANGED = """
from dataclasses import replace
import numpy as np
from fsipetsc import Option
from fsipetsc.cases import load_case

piston = load_case("piston")
OPTIONS = (*piston.OPTIONS, Option("changed", str, "", "", "what is changed"))
DEFAULTS = piston.DEFAULTS

def build(opt):
    problem, T, p = piston.build(opt), 300.0, 1e5
    below, layer, above = problem.layers
    if opt["changed"] == "jump":
        jump = lambda X: (np.where(X < 0.5, 2.0, 1.0) * p / 287.0 / T, 0.0 * X, T + 0.0 * X)
        below = replace(below, initial=jump)
    if opt["changed"] == "apart":
        layer = replace(layer, initial=lambda X: (0.0 * X, -p + 0.0 * X, T + 0.0 * X, X + 0.02))
    if opt["changed"] == "sign":
        layer = replace(layer, initial=lambda X: (0.0 * X, 0.0 * X + p, 0.0 * X + T, X))
    return replace(problem, layers=(below, layer, above))
"""
SIGN = "has a pressure of 1e+05 Pa where it meets 'layer', which pushes with -1e+05 Pa "
OTHER = "volume and mass than its map gives it: the first state of a solid beside it is not where"
#: what is changed -> what the notes say, with … for what stands between
NOTES = {
    "nothing": [],
    "sign": [f"at t = 0 'driven' {SIGN}", f"at t = 0 'behind' {SIGN}"],
    "apart": [f"'driven' begins with … % more {OTHER}", f"'behind' begins with … % less {OTHER}"],
    "jump": ["at the end the pressure in 'driven' changes by … one node to the next, at X = 0."],
}


@pytest.mark.parametrize("changed", NOTES)
def test_what_may_not_be_meant_is_said(changed, tmp_path):
    (tmp_path / "changed.py").write_text(CHANGED)
    line = "changed.py", "-changed", changed, "-ts_max_steps", 1
    done = well(solve(*line, cwd=tmp_path, ranks=2))
    found = [line for line in done.stdout.splitlines() if line.startswith("note: ")]
    assert len(found) == len(NOTES[changed]), found
    for line, note in zip(found, NOTES[changed], strict=True):
        assert all(word in line for word in note.split("…")), line
