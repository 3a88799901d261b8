"""What the program does as a process: its streams, and signals before a run heeds them. This module
is loaded first, so it imports nothing large.
"""

import contextlib
import os
import signal
import sys

#: where launchers tell a process its rank
_RANKS = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID")


def launcher_rank() -> int | None:
    """Return this process's rank as mpiexec tells it, for what needs no MPI; None without it."""
    found = (os.environ.get(name, "") for name in _RANKS)
    return next((int(text) for text in found if text.isdigit()), None)


def end_on_signals() -> None:
    """Let SIGINT and SIGTERM end the process with a line and the status 128 + signal, wherever it
    is: KeyboardInterrupt, raised while modules load, may come out of them as another error. A run
    heeds signals in its own way (fsipetsc.stepping.run). One that is ignored stays so.
    """

    def end(number: int, frame: object) -> None:
        for other in (signal.SIGINT, signal.SIGTERM):
            signal.signal(other, signal.SIG_DFL)
        with contextlib.suppress(OSError, ValueError, RuntimeError):  # nobody reads it
            if not launcher_rank():
                line = f"fsipetsc: error: stopped by {signal.Signals(number).name}\n"
                os.write(2, line.encode())
            sys.stdout.flush()
        os._exit(128 + number)

    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


def say(text: str) -> None:
    """Print a line of a run; where nothing can be printed any more, the run goes on in silence."""
    try:
        print(text, flush=True)
    except OSError:
        abandon_output()


def abandon_output() -> None:
    """Let everything still to be printed on stdout, by C code too, go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.close(null)
