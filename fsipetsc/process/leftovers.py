"""Files of Open MPI's that a run which is killed (SIGKILL) would leave behind: shared memory, and the folder of a session.

Each rank has a file in /dev/shm (vader_segment…, sm_segment… of Open MPI 5) through which others on its node write to it. Once
all have mapped it, nobody needs its name: it is removed, and the memory goes with the last process, however that ends. Open MPI
4 complains where the name is not there in the end, so an empty file takes its place for that moment; 5 does not, and a process
that no mpiexec has started leaves the file, however it ends (5.0.7).

mpiexec keeps a folder of its session (ompi.HOST.USER/pid.N, prterun.HOST.N.USER), which it removes when it ends. If it is
killed, too, nobody does; the next run of the same result does, which knows from the lock of the killed one where it is
(fsipetsc.output.claim).

Until there is that lock, and until all have mapped the memory, a mark in the folder for temporary files stands for both: it is
there from the first moment of the program on, locked by the process that made it. If a run is killed so early, the next one of
this user on this host finds a mark that nobody holds, and removes what it tells of, and the mark.
"""

from __future__ import annotations

import atexit
import fcntl
import os
import re
import shutil
import socket
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mpi4py import MPI

_SEGMENT = re.compile(r"/\S*/(?:vader|sm)_segment\.[^/\s]*\.(\d+)$")
_SESSION = re.compile(r"/\S+/(?:ompi\.[^/\s]+/pid\.(?=\d+$)|prterun\.[^/\s]+\.(?=\d+\.\d+$))(\d+)(?:\.\d+)?")
_LOCK = re.compile(rf"process \d+ on ([^,\s]+), session ({_SESSION.pattern})")
#: where the session is, and which job this is: of Open MPI 4 and, as PMIx has it, of 5
_KEPT = "OMPI_MCA_orte_jobfam_session_dir", "PMIX_SERVER_TMPDIR"
_JOB, _NAMESPACE = "OMPI_MCA_ess_base_jobid", "PMIX_NAMESPACE"
_ON_NODE = "OMPI_COMM_WORLD_LOCAL_RANK"
#: first words of the names of Open MPI's shared memory, which have the number of the job in them -> what says where it is
_SHARED = {
    "vader_segment": "OMPI_MCA_btl_vader_backing_directory",
    "sm_segment": "OMPI_MCA_btl_sm_backing_directory",
    "osc_sm": "OMPI_MCA_osc_sm_backing_directory",
}
_MARK = re.compile(r"fsipetsc\.(\d+)\.([0-9a-f]+)\.start")
#: bytes of what a mark or a lock says
LONGEST = 300
_marks: dict[Path, int] = {}  # of this process -> descriptor, which holds the lock


def mark_start() -> None:
    """Say that a job of mpiexec begins, and remove what those have left that were killed as they began.

    For a process of the program's own. The first rank of a node does so for all; one without mpiexec has nothing to say.
    """
    if os.environ.get(_ON_NODE, "0") != "0":
        return
    folder, own = Path(tempfile.gettempdir()), job_number(os.environ)
    for name in _names(folder):
        match = _MARK.fullmatch(name)
        if match and int(match[1]) == os.getuid():
            with suppress(OSError):  # one that cannot be read, or removed, stops nothing
                _follow(folder / name, match[2], own)
    if not session() or not own:
        return
    path = folder / f"fsipetsc.{os.getuid()}.{own}.start"
    with suppress(OSError):
        _make(path)
    atexit.register(remove_mark)


def job_number(environment: Mapping[str, str]) -> str:
    """The number of a process's job as it stands in the names of its shared memory, hexadecimal; "" without mpiexec.

    Open MPI 5 makes it of the name that mpiexec gives the job, "prterun-HOST-PID@1": 16 bits of a hash of what stands before
    the @, R. J. Jenkins' one-at-a-time hash (Dr. Dobb's Journal, September 1997), and 16 of the number behind it.
    """
    job, name = environment.get(_JOB, ""), environment.get(_NAMESPACE, "")
    if job.isdigit():
        return f"{int(job):x}"
    words = re.fullmatch(r"(prterun-\S+)@(\d+)", name)
    if words is None:
        return ""
    number = 0
    for byte in words[1].encode():
        number = (number + byte) * 0x401 & 0xFFFFFFFF
        number ^= number >> 6
    number = number * 9 & 0xFFFFFFFF
    number ^= number >> 11
    number = number * 0x8001 & 0xFFFFFFFF
    return f"{(number >> 16 ^ number & 0xFFFF) << 16 | int(words[2]) & 0xFFFF:x}"


def remove_mark() -> None:
    """What the mark tells of is known otherwise by now, or gone."""
    while _marks:
        path, descriptor = _marks.popitem()
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)


