"""Checkpoints: whole or refused, whatever is done to the file; what a run goes on from, and what
becomes of the checkpoints of other runs.
"""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import message, solve

import fsipetsc
from fsipetsc.errors import FileError, InputError
from fsipetsc.output import checkpoint_file
from fsipetsc.output.checkpoint_file import CheckpointError, pack, read, unpack, write
from fsipetsc.output.file_layout import in_memory

SMALL = {"case": "rod", "memory": {"t": float("inf")}}, {"layer0": np.arange(6.0)}


def test_what_is_written_is_read(tmp_path):
    write(tmp_path / "a.h5", pack(*SMALL))
    header, arrays = read(tmp_path / "a.h5")
    assert header == SMALL[0] and np.array_equal(arrays["layer0"], SMALL[1]["layer0"])
    with h5py.File(tmp_path / "a.h5") as file:  # as it is for other programs
        assert file["arrays/layer0"][3] == 3.0


def test_each_byte_counts():
    """Any one that is flipped, in one bit or in all, is noticed, and so is a file that was cut."""
    content = bytearray(pack(*SMALL))
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


@pytest.mark.parametrize("at", ["fsync", "replace"])
def test_what_fails_in_the_middle_leaves_the_one_before(at, tmp_path, monkeypatch):
    target = tmp_path / "a.h5"
    write(target, pack({"steps": 2}, {}))

    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as context:
        context.setattr(os, at, full)
        with pytest.raises(CheckpointError, match=r"No space left .*; the one before is kept in"):
            write(target, pack({"steps": 3}, {}))
    assert read(target)[0]["steps"] == 2
    assert {path.name for path in tmp_path.iterdir()} == {"a.h5"}
    target.write_bytes(b"years of work")
    with pytest.raises(CheckpointError, match="exists and is not a checkpoint of fsipetsc"):
        write(target, pack(*SMALL))
    assert target.read_bytes() == b"years of work"


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
    good = bytearray((stopped / "rod.checkpoint.h5").read_bytes())
    good[len(good) // 2] ^= 1
    (tmp_path / "rod.checkpoint.h5").write_bytes(good)
    (tmp_path / "result.h5").write_bytes((stopped / "rod.h5").read_bytes())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    said = {"none.h5": "no such file", "result.h5": "is not a checkpoint"}
    said["auto"] = "rod.checkpoint.h5: the checkpoint is damaged"
    for name, words in said.items():
        done = solve("rod", "-fsi_restart", name, cwd=tmp_path, ranks=ranks)
        message(done, 4, words, "begins anew" if name == "auto" else name)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def wrong_files(header, arrays):
    """Contents with right checksums: no HDF5, no header, no JSON, headers that lack an entry or
    have one of another kind, a layer that is missing."""
    bodies = [b"no HDF5"]
    for name, value in (("other", 1.0), ("header", 1.0), ("header", "no JSON")):
        with in_memory() as (file, image):
            file[name] = value
        bodies.append(image.getvalue())
    yield from (checkpoint_file._head(body) + body for body in bodies)
    yield from (pack(wrong, arrays) for wrong in ([], "rod", {**header, "result": [1]}))
    yield pack(header, {name: array for name, array in arrays.items() if name != "layer1"})
    places = [(header, ()), *((header[name], (name,)) for name in ("memory", "ledgers", "run"))]
    for entries, inside in places:
        for name in entries:
            for kept in ({}, {name: True}):
                wrong = {k: v for k, v in entries.items() if k != name} | kept
                yield pack({**header, inside[0]: wrong} if inside else wrong, arrays)


def test_a_header_that_no_run_has_written_is_refused(stopped, tmp_path):
    """Status 4, and one message."""
    from mpi4py import MPI

    from fsipetsc.cases import load_case
    from fsipetsc.stepping.restart import find_past

    target = tmp_path / "a.h5"
    header, arrays = read(stopped / "rod.checkpoint.h5")
    for content in wrong_files(header, arrays):
        target.write_bytes(content)
        with pytest.raises(FileError, match=r"a\.h5: the (checkpoint has no )?header"):
            find_past(load_case("rod"), {"fsi_restart": str(target)}, MPI.COMM_SELF)
    message(solve("rod", "-fsi_restart", "a.h5", cwd=tmp_path), 4, "a.h5: the header")


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
    checkpoint = stopped / "rod.checkpoint.h5"
    words = "-ts_dt", "1e-5", "-ts_max_steps", 70, "-fsi_output", "new.h5"
    done = solve("rod", "-fsi_restart", checkpoint, *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "note: -ts_dt 1e-5: it was not given" in done.stdout and "step 60, t = " in done.stdout
    with fsipetsc.open_run(tmp_path / "new.h5") as result:
        assert result.series["dt"].tolist() == [1e-5] * 10
        assert result.time[0] == checkpoint_file.read(checkpoint)[0]["memory"]["t"]
        assert result.summary["steps"] == 70


def test_places_where_no_checkpoint_can_be_are_found_out_before_the_run(tmp_path):
    message(
        solve(*SHORT, "-fsi_checkpoint", "rod.h5", cwd=tmp_path), 2, "that is where the result goes"
    )
    said = "no/a.h5: no file can be written", "No such file or directory"
    message(solve(*SHORT, "-fsi_checkpoint", "no/a.h5", cwd=tmp_path), 4, *said)
    (tmp_path / "a.h5").write_text("years of work")
    said = "a.h5: exists and is not a checkpoint of fsipetsc"
    message(solve(*SHORT, "-fsi_checkpoint", "a.h5", cwd=tmp_path), 4, said)
    assert (tmp_path / "a.h5").read_text() == "years of work"
    assert not (tmp_path / "rod.h5").exists()


def test_another_extent_of_a_layer_is_found_out(tmp_path):
    """The case itself has changed: no option tells."""
    case = "from fsipetsc.cases import rod\nfrom fsipetsc.cases.rod import *\nNAME = 'mine'\n"
    case += "def build(opt):\n    return rod.build({**opt, 'rod_top': TOP})\n"
    (tmp_path / "mine.py").write_text(case.replace("TOP", "3.0"))
    assert solve("mine.py", *SHORT[1:], cwd=tmp_path).returncode == 0
    (tmp_path / "mine.py").write_text(case.replace("TOP", "3.2"))
    done = solve("mine.py", "-fsi_restart", "mine.checkpoint.h5", cwd=tmp_path)
    message(done, 2, "X of 'above' is [", ", 3.2], and was [", ", 3.0] when the checkpoint")


def test_another_number_of_points_is_found_out():
    """Of layers whose ends differ by less than their description shows."""
    pytest.importorskip("petsc4py")
    from mpi4py import MPI

    from fsipetsc.cases import load_case
    from fsipetsc.options import defaults
    from fsipetsc.stepping import restart
    from fsipetsc.stepping.solve import build_problem, make_state

    case = load_case("rod")

    def state(top):
        opt = {**defaults(case), "fsi_h": 0.05, "fsi_coupling": "projection", "rod_top": top}
        return make_state(build_problem(case, opt, MPI.COMM_SELF), opt, MPI.COMM_SELF)

    with state(3.0) as before, state(3.0 + 4e-10) as now:
        problem, columns = restart.described(before.problem), restart.columns_of(before)
        assert problem == restart.described(now.problem)
        header = {"problem": problem, "columns": columns}
        past = restart.Past("a.h5", header, before.capture(), [])
        restart.check_problem(past, before)
        said = r"nodes of 'above' is \[40\], and was \[39\] when the checkpoint a\.h5"
        with pytest.raises(InputError, match=said):
            restart.check_problem(past, now)


WORDS = "rod -fsi_h 0.05 -ts_max_time 1 -fsi_checkpoint_steps 20 -ts_max_steps".split()
NEWEST = "rod.checkpoint.h5"


def steps(path: Path) -> int:
    return read(path)[0]["memory"]["steps"]


def goes_on(folder: Path, *words: object, ranks: int = 1) -> str:
    """From which checkpoint, as the run says itself."""
    done = solve(*words, cwd=folder, ranks=ranks)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.partition("goes on from ")[2].partition(", t = ")[0]


@pytest.mark.mpi
def test_what_was_given_up_is_not_gone_on_from(tmp_path):
    """Neither steps beyond an earlier checkpoint that was named, nor those of a former run; nor
    are two branches joined; what another run has left is kept.
    """
    assert goes_on(tmp_path, *WORDS, 20) == ""
    shutil.copy(tmp_path / NEWEST, tmp_path / "old.h5")
    assert goes_on(tmp_path, *WORDS, 40, "-fsi_restart", "auto") == f"{NEWEST}: step 20"
    shutil.copy(tmp_path / NEWEST, tmp_path / "late.h5")
    words = *WORDS, 30, "-ts_dt", "1e-5", "-fsi_restart", "old.h5"
    assert goes_on(tmp_path, *words) == "old.h5: step 20"
    assert [steps(tmp_path / name) for name in (NEWEST, "rod.checkpoint.1.h5")] == [30, 40]
    assert goes_on(tmp_path, *WORDS, 50, "-fsi_restart", "auto", ranks=2) == f"{NEWEST}: step 30"
    before = {path.name: path.read_bytes() for path in tmp_path.glob("*.h5")}
    done = solve(*WORDS, 60, "-fsi_restart", "late.h5", cwd=tmp_path)
    message(done, 4, "its step 40 ends at t = ")
    assert {path.name: path.read_bytes() for path in tmp_path.glob("*.h5")} == before
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
