"""Runs that start together with one output name: each gets a file of its own or is refused, and none loses anything."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import claim_program
import output_program
import pytest
from helpers import PATIENCE, environment, message, run, solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.claim import Claim, keep_earlier, publish, set_aside

PROGRAM = Path(claim_program.__file__)


@pytest.mark.parametrize("locks", [""], ids=["locks"])
def test_many_runs_at_once(tmp_path: Path, locks: str) -> None:
    """Every file that a run was given is there in the end, whole, under some name; nothing else is."""
    target, command = tmp_path / "run.h5", [sys.executable, str(PROGRAM)]
    started = [
        subprocess.Popen([*command, str(target), "5", str(k), locks], env=environment(), stdout=subprocess.PIPE, text=True)
        for k in range(12)
    ]
    time.sleep(1.0)
    (tmp_path / "go").touch()
    made = []
    for process in started:
        said = process.communicate(timeout=PATIENCE)[0]
        assert process.returncode == 0
        made += [line.split("|")[0] for line in said.splitlines()]
    (tmp_path / "go").unlink()
    found = [path.read_text() for path in tmp_path.iterdir()]
    assert sorted(found) == sorted(made) and len(made) == 12 * 5, (len(found), len(made))
    assert {path.name for path in tmp_path.iterdir()} == {"run.h5", *(f"run.{k}.h5" for k in range(1, len(made)))}


def test_a_second_run_is_refused_while_the_first_goes_on(tmp_path: Path) -> None:
    pytest.importorskip("petsc4py")
    path, program = tmp_path / "run.h5", output_program.__file__
    first = subprocess.Popen([sys.executable, program, "slowly", path, "100000", "0.01"], env=environment())
    try:
        end = time.monotonic() + PATIENCE
        while not path.exists() and time.monotonic() < end:
            time.sleep(0.01)
        answer = run(program, "refuse", path)
        assert answer.stdout.startswith("1 4 ") and f"process {first.pid} on" in answer.stdout, answer
        assert "-fsi_output" in answer.stdout
    finally:
        first.send_signal(signal.SIGKILL)
        first.wait()
    assert run(program, "blocks", path, 2).stdout.split()[-1] == "run.1.h5", "the lock of a killed run is none"
    with fsipetsc.open_run(path) as result:
        assert result.complete and result.nframes == 2
    assert sorted(os.listdir(tmp_path)) == ["run.1.h5", "run.h5"]


def test_what_others_left_is_neither_followed_nor_overwritten(tmp_path: Path) -> None:
    """A link in the place of the lock, a pipe in that of the result, leftovers of killed programs."""
    target, elsewhere = tmp_path / "run.h5", tmp_path / "elsewhere"
    elsewhere.write_text("precious")
    (tmp_path / ".run.h5.lock").symlink_to(elsewhere)
    with pytest.raises(OSError, match="symbolic"):
        Claim(target)
    assert elsewhere.read_text() == "precious"
    (tmp_path / ".run.h5.lock").unlink()
    (tmp_path / ".run.h5.lock").write_text("process 12345 on a machine, of a killed run")
    (tmp_path / f".run.h5.{os.getpid()}.new").write_text("of a killed run")
    claim = Claim(target)
    assert publish(target, b"ours") and not publish(target, b"another's")
    assert target.read_bytes() == b"ours"
    (tmp_path / "run.1.h5").symlink_to("nowhere")
    assert keep_earlier(target) == tmp_path / "run.2.h5" and keep_earlier(target) is None
    os.mkfifo(target)
    with pytest.raises(FileError, match="not a regular file"):
        keep_earlier(target)
    claim.release()
    claim.release()
    assert sorted(os.listdir(tmp_path)) == ["elsewhere", "run.1.h5", "run.2.h5", "run.h5"]


@pytest.mark.parametrize("seen", [True, False])
def test_files_that_belong_together_get_the_same_number(seen: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first that is free for all, also where another program takes one at the last moment; no empty file is left."""
    result, checkpoint, before = (tmp_path / f"run.{rest}" for rest in ("h5", "checkpoint.h5", "checkpoint.previous.h5"))
    for path in (result, checkpoint, tmp_path / "run.1.checkpoint.h5", tmp_path / "run.2.h5"):
        path.write_text(path.name)
    if seen:
        assert set_aside([], "run") == {} == set_aside([before], "run")
        (tmp_path / "run.3.checkpoint.previous.h5").mkdir()
    else:
        monkeypatch.setattr(os.path, "lexists", lambda path: False)
    number = 4 if seen else 3
    renamed = {path: path.with_name(f"run.{number}{path.name[3:]}") for path in (result, checkpoint)}
    assert set_aside([result, checkpoint], "run", [before]) == renamed
    assert all(new.read_text() == old.name for old, new in renamed.items())
    there = {"run.1.checkpoint.h5", "run.2.h5"} | ({"run.3.checkpoint.previous.h5"} if seen else set())
    assert {path.name for path in tmp_path.iterdir()} == there | {new.name for new in renamed.values()}


