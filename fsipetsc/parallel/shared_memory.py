"""How all ranks meet: by a reduction of MPI's or, if they share a node, in shared memory. Compiled, but for ``Mailboxes``.

In a window of MPI's each rank has a mailbox: a count of the turns that it has made, and two buffers. In a turn a rank fills
the buffer of the turn, counts it, waits until all have counted it, and reads what the others have filled in. It writes to
that buffer again two turns later: then all have counted the turn between, and have read before.

A count is set with release and read with acquire semantics, so that what was filled in before it is seen behind it, on any
processor. On x86 every store and load has them: there no test can tell whether the words say so, on ARM and POWER they must.
"""

from __future__ import annotations

import os

import numpy as np
from mpi4py import MPI
from numba import njit

from fsipetsc.operators.kernels import OPTIONS
from fsipetsc.parallel.mpi import handle, mpi_allreduce, mpi_iprobe, sched_yield
from fsipetsc.parallel.pointers import load_acquire, store_release, words_at

#: bytes of a cache line: count and buffers lie on different ones
LINE = 64
#: a rank reads all mailboxes, one after the other: with more ranks a reduction, which is a tree, is faster
MOST = 16
#: bytes that a window takes beyond those of its ranks, with plenty of room
BESIDE = 1 << 18
#: looks at a count before MPI may work and the processor is offered to others, where there are more ranks than processors;
#: and else: who offers it to another program waits for all of that one's time slice
FEW_LOOKS, MANY_LOOKS = 1000, 1_000_000


#: what compiled code needs to meet; without mailboxes their address is 0. The constants of MPI are among it, since kernels that
#: one library's constants had become part of would be found on disk by a run with another library
_NAMES = (
    *("comm", "rank", "size", "word", "max", "any_source", "any_tag"),
    *("mailboxes", "mailbox", "buffer", "patience", "flag", "status"),
)
WORLD = np.dtype([(name, np.int64) for name in _NAMES])


