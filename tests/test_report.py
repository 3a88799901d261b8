"""What a run says of itself: how it ended, and of steps that are too long."""

from __future__ import annotations

import pytest
from helpers import solve

import fsipetsc

pytest.importorskip("petsc4py")


@pytest.fixture(scope="module")
def where(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


def box(where, *words):
    return solve("box", "-fsi_h", 0.1, "-fsi_order", 2, "-fsi_output", "r.h5", *words, cwd=where)


def test_an_end_by_the_number_of_steps_is_not_said_to_be_the_end(where):
    done = box(where, "-ts_max_steps", 1)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(where / "r.h5") as result:
        t, summary, complete = result.series["t"][-1], result.summary, result.complete
    words = f"ended by -ts_max_steps at t = {t:g}, before -ts_max_time 2"
    assert f"\n{words}: 1 step in " in done.stdout and "done at" not in done.stdout
    assert (summary["status"], summary["message"], complete) == ("done", words, True), (
        "as the user wished"
    )
    assert words in solve("info", "r.h5", cwd=where).stdout


def test_steps_far_beyond_their_bound_are_noted(where):
    """Those that were asked for: with -ts_dt or with -fsi_cfl; not the default ones."""
    noted = {}
    for words in ((), ("-ts_dt", 1e-4), ("-ts_dt", 1.0), ("-fsi_cfl", 4)):
        done = box(where, "-ts_max_steps", 1, *words)
        noted[words] = [line for line in done.stdout.splitlines() if line.startswith("note: ")]
    with fsipetsc.open_run(where / "r.h5") as result:
        bound = result.series["dt"][0]
    assert noted.pop(("-fsi_cfl", 4))[0].startswith(
        "note: -fsi_cfl 4 is 4 times the bound on the step at t = 0, "
    )
    assert noted.pop(("-ts_dt", 1.0))[0].startswith("note: -ts_dt 1 is ")
    assert list(noted.values()) == [[], []] and bound > 0
    said = box(where, "-ts_dt", 4, "-fsi_output_dt", 8).stderr  # and where they fail
    assert "; -ts_dt 4 is " in said and " times the bound on the step at t = 0" in said
