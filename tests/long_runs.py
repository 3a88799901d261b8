"""Long runs, looked at from outside while they go on: do they stay finite, and are memory and open files what they were?

Called by scripts/soak: long_runs.py [FACTOR], FACTOR times the length of the runs.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from helpers import environment

import fsipetsc

ROD = "rod", "-fsi_h", "0.05", "-fsi_output_dt", "0.1"
BLAST = "blast", "-fsi_h", "0.0625", "-fsi_output_dt", "0.2"
#: what is run, and to which time [s]
RUNS = (
    *((f"{ROD[0]}, {order}, {how}", (*ROD, "-fsi_order", str(order), *words), 30.0) for how, words in (
        ("projection, rigid", ()),
        ("conservative, stretched", ("-fsi_coupling", "conservative", "-fsi_mapping", "stretched")),
    ) for order in (2, 4, 6, 8)),
    *((f"{BLAST[0]}, {order}", (*BLAST, "-fsi_order", str(order)), 60.0) for order in (2, 4)),
)  # fmt: skip
#: seconds between two looks; bytes by which the memory may rise in the last two thirds; files that come and go
LOOKS, MOST, FEW = 0.5, 8 << 20, 3


def seen(pid: int) -> tuple[int, int] | None:
    """Bytes in memory and number of open files of a process; None if it has ended."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE"), len(os.listdir(f"/proc/{pid}/fd"))
    except (OSError, IndexError, ValueError):
        return None


def watched(words: tuple[str, ...], folder: Path) -> tuple[str, list[tuple[int, int]]]:
    """What a run says, and what was seen of it while it made steps. AssertionError where it fails."""
    output = folder / "run.h5"
    command = [sys.executable, "-m", "fsipetsc", *words, "-fsi_output", str(output)]
    alone = {"OMPI_MCA_ess_singleton_isolated": "1"}
    process = subprocess.Popen(
        command, cwd=folder, env=environment(alone), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    found, begun = [], 0  # bytes of a result that is no more than its beginning
    while process.poll() is None:
        now = seen(process.pid)
        size = output.stat().st_size if output.exists() else 0
        begun = begun or size
        if now is not None and size > begun:
            found.append(now)
        time.sleep(LOOKS)
    said = process.stdout.read().decode() if process.stdout else ""
    assert process.returncode == 0, said
    return said, found


def main(factor: float = 1.0) -> None:
    print("| run | t | steps | kept | energy of the last tenth, least to most | memory, MB | open files |")
    print("|---|---|---|---|---|---|---|")
    faults = []
    for name, words, end in RUNS:
        with tempfile.TemporaryDirectory(prefix="fsipetsc-long-") as place:
            said, looks = watched((*words, "-ts_max_time", str(factor * end)), Path(place))
            with fsipetsc.open_run(Path(place) / "run.h5") as run:
                finite = all(np.isfinite(layer.frame(-1)["T"]).sum() > 1 for layer in run.layers)
                finite = finite and bool(np.isfinite(run.series["energy"]).all())
                energy, steps, t = run.series["energy"], run.summary["steps"], run.summary["t"]
        kept = next((line.removeprefix("kept: ") for line in said.splitlines() if line.startswith("kept: ")), "")
        late = energy[-max(1, len(energy) // 10) :] / energy[0]
        settled = np.array(looks[len(looks) // 3 : -max(2, len(looks) // 10)])  # nor while it closes the file and ends
        memory, files = settled[:, 0], settled[:, 1]
        span = f"{memory.min() / 2**20:.0f} … {memory.max() / 2**20:.0f} | {files.min()} … {files.max()}"
        print(f"| {name} | {t:g} | {steps} | {kept} | {late.min():.6f} … {late.max():.6f} | {span} |", flush=True)
        part = max(1, len(files) // 3)
        more = np.median(files[-part:]) - np.median(files[:part])
        if not finite or memory.max() - memory[0] > MOST or more > FEW:
            faults.append(name)
    if faults:
        sys.exit(f"not finite, or not as much memory and as many files as before: {'; '.join(faults)}")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
