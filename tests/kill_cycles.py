"""A run that is killed again and again, and goes on each time on another number of ranks, ends like one that was left alone.

`cycles` is called by tests/test_kills.py, and, many times, by scripts/soak: kill_cycles.py rod|blast KILLS [SEED].
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from helpers import environment, run, solve

import fsipetsc

#: case and options: runs of some seconds
RUNS = {
    "rod": ("rod", "-ts_max_time", "3", "-fsi_output_dt", "0.02"),
    "blast": ("blast", "-fsi_h", "0.0625", "-fsi_order", "2", "-ts_max_time", "60", "-fsi_output_dt", "0.2"),
}
#: wall time between checkpoints: many kills come in the middle of one
INTERVAL = 0.05
RANKS = 1, 2, 3, 4
PATIENCE = 1800.0


def descendants(pid: int) -> list[int]:
    """The processes that a process has started, and theirs."""
    parents: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            parents.setdefault(int(fields[1]), []).append(int(entry.name))
    found, waiting = [], [pid]
    while waiting:
        for child in parents.get(waiting.pop(), ()):
            found.append(child)
            waiting.append(child)
    return found


def ranks_of(pid: int, output: Path) -> list[int]:
    """Those of the descendants that compute."""
    found = []
    for child in descendants(pid):
        try:
            words = Path(f"/proc/{child}/cmdline").read_bytes()
        except OSError:
            continue
        if str(output).encode() in words and b"mpiexec" not in words.split(b"\0")[0]:
            found.append(child)
    return found


def alive(pids: list[int]) -> list[int]:
    """Those that are still there, and no zombies."""
    found = []
    for pid in pids:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if state not in "ZX":
            found.append(pid)
    return found


def killed_once(words: list[str], ranks: int, folder: Path, chance: random.Random) -> str:
    """Start a run, kill it at some moment; what was killed, or "ended" if it had come to its end before."""
    output, checkpoint = folder / "run.h5", folder / "run.checkpoint.h5"
    before = checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
    command = ["mpiexec", "-n", str(ranks), sys.executable, "-m", "fsipetsc", *words, "-fsi_output", str(output)]
    none = subprocess.DEVNULL
    process = subprocess.Popen(command, cwd=folder, env=environment(), stdin=none, stdout=none, stderr=none)
    early = chance.random() < 0.15  # while it starts
    end, everybody = time.monotonic() + (chance.uniform(0.3, 3.0) if early else PATIENCE), []
    while process.poll() is None and time.monotonic() < end:
        if checkpoint.exists() and checkpoint.stat().st_mtime_ns != before:
            time.sleep(chance.uniform(0.0, 4 * INTERVAL))
            break
        time.sleep(0.002)
    computing = ranks_of(process.pid, output)
    everybody = [process.pid, *descendants(process.pid)]
    which = chance.choice(("one rank", "all ranks", "all and the launcher")) if computing else "the launcher"
    victims = {"one rank": computing[-1:], "all ranks": computing}.get(which, [process.pid, *computing])
    if process.poll() is not None:
        assert process.returncode == 0, f"ended with status {process.returncode} on {ranks} ranks"
        return "ended"
    for pid in victims:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    try:
        process.wait(PATIENCE)
    finally:
        process.kill()
    end = time.monotonic() + PATIENCE
    while (left := alive(everybody)) and time.monotonic() < end:
        time.sleep(0.01)
    assert not left, f"{which} killed, and half an hour later there is {left}"
    return f"{which}{' at the start' if early else ''}"


def cycles(folder: Path, case: str, kills: int, seed: int) -> list[str]:
    """Kill a run so many times, let it end, and compare; what was killed. AssertionError."""
    from test_restart import differences

    chance, words = random.Random(seed), [*RUNS[case], "-fsi_quiet"]
    whole = solve(*words, "-fsi_output", folder / "whole.h5", cwd=folder)
    assert whole.returncode == 0, whole.stderr
    words += ["-fsi_restart", "auto", "-fsi_checkpoint_wall", str(INTERVAL)]
    said = killed(folder, words, kills, chance)
    last = run("-m", "fsipetsc", *words, "-fsi_output", folder / "run.h5", cwd=folder)
    assert last.returncode == 0, last.stderr
    assert differences(folder / "whole.h5", folder / "run.h5", same_ranks=False) == []
    left = {path.name for path in folder.iterdir()} - {"whole.h5", "run.h5", "run.checkpoint.h5", "run.checkpoint.previous.h5"}
    assert not {name for name in left if not name.endswith(".xdmf")}, left
    return said


def killed(folder: Path, words: list[str], kills: int, chance: random.Random) -> list[str]:
    """Kill it so many times; what was killed, and what the result had then."""
    said: list[str] = []
    while len(said) < kills:
        ranks = chance.choice(RANKS)
        how = killed_once(words, ranks, folder, chance)
        assert how != "ended", f"the run was over after {len(said)} kills: {said}"
        if (folder / "run.h5").exists() or (folder / "run.parts/header.json").exists():
            with fsipetsc.open_run(folder / "run.h5") as result:
                reached = result.series["t"][-1] if result.series else 0.0
                said.append(f"{ranks} ranks, {how}: the result has {result.nframes} frames, and steps to t = {reached:.4g}")
        else:
            said.append(f"{ranks} ranks, {how}: no result yet")
        if len(said) % 5 == 0:
            print(said[-1], flush=True)
    return said


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        name, count, seed = sys.argv[1], int(sys.argv[2]), int((sys.argv[3:] or ["1"])[0])
        print(json.dumps(cycles(Path(place), name, count, seed), indent=1))
