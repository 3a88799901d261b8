"""Standard streams that are closed, full or read by nobody: what is computed matters more than the lines about it."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO


def complete_streams() -> None:
    """Open /dev/null where one of the three standard streams is closed, so that no file of ours gets its number."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(number)
    for name, stream in (("stdout", sys.stdout), ("stderr", sys.stderr)):
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal that lacks a letter must not end a run


def abandon_stdout() -> None:
    """Let everything that is still to be printed, by C code too, go nowhere."""
    _abandon(1)


def _abandon(number: int) -> None:
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, number)
        os.close(null)


def say_error(text: str, end: str = "\n") -> None:
    """A line on stderr, if that is possible."""
    try:
        print(text, end=end, file=sys.stderr, flush=True)
    except (OSError, ValueError):
        # the stream still holds the line: Python 3.13 writes it at the end, and has 120 for a status if it cannot
        with contextlib.suppress(OSError, ValueError):
            if sys.stderr.fileno() == 2:
                _abandon(2)


class _Heedless:
    """A text stream that goes on where nothing can be written any more, and says so once on stderr."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._lost = stream, False

    def write(self, text: str) -> int:
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        self._attempt(self._stream.flush)

    def _attempt(self, action: Any) -> None:
        if self._lost:
            return
        try:
            action()
        except (OSError, ValueError) as error:
            self._lost = True
            abandon_stdout()
            if not isinstance(error, BrokenPipeError):  # a reader that has seen enough, such as head, wants no more words
                reason = getattr(error, "strerror", None) or error
                say_error(f"fsipetsc: nothing can be printed any more ({reason}); the computation goes on")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def heedless() -> Iterator[None]:
    """Within, what cannot be printed is no error."""
    stream = sys.stdout
    sys.stdout = _Heedless(stream)
    try:
        yield
        sys.stdout.flush()
    finally:
        sys.stdout = stream
