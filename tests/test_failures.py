"""Runs that cannot start or go on: exit status, one message that helps, what is left on disk."""

import shutil
import sys
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from helpers import REPOSITORY, assert_readable, files, launch, message, solve, well

import fsipetsc
from fsipetsc.cli import main
from fsipetsc.stepping.notes import help_with
from fsipetsc.stepping.run import Run


def test_a_layer_that_becomes_too_short(tmp_path):
    """With a wall close under the rod there is soon no room for 8 points of the 4/2 operator."""
    line = "rod -fsi_coupling projection -fsi_h 0.025 -rod_wall 0.81 -rod_top 3 -rod_gravity -100"
    words = "'below'", "too short", "t = ", ", step ", "x = ", "needs 8 points"
    message(solve(*line.split(), cwd=tmp_path, ranks=2), 3, *words)
    assert_readable(tmp_path / "rod.h5", "failed", 0.5)


def test_steps_beyond_their_bound_are_noted_at_the_start(tmp_path):
    done = solve("rod", "-fsi_cfl", 4, "-fsi_h", 0.1, "-ts_max_steps", 1, cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.count("note: ") == 1, done.stderr
    assert "note: -fsi_cfl 4 is 4 times the bound on the step at t = 0 s" in done.stdout


def test_a_run_without_steps_ends_as_others_do(tmp_path):
    for words in ("-ts_max_steps 0", "-ts_max_time 0", "-ts_max_time 0 -fsi_check"):
        well(solve("pulse", "-fsi_h", 0.1, *words.split(), cwd=tmp_path))


def test_a_failure_within_a_batch_loses_nothing(tmp_path):
    """Neither steps of the series nor of the summary, as if they had been made one by one."""
    line = "rod -fsi_coupling projection -fsi_h 0.025 -ts_max_time 0.5 -ts_dt 3e-4"
    found, words = [], ["in layer '", "at x = ", ", X = ", "t = ", ", step ", "computed before"]
    for watch in ((), ("-ts_monitor",)):  # which makes batches of one step
        done = solve(*line.split(), *watch, cwd=tmp_path)
        message(done, 3, *words, "; -ts_dt 0.0003 s is ", " times the bound on the step at t = 0")
        assert "steps (-ts_dt), a finer" in done.stderr and "-fsi_coupling cons" in done.stderr
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
    ("gsg", 1, "y", -1e6, "J = -"),
    ("sgs", 2, "T", -1e6, "T = -"),
    ("gsg", 2, "e", 1e308, "T = 6.66667e+303"),
    ("gsg", 0, "place", 2000, "T = -"),  # it takes all heat of the gas beside it
]


@pytest.mark.parametrize(("layers", "number", "field", "rate", "said"), DRIVEN)
def test_what_went_wrong_is_named_and_what_helps(layers, number, field, rate, said, tmp_path):
    """Field, layer, place, time and step, the same on any number of ranks; the result opens."""
    time, texts = 0.0101 if field == "place" else 0.01, []
    line = f"-mad_layers {layers} -mad_layer {number} -mad_rate {rate}"
    words = [CASE, *line.split(), "-mad_field", field, "-mad_time", time, "-fsi_quiet"]
    layer = f"layer '{'gas' if layers[number] == 'g' else 'bar'} {number}'"
    where = layer, " at (x, y) = (", "), (X, Y) = (", ", t = 0.01", ", step 1", "what usually helps"
    for ranks in (1, 3):
        done = solve(*words, "-fsi_output", "mad.h5", cwd=tmp_path, ranks=ranks)
        texts.append(message(done, 3, f"error: {said}", *where))
        with fsipetsc.open_run(tmp_path / "mad.h5") as result:
            assert result.summary["status"] == "failed" and result.summary["steps"] >= 10
    assert texts[0] == texts[1]
    assert "where there are shocks -fsi_dissipation 1 -fsi_shock 1" in texts[0]
    used = {"ts_dt": None, "fsi_coupling": "conservative", "fsi_dissipation": 1, "fsi_shock": 1}
    assert help_with(used).endswith("(-fsi_cfl or -ts_dt), a finer grid (-fsi_h)")


def test_progress_after_a_restart_counts_the_steps_of_the_job():
    """Of which it made 10 in 2 s, a quarter of the run, after another quarter of it."""
    run = {"_speaks": True, "_next_line": 0.0, "_interval": 9.0, "wall_time": 102.0, "bound": ""}
    run |= {"t": 0.5, "s": " s", "steps": 60, "opt": {"ts_max_time": 1.0, "ts_max_steps": 999}}
    Run.say_progress(SimpleNamespace(**run, _job=(0.25, 50, 100.0), line=(said := []).append), 0.1)
    assert said == ["  t = 0.5 of 1 s (50 %), step 60, dt = 0.1 s, 5 steps/s, 4 s left"]


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


