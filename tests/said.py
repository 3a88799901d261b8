"""What the program says of an error: one message, and before it the traceback of a user's function, if that has failed."""

from __future__ import annotations

import re

#: a traceback of the program's own begins in it
_ITS_OWN = re.compile(r'  File "[^"]*(/fsipetsc/(?!cases/)|/bin/fsipetsc)')


def parted(said: str) -> tuple[str, str]:
    """(traceback of a user's function or "", the rest); AssertionError for more than one, or one that begins elsewhere."""
    headline = "Traceback (most recent call last):\n"
    if headline not in said:
        return "", said
    assert said.count(headline) == 1, said
    before, rest = said.split(headline)
    lines = rest.splitlines(keepends=True)
    end = next(k for k, line in enumerate(lines) if line.startswith("fsipetsc: error: "))
    assert lines[0].startswith("  File ") and not _ITS_OWN.match(lines[0]), said
    assert lines[end - 1][0] != " ", said
    return "".join(lines[:end]), before + "".join(lines[end:])
