"""Libraries of kernels for all ranks: each text in C is compiled once, by one rank.

Ranks first agree who lacks which library, and go on in the same order: a rank that went its own way
would let the others wait for ever. What is compiled is sent as bytes, and a rank that lacks it
loads it from a file of its own, so that no file system has to show a new file in time.
"""

import ctypes
import os
import tempfile
import time
from collections.abc import Callable, Sequence
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
    says = announce if comm.rank == 0 else lambda text: None
    names = together(comm, lambda: [build.name_of(text) for text in texts])
    text_of, sent = dict(zip(names, texts, strict=True)), dict[str, bytes]()
    lacking = comm.allgather(sorted({name for name in names if build.kept(name) is None}))
    # name -> the rank that compiles it: the lowest one that lacks it
    makers = {name: k for k, some in reversed([*enumerate(lacking)]) for name in some}
    for name, text in text_of.items() if keeps_text and comm.rank == 0 else ():
        says(f"C text of kernels: {build.keep(name.replace('.so', '.c'), text.encode())}")
    if makers:
        begin, mine = time.monotonic(), [name for name, k in makers.items() if k == comm.rank]
        says(f"compiling the kernels of this case (libraries: {len(makers)})")
        # asleep: who compiles may have this rank's core
        made = together(comm, lambda: _made([(name, text_of[name]) for name in mine]), asleep=True)
        says(f"compiled in {time.monotonic() - begin:.1f} s")
        sent = {name: library for of_rank in comm.allgather(made) for name, library in of_rank}
    return together(comm, lambda: [_loaded(name, sent) for name in names])


def _made(texts: Sequence[tuple[str, str]]) -> list[tuple[str, bytes]]:
    """Return libraries of texts, all with names, and keep them. If one fails, or a signal comes,
    nothing waits for the others.
    """
    pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))  # threads that wait for compilers
    try:
        made = [(name, pool.submit(build.made, text)) for name, text in texts]
        found = [(name, library.result()) for name, library in made]
    except BaseException:
        build.end_compilers()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    for name, library in found:
        build.keep(name, library)
    return found


def _loaded(name: str, sent: dict[str, bytes]) -> ctypes.CDLL:
    """Return a library that is kept in a file, or was sent as bytes. FileError."""
    path = build.kept(name)
    if path is not None:
        return build.loaded(path)
    try:
        with tempfile.NamedTemporaryFile(prefix="fsipetsc-", suffix=".so") as file:
            file.write(sent[name])
            file.flush()
            return ctypes.CDLL(file.name)
    except OSError as error:
        raise FileError(f"compiled kernels cannot be loaded: {error}") from error
