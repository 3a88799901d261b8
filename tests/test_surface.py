"""What a run shows, and that its ledgers go on after a checkpoint."""

from __future__ import annotations

import pytest
from helpers import computed, solve

import fsipetsc

pytest.importorskip("petsc4py")


def test_ledgers_go_on_after_a_checkpoint(tmp_path):
    """The summary of the whole says what bounded the steps and what was kept."""
    words = *"box -fsi_h 0.05 -fsi_order 2 -ts_max_time 0.8 -fsi_output".split(), "whole.h5"
    done = solve(*words, cwd=tmp_path)
    for line in ("interfaces ", "step bounded by ", "conserved ", "result in ", "next: "):
        assert f"\n{line}" in done.stdout, done.stdout
    solve(
        *words[:-1], "parts.h5", *"-ts_max_steps 20 -fsi_checkpoint_steps 20".split(), cwd=tmp_path
    )
    more = "box", "-ts_max_steps", 100000, "-fsi_restart", "parts.checkpoint.h5"
    with fsipetsc.open_run(tmp_path / "whole.h5") as a, computed(tmp_path, "parts.h5", *more) as b:
        for key in ("steps", "departures", "bound"):
            assert a.summary[key] == b.summary[key]
        assert a.summary["steps"] > 40 and a.summary["bound"] != ""
    # from the checkpoint at the end no step follows, and nothing is known of its bound
    with computed(tmp_path, "none.h5", *more) as c:
        assert (c.summary["steps"], c.summary["bound"]) == (a.summary["steps"], "")
