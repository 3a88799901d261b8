"""The file of a checkpoint: whole or refused, whatever is done to it; the one before stays until
the new one is there."""

from __future__ import annotations

import errno
import io
import os
import pickle

import h5py
import numpy as np
import pytest
from helpers import message, solve

from fsipetsc.errors import FileError
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import (
    Checkpoint,
    CheckpointError,
    pack,
    previous,
    read,
    unpack,
    write,
)

SMALL = Checkpoint({"case": "rod", "memory": {"t": float("inf")}}, {"layer0": np.arange(6.0)})


def test_what_is_written_is_read(tmp_path):
    write(tmp_path / "a.h5", pack(SMALL))
    found = read(tmp_path / "a.h5")
    assert found.header == SMALL.header and np.array_equal(
        found.arrays["layer0"], SMALL.arrays["layer0"]
    )
    with h5py.File(tmp_path / "a.h5") as file:  # as it is for other programs
        assert file["arrays/layer0"][3] == 3.0


def test_each_byte_counts():
    """Any one that is flipped, in one bit or in all, is noticed, and so is a file that was cut."""
    content = bytearray(pack(SMALL))
    for i in range(len(content)):
        for flip in (1 << i % 8, 0xFF):
            content[i] ^= flip
            with pytest.raises(FileError):
                unpack(bytes(content), "a.h5")
            content[i] ^= flip
    unpack(bytes(content), "a.h5")
    for length in {0, 1, 19, 511, 512, 513, len(content) // 2, len(content) - 1}:
        with pytest.raises(FileError, match=r"is not a checkpoint|damaged"):
            unpack(bytes(content[:length]), "a.h5")
    with pytest.raises(FileError, match="damaged"):
        unpack(bytes(content) + b"\0", "a.h5")


def test_what_is_no_checkpoint_is_refused(tmp_path):
    (tmp_path / "text").write_text("not this one")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1
    os.mkfifo(tmp_path / "pipe")
    for name, words in {
        "text": "is not a checkpoint of fsipetsc",
        "other.h5": "is not a checkpoint of fsipetsc",
        "pipe": "is not a checkpoint of fsipetsc",
        "none.h5": "there is no such file",
        ".": "is not a checkpoint of fsipetsc",
    }.items():
        with pytest.raises(FileError, match=words):
            read(tmp_path / name)


def made_by_somebody(change) -> bytes:
    """A checkpoint with a right checksum that somebody has changed."""
    with h5py.File(io.BytesIO(pack(SMALL)[checkpoint_file._HEAD :]), "r+") as file:
        change(file)
        file.flush()
        body = file.id.get_file_image()
    return checkpoint_file._head(body) + body


class Trap:
    """What would do harm if it were unpickled."""

    def __reduce__(self):
        return os.mkdir, ("sprung",)


FOREIGN = {
    "texts": lambda file: file.__setitem__("arrays/layer1", ["a", "b"]),
    "a pickle": lambda file: file.__setitem__("arrays/layer1", np.void(pickle.dumps(Trap()))),
    "no header": lambda file: file.__delitem__("header"),
    "a header of numbers": lambda file: (file.pop("header"), file.__setitem__("header", 3.0)),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_it_holds_numbers_and_text_and_nothing_is_done_with_them(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    content = made_by_somebody(FOREIGN[name])
    with pytest.raises(FileError, match=r"^a\.h5: is not a checkpoint of fsipetsc: "):
        unpack(content, "a.h5")
    assert not os.path.exists("sprung")


def test_the_last_two_are_kept(tmp_path):
    target = tmp_path / "a.h5"
    for steps in (1, 2, 3):
        write(target, pack(Checkpoint({"steps": steps}, {})))
    assert (read(target).header["steps"], read(previous(target)).header["steps"]) == (3, 2)
    assert {path.name for path in tmp_path.iterdir()} == {"a.h5", "a.previous.h5"}
    target.unlink()
    with pytest.raises(FileError, match=f"the one before it is there: {previous(target)}"):
        read(target)


@pytest.mark.parametrize("at", ["fsync", "replace"])
def test_what_fails_in_the_middle_leaves_the_one_before(at, tmp_path, monkeypatch):
    target = tmp_path / "a.h5"
    for steps in (1, 2):
        write(target, pack(Checkpoint({"steps": steps}, {})))

    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as context:
        context.setattr(os, at, full)
        with pytest.raises(CheckpointError, match=r"No space left .*; the one before is kept in"):
            write(target, pack(Checkpoint({"steps": 3}, {})))
    assert read(target).header["steps"] == 2
    assert {path.name for path in tmp_path.iterdir()} == {"a.h5", "a.previous.h5"}
    write(target, pack(Checkpoint({"steps": 4}, {})))
    assert read(target).header["steps"] == 4


@pytest.mark.parametrize("at", ["a.h5", "a.previous.h5"])
def test_what_is_no_checkpoint_is_never_written_over(at, tmp_path):
    """Before the run, and where it came there meanwhile; but a damaged checkpoint is."""
    target, content = tmp_path / "a.h5", pack(SMALL)
    if at == "a.previous.h5":
        write(target, content)
    (tmp_path / at).write_bytes(b"years of work")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    said = f"{at}: exists and is not a checkpoint of fsipetsc"
    with pytest.raises(FileError, match=f"{said}: no checkpoint can be written"):
        checkpoint_file.check_place(target)
    with pytest.raises(CheckpointError, match=f"cannot be written: .*{said}"):
        write(target, content)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    (tmp_path / at).write_bytes(content[:-1])
    checkpoint_file.check_place(target)
    write(target, content)
    assert read(target).header == SMALL.header


def test_looking_for_a_place_leaves_what_another_run_is_writing(tmp_path):
    draft = checkpoint_file.draft_of(tmp_path / "a.h5")
    draft.write_text("half of it")
    checkpoint_file.check_place(tmp_path / "a.h5")
    assert draft.read_text() == "half of it"


SHORT = (
    "rod -fsi_h 0.05 -ts_max_time 1 -ts_max_steps 60 -fsi_checkpoint_steps 20 -fsi_quiet".split()
)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A folder with rod.h5 and its checkpoints."""
    pytest.importorskip("petsc4py")
    folder = tmp_path_factory.mktemp("stopped")
    done = solve(*SHORT, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 3])
def test_a_file_that_cannot_be_gone_on_from_ends_all(ranks, stopped, tmp_path):
    """Status 4, one message, nothing written."""
    good = (stopped / "rod.checkpoint.h5").read_bytes()
    flipped = bytearray(good)
    flipped[len(good) // 2] ^= 1
    (tmp_path / "flipped.h5").write_bytes(flipped)
    (tmp_path / "cut.h5").write_bytes(good[:-1000])
    (tmp_path / "result.h5").write_bytes((stopped / "rod.h5").read_bytes())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    cases = {"flipped.h5": "damaged", "cut.h5": "damaged", "none.h5": "no such file"}
    cases["result.h5"] = "is not a checkpoint"
    for name, words in cases.items() if ranks == 1 else list(cases.items())[:1]:
        done = solve("rod", "-fsi_restart", name, cwd=tmp_path, ranks=ranks)
        message(done, 4, name, words)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_header_that_somebody_has_made(stopped, tmp_path):
    """Status 4 whatever is missing, before the run begins or as it goes on."""
    whole = read(stopped / "rod.checkpoint.h5")
    for name in ("case", "run", "result", "memory", "problem", "columns", "limits", "saved_at"):
        header = {key: value for key, value in whole.header.items() if key != name}
        (tmp_path / "a.h5").write_bytes(pack(Checkpoint(header, whole.arrays)))
        message(solve("rod", "-fsi_restart", "a.h5", cwd=tmp_path), 4, "a.h5: ", "checkpoint")
    (tmp_path / "a.h5").write_bytes(pack(Checkpoint(whole.header, {})))
    message(solve("rod", "-fsi_restart", "a.h5", cwd=tmp_path), 4, "a.h5: the checkpoint does not")


def test_options_that_cannot_change_are_named(stopped, tmp_path):
    checkpoint = stopped / "rod.checkpoint.h5"
    for name, value in (
        ("fsi_order", "6"),
        ("fsi_h", "0.025"),
        ("fsi_mapping", "stretched"),
        ("solid_kappa", "3"),
    ):
        done = solve("rod", "-fsi_restart", checkpoint, f"-{name}", value, cwd=tmp_path)
        message(done, 2, f"-{name} {value}: it was ", "cannot change at a restart; leave it out")
    done = solve("rod", "-fsi_restart", checkpoint, "-rod_wall", "0.6", cwd=tmp_path)
    message(done, 2, "-rod_wall 0.6: it was ")
    message(
        solve("pulse", "-fsi_restart", checkpoint, cwd=tmp_path),
        2,
        "is a checkpoint of the case rod, not of pulse",
    )
    assert not list(tmp_path.glob("*.h5"))


def test_steps_may_change_where_it_is_said_and_a_result_may_begin_anew(stopped, tmp_path):
    import fsipetsc

    checkpoint = stopped / "rod.checkpoint.h5"
    words = "-ts_dt", "1e-5", "-ts_max_steps", 70, "-fsi_output", "new.h5"
    done = solve("rod", "-fsi_restart", checkpoint, *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "note: -ts_dt 1e-5: it was not given" in done.stdout and "step 60, t = " in done.stdout
    with fsipetsc.open_run(tmp_path / "new.h5") as result:
        assert result.series["dt"].tolist() == [1e-5] * 10
        assert (
            result.time[0]
            == result.header["restarts"][0]["t"]
            == checkpoint_file.read(checkpoint).header["memory"]["t"]
        )
        assert result.summary["steps"] == 70


def test_auto_begins_takes_the_newest_and_passes_over_the_damaged(tmp_path):
    """The line of a batch script."""
    line = [*SHORT[:-1], "-fsi_restart", "auto"]
    first = solve(*line, cwd=tmp_path)
    assert (first.returncode, "goes on" in first.stdout) == (0, False), first.stderr
    second = solve(*line, "-ts_max_steps", 80, cwd=tmp_path)
    assert "goes on from rod.checkpoint.h5: step 60" in second.stdout, second.stderr
    newest = tmp_path / "rod.checkpoint.h5"
    newest.write_bytes(newest.read_bytes()[:-1])
    third = solve(*line, "-ts_max_steps", 90, cwd=tmp_path)
    assert "goes on from rod.checkpoint.previous.h5: step 60" in third.stdout, third.stderr
    assert "note: rod.checkpoint.h5: the checkpoint is damaged" in third.stdout
    for path in tmp_path.glob("*checkpoint*"):
        path.write_bytes(b"fsipetsc checkpoint 1")
    message(solve(*line, cwd=tmp_path), 4, "without them -fsi_restart auto begins anew")


def test_places_where_no_checkpoint_can_be_are_found_out_before_the_run(tmp_path):
    message(
        solve(*SHORT, "-fsi_checkpoint", "rod.h5", cwd=tmp_path), 2, "that is where the result goes"
    )
    said = "no/a.h5: the directory", "does not exist"
    message(solve(*SHORT, "-fsi_checkpoint", "no/a.h5", cwd=tmp_path), 4, *said)
    (tmp_path / "a.h5").mkdir()
    message(
        solve(*SHORT, "-fsi_checkpoint", "a.h5", cwd=tmp_path),
        4,
        "a.h5: exists and is not a regular file",
    )
    assert not (tmp_path / "rod.h5").exists()


def test_no_other_file_is_taken_for_the_checkpoint(tmp_path):
    """A default name counts where checkpoints are asked for."""
    (tmp_path / "rod.checkpoint.h5").write_text("years of work")
    said = "rod.checkpoint.h5: exists and is not a checkpoint of fsipetsc"
    message(solve(*SHORT, cwd=tmp_path), 4, said)
    assert (tmp_path / "rod.checkpoint.h5").read_text() == "years of work"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_result_whose_name_has_another_ending(tmp_path):
    """Its files and what is said of them have this name."""
    line = [*SHORT[:-1], "-fsi_output", "run.v2", "-ts_max_steps", 20]
    assert solve(*line, cwd=tmp_path).returncode == 0
    done = solve(*line, cwd=tmp_path)
    assert f"kept the earlier run.v2 as {tmp_path}/run.v2.1\n" in done.stdout, done.stderr
    assert f"kept earlier checkpoints as {tmp_path}/run.v2.checkpoint.1.h5\n" in done.stdout
    names = {"run.v2", "run.v2.1", "run.v2.checkpoint.h5", "run.v2.checkpoint.1.h5"}
    assert {path.name for path in tmp_path.iterdir()} == names
    restart = "-fsi_restart", "run.v2.checkpoint.1.h5", "-ts_max_steps", 30
    assert solve("rod", *restart, "-fsi_output", "on.h5", cwd=tmp_path).returncode == 0


def test_another_extent_of_a_layer_is_found_out(tmp_path):
    """The case itself has changed: no option tells."""
    case = "from fsipetsc.cases import rod\nfrom fsipetsc.cases.rod import *\nNAME = 'mine'\n"
    case += "def build(opt):\n    return rod.build({**opt, 'rod_top': TOP})\n"
    (tmp_path / "mine.py").write_text(case.replace("TOP", "3.0"))
    assert solve("mine.py", *SHORT[1:], cwd=tmp_path).returncode == 0
    (tmp_path / "mine.py").write_text(case.replace("TOP", "3.2"))
    done = solve("mine.py", "-fsi_restart", "mine.checkpoint.h5", cwd=tmp_path)
    message(done, 2, "X of layer 'above' is [", ", 3.2], and was [", ", 3.0] when the checkpoint")
