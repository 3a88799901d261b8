"""What a killed run leaves of Open MPI's: only the folder of its own session is removed, and only when its mpiexec is gone."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import PATIENCE

from fsipetsc.errors import FileError
from fsipetsc.output.claim import Claim
from fsipetsc.process import leftovers
from fsipetsc.process.leftovers import remove_session

HERE = f"process 1 on {socket.gethostname()}"


@pytest.fixture
def dead() -> int:
    """The number of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def session(base: Path, number: int) -> Path:
    folder = base / "ompi.machine.0" / f"pid.{number}"
    (folder / "0").mkdir(parents=True)
    (folder / "contact.txt").write_text("somebody")
    return folder


def test_only_the_session_of_a_launcher_that_is_gone_is_removed(tmp_path, dead):
    gone, there = session(tmp_path, dead), session(tmp_path, os.getpid())
    other = tmp_path / f"pid.{dead}"  # not in a folder of Open MPI's
    other.mkdir()
    for folder in (gone, there, other, gone.parent):
        remove_session(f"{HERE}, session {folder}")
    assert not gone.exists() and there.exists() and other.exists()


def test_what_is_linked_there_stays(tmp_path, dead):
    kept = tmp_path / "kept"
    kept.mkdir()
    folder = tmp_path / "ompi.machine.0" / f"pid.{dead}"
    folder.parent.mkdir()
    folder.symlink_to(kept)
    remove_session(f"{HERE}, session {folder}")
    assert kept.exists() and folder.is_symlink()


def test_of_what_nothing_is_known_nothing_is_removed(tmp_path, monkeypatch, dead):
    """A session of another host, whose processes are not ours; words that only look like one; a system without /proc."""
    folder = session(tmp_path, dead)
    said = f"{HERE}, session {folder}"
    elsewhere = said.replace(socket.gethostname(), "machine", 1)
    for other in (elsewhere, f"session {folder}", f"{said}x", f"{said}/0", f"{said} or so"):
        remove_session(other)
        assert folder.exists(), other
    exists = os.path.exists
    with monkeypatch.context() as context:
        context.setattr(os.path, "exists", lambda path: not str(path).startswith("/proc") and exists(path))
        remove_session(said)
        assert folder.exists()
    remove_session(f"{said}\n")
    assert not folder.exists()


def test_the_next_run_of_a_result_removes_what_the_killed_one_named(tmp_path, monkeypatch, dead):
    """The lock of a run that goes on says nothing of it to others, and nothing is removed."""
    gone, own = session(tmp_path, dead), session(tmp_path, os.getpid())
    target = tmp_path / "run.h5"
    (tmp_path / ".run.h5.lock").write_text(f"process {dead} on {socket.gethostname()}, session {gone}")
    monkeypatch.setenv("OMPI_MCA_orte_jobfam_session_dir", str(own))
    claim = Claim(target)
    assert not gone.exists() and str(own) in (tmp_path / ".run.h5.lock").read_text()
    program = f"from pathlib import Path\nfrom fsipetsc.output.claim import Claim\nClaim(Path({str(target)!r}))"
    done = subprocess.run([sys.executable, "-c", program], text=True, capture_output=True, timeout=PATIENCE)
    assert FileError.__name__ in done.stderr and "another run is writing it" in done.stderr and "session" not in done.stderr
    claim.release()
    assert own.exists()


def test_names_are_known_by_what_is_mapped(tmp_path, monkeypatch):
    lines = "7f-80 rw-s 0 00:01 5   /dev/shm/vader_segment.machine.0.13f10001.1\n7f-81 r--p 0 00:01 6   /usr/lib/vader.so\n"
    (tmp_path / "maps").write_text(lines)
    monkeypatch.setattr("builtins.open", lambda *_: (tmp_path / "maps").open())
    assert leftovers._mapped() == {"/dev/shm/vader_segment.machine.0.13f10001.1": "1"}