def test_where_one_cannot_be_renamed_all_keep_their_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last is another user's, in a folder where only owners may rename; a file that has come meanwhile is not replaced."""
    files = [tmp_path / f"run.{rest}" for rest in ("checkpoint.h5", "checkpoint.previous.h5", "h5")]
    for path in files:
        path.write_text(path.name)
    rename = os.rename

    def refuse(old: Path, new: Path) -> None:
        if old == files[2]:
            files[1].write_text("new")
            raise PermissionError(1, "Operation not permitted", str(old))
        rename(old, new)

    monkeypatch.setattr(os, "rename", refuse)
    with pytest.raises(PermissionError, match=r"run\.h5"):
        set_aside(files, "run")
    there = {path.name: path.read_text() for path in tmp_path.iterdir()}
    kept = {"run.1.checkpoint.previous.h5": files[1].name, files[1].name: "new"}
    assert there == {files[0].name: files[0].name, **kept, "run.h5": "run.h5"}


def other_file(path: Path) -> None:
    path.write_text("process of thought: precious")


def long_file(path: Path) -> None:
    path.write_text("process 1 on " + "x" * 1000)


def pipe(path: Path) -> None:
    os.mkfifo(path)


def second_name(path: Path) -> None:
    path.with_name("precious").touch()
    os.link(path.with_name("precious"), path)


@pytest.mark.parametrize("locks", [True, False], ids=["locks", "no locks"])
@pytest.mark.parametrize("make", [other_file, long_file, pipe, second_name])
def test_what_is_no_lock_stays_as_it_is(tmp_path: Path, monkeypatch, make, locks: bool) -> None:
    """A file that somebody has called like the lock is neither written to nor removed, and the run is refused."""
    if not locks:

        def refuse(*_: object) -> None:
            raise OSError("no locks here")

        monkeypatch.setattr("fsipetsc.output.claim.fcntl.flock", refuse)
    path = tmp_path / ".run.h5.lock"
    make(path)
    before = os.lstat(path), path.read_bytes() if path.is_file() else b""
    for _ in range(2):
        with pytest.raises(FileError, match=r"\.run\.h5\.lock: stands where the lock of run\.h5 belongs"):
            Claim(tmp_path / "run.h5")
    after = os.lstat(path), path.read_bytes() if path.is_file() else b""
    assert (before[0].st_ino, before[0].st_mtime_ns, before[1]) == (after[0].st_ino, after[0].st_mtime_ns, after[1])


