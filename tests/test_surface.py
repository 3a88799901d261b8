"""What a run shows: lines of progress, what bounds the steps, a summary that goes on after a
checkpoint.
"""

from helpers import solve

import fsipetsc


def test_ledgers_go_on_after_a_checkpoint(tmp_path):
    """And the summary of the whole says what bounded the steps and what was kept."""
    words = ("box", "-fsi_h", 0.05, "-fsi_order", 2)
    done = solve(*words, "-ts_max_time", 0.8, "-fsi_output", "whole.h5", cwd=tmp_path)
    for line in (
        "interfaces ",
        "step bounded by ",
        "conserved ",
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
    assert (done.returncode, done.stderr) == (0, "")
    assert "goes on from parts.checkpoint.h5: step 20" in done.stdout
    with (
        fsipetsc.open_run(tmp_path / "whole.h5") as a,
        fsipetsc.open_run(tmp_path / "parts.h5") as b,
    ):
        assert a.summary["steps"] == b.summary["steps"] > 40
        assert a.summary["departures"] == b.summary["departures"]
        assert a.summary["bound"] == b.summary["bound"] != ""
    # from the checkpoint at the end no step follows, and nothing is known of its bound
    done = solve("box", *more[:2], "-fsi_output", "none.h5", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "none.h5") as c:
        assert (c.summary["steps"], c.summary["bound"]) == (b.summary["steps"], "")
