"""What the command ``bench`` measures around the time steps: output, start of the program, memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from mpi4py import MPI

from fsipetsc.bench.measure import spacing
from fsipetsc.output.reader import open_run
from fsipetsc.stepping.phases import LOOP, OUTPUT
from fsipetsc.stepping.run import run_case

#: variables that tell a process that it belongs to a parallel run
_OF_MPI = ("OMPI_", "PMIX_", "PMI_", "HYDRA_", "MPI_", "SLURM_", "PRTE_")
#: runs a program and says its status, times and largest resident set. In between, because a process is born with the
#: largest resident set of the one that starts it.
_LAUNCHER = """
import resource, subprocess, sys, time
begun = time.perf_counter()
status = subprocess.call(sys.argv[1:], stdout=subprocess.DEVNULL)
wall, used = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
print(status, wall, used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


def output_share(case: Any, opt: Mapping[str, Any], comm: MPI.Comm, runs: int) -> float:
    """How much of a run, in percent of the time loop and what follows it, goes into output; median. Collective."""
    folder = tempfile.mkdtemp() if comm.rank == 0 else None
    path = Path(comm.bcast(folder)) / "run.h5"
    shares = []
    for _ in range(runs):
        run_case(case, {**opt, "fsi_quiet": True, "fsi_output": str(path)}, comm)
        if comm.rank == 0:
            with open_run(path) as run:
                spent = run.summary["phases"]
            shares.append(100 * spent[OUTPUT] / (spent[OUTPUT] + spent[LOOP]))
            path.unlink()
    if comm.rank == 0:
        path.parent.rmdir()
    return comm.bcast(median(shares) if shares else None)


class Cost(NamedTuple):
    """Of a whole process: wall time [s], processor time [s], largest resident set [bytes]."""

    wall: float
    cpu: float
    memory: int


def start_costs(repeats: int) -> dict[str, Cost]:
    """Of the usage, of a run of one step, and of that with no kernel compiled before; medians but for the last.

    Not collective; other processes of this machine should be at rest.
    """
    with tempfile.TemporaryDirectory() as folder:
        one_step = ("rod", "-ts_max_steps", "1", "-fsi_quiet", "-fsi_output", f"{folder}/run.h5")
        _process(one_step)  # so that the kernels are there
        return {
            "usage": _medians([_process(()) for _ in range(repeats)]),
            "one step": _medians([_process(one_step) for _ in range(repeats)]),
            "first run": _process(one_step, {"NUMBA_CACHE_DIR": f"{folder}/kernels"}),
        }


def _medians(costs: Sequence[Cost]) -> Cost:
    return Cost(*map(median, zip(*costs)))


def doubles_per_point(sizes: tuple[int, int] = (100_000, 1_000_000)) -> float:
    """Memory of a run with its first and last frame, per point: the growth of the largest resident set, in doubles."""
    with tempfile.TemporaryDirectory() as folder:
        used = []
        for points in sizes:
            words = ("rod", "-ts_max_steps", "2", "-fsi_quiet", "-fsi_output", f"{folder}/{points}.h5")
            used.append(_process((*words, "-fsi_h", repr(spacing(points)))).memory)
    return (used[1] - used[0]) / 8 / (sizes[1] - sizes[0])


def _process(words: tuple[str, ...], extra: Mapping[str, str] | None = None) -> Cost:
    """Cost of the program with these arguments, on one rank."""
    env = {name: value for name, value in os.environ.items() if not name.startswith(_OF_MPI)}
    kept = {name: value for name, value in os.environ.items() if name.startswith("OMPI_ALLOW_RUN_AS_ROOT")}
    package = str(Path(__file__).resolve().parents[2])
    env.update(kept, PYTHONPATH=os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH")))), **(extra or {}))
    command = [sys.executable, "-c", _LAUNCHER, sys.executable, "-m", "fsipetsc", *words]
    found = subprocess.run(command, env=env, stdout=subprocess.PIPE, check=True, text=True).stdout.split()
    if int(found[0]):
        raise RuntimeError(f"{' '.join(words)} ended with status {found[0]}")
    wall, cpu, largest = map(float, found[1:])
    return Cost(wall, cpu, int(largest) * (1 if sys.platform == "darwin" else 1024))