@pytest.mark.parametrize("sticky", [False, True], ids=["may be removed", "may not be removed"])
def test_the_lock_of_another_user_s_killed_run_is_none(tmp_path: Path, monkeypatch, sticky: bool) -> None:
    """Its file cannot be written: it is locked all the same, and makes way where the folder lets it."""
    lock = tmp_path / ".run.h5.lock"
    lock.write_text("process 12345 on a machine, of a killed run")
    theirs, opened = lock.stat().st_ino, os.open

    def open_(path, flags, *mode):
        if Path(path) == lock and flags & os.O_RDWR and lock.exists() and lock.stat().st_ino == theirs:
            raise PermissionError(13, "Permission denied")
        return opened(path, flags, *mode)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr("fsipetsc.output.claim.os.open", open_)
    if sticky:
        monkeypatch.setattr("fsipetsc.output.claim.Path.unlink", refuse)
    claim = Claim(tmp_path / "run.h5")
    program = f"from pathlib import Path\nfrom fsipetsc.output.claim import Claim\nClaim(Path({str(tmp_path / 'run.h5')!r}))"
    second = subprocess.run(
        [sys.executable, "-c", program], env=environment(), text=True, capture_output=True, timeout=PATIENCE
    )
    assert "another run is writing it" in second.stderr
    assert lock.read_text().startswith("process 12345 on a" if sticky else f"process {os.getpid()} on ")
    claim.release()
    assert lock.exists() == sticky


def test_without_hard_links_nothing_is_overwritten_either(tmp_path: Path, monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError("no hard links here")

    monkeypatch.setattr("fsipetsc.output.claim.os.link", refuse)
    target = tmp_path / "run.h5"
    assert publish(target, b"ours") is not None
    monkeypatch.setattr("fsipetsc.output.claim.os.path.lexists", lambda path: False)  # made between a look and the writing
    assert publish(target, b"another's") is None
    assert target.read_bytes() == b"ours" and os.listdir(tmp_path) == ["run.h5"]


@pytest.mark.parametrize("ranks", [1, pytest.param(3, marks=pytest.mark.mpi)])
def test_checkpoints_of_a_name_are_one_run_s(tmp_path: Path, ranks: int) -> None:
    """Another one is refused, whichever way it comes to the name, and nothing has changed; a killed run's lock is none."""
    pytest.importorskip("petsc4py")
    words = "rod -fsi_h 0.05 -ts_max_steps 3 -fsi_quiet".split()
    assert solve(*words, "-fsi_output", "a.h5", "-fsi_checkpoint_steps", 2, cwd=tmp_path).returncode == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert sorted(before) == ["a.checkpoint.h5", "a.checkpoint.previous.h5", "a.h5"]
    lock = tmp_path / ".a.checkpoint.h5.lock"
    claim = Claim(tmp_path / "a.checkpoint.h5")  # as a run has it; the result's name is free
    here = f"(process {os.getpid()} on "
    for more, said in (
        ("-fsi_output b.h5 -fsi_checkpoint a.checkpoint.h5", "a.checkpoint.h5: another run writes its checkpoints (process "),
        ("-fsi_output b.h5 -fsi_checkpoint a.checkpoint.h5 -fsi_restart auto", "a name of its own with -fsi_checkpoint"),
        ("-fsi_output a.hdf5", "a.hdf5: another run is writing it, or its checkpoints (process "),
        ("-fsi_output a.h5 -fsi_restart auto", "give this one a name of its own with -fsi_output"),
    ):
        message(solve(*words, *more.split(), cwd=tmp_path, ranks=ranks), 4, said, here)
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir() if path != lock} == before, more
    claim.release()
    lock.write_text("process 12345 on a machine, of a killed run")
    done = solve(*words, "-fsi_output", "b.h5", "-fsi_checkpoint", "a.checkpoint.h5", cwd=tmp_path, ranks=ranks)
    assert (done.returncode, done.stderr) == (0, "")
    kept = {"a.checkpoint.1.h5": "a.checkpoint.h5", "a.checkpoint.1.previous.h5": "a.checkpoint.previous.h5"}
    assert {(tmp_path / name).read_bytes() == before[earlier] for name, earlier in kept.items()} == {True}
    assert sorted(os.listdir(tmp_path)) == sorted([*kept, "a.h5", "b.h5"])
    lock.mkdir()
    done = solve(*words, "-fsi_output", "c.h5", "-fsi_checkpoint", "a.checkpoint.h5", cwd=tmp_path, ranks=ranks)
    message(done, 4, "a.checkpoint.h5: no checkpoint can be written there: Is a directory")
    assert not (tmp_path / "c.h5").exists()