class Mailboxes:
    """The mailboxes of all ranks of comm, with buffers of ``nbytes``. Collective, as is ``free``.

    Raises MPI.Exception, on all ranks, where MPI has no memory that they could share.
    """

    def __init__(self, comm: MPI.Comm, nbytes: int) -> None:
        self.buffer = -(-nbytes // LINE) * LINE
        self.mailbox = LINE + 2 * self.buffer
        # all in the part of rank 0, so that they lie one after the other
        self._window = shared_window(comm, (comm.size * self.mailbox + LINE) if comm.rank == 0 else 0)
        memory, _ = self._window.Shared_query(0)
        self.address = -(-memory.address // LINE) * LINE
        if comm.rank == 0:
            np.frombuffer(memory, np.uint8)[:] = 0
        processors = set().union(*comm.allgather(_processors()))  # all have reached this: the mailboxes are clean
        self.patience = MANY_LOOKS if len(processors) >= comm.size else FEW_LOOKS
        self.flag, self.status = np.zeros(1, np.int32), np.zeros(MPI._sizeof(MPI.Status), np.uint8)  # of probes

    def part(self, rank: int) -> int:
        """Address of the buffer of a rank in even turns; in odd ones it is ``buffer`` bytes further."""
        return self.address + rank * self.mailbox + LINE

    def free(self) -> None:
        self._window.Unlock_all()
        self._window.Free()


def shared_window(comm: MPI.Comm, size: int) -> MPI.Win:
    """Memory that all ranks of comm share, in an epoch in which they may read and write it. Collective.

    size: bytes of this rank's part. Raises MPI.Exception on all ranks if one of them cannot have it: some installations
    have no such windows, there may be no room, and what a rank writes must be what the others read (MPI's unified model).
    """
    if not all(comm.allgather(free_space() >= size + BESIDE)):
        raise MPI.Exception(MPI.ERR_NO_MEM)
    window, error = MPI.WIN_NULL, 0
    try:
        window = MPI.Win.Allocate_shared(size, 1, comm=comm)
        if not unified(window):
            error = MPI.ERR_RMA_SHARED
    except MPI.Exception as exception:
        error = exception.Get_error_code()
    errors = comm.allgather((error, window != MPI.WIN_NULL))
    if any(error for error, _ in errors):
        if all(made for _, made in errors):
            window.Free()
        raise MPI.Exception(next(error for error, _ in errors if error))
    window.Lock_all(MPI.MODE_NOCHECK)
    return window


def free_space() -> float:
    """Bytes left where windows are made on Linux; infinite where that is not known.

    Open MPI 4.1 looks, too, but on one rank only, which returns with an error while the others wait for it.
    """
    try:
        place = os.statvfs(os.environ.get("OMPI_MCA_osc_sm_backing_directory", "/dev/shm"))
    except OSError:
        return np.inf
    return place.f_bavail * place.f_frsize


def unified(window: MPI.Win) -> bool:
    """There is one copy of the window's memory, not one for its owner and one for all others."""
    return window.Get_attr(MPI.WIN_MODEL) == MPI.WIN_UNIFIED


def world_record(comm: MPI.Comm, mailboxes: Mailboxes | None) -> np.ndarray:
    """The ranks of comm as compiled code sees them."""
    record = np.zeros(1, WORLD)
    record["comm"], record["rank"], record["size"] = handle(comm), comm.rank, comm.size
    record["word"], record["max"] = handle(MPI.UINT64_T), handle(MPI.MAX)
    record["any_source"], record["any_tag"] = MPI.ANY_SOURCE, MPI.ANY_TAG
    if mailboxes is not None:
        record["mailboxes"], record["mailbox"], record["buffer"] = mailboxes.address, mailboxes.mailbox, mailboxes.buffer
        record["patience"] = mailboxes.patience
        record["flag"], record["status"] = mailboxes.flag.ctypes.data, mailboxes.status.ctypes.data
    return record


def _processors() -> set[int]:
    """Those that this rank may run on."""
    try:
        return os.sched_getaffinity(0)
    except AttributeError:  # not Linux
        return set(range(os.cpu_count() or 1))


def make_mailboxes(comm: MPI.Comm, nbytes: int) -> Mailboxes | None:
    """Mailboxes with buffers of ``nbytes`` where the ranks can have them; None, on all of them, where not. Collective."""
    if not share_a_node(comm):
        return None
    try:
        return Mailboxes(comm, nbytes)
    except MPI.Exception:
        return None


def share_a_node(comm: MPI.Comm) -> bool:
    """All ranks can reach the same memory, and are few. Collective."""
    if not 1 < comm.size <= MOST:
        return False
    node = comm.Split_type(MPI.COMM_TYPE_SHARED, comm.rank)
    together = node.size == comm.size
    node.Free()
    return together


@njit(**OPTIONS)
def next_turn(world):
    """Number of the turn that comes; 0 without mailboxes."""
    return load_acquire(world.mailboxes + world.rank * world.mailbox) + 1 if world.mailboxes != 0 else 0


@njit(**OPTIONS)
def largest(world, source, result, count):
    """The largest of each of ``count`` 64-bit words over all ranks, exactly; addresses. Collective, one turn of mailboxes."""
    if world.mailboxes == 0:
        mpi_allreduce(source, result, count, world.word, world.max, world.comm)
        return
    turn, mine = next_turn(world), world.mailboxes + world.rank * world.mailbox
    buffer = LINE + (turn & 1) * world.buffer
    words, given, found = words_at(mine + buffer, count), words_at(source, count), words_at(result, count)
    for i in range(count):
        words[i] = found[i] = given[i]
    store_release(mine, turn)
    for rank in range(world.size):
        mailbox, looks = world.mailboxes + rank * world.mailbox, 0
        while load_acquire(mailbox) < turn:
            looks += 1
            if looks > world.patience:
                # whoever is late may need what MPI has not yet sent in our name, and it sends in calls only
                mpi_iprobe(world.any_source, world.any_tag, world.comm, world.flag, world.status)
                sched_yield()
        words = words_at(mailbox + buffer, count)
        for i in range(count):
            found[i] = max(found[i], words[i])
