"""Libraries of kernels for all ranks: each text in C is compiled once, by one rank.

Ranks first agree who lacks which library, and go on in the same order: a rank that went its own way
would let the others wait for ever. What is compiled is sent as bytes, and a rank that lacks it
loads it from a file of its own, so that no file system has to show a new file in time.
"""

import ctypes
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

from fsipetsc.errors import FileError
from fsipetsc.kernels import build
from fsipetsc.process.together import Comm, together

#: whether the first rank keeps the texts, too, and says where (-fsi_debug)
keeps_text = False


def libraries(
    comm: Comm, texts: Sequence[str], announce: Callable[[str], None] = lambda text: None
) -> list[ctypes.CDLL]:
    """Return the libraries of this rank's texts. Collective, though ranks may have other texts.

    announce: called on rank 0 before and after somebody compiles. InputError where there is no
    compiler, or it fails; FileError.
    """
    build.tells = comm.rank == 0
    names = together(comm, lambda: [build.name_of(text) for text in texts])
    lacking = comm.allgather(sorted({name for name in names if build.kept(name) is None}))
    # name -> the rank that compiles it: the lowest one that lacks it
    makers = {name: k for k, some in reversed([*enumerate(lacking)]) for name in some}
    if keeps_text and comm.rank == 0:
        for name, text in zip(names, texts, strict=True):
            kept = build.keep(name.replace(".so", ".c"), text.encode())
            announce(f"C text of kernels: {kept}")
    sent = _made(comm, dict(zip(names, texts, strict=True)), makers, announce) if makers else {}
    return together(comm, lambda: [_loaded(name, sent) for name in names])


def _made(
    comm: Comm, texts: dict[str, str], makers: dict[str, int], announce: Callable[[str], None]
) -> dict[str, bytes]:
    """Return the bytes of all libraries that some rank lacks, on all ranks. Collective."""
    begin = time.monotonic()
    if comm.rank == 0:
        announce(f"compiling the kernels of this case (libraries: {len(makers)})")

    def make() -> dict[str, bytes]:
        mine = [name for name, rank in makers.items() if rank == comm.rank]
        made = dict(zip(mine, _side_by_side([texts[name] for name in mine])))
        for name, library in made.items():
            build.keep(name, library)
        return made

    mine = together(comm, make, asleep=True)  # who compiles may have this rank's core
    if comm.rank == 0:
        announce(f"compiled in {time.monotonic() - begin:.1f} s")
    return {name: library for of_rank in comm.allgather(mine) for name, library in of_rank.items()}


def _side_by_side(texts: Sequence[str]) -> Iterator[bytes]:
    """Yield libraries of texts. If one fails, or a signal comes, nothing waits for the others."""
    pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))  # threads that wait for compilers
    try:
        yield from pool.map(build.made, texts)
    except BaseException:
        build.end_compilers()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _loaded(name: str, sent: dict[str, bytes]) -> ctypes.CDLL:
    """Return a library that is kept in a file, or was sent as bytes. FileError."""
    path = build.kept(name)
    if path is not None:
        return build.loaded(path)
    handle, own = tempfile.mkstemp(prefix="fsipetsc-", suffix=".so")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(sent[name])
        return ctypes.CDLL(own)
    except OSError as error:
        raise FileError(f"compiled kernels cannot be loaded from {own}: {error}") from error
    finally:
        os.unlink(own)
