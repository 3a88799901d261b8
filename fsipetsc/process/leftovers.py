"""Files of Open MPI's that a run which is killed (SIGKILL) would leave behind: shared memory, and the folder of a session.

Each rank has a file in /dev/shm (vader_segment…) through which others on its node write to it. Once all have mapped it, nobody
needs its name: it is removed, and the memory goes with the last process, however that ends. Open MPI complains where the name
is not there in the end, so an empty file takes its place for that moment.

mpiexec keeps a folder of its session (ompi.HOST.USER/pid.N), which it removes when it ends. If it is killed, too, nobody does;
the next run of the same result does, which knows from the lock of the killed one where it is (fsipetsc.output.claim).
"""

from __future__ import annotations

import atexit
import os
import re
import shutil
import socket
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mpi4py import MPI

_SEGMENT = re.compile(r"/\S*/vader_segment\.[^/\s]*\.(\d+)$")
_SESSION = re.compile(r"/\S+/ompi\.[^/\s]+/pid\.(\d+)")
_LOCK = re.compile(rf"process \d+ on ([^,\s]+), session ({_SESSION.pattern})")
_KEPT = "OMPI_MCA_orte_jobfam_session_dir"


def release_names(comm: MPI.Comm) -> None:
    """Remove the names of this job's shared memory, if all ranks have mapped what there is; for a process of the program's own.

    Collective; nothing happens with another MPI.
    """
    found = _mapped()
    own = [path for path, number in found.items() if number == os.environ.get("OMPI_COMM_WORLD_LOCAL_RANK")]
    everybody = comm.allgather((len(own), len(found)))
    if any(entry != (1, comm.size) for entry in everybody):  # among them: ranks on several nodes
        return
    with suppress(OSError):
        os.unlink(own[0])
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
    folder = os.environ.get(_KEPT, "")
    return folder if _SESSION.fullmatch(folder) else ""


def remove_session(said: str) -> None:
    """Remove the folder that a killed run has named, if it is such a one, this user's, and its mpiexec is gone.

    said: the run's lock, "process N on HOST, session FOLDER". Of another host, or without /proc, nothing is known, nor removed.
    """
    match = _LOCK.fullmatch(said.strip())
    if match is None or match[1] != socket.gethostname() or match[2] == session():
        return
    if not os.path.exists("/proc/self") or os.path.exists(f"/proc/{match[3]}"):
        return
    with suppress(OSError):
        folder = Path(match[2])
        if not folder.is_symlink() and not folder.parent.is_symlink() and folder.stat().st_uid == os.getuid():
            shutil.rmtree(folder, ignore_errors=True)
