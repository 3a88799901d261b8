"""What a run shows: lines of progress, what bounds the steps, a summary that goes on behind a
checkpoint.
"""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import solve

import fsipetsc

pytest.importorskip("petsc4py")

from fsipetsc.stepping import report


@pytest.mark.parametrize(("asked", "first"), [(False, 10.0), (True, 2.0)])
def test_lines_of_progress(asked, first, monkeypatch, capsys):
    """No sooner than after some seconds, ever rarer; what is left counts from where the run began.

    """
    clock = iter(np.arange(0.0, 1e4, 0.5))
    monkeypatch.setattr(report.time, "monotonic", lambda: float(next(clock)))
    monkeypatch.setattr(report, "bound_of_step", lambda state, opt: "sound in gas")
    opt = {
        "fsi_quiet": False,
        "fsi_progress": asked,
        "ts_max_time": 10.0,
        "ts_max_steps": 2**31 - 1,
    }
    state = SimpleNamespace(problem=SimpleNamespace(unit=lambda name: f" {name}"))
    shown = report.Reporter(SimpleNamespace(rank=0, size=1), "rod", opt, state)
    shown.start(2.0, 1000)  # as after a restart
    lines = []
    for step in range(1000, 40_000):
        shown.step(step, 2.0 + 8.0 * (step - 1000) / 39_000, 1e-3)
        said = capsys.readouterr().out
        lines += [(step, said)] if said else []
    seconds = np.array(
        [(step - 1000) / 64 for step, _ in lines]
    )  # 0.5 s at each look, one in 32 steps
    assert abs(seconds[0] - first) <= 1.0 and np.all(np.diff(seconds) <= 61.0)
    assert np.diff(seconds)[-1] > 2.0 * first
    t, left = (
        float(re.search(what, lines[-1][1])[1])
        for what in (r"t = (\S+) of", r"(\d+(?:\.\d+)?) s left")
    )
    assert left == pytest.approx(seconds[-1] * (10.0 - t) / (t - 2.0), rel=0.1, abs=1.5)
    assert "dt = 0.001 s by sound in gas" in lines[0][1] and lines[0][1].count("\n") == 1


def test_shares_of_the_time():
    found = report.shares([[0.0, "a"], [1.0, "b"], [1.5, "a"]], 4.0)
    assert found == [("a", 3.5 / 4), ("b", 0.5 / 4)] and report.shares([], 1.0) == []


def test_ledgers_go_on_behind_a_checkpoint(tmp_path):
    """And the summary of the whole says what was solved, what bounded the steps and what was kept.

    """
    words = ("box", "-fsi_h", 0.05, "-fsi_order", 2)
    done = solve(*words, "-ts_max_time", 0.8, "-fsi_output", "whole.h5", cwd=tmp_path)
    for line in (
        "solved: left (fluid), solid (solid)",
        "interfaces: ",
        "dt: ",
        "kept: ",
        "result in ",
        "next: ",
    ):
        assert any(said.startswith(line) for said in done.stdout.splitlines()), done.stdout
    first = ("-fsi_output", "parts.h5", "-ts_max_steps", 20, "-fsi_checkpoint_steps", 20)
    solve(*words, "-ts_max_time", 0.8, *first, cwd=tmp_path)
    more = (
        "-fsi_restart",
        "parts.checkpoint.h5",
        "-ts_max_steps",
        100000,
        "-fsi_output",
        "parts.h5",
    )
    done = solve("box", *more, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and "phases since the restart: " in done.stdout
    with (
        fsipetsc.open_run(tmp_path / "whole.h5") as a,
        fsipetsc.open_run(tmp_path / "parts.h5") as b,
    ):
        assert a.summary["steps"] == b.summary["steps"] == b.summary["part"]["steps"] + 20 > 40
        assert (
            a.summary["departures"] == b.summary["departures"]
            and a.summary["limits"] == b.summary["limits"]
        )