def test_a_run_that_cannot_begin_touches_no_file(here):
    case, line = here / "mad.py", ("mad.py", "-mad_layers", "s", "-ts_max_steps", 1)
    case.write_text(CASE.read_text())
    well(solve(*line, cwd=here))
    assert main(["plot", "mad.h5", "-streamlines"]) == 0  # there is no gas
    case.write_text(CASE.read_text().replace("1.0, X, Y", "1.0, X - 0.3 * np.sin(6 * X), Y"))
    before = files(here)
    message(solve(*line, cwd=here), 2, "the run cannot begin: J = -")
    assert files(here) == before
    with h5py.File("mad.h5", "r+") as file:  # as of a run that was killed at its start
        del file["layer0"], file["time"]
        file["time"] = np.zeros(0)
    assert all(main([word, "mad.h5"]) == 0 for word in ("info", "report", "plot"))


TABLE = """
from pathlib import Path
from fsipetsc import Fluid, FluidLayer, Problem, Wall

NAME, OPTIONS, DEFAULTS = "table", (), {"fsi_h": 0.05, "ts_max_time": 1.0}


def heated(t):
    if Path("ended").exists() and t > 0.0:
        raise ValueError("the table ends")
    return 300.0 + t

def build(opt):
    air = Fluid(1.8e-5, 0.026, 1.4, 287.0)
    at_rest = lambda X: (1.2 + 0.0 * X, 0.0 * X, 300.0 + 0.0 * X)
    return Problem((FluidLayer("air", air, (0.0, 1.0), at_rest),), Wall(0.0, T=heated), Wall(1.0))
"""


def test_a_restart_whose_data_fail(tmp_path):
    (tmp_path / "table.py").write_text(TABLE)
    line = "table.py", "-fsi_checkpoint_steps", 3, "-fsi_quiet", "-ts_max_steps"
    well(solve(*line, 6, cwd=tmp_path))
    (tmp_path / "ended").touch()
    shutil.copy(tmp_path / "table.h5", tmp_path / "other.h5")
    for more in ((), ("-fsi_output", "other.h5", "-fsi_checkpoint", "new.h5")):
        before = files(tmp_path)
        restart = "-fsi_restart", "table.checkpoint.h5", *more
        done = solve(*line, 9, *restart, cwd=tmp_path)
        message(done, 2, "table.py, line 10", "ValueError: the table ends")
        assert files(tmp_path) == before


@pytest.mark.parametrize("into", [">/dev/full", "| head -n 0; exit ${PIPESTATUS[0]}"])
def test_a_run_goes_on_where_nothing_can_be_printed(into, tmp_path):
    """It prints far more than what one who leaves after a line has read, in many writes."""
    line = f"{sys.executable} -m fsipetsc rod -fsi_h 0.1 -ts_max_steps 300 -ts_monitor {into}"
    well(launch(["bash", "-c", line], tmp_path))
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["steps"] == 300


def test_a_rod_that_is_crushed(tmp_path):
    """By a shock of ten times its modulus: it fails, not the gas, which has NaN afterwards."""
    line = "shock -shock_problem strong -shock_mach 7 -fsi_order 2 -fsi_h 0.1 -fsi_quiet"
    said = message(solve(*line.split(), cwd=tmp_path, ranks=2), 3, "error: J = -")
    assert " in layer 'rod' at x = 1.1" in said and ", X = 1, t = 0.02" in said
    assert "nan" not in said


PRESSED = """
import numpy as np
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = ()
DEFAULTS = {"fsi_h": 0.1, "fsi_order": 2, "ts_max_time": 0.3, "fsi_output_dt": 0.05}

def build(opt):
    bar = ElasticSolid(1.0, 1.0, 0.0, 1.0, 1.0, law="svk")
    pressed = Layer("bar", bar, (0.0, 2.0), lambda X: (-1.5 * np.tanh(4.0 * (X - 1.0)), 1.0, X))
    both = {"lower": Clamped(), "upper": Clamped()}
    return layers(pressed, along=(), h=opt["fsi_h"], order=opt["fsi_order"], units="none", **both)
"""


def test_one_note_says_that_waves_are_imaginary_and_the_failure_names_them(tmp_path):
    (tmp_path / "pressed.py").write_text(PRESSED)
    done = [solve("pressed.py", cwd=tmp_path, ranks=ranks) for ranks in (1, 2)]
    for one in done:
        notes = [line for line in one.stdout.splitlines() if line.startswith("note: ")]
        assert len(notes) == 1 and notes[0].startswith("note: waves have become imaginary in 'bar'")
        assert ", t = 0.1, where the stretch along them is 0.4" in notes[0]
    first, second = (message(one, 3, "error: J = -", "waves have become imaginary") for one in done)
    assert first.split("; what")[0] == second.split("; what")[0] and "fsi_cfl" not in first