def _names(folder: Path) -> list[str]:
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def _make(path: Path) -> None:
    """Make a mark, and hold it. OSError, also where there is one."""
    while path not in _marks:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)  # another run that has found it as it came holds it for a moment
            if is_still(descriptor, path):
                os.write(descriptor, whereabouts().encode())
                _marks[path] = descriptor
        except OSError:  # no locks here, or a full disk: a mark that nobody holds would stand for a killed run
            path.unlink(missing_ok=True)
            raise
        finally:
            if path not in _marks:
                os.close(descriptor)


def is_still(descriptor: int, path: Path) -> bool:
    """Whether an open file is still the one of this name: what is locked may have been removed meanwhile."""
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(descriptor), os.lstat(path))
    return False


def _follow(path: Path, job: str, own: str = "") -> None:
    """Remove what a mark tells of if nobody holds it and its mpiexec is gone, and the mark if nothing is left. OSError.

    job: whose mark it is. own: of this process; one that was killed may have had the same number, and new files the same names.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        if os.fstat(descriptor).st_uid != os.getuid() or os.fstat(descriptor).st_nlink != 1:
            return
        with suppress(BlockingIOError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            said = os.pread(descriptor, LONGEST, 0).decode(errors="replace")
            if not is_still(descriptor, path) or (said and f" on {socket.gethostname()}, " not in said):
                return
            if not said:  # one that is being made, whose job goes on, or was killed in the midst of it
                path.unlink()
                return
            remove_session(said)
            match = _LOCK.fullmatch(said)
            # a later mpiexec that has the number of the killed one has a job of the same number, and memory of the same names
            goes_on = job != own and match is not None and _is_running(match[3])
            if job != own and not goes_on:
                _remove_shared(job)
            if match is None or not (goes_on or os.path.lexists(match[2])):
                path.unlink()
    finally:
        os.close(descriptor)


def _is_running(number: str) -> bool:
    """Whether there is a process of this number; not, without /proc."""
    return os.path.exists(f"/proc/{number}")


def _remove_shared(job: str) -> None:
    """The shared memory of a job that is no more."""
    for word, elsewhere in _SHARED.items():
        for path in Path(os.environ.get(elsewhere, "/dev/shm")).glob(f"{word}.*.{job}.*"):
            with suppress(OSError):
                if path.lstat().st_uid == os.getuid():
                    path.unlink()


def release_names(comm: MPI.Comm) -> None:
    """Remove the names of this job's shared memory, if all ranks have mapped what there is; for a process of the program's own.

    Collective; nothing happens with another MPI.
    """
    found, this = _mapped(), os.environ.get(_ON_NODE)  # without mpiexec: of this process alone
    own = [path for path, number in found.items() if this is None or number == this]
    everybody = comm.allgather((len(own), len(found)))
    if any(entry != (1, comm.size) for entry in everybody):  # among them: ranks on several nodes
        return
    with suppress(OSError):
        os.unlink(own[0])
        if "/vader_segment." in own[0]:
            atexit.register(_put_back, own[0])  # before MPI ends, which takes the name away


def _mapped() -> dict[str, str]:
    """Files of shared memory that this process has mapped -> number of the rank on this node."""
    with suppress(OSError), open("/proc/self/maps") as file:
        found = (_SEGMENT.search(line.rstrip()) for line in file)
        return {match[0]: match[1] for match in found if match}
    return {}


def _put_back(path: str) -> None:
    with suppress(OSError):
        os.close(os.open(path, os.O_CREAT | os.O_WRONLY | os.O_EXCL, 0o600))


def session() -> str:
    """The folder of mpiexec's session, "" if there is none."""
    folders = (os.environ.get(name, "") for name in _KEPT)
    return next(filter(_SESSION.fullmatch, folders), "")


def whereabouts() -> str:
    """Who this is, in words that others can follow: process, host and, if that is short enough to say, session."""
    who = f"process {os.getpid()} on {socket.gethostname()}"
    more = f"{who}, session {session()}"
    return more if session() and len(more.encode()) <= LONGEST else who


def remove_session(said: str) -> None:
    """Remove the folder that a killed run has named, if it is such a one, this user's, and its mpiexec is gone.

    said: the run's lock, "process N on HOST, session FOLDER". Of another host, or without /proc, nothing is known, nor removed.
    """
    match = _LOCK.fullmatch(said.strip())
    if match is None or match[1] != socket.gethostname() or match[2] == session():
        return
    if not os.path.exists("/proc/self") or _is_running(match[3]):
        return
    with suppress(OSError):
        folder = Path(match[2])
        if not folder.is_symlink() and not folder.parent.is_symlink() and folder.stat().st_uid == os.getuid():
            shutil.rmtree(folder, ignore_errors=True)
