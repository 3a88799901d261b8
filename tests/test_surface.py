"""What a run shows: progress on a terminal and in a log, what bounds the steps, -fsi_view, a summary that fits on a screen."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import PATIENCE, environment, solve

import fsipetsc

pytest.importorskip("petsc4py")


def on_a_terminal(*words, cwd, env=None):
    """Everything that the program writes to a terminal of 100 columns, and its exit status."""
    ours, its = pty.openpty()
    command = [sys.executable, "-m", "fsipetsc", *map(str, words)]
    alone = {"OMPI_MCA_ess_singleton_isolated": "1", "COLUMNS": "100", **(env or {})}
    process = subprocess.Popen(command, cwd=cwd, env=environment(alone), stdin=its, stdout=its, stderr=its)
    os.close(its)
    said, until = b"", time.monotonic() + PATIENCE
    while time.monotonic() < until:
        ready, _, _ = select.select([ours], [], [], 1.0)
        try:
            piece = os.read(ours, 65536) if ready else b""
        except OSError:  # the other side is closed
            break
        said += piece
        if ready and not piece:
            break
    os.close(ours)
    return said.decode(), process.wait(timeout=PATIENCE)


def as_seen(said):
    """The lines that stand on the terminal in the end."""
    lines = []
    for line in said.replace("\r\n", "\n").split("\n"):
        row = ""
        for piece in line.replace("\x1b[A", "").split("\r"):
            row = piece + row[len(piece) :]
        lines.append(row.rstrip())
    return lines


def test_a_bar_on_a_terminal_that_leaves_nothing_behind(tmp_path):
    pytest.importorskip("tqdm")
    said, status = on_a_terminal("rod", "-fsi_h", 0.025, "-ts_max_time", 4, cwd=tmp_path)
    assert status == 0
    shown = re.findall(r"\rt (\S+)/4 s \|([^|]*)\| *(\d+) %, ([^,]+) left, step (\d+) \(\S+/s\), dt \S+ s", said)
    assert shown, said
    times, parts, steps = ([float(row[k]) for row in shown] for k in (0, 2, 4))
    assert times == sorted(times) and steps == sorted(steps)
    assert np.allclose(parts, 25 * np.array(times), atol=0.7) and all(len(row[1]) == 10 for row in shown)
    assert re.search(r"dt \S+ s: (sound|waves|friction and conduction|conduction) in (below|rod|above)", said)
    lines = as_seen(said)
    assert not any("left, step" in line for line in lines), lines
    assert any(line.startswith("done at t = 4 s: ") for line in lines)
    assert len([line for line in lines if line]) <= 24 and max(map(len, lines)) <= 100 + len(str(tmp_path))


def test_nothing_on_a_terminal_that_is_to_be_quiet(tmp_path):
    said, status = on_a_terminal("box", "-fsi_h", 0.1, "-fsi_order", 2, "-fsi_quiet", cwd=tmp_path)
    assert (said, status) == ("", 0)


def test_lines_where_there_is_no_terminal(tmp_path, monkeypatch, capsys):
    """No sooner than after some seconds, ever rarer, without anything that only terminals understand."""
    from fsipetsc.stepping import progress

    clock = iter(np.arange(0.0, 1e4, 0.5))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    for asked, first in ((False, 10.0), (True, 2.0)):
        shown = progress.Progress(10.0, " s", asked)
        shown.start(2.0, 1000)  # as after a restart: what is left is reckoned from here
        begun, lines = 1000, []
        for step in range(1000, 40_000):
            shown.step(step, 2.0 + 8.0 * (step - begun) / 39_000, 1e-3, lambda: "sound in gas")
            said = capsys.readouterr().out
            lines += [(step, said)] if said else []
        assert all(said.count("\n") == 1 and "\r" not in said and "\x1b" not in said for _, said in lines)
        # the clock goes 0.5 s at each look: one look in 32 steps
        seconds = np.array([(step - begun) / 64 for step, _ in lines])
        assert abs(seconds[0] - first) <= 1.0 and np.all(np.diff(seconds) <= 61.0) and np.diff(seconds)[-1] > 2.0 * first
        t, left = (float(re.search(rf"{what}", lines[-1][1])[1]) for what in (r"t = (\S+) of", r"(\d+(?:\.\d+)?) s left"))
        assert left == pytest.approx(seconds[-1] * (10.0 - t) / (t - 2.0), rel=0.1, abs=1.5)
        assert "dt = 0.001 s by sound in gas" in lines[0][1]


@pytest.mark.parametrize(
    ("most", "wall", "part", "left"),
    [
        (2**31 - 1, np.inf, 25, "3 min 0 s left"),
        (1100, np.inf, 50, "1 min 0 s left to -ts_max_steps"),
        (1100, 80.0, 75, "20 s left to -fsi_wall_limit"),
        (1100, 600.0, 50, "1 min 0 s left to -ts_max_steps"),
    ],
)
def test_what_is_left_is_left_to_the_nearest_end(monkeypatch, capsys, most, wall, part, left):
    """And as that, the part that is done counts from where this run began: here a checkpoint at t = 2, after 1000 steps."""
    from fsipetsc.stepping import progress, report

    now = [500.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(report, "reason", lambda state, opt, dt: "")
    opt = {"fsi_quiet": False, "fsi_progress": True, "ts_max_time": 10.0, "ts_max_steps": most}
    shown = report.Reporter(SimpleNamespace(rank=0, size=1), "rod", opt)
    shown.start(2.0, 1000, 500.0 + wall)
    now[0] += 60.0
    shown.step(1050, 4.0, 1e-3)
    said = capsys.readouterr().out
    assert f"t = 4 of 10 s ({part} %), step 1050" in said and said.endswith(f", {left}\n"), said


def test_when_the_wall_time_is_used_up(monkeypatch):
    from fsipetsc.stepping.pauses import OUT_OF_TIME, RESERVE, Pauses

    opt = {"fsi_checkpoint_steps": None, "fsi_checkpoint_wall": None, "fsi_wall_limit": 100.0}
    monkeypatch.setattr("fsipetsc.stepping.pauses.time", SimpleNamespace(monotonic=lambda: 7.0))
    pauses = Pauses(opt, True)
    assert pauses.ends == 7.0 + 100.0 - RESERVE and pauses.word() == 0.0
    pauses.written(40.0)
    assert pauses.ends < 7.0 and pauses.word() == OUT_OF_TIME
    assert Pauses(opt, False).ends == Pauses({**opt, "fsi_wall_limit": None}, True).ends == np.inf


def state_of(name, **options):
    """A state of a case on this rank, after its first step was planned; to be used as a context."""
    from fsipetsc.cases import load_case
    from fsipetsc.options import read_options
    from fsipetsc.options.sources import given_options
    from fsipetsc.process.launch import start_mpi, start_petsc
    from fsipetsc.stepping.solve import build_problem, make_state

    comm, case = start_mpi(), load_case(name)
    words = [word for key, value in options.items() for word in (f"-{key}", str(value))]
    start_petsc(words, comm)
    opt = read_options(case, given_options(words, {}))
    return make_state(build_problem(case, opt, comm), opt, comm), opt


CASES = {
    "rod": {"fsi_h": 0.05},
    "box": {"fsi_h": 0.025, "fsi_order": 6},
    "blast": {"fsi_h": 0.0625},
}


@pytest.mark.parametrize("name", CASES)
def test_what_bounds_the_step_is_what_bounds_it(name):
    """The rates of the layers make the rate that the step is taken of; the fastest one is named."""
    from fsipetsc.scheme.plan import RATE
    from fsipetsc.stepping import limits

    state, opt = state_of(name, **CASES[name])
    with state:
        state.compile(lambda text: None)
        state.set_initial()
        if name != "rod":
            state.finish()
        rates = state.rates
        assert rates.shape == (len(state.problem.layers), 2) and (rates[:, 0] > 0).all()
        assert np.sum(rates.max(axis=0) ** 4) ** 0.25 == pytest.approx(state.results[RATE], rel=1e-12)
        k, which = np.unravel_index(np.argmax(rates), rates.shape)
        named = limits.reason(state, opt)
        assert named.endswith(f" in {state.problem.layers[k].name}") and ("conduction" in named) == bool(which)
        assert limits.reason(state, {**opt, "ts_dt": 1e-3}) == "-ts_dt"


def test_shares_of_the_time():
    from fsipetsc.stepping.limits import shares

    found = shares([[0.0, "a"], [1.0, "b"], [1.5, "a"]], 4.0)
    assert found == [("a", 3.5 / 4), ("b", 0.5 / 4)] and shares([], 1.0) == [] and shares([[0.0, "a"]], 0.0) == [("a", 1.0)]


def test_ledgers_go_on_behind_a_checkpoint(tmp_path):
    words = ("box", "-fsi_h", 0.05, "-fsi_order", 2, "-fsi_quiet")
    solve(*words, "-ts_max_time", 0.8, "-fsi_output", "whole.h5", cwd=tmp_path)
    first = ("-fsi_output", "parts.h5", "-ts_max_steps", 20, "-fsi_checkpoint_steps", 20)
    solve(*words, "-ts_max_time", 0.8, *first, cwd=tmp_path)
    more = ("-fsi_restart", "parts.checkpoint.h5", "-ts_max_steps", 100000, "-fsi_output", "parts.h5")
    done = solve("box", "-fsi_quiet", *more, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "whole.h5") as a, fsipetsc.open_run(tmp_path / "parts.h5") as b:
        assert a.summary["steps"] == b.summary["steps"] > 40
        assert a.summary["departures"] == b.summary["departures"] and a.summary["limits"] == b.summary["limits"]
