"""What a killed run leaves of Open MPI's: only what is its own is removed, by a later run, when nobody has it any more."""

from __future__ import annotations

import fcntl
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from helpers import PATIENCE, REPOSITORY, environment, run
from kill_cycles import alive, descendants, places, sessions_in

from fsipetsc.errors import FileError
from fsipetsc.output.claim import Claim
from fsipetsc.process import leftovers
from fsipetsc.process.leftovers import job_number, remove_session

HERE = f"process 1 on {socket.gethostname()}"


@pytest.fixture
def dead() -> int:
    """The number of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def session(base: Path, number: int, name: str = "ompi.machine.0/pid.{}") -> Path:
    folder = base / name.format(number)
    (folder / "0").mkdir(parents=True)
    (folder / "contact.txt").write_text("somebody")
    return folder


@pytest.mark.parametrize("name", ["ompi.machine.0/pid.{}", "prterun.machine.{}.0"])
def test_only_the_session_of_a_launcher_that_is_gone_is_removed(name, tmp_path, dead):
    gone, there = session(tmp_path, dead, name), session(tmp_path, os.getpid(), name)
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


@pytest.mark.parametrize("name", ["vader_segment", "sm_segment"])
def test_names_are_known_by_what_is_mapped(name, tmp_path, monkeypatch):
    lines = f"7f-80 rw-s 0 00:01 5   /dev/shm/{name}.machine.0.13f10001.1\n7f-81 r--p 0 00:01 6   /usr/lib/vader.so\n"
    (tmp_path / "maps").write_text(lines)
    monkeypatch.setattr("builtins.open", lambda *_: (tmp_path / "maps").open())
    assert leftovers._mapped() == {f"/dev/shm/{name}.machine.0.13f10001.1": "1"}


@pytest.mark.parametrize("number", ["1", None])
@pytest.mark.parametrize("name", ["vader_segment", "sm_segment"])
def test_names_are_removed_once_all_have_mapped_them(name, number, tmp_path, monkeypatch):
    """Of a job of mpiexec, and of a process alone; Open MPI 4 has an empty file in its place in the end."""
    ranks = 1 if number is None else 2
    paths = [tmp_path / f"{name}.machine.0.13f10001.{rank}" for rank in range(ranks)]
    own, registered = paths[-1], []
    for path in paths:
        path.write_text("memory")
    monkeypatch.setattr(leftovers, "_mapped", lambda: {str(path): path.suffix[1:] for path in paths})
    monkeypatch.setattr(leftovers.atexit, "register", lambda *call: registered.append(call))
    if number is None:
        monkeypatch.delenv("OMPI_COMM_WORLD_LOCAL_RANK", raising=False)
    else:
        monkeypatch.setenv("OMPI_COMM_WORLD_LOCAL_RANK", number)
    leftovers.release_names(SimpleNamespace(size=2, allgather=lambda entry: [entry, (1, 1)]))
    assert own.exists(), "one rank has not mapped all"
    leftovers.release_names(SimpleNamespace(size=ranks, allgather=lambda entry: [entry] * ranks))
    assert not own.exists() and [path.exists() for path in paths] == [True, False][2 - ranks :]
    assert registered == ([(leftovers._put_back, str(own))] if name == "vader_segment" else [])


@pytest.mark.parametrize(
    ("name", "value", "job"),
    [
        ("OMPI_MCA_ess_base_jobid", str(0x13F10001), "13f10001"),
        ("PMIX_NAMESPACE", "prterun-vm-13306@1", "adff0001"),  # as Open MPI 5.0.7 names its memory then
        ("PMIX_NAMESPACE", "prterun-vm-13306@2", "adff0002"),
        ("PMIX_NAMESPACE", "slurm.pmix.7.0", ""),
    ],
)
def test_the_number_of_a_job(name, value, job):
    assert job_number({name: value}) == job


@pytest.fixture
def begins(tmp_path, monkeypatch) -> Path:
    """A folder for temporary files, shared memory in it; this process is the first rank of job abc, and its mpiexec."""
    monkeypatch.setattr(leftovers.tempfile, "gettempdir", lambda: str(tmp_path))
    for name, value in (
        ("OMPI_MCA_btl_vader_backing_directory", str(tmp_path)),
        ("OMPI_MCA_btl_sm_backing_directory", str(tmp_path)),
        ("OMPI_MCA_osc_sm_backing_directory", str(tmp_path)),
        ("OMPI_MCA_orte_jobfam_session_dir", str(session(tmp_path, os.getpid()))),
        ("OMPI_MCA_ess_base_jobid", str(0xABC)),
        ("OMPI_COMM_WORLD_LOCAL_RANK", "0"),
    ):
        monkeypatch.setenv(name, value)
    return tmp_path


def test_what_a_mark_tells_of_is_removed_when_nobody_holds_it(begins, dead):
    """Not so of another host, nor shared memory of other jobs; a mark stays as long as its mpiexec."""
    user, gone = os.getuid(), session(begins, dead)
    names = "vader_segment.machine.0.def.0", "vader_segment.machine.0.def.1", "osc_sm.machine.def.0.7"
    memory = [begins / name for name in names]
    others = [begins / name for name in ("vader_segment.machine.0.defa.0", "other.0.def.0", f"fsipetsc.{user + 1}.def.start")]
    stale, elsewhere, living = (begins / f"fsipetsc.{user}.{job}.start" for job in ("def", "defa", "fed"))
    for path in (*memory, *others):
        path.touch()
    stale.write_text(f"{HERE}, session {gone}")
    elsewhere.write_text(f"process 1 on machine, session {gone}")
    living.write_text(f"{HERE}, session {gone.with_name(f'pid.{os.getpid()}')}")
    leftovers.mark_start()
    own = begins / f"fsipetsc.{user}.abc.start"
    assert not stale.exists() and not gone.exists() and not any(path.exists() for path in memory)
    assert all(path.exists() for path in (*others, elsewhere, living)) and str(os.getpid()) in own.read_text()
    again = subprocess.run(
        [sys.executable, "-c", "from fsipetsc.process.leftovers import mark_start; mark_start()"],
        env={**os.environ, "TMPDIR": str(begins), "PYTHONPATH": str(REPOSITORY)},
        check=False,
        timeout=60,
    )
    assert again.returncode == 0 and own.exists(), "what is held is a run that goes on"
    leftovers.remove_mark()
    assert not own.exists()
    leftovers.remove_mark()


def test_memory_stays_while_there_is_a_process_of_the_launcher_s_number(begins):
    """Which may be the mpiexec of another job, and that has the same names then; the mark stays for a later run."""
    launcher = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    memory, mark = begins / "vader_segment.machine.0.def.1", begins / f"fsipetsc.{os.getuid()}.def.start"
    memory.touch()
    mark.write_text(f"{HERE}, session {begins}/ompi.machine.0/pid.{launcher.pid}")  # a folder that is gone already
    leftovers.mark_start()
    assert memory.exists() and mark.exists()
    launcher.communicate(b"\n")
    leftovers.mark_start()
    assert not memory.exists() and not mark.exists()
    leftovers.remove_mark()


def test_marks_and_memory_of_open_mpi_5(begins, monkeypatch, dead):
    """Of a dead job they go; of one that holds its mark, or has the number of this job, memory stays."""
    for name in ("OMPI_MCA_ess_base_jobid", "OMPI_MCA_orte_jobfam_session_dir"):
        monkeypatch.delenv(name)
    monkeypatch.setenv("PMIX_NAMESPACE", "prterun-vm-13306@1")
    monkeypatch.setenv("PMIX_SERVER_TMPDIR", str(session(begins, os.getpid(), "prterun.vm.{}.0")))
    user, gone = os.getuid(), session(begins, dead, "prterun.vm.{}.0")
    jobs = "def0001", "1230001", "adff0001"
    memory = {job: begins / f"sm_segment.vm.0.{job}.1" for job in jobs}
    marks = {job: begins / f"fsipetsc.{user}.{job}.start" for job in jobs}
    for job in jobs:
        memory[job].touch()
        marks[job].write_text(f"{HERE}, session {gone}")
    with marks["1230001"].open() as living:
        fcntl.flock(living, fcntl.LOCK_EX)
        leftovers.mark_start()
    assert [job for job in jobs if memory[job].exists()] == ["1230001", "adff0001"] and not gone.exists()
    assert [job for job in jobs if marks[job].exists()] == ["1230001", "adff0001"]
    assert str(os.getpid()) in marks["adff0001"].read_text()
    leftovers.mark_start()
    assert not memory["1230001"].exists() and memory["adff0001"].exists()
    leftovers.remove_mark()


def test_a_mark_that_cannot_be_followed_stops_nothing(begins, dead):
    user, gone = os.getuid(), session(begins, dead)
    first, second = (begins / f"fsipetsc.{user}.{job}.start" for job in ("d", "e"))
    first.symlink_to("nowhere")
    second.write_text(f"{HERE}, session {gone}")
    leftovers.mark_start()
    leftovers.remove_mark()
    assert first.is_symlink() and not second.exists() and not gone.exists()


def test_a_mark_that_is_being_made(begins, monkeypatch):
    """Another run finds it before it is locked, and removes it: it is made once more, and no memory is touched."""
    own, memory = begins / f"fsipetsc.{os.getuid()}.abc.start", begins / "vader_segment.machine.0.abc.1"
    memory.touch()
    lock, met = leftovers.fcntl.flock, []

    def late(descriptor: int, how: int) -> None:
        if not met:
            met.append(own.stat().st_ino)
            leftovers._follow(own, "abc")
            assert not own.exists()
        lock(descriptor, how)

    monkeypatch.setattr(leftovers.fcntl, "flock", late)
    leftovers.mark_start()
    assert met and str(os.getpid()) in own.read_text() and memory.exists()
    leftovers.remove_mark()


def test_a_mark_of_the_name_that_was_made_anew_stays(begins, dead, monkeypatch):
    """Between opening and locking it was removed, and a job of the same number has made its own."""
    own, memory = begins / f"fsipetsc.{os.getuid()}.abc.start", begins / "vader_segment.machine.0.abc.1"
    memory.touch()
    own.write_text(f"{HERE}, session {session(begins, dead)}")
    lock = leftovers.fcntl.flock

    def late(descriptor: int, how: int) -> None:
        own.with_name("new").touch()
        os.replace(own.with_name("new"), own)
        lock(descriptor, how)

    monkeypatch.setattr(leftovers.fcntl, "flock", late)
    leftovers._follow(own, "abc")
    assert own.exists() and memory.exists()


def test_without_locks_there_is_no_mark(begins, monkeypatch):
    def refuse(*_: object) -> None:
        raise OSError("no locks here")

    monkeypatch.setattr(leftovers.fcntl, "flock", refuse)
    leftovers.mark_start()
    assert not list(begins.glob("fsipetsc.*"))


@pytest.mark.mpi
def test_the_next_run_removes_what_one_leaves_that_is_killed_as_it_begins(tmp_path):
    """All ranks and the launcher, when there is shared memory and no result yet; the next run is of another name."""
    pytest.importorskip("petsc4py")
    temporary, memory = tmp_path / "t", tmp_path / "m"
    temporary.mkdir(), memory.mkdir()
    where = places(str(temporary), str(memory))
    command = ["mpiexec", "-n", "2", sys.executable, "-m", "fsipetsc", "rod", "-fsi_quiet"]
    killed = subprocess.Popen(command, cwd=tmp_path, env=environment(where), stderr=subprocess.DEVNULL)
    end = time.monotonic() + PATIENCE
    while not list(memory.iterdir()) and killed.poll() is None and time.monotonic() < end:
        time.sleep(0.001)
    everybody = [killed.pid, *descendants(killed.pid)]
    for pid in everybody:
        os.kill(pid, signal.SIGKILL)
    killed.wait()
    while alive(everybody) and time.monotonic() < end:
        time.sleep(0.01)
    if not sessions_in(temporary):
        pytest.skip("another MPI, of whose jobs nothing is known")
    assert list(temporary.glob("fsipetsc.*.start"))
    words = "rod -fsi_h 0.05 -ts_max_steps 1 -fsi_quiet -fsi_output next.h5".split()
    done = run("-m", "fsipetsc", *words, cwd=tmp_path, env=where)
    assert (done.returncode, done.stderr) == (0, "")
    left = [path for path in (*temporary.rglob("*"), *memory.iterdir()) if not path.is_dir()]
    assert not left and not sessions_in(temporary)
