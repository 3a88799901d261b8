"""Standard streams that nobody reads: what is computed matters more than lines."""

import contextlib
import os
import sys


def complete_streams() -> None:
    """Open /dev/null where a standard stream is closed, so that no file of ours gets its number."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(number)
    for name, stream in (("stdout", sys.stdout), ("stderr", sys.stderr)):
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a letter that a terminal lacks ends no run


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
    except OSError as error:
        abandon(1)
        if not isinstance(error, BrokenPipeError):  # a reader that has seen enough, such as head
            say_error(f"fsipetsc: nothing can be printed ({error.strerror}); the run goes on")


def say_error(text: str) -> None:
    """A line on stderr, if that is possible."""
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError):
        abandon(2)
