"""A run that is killed again and again, and goes on each time on another number of ranks, ends like
one that was left alone.

The run signals itself or its mpiexec at named places (signalled_program.py), so each cycle can be
made again. tests/test_kills.py calls `cycles`; so does scripts/soak, many times:
kill_cycles.py rod|blast KILLS [SEED].
"""

import fcntl
import json
import random
import signal
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from helpers import REPOSITORY, computed, different, mpirun

import fsipetsc

PROGRAM = REPOSITORY / "tests" / "signalled_program.py"
#: case and options; steps from one checkpoint to the next
RUNS = {
    "rod": ("rod -fsi_coupling projection -fsi_h 0.05 -ts_max_time 0.9 -fsi_output_dt 0.01", 40),
    "blast": ("blast -fsi_h 0.125 -fsi_order 2 -ts_max_time 4 -fsi_output_dt 0.04", 4),
}
#: said where a run ended before the place: after a signal to mpiexec fast machines make many steps
AT_END = "the run ended before"
PLACES = "frame", "fill", "piece", "checkpoint", "begin", "begun"
KILL, TERM, INT = signal.SIGKILL, signal.SIGTERM, signal.SIGINT


def at_random(chance: random.Random, number: int) -> tuple[int, list]:
    """(ranks, place) of kill number 0, 1 …: SIGKILL most of the times; a minus: to mpiexec."""
    ranks = chance.randint(1, 3)
    place = chance.choice(PLACES) if number else "checkpoint"  # else there is nothing to take over
    rank = chance.randrange(ranks) if place in ("frame", "fill") else 0
    count = 1 if place in ("begin", "begun") else chance.randint(2, 4)
    sent = chance.choice((KILL, KILL, KILL, TERM, INT)) * chance.choice((1, 1, 1, -1))
    return ranks, [place, count, rank, sent]


def killed(folder: Path, words: list[str], ranks: int, place: list) -> str:
    """Let the run be killed there; what was done, and what the result has then."""
    done = mpirun(ranks, PROGRAM, json.dumps([place]), *words, cwd=folder)
    # ranks whose mpiexec was killed may still run: they have the lock
    with suppress(FileNotFoundError), (folder / "run.parts" / "lock").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
    ended = f"{ranks} ranks, {place}, status {done.returncode}"
    if not (folder / "run.h5").exists() and not (folder / "run.parts/header.json").exists():
        return f"{ended}: no result yet"
    with fsipetsc.open_run(folder / "run.h5") as result:
        for layer in result.layers:
            assert all(layer[name].shape[0] == result.nframes for name in layer.fields)
        if not done.returncode and place[3] > 0:
            return f"{ended}: {AT_END}"
        return f"{ended}: {result.nframes} frames, {len(result.series.get('t', ()))} steps"


def cycles(folder: Path, case: str, kills: list[tuple[int, list]]) -> list[str]:
    """Kill a run at these places, let it end, compare; what was done, up to its end."""
    line, steps = RUNS[case]
    computed(folder, "whole.h5", *line.split())
    words = [*line.split(), "-fsi_restart", "auto", "-fsi_checkpoint_steps", str(steps)]
    said: list[str] = []
    for kill in kills:
        said.append(killed(folder, [*words, "-fsi_quiet", "-fsi_output", "run.h5"], *kill))
        if said[-1].endswith(AT_END):
            break
    computed(folder, "run.h5", *words)
    found = different(folder / "whole.h5", folder / "run.h5", same_ranks=False)
    assert found == [], (found, said)
    left = {path.name for path in folder.iterdir() if path.suffix != ".xdmf"}
    assert left == {"whole.h5", "run.h5", "run.checkpoint.h5"}, left
    return said


if __name__ == "__main__":
    name, count, seed = sys.argv[1], int(sys.argv[2]), int((sys.argv[3:] or ["1"])[0])
    chance = random.Random(seed)
    chosen = [at_random(chance, number) for number in range(count)]
    while chosen:  # in runs one after the other
        with tempfile.TemporaryDirectory() as place:
            done = cycles(Path(place), name, chosen)
        print(json.dumps(done, indent=1))
        chosen = chosen[len(done) :]
