"""A run that is killed again and again, and goes on each time on another number of ranks, ends like
one that was left alone.

The run signals itself or its mpiexec at named places (signalled_program.py), so each cycle can be
made again. `cycles` is called by tests/test_kills.py, and, many times, by scripts/soak:
kill_cycles.py rod|blast KILLS [SEED].
"""

from __future__ import annotations

import json
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from helpers import PATIENCE, REPOSITORY, mpirun, solve

import fsipetsc
from fsipetsc.errors import FileError
from fsipetsc.output.lock import Lock

PROGRAM = REPOSITORY / "tests" / "signalled_program.py"
#: case and options; steps from one checkpoint to the next
RUNS = {
    "rod": ("rod -fsi_h 0.05 -ts_max_time 0.9 -fsi_output_dt 0.01", 40),
    "blast": ("blast -fsi_h 0.125 -fsi_order 2 -ts_max_time 4 -fsi_output_dt 0.04", 4),
}
PLACES = "frame", "fill", "piece", "checkpoint", "begin", "begun"
#: of places that are reached a few times only
FIRST = "begin", "begun"
KILL, TERM, INT = signal.SIGKILL, signal.SIGTERM, signal.SIGINT


def at_random(chance: random.Random, number: int) -> tuple[int, list]:
    """(ranks, place) of kill number 0, 1 …: SIGKILL most of the times; a minus: to mpiexec."""
    ranks, place = (
        chance.randint(1, 3),
        chance.choice(PLACES) if number else "checkpoint",
    )  # else there is nothing to take over
    rank = chance.randrange(ranks) if place in ("frame", "fill") else 0
    count = 1 if place in FIRST else chance.randint(2, 4)
    return ranks, [
        place,
        count,
        rank,
        chance.choice((KILL, KILL, KILL, TERM, INT)) * chance.choice((1, 1, 1, -1)),
    ]


def wait_for_the_end(folder: Path) -> None:
    """Of the ranks whose mpiexec was killed: the lock is free."""
    end = time.monotonic() + PATIENCE
    while (folder / "run.parts").exists():
        try:
            return Lock(folder / "run.parts", "run.h5").release(
                remove=not (folder / "run.parts/header.json").exists()
            )
        except FileError:
            assert time.monotonic() < end, "ranks are left"
            time.sleep(0.05)


def killed(folder: Path, words: list[str], ranks: int, place: list) -> str:
    """Let the run be killed there; what was done, and what the result has then."""
    done = mpirun(ranks, PROGRAM, json.dumps([place]), *words, cwd=folder)
    wait_for_the_end(folder)
    if not (folder / "run.h5").exists() and not (folder / "run.parts/header.json").exists():
        return f"{ranks} ranks, {place}: no result yet"
    with fsipetsc.open_run(folder / "run.h5") as result:
        reached = len(result.series.get("t", ()))
        assert all(
            layer[name].shape[0] == result.nframes
            for layer in result.layers
            for name in layer.fields
        )
        assert done.returncode != 0 or place[3] < 0, f"{place} was not reached: {done.stderr}"
        ended = f"{ranks} ranks, {place}, status {done.returncode}"
        return f"{ended}: {result.nframes} frames, {reached} steps"


def cycles(folder: Path, case: str, kills: list[tuple[int, list]]) -> list[str]:
    """Kill a run at all these places, let it end, and compare; what was done. AssertionError."""
    from test_restart import different

    line, steps = RUNS[case]
    words = [*line.split(), "-fsi_quiet", "-fsi_output", "run.h5"]
    whole = solve(*words[:-1], "whole.h5", cwd=folder)
    assert whole.returncode == 0, whole.stderr
    words += ["-fsi_restart", "auto", "-fsi_checkpoint_steps", str(steps)]
    said = [killed(folder, words, *kill) for kill in kills]
    last = solve(*words, cwd=folder)
    assert last.returncode == 0, last.stderr
    found = different(folder / "whole.h5", folder / "run.h5", same_ranks=False)
    assert found == [], (found, said)
    left = {path.name for path in folder.iterdir() if path.suffix != ".xdmf"}
    assert left == {"whole.h5", "run.h5", "run.checkpoint.h5"}, left
    return said


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        name, count, seed = sys.argv[1], int(sys.argv[2]), int((sys.argv[3:] or ["1"])[0])
        chance = random.Random(seed)
        chosen = [at_random(chance, number) for number in range(count)]
        print(json.dumps(cycles(Path(place), name, chosen), indent=1))
        print(
            Counter(
                f"{where[0]} {signal.Signals(abs(where[3])).name} "
                f"to {'mpiexec' if where[3] < 0 else 'a rank'}"
                for _, where in chosen
            )
        )
