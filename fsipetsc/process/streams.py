"""Standard streams that nobody reads: what is computed matters more than lines."""

import contextlib
import os
import sys


def replace_letters() -> None:
    """Letters that a terminal lacks are printed as question marks, and end no run."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def abandon(number: int) -> None:
    """Let everything still to be printed on stream 1 or 2, by C code too, go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, number)
        os.close(null)


def say(text: str) -> None:
    """Print a line of a run; where nothing can be printed any more, the run goes on in silence."""
    try:
        print(text, flush=True)
    except OSError:  # the reader, such as head, has seen enough; or the disk is full
        abandon(1)


def say_error(text: str) -> None:
    """A line on stderr, if that is possible."""
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError):
        abandon(2)
