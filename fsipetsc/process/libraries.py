"""Libraries of kernels for all ranks: each text in C is compiled once, by one rank.

Ranks first agree who lacks which library, and go on in the same order: a rank that went its own way
would let the others wait for ever. What is compiled is sent as bytes, and a rank that lacks it
loads it from a file of its own, so that no file system has to show a new file in time.
"""

import ctypes
import time
from collections.abc import Callable, Sequence

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
    lacking = comm.allgather(sorted(filter(build.lacks, text_of)))
    # name -> the rank that compiles it: the lowest one that lacks it
    makers = {name: k for k, some in reversed([*enumerate(lacking)]) for name in some}
    for name, text in text_of.items() if keeps_text and comm.rank == 0 else ():
        says(f"C text of kernels: {build.keep(name.replace('.so', '.c'), text.encode())}")
    if makers:
        begin, mine = time.monotonic(), [name for name, k in makers.items() if k == comm.rank]
        says(f"compiling the kernels of this case (libraries: {len(makers)})")
        # asleep: who compiles may have this rank's core
        made = together(comm, lambda: build.made([text_of[n] for n in mine]), asleep=True)
        says(f"compiled in {time.monotonic() - begin:.1f} s")
        for name, library in zip(mine, made):
            build.keep(name, library)
        for of_rank in comm.allgather(dict(zip(mine, made))):
            sent.update(of_rank)
    return together(comm, lambda: [build.loaded(name, sent) for name in names])
