"""Checkpoints: whole or refused; what a run goes on from, and those of other runs."""

import errno
import os
import shutil
from unittest.mock import Mock

import h5py
import numpy as np
import pytest
from helpers import files, kept, message, solve, well

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import CheckpointError, read_checkpoint, write_checkpoint

SMALL = {"case": "rod", "memory": {"t": float("inf")}}, {"layer0": np.arange(6.0)}


def test_each_byte_counts(tmp_path):
    """A bit that changes is noticed (one in every third byte), and so is a file that was cut."""
    write_checkpoint(tmp_path / "a.h5", *SMALL)
    header, arrays = read_checkpoint(tmp_path / "a.h5")
    assert header == SMALL[0] and np.array_equal(arrays["layer0"], SMALL[1]["layer0"])
    with h5py.File(tmp_path / "a.h5") as file:  # as it is for other programs
        assert file["arrays/layer0"][3] == 3.0
    content = bytearray((tmp_path / "a.h5").read_bytes())

    def refused(content):
        (tmp_path / "a.h5").write_bytes(content)
        with pytest.raises(FileError, match=r"is not a checkpoint|damaged"):
            read_checkpoint(tmp_path / "a.h5")

    for i in range(0, len(content), 3):
        content[i] ^= 1 << i % 8
        refused(content)
        content[i] ^= 1 << i % 8
    for length in {0, 1, 19, 511, 512, 513, len(content) // 2, len(content) - 1}:
        refused(content[:length])
    with pytest.raises(FileError, match=r"is no regular file"):
        read_checkpoint(tmp_path)


@pytest.mark.parametrize("at", ["fsync", "replace"])
def test_what_fails_in_the_middle_leaves_the_one_before(at, tmp_path, monkeypatch):
    target = tmp_path / "a.h5"
    write_checkpoint(target, {"steps": 2}, {})

    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with monkeypatch.context() as context:
        context.setattr(os, at, Mock(side_effect=full))
        with pytest.raises(CheckpointError, match=r"No space left .*; the one before is kept in"):
            write_checkpoint(target, {"steps": 3}, {})
    assert read_checkpoint(target)[0]["steps"] == 2
    assert os.listdir(tmp_path) == ["a.h5"]


WORDS = "rod -fsi_coupling projection -fsi_h 0.05 -ts_max_time 1 -fsi_checkpoint_steps 20".split()
WORDS.append("-ts_max_steps")
NEWEST = "rod.checkpoint.h5"


def goes_on(folder, *words, ranks=1):
    done = well(solve(*words, cwd=folder, ranks=ranks))
    return done.stdout.partition("goes on from ")[2].partition(", t = ")[0]


def test_what_cannot_change_is_named(tmp_path):
    assert goes_on(tmp_path, *WORDS, 60) == ""
    before = files(tmp_path)
    for words in ("-fsi_order 6", "-fsi_h 0.025", "-fsi_viscous narrow", "-rod_wall 0.6"):
        done = solve("rod", "-fsi_restart", NEWEST, *words.split(), cwd=tmp_path)
        message(done, 2, f"{words}: it was ", "cannot change at a restart")
    done = solve("pulse", "-fsi_restart", NEWEST, cwd=tmp_path)
    message(done, 2, "is a checkpoint of the case rod, not of pulse")
    assert files(tmp_path) == before


def test_what_was_given_up_is_not_gone_on_from(tmp_path):
    """Steps beyond an earlier checkpoint, or of a former run; what another run left is kept."""
    assert goes_on(tmp_path, *WORDS, 20) == ""
    shutil.copy(tmp_path / NEWEST, tmp_path / "old.h5")
    assert goes_on(tmp_path, *WORDS, 40, "-fsi_restart", "auto") == f"{NEWEST}: step 20"
    shutil.copy(tmp_path / NEWEST, tmp_path / "late.h5")
    words = *WORDS, 30, "-ts_dt", "1e-5", "-fsi_restart", "old.h5"
    assert goes_on(tmp_path, *words) == "old.h5: step 20"
    both = (read_checkpoint(tmp_path / name)[0] for name in (NEWEST, "rod.checkpoint.1.h5"))
    assert [header["memory"]["steps"] for header in both] == [30, 40]
    assert goes_on(tmp_path, *WORDS, 50, "-fsi_restart", "auto", ranks=2) == f"{NEWEST}: step 30"
    before = files(tmp_path)
    done = solve(*WORDS, 60, "-fsi_restart", "late.h5", cwd=tmp_path)
    message(done, 4, "its step 40 ends at t = ")
    assert files(tmp_path) == before
    done = solve(*WORDS, 10, cwd=tmp_path)
    assert "kept the earlier rod.h5 as " in done.stdout and done.stdout.count("kept the ") == 2
    assert (tmp_path / "rod.1.h5").read_bytes() == before["rod.h5"]
    assert (tmp_path / "rod.checkpoint.2.h5").read_bytes() == before[NEWEST]
    assert goes_on(tmp_path, *WORDS, 25, "-fsi_restart", "auto") == f"{NEWEST}: step 10"
    words = "-fsi_restart", "rod.checkpoint.2.h5", "-fsi_output", "rod.1.h5"
    assert goes_on(tmp_path, *WORDS, 60, *words) == "rod.checkpoint.2.h5: step 50"
    for name, count in (("rod.h5", 25), ("rod.1.h5", 60)):
        with fsipetsc.open_run(tmp_path / name) as result:
            assert result.summary["steps"] == len(result.series["t"]) == count
    (tmp_path / "rod.parts").mkdir()
    shutil.copy(tmp_path / "rod.1.h5", tmp_path / "rod.parts" / "000001.h5")
    assert goes_on(tmp_path, *WORDS, 26, "-fsi_restart", "auto") == f"{NEWEST}: step 25"
    assert (tmp_path / "rod.2.parts" / "000001.h5").exists(), "the pieces of another run"


def test_a_result_that_begins_at_a_restart_is_held_to_its_laws_from_there(tmp_path):
    """Gas has left by the open end before: its mass and energy count from the restart."""
    words = "rod -fsi_h 0.05 -ts_max_time 1 -fsi_checkpoint_steps 300 -ts_max_steps".split()
    assert goes_on(tmp_path, *words, 300, ranks=2) == ""
    own = "-fsi_restart", NEWEST, "-fsi_output", "own.h5"
    for steps in (305, 600):  # the first file is kept under another name
        assert goes_on(tmp_path, *words, steps, *own, ranks=2) == f"{NEWEST}: step 300"
    assert fsipetsc.open_run(tmp_path / "own.1.h5").series["t"].size == 5
    begun, gone_on = (fsipetsc.open_run(tmp_path / name) for name in ("rod.h5", "own.h5"))
    assert kept(gone_on, 1e-12).series["t"].size == 300
    reached = {name: begun.series[name][-1] for name in ("mass", "energy", "momentum_x")}
    for name, value in reached.items():
        assert np.array_equal(gone_on.summary[f"initial_{name}"], value), name
