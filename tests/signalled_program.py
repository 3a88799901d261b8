"""The command line in a process that signals itself at named places: PLACES WORDS...

PLACES: JSON, a list of [place, count, rank, number of the signal]: as the count-th frame is to be saved, with "frame"; when
half of the count-th checkpoint is written, with "checkpoint" (which rank 0 writes). So the order of what happens is certain.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections import Counter

from fsipetsc import cli
from fsipetsc.output import checkpoint_file
from fsipetsc.process.launch import launcher_rank
from fsipetsc.stepping import run

places, seen = json.loads(sys.argv.pop(1)), Counter()
frame, put = run._Run._frame, checkpoint_file._put


def reached(place: str) -> list[int]:
    """The signals that are to come here, this time."""
    seen[place] += 1
    return [number for name, count, rank, number in places if (name, count, rank) == (place, seen[place], launcher_rank())]


def frame_signalled(self: object, t: float) -> None:
    for number in reached("frame"):
        signal.raise_signal(number)
    frame(self, t)


def put_signalled(descriptor: int, content: bytes) -> None:
    for number in reached("checkpoint"):
        os.write(descriptor, content[: len(content) // 2])
        signal.raise_signal(number)
    put(descriptor, content)


run._Run._frame, checkpoint_file._put = frame_signalled, put_signalled
sys.exit(cli.main())
