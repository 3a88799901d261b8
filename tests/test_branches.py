"""Checkpoints that are not those of the steps before: of steps given up, of other runs, of one that went on meanwhile."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from helpers import message, solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import Checkpoint
from fsipetsc.output.lock import Lock
from fsipetsc.stepping.output_times import times_without_frame

pytest.importorskip("petsc4py")

WORDS = "rod -fsi_h 0.05 -ts_max_time 1 -fsi_checkpoint_steps 20 -ts_max_steps".split()
NEWEST, BEFORE = "rod.checkpoint.h5", "rod.checkpoint.previous.h5"
#: the rod; as it begins, the files that stand ready take their places: of a run that had the right to write until now
MEANWHILE = """
import os
from contextlib import suppress
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "meanwhile", rod.OPTIONS, rod.DEFAULTS


def build(opt):
    for name in os.listdir("ready") if os.path.isdir("ready") else ():
        with suppress(FileNotFoundError):  # another rank was faster
            os.replace(f"ready/{name}", name)
    return rod.build(opt)
"""


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
    """Neither steps beyond an earlier checkpoint that was named, nor those of a former run; nor are two branches joined."""
    assert goes_on(tmp_path, *WORDS, 40) == ""
    shutil.copy(tmp_path / NEWEST, tmp_path / "old.h5")
    assert goes_on(tmp_path, *WORDS, 30, "-ts_dt", "1e-5", "-fsi_restart", BEFORE) == f"{BEFORE}: step 20"
    assert [steps(tmp_path / name) for name in (NEWEST, BEFORE)] == [30, 20]
    assert goes_on(tmp_path, *WORDS, 50, "-fsi_restart", "auto", ranks=2) == f"{NEWEST}: step 30"
    before = contents(tmp_path)
    message(solve(*WORDS, 60, "-fsi_restart", "old.h5", cwd=tmp_path), 4, "its step 40 ends at t = ")
    assert contents(tmp_path) == before
    assert goes_on(tmp_path, *WORDS, 10) == ""
    assert steps(tmp_path / NEWEST) == 10 and not (tmp_path / BEFORE).exists()
    assert goes_on(tmp_path, *WORDS, 25, "-fsi_restart", "auto") == f"{NEWEST}: step 10"
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.summary["steps"] == len(result.series["t"]) == 25


def test_checkpoints_of_an_earlier_run_are_kept(tmp_path):
    """As its result is, and with its number: so the earlier run can be gone on with, bit for bit as it stood."""
    assert goes_on(tmp_path, *WORDS, 40) == ""
    first = contents(tmp_path)
    (tmp_path / "rod.1.checkpoint.previous.h5").write_text("of somebody else")
    done = solve(*WORDS, 60, cwd=tmp_path)
    assert "kept the earlier rod.h5 as " in done.stdout and done.stdout.count("kept ") == 2
    names = {name: name.replace("rod.", "rod.2.") for name in first}
    assert f"kept earlier checkpoints as {tmp_path / names[NEWEST]}, {tmp_path / names[BEFORE]}\n" in done.stdout
    assert {name: (tmp_path / kept).read_bytes() for name, kept in names.items()} == first
    assert [steps(tmp_path / name) for name in (NEWEST, BEFORE)] == [60, 40]
    second = contents(tmp_path)
    words = "-fsi_restart", "auto", "-fsi_output", "rod.2.h5"
    assert goes_on(tmp_path, *WORDS, 50, *words) == f"{names[NEWEST]}: step 40"
    with fsipetsc.open_run(tmp_path / "rod.2.h5") as result:
        assert len(result.series["t"]) == 50
    for name in (*first, "rod.1.checkpoint.previous.h5"):  # and nothing else has changed
        assert (tmp_path / name).read_bytes() == second[name]


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_checkpoints_of_another_run_are_kept_by_one_that_goes_on(ranks, tmp_path):
    """From a checkpoint elsewhere, where its own ones will stand; what is no checkpoint stays where it is."""
    assert goes_on(tmp_path, *WORDS, 20) == ""
    shutil.move(tmp_path / NEWEST, tmp_path / "old.h5")
    words = *WORDS, 60, "-fsi_checkpoint", "own.h5"
    assert goes_on(tmp_path, *words) == ""
    newest, before = (tmp_path / name for name in ("own.h5", "own.previous.h5"))
    first = {path.name: path.read_bytes() for path in (newest, before)}
    assert goes_on(tmp_path, *words, "-fsi_restart", "old.h5", ranks=ranks) == "old.h5: step 20"
    assert [steps(path) for path in (newest, before)] == [60, 40]
    assert {name: (tmp_path / name.replace("own.", "own.1.")).read_bytes() for name in first} == first
    assert goes_on(tmp_path, *words, "-fsi_restart", "own.previous.h5", ranks=ranks) == "own.previous.h5: step 40"
    assert not (tmp_path / "own.2.h5").exists()
    newest.write_text("a text")
    message(solve(*words, cwd=tmp_path, ranks=ranks), 4, "own.h5: exists and is not a checkpoint of fsipetsc")
    assert newest.read_text() == "a text" and not (tmp_path / "own.2.previous.h5").exists()


def test_how_long_a_run_took_in_parts(tmp_path):
    """Steps and times are of the whole run, `part` and `phases` of what came since the restart; unknown is unknown."""
    assert goes_on(tmp_path, *WORDS, 40) == ""
    first = checkpoint_file.read(tmp_path / NEWEST)
    loop, total = first.header["memory"]["wall_time"], first.header["wall_time_total"]
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        summary = result.summary
    assert 0 < loop <= summary["wall_time"] and loop < total <= summary["wall_time_total"] == sum(summary["phases"].values())
    assert summary["part"] == {name: summary[name] for name in ("steps", "wall_time", "wall_time_total")}
    former = Checkpoint({name: value for name, value in first.header.items() if name != "wall_time_total"}, first.arrays)
    (tmp_path / "former.h5").write_bytes(checkpoint_file.pack(former))
    without = 60, "-fsi_restart", "former.h5", "-fsi_output", "f.h5"
    for words, before in (((50, "-fsi_restart", "auto"), total), (without, None)):
        done = solve(*WORDS, *words, cwd=tmp_path)
        assert done.returncode == 0 and f"\n{words[0] - 40} steps of these in " in done.stdout
        assert "since the restart\n" in done.stdout and "phases since the restart: " in done.stdout
        with fsipetsc.open_run(tmp_path / ("rod.h5" if before else "f.h5")) as result:
            summary, part = result.summary, result.summary["part"]
        assert (summary["steps"], part["steps"]) == (words[0], words[0] - 40)
        assert summary["wall_time"] == pytest.approx(loop + part["wall_time"], abs=1e-9) and part["wall_time"] > 0
        assert part["wall_time_total"] == pytest.approx(sum(summary["phases"].values()), abs=1e-9)
        assert summary["wall_time_total"] == (before and pytest.approx(before + part["wall_time_total"], abs=1e-9))


@pytest.mark.mpi
def test_what_is_given_up_stays_until_the_run_can_begin(tmp_path):
    """Where another one is writing the result nothing has changed."""
    assert goes_on(tmp_path, *WORDS, 40) == ""
    before = contents(tmp_path)
    lock = Lock(tmp_path / "rod.parts", "rod.h5")
    message(solve(*WORDS, 60, "-fsi_restart", BEFORE, cwd=tmp_path, ranks=2), 4, "rod.h5: another run is writing it")
    lock.release()
    assert contents(tmp_path) == before


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
@pytest.mark.parametrize("asked", ["auto", NEWEST])
def test_a_checkpoint_that_another_run_has_written_meanwhile(asked, ranks, tmp_path):
    """Between a look and the lock: `auto` found none, or the one that was named is the one before by now."""
    (tmp_path / "meanwhile.py").write_text(MEANWHILE)
    (tmp_path / "ready").mkdir()
    words = ["meanwhile.py", *WORDS[1:], 60, "-fsi_output", "rod.h5"]
    assert goes_on(tmp_path, *words, "-ts_max_steps", 40) == ""
    shutil.move(tmp_path / NEWEST, tmp_path / "ready" / NEWEST)
    (shutil.move if asked == "auto" else shutil.copy)(tmp_path / BEFORE, tmp_path / "ready" / BEFORE)
    if asked == NEWEST:
        shutil.move(tmp_path / BEFORE, tmp_path / NEWEST)
    everything = {**contents(tmp_path), **contents(tmp_path / "ready")}
    done = solve(*words, "-fsi_restart", asked, cwd=tmp_path, ranks=ranks)
    message(done, 4, "has changed since it was read: another run has gone on; start again")
    assert contents(tmp_path) == everything
    assert goes_on(tmp_path, *words, "-fsi_restart", asked) == f"{NEWEST}: step 40"


@pytest.mark.parametrize("rank", [0, 1])
def test_a_mere_note_ends_no_run(rank, tmp_path):
    """The result cannot be read, on rank 0; no other rank looks, nor waits."""
    from fsipetsc.stepping.run import _Run

    def line(text: str) -> None:
        raise AssertionError(text)

    path = tmp_path / "rod.h5"
    path.write_text("no result")
    past = SimpleNamespace(options={"fsi_output_times": None})
    run = SimpleNamespace(opt={"fsi_output_times": [0.1]}, comm=SimpleNamespace(rank=rank), report=SimpleNamespace(line=line))
    run.integrator, run.writer = SimpleNamespace(t=0.2), SimpleNamespace(path=path)
    with pytest.raises(FileError):
        times_without_frame([0.1], 0.2, path)
    _Run._note_missed(run, past)
