"""Checkpoints that are not those of the steps before: of steps given up, of other runs."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from helpers import message, solve

import fsipetsc
from fsipetsc.output import checkpoint_file

pytest.importorskip("petsc4py")

WORDS = "rod -fsi_h 0.05 -ts_max_time 1 -fsi_checkpoint_steps 20 -ts_max_steps".split()
NEWEST, BEFORE = "rod.checkpoint.h5", "rod.checkpoint.previous.h5"


def steps(path: Path) -> int:
    return checkpoint_file.read(path).header["memory"]["steps"]


def goes_on(folder: Path, *words: object, ranks: int = 1) -> str:
    """From which checkpoint, as the run says itself."""
    done = solve(*words, cwd=folder, ranks=ranks)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.partition("goes on from ")[2].partition(", t = ")[0]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.h5")}


@pytest.mark.mpi
def test_what_was_given_up_is_not_gone_on_from(tmp_path):
    """Neither steps beyond an earlier checkpoint that was named, nor those of a former run; nor
    are two branches joined.
    """
    assert goes_on(tmp_path, *WORDS, 40) == ""
    shutil.copy(tmp_path / NEWEST, tmp_path / "old.h5")
    assert (
        goes_on(tmp_path, *WORDS, 30, "-ts_dt", "1e-5", "-fsi_restart", BEFORE)
        == f"{BEFORE}: step 20"
    )
    assert [steps(tmp_path / name) for name in (NEWEST, BEFORE)] == [30, 20]
    assert goes_on(tmp_path, *WORDS, 50, "-fsi_restart", "auto", ranks=2) == f"{NEWEST}: step 30"
    before = contents(tmp_path)
    message(
        solve(*WORDS, 60, "-fsi_restart", "old.h5", cwd=tmp_path), 4, "its step 40 ends at t = "
    )
    assert contents(tmp_path) == before
    assert goes_on(tmp_path, *WORDS, 10) == ""
    assert steps(tmp_path / NEWEST) == 10 and not (tmp_path / BEFORE).exists()
    assert goes_on(tmp_path, *WORDS, 25, "-fsi_restart", "auto") == f"{NEWEST}: step 10"
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.summary["steps"] == len(result.series["t"]) == 25


def test_checkpoints_of_an_earlier_run_are_kept(tmp_path):
    """As its result is; the earlier run can be gone on with, as it stood."""
    assert goes_on(tmp_path, *WORDS, 40) == ""
    first = contents(tmp_path)
    done = solve(*WORDS, 60, cwd=tmp_path)
    assert "kept the earlier rod.h5 as " in done.stdout and done.stdout.count("kept ") == 2
    names = {
        "rod.h5": "rod.1.h5",
        NEWEST: "rod.checkpoint.1.h5",
        BEFORE: "rod.checkpoint.1.previous.h5",
    }
    assert {name: (tmp_path / kept).read_bytes() for name, kept in names.items()} == first
    assert [steps(tmp_path / name) for name in (NEWEST, BEFORE)] == [60, 40]
    words = (
        "-fsi_restart",
        names[NEWEST],
        "-fsi_output",
        "rod.1.h5",
        "-fsi_checkpoint",
        names[NEWEST],
    )
    assert goes_on(tmp_path, *WORDS, 50, *words) == f"{names[NEWEST]}: step 40"
    with fsipetsc.open_run(tmp_path / "rod.1.h5") as result:
        assert len(result.series["t"]) == 50
        assert result.summary["part"]["steps"] == 10 and result.summary["wall_time_total"] > 0


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_checkpoints_of_another_run_are_kept_by_one_that_goes_on(ranks, tmp_path):
    """From a checkpoint elsewhere, where its own ones will stand; what is no checkpoint stays
    where it is.
    """
    assert goes_on(tmp_path, *WORDS, 20) == ""
    shutil.move(tmp_path / NEWEST, tmp_path / "old.h5")
    words = *WORDS, 60, "-fsi_checkpoint", "own.h5"
    assert goes_on(tmp_path, *words) == ""
    newest, before = (tmp_path / name for name in ("own.h5", "own.previous.h5"))
    first = {path.name: path.read_bytes() for path in (newest, before)}
    assert goes_on(tmp_path, *words, "-fsi_restart", "old.h5", ranks=ranks) == "old.h5: step 20"
    assert [steps(path) for path in (newest, before)] == [60, 40]
    assert {
        name: (tmp_path / name.replace("own.", "own.1.")).read_bytes() for name in first
    } == first
    assert (
        goes_on(tmp_path, *words, "-fsi_restart", "own.previous.h5", ranks=ranks)
        == "own.previous.h5: step 40"
    )
    assert not (tmp_path / "own.2.h5").exists()
    newest.write_text("a text")
    message(
        solve(*words, cwd=tmp_path, ranks=ranks),
        4,
        "own.h5: exists and is not a checkpoint of fsipetsc",
    )
    assert newest.read_text() == "a text" and not (tmp_path / "own.2.previous.h5").exists()
