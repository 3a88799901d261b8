"""Runs on disks that are full, read-only or in use, all in one process for each rank: prints what came of each as JSON.

Started in a folder of its own, by tests/test_disk.py; where the folders `tiny…` and `fixed` are there, they are file systems of
some MB, and one that is read-only. What lies in them is copied to `out` after each run: they end with the program.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import resource
import shutil
from collections.abc import Iterator
from pathlib import Path

from many_runs_program import answer

from fsipetsc.process.launch import start_mpi

ROD = "rod -fsi_h 0.05 -ts_max_time 0.05 -fsi_quiet"
MANY = f"{ROD} -fsi_output_dt 0.0001"
BLAST = "blast -fsi_h 0.0625 -fsi_order 2 -ts_max_time 0.5 -fsi_output_dt 0.0025 -fsi_quiet"
OFTEN = f"{ROD} -fsi_checkpoint_steps 20"


@contextlib.contextmanager
def limited(size: int) -> Iterator[None]:
    """No file may become larger: "File too large", as a disk may say that it is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def held(path: str) -> Iterator[None]:
    """Somebody has the file open, with the lock that HDF5 takes for writing."""
    descriptor = os.open(path, os.O_RDWR)
    if start_mpi().rank == 0:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        yield
    finally:
        os.close(descriptor)


if __name__ == "__main__":
    comm, found = start_mpi(), {}

    def run(name: str, line: str) -> None:
        found[name] = answer(line.split())
        comm.Barrier()
        for folder in map(Path, ("tiny1", "tiny2")) if comm.rank == 0 else ():
            if folder.is_dir():
                shutil.copytree(folder, Path("out") / name.replace(" ", "-"), dirs_exist_ok=True)
                for file in folder.iterdir():
                    shutil.rmtree(file) if file.is_dir() else file.unlink()
        comm.Barrier()

    run("whole", f"{OFTEN} -fsi_output whole.h5")
    with limited(3_500_000):  # MPI has files of its own, of shared memory: at the start there may be no limit
        run("limit 3500000", f"{MANY} -fsi_output limit3500000.h5")
    with limited(3_500_000):
        run("limit blast", f"{BLAST} -fsi_output blast.h5")
    if comm.rank == 0:
        os.mkfifo("pipe.h5")  # for all that is no regular file: not a device, which root could rename
    comm.Barrier()
    for place in ("pipe.h5", "/proc/x.h5", "no/where.h5"):
        run(f"output {place}", f"{ROD} -fsi_output {place}")
        run(f"checkpoint {place}", f"{OFTEN} -fsi_output c.h5 -fsi_checkpoint {place}")
        run(f"restart {place}", f"{ROD} -fsi_output c.h5 -fsi_restart {place}")
    if Path("fixed").is_dir():
        run("output fixed", f"{ROD} -fsi_output fixed/a.h5")
        run("checkpoint fixed", f"{OFTEN} -fsi_output c.h5 -fsi_checkpoint fixed/a.h5")
    if Path("tiny1").is_dir():
        run("full result", f"{MANY} -fsi_output tiny1/a.h5")
        run("full blast", f"{BLAST} -fsi_output tiny1/b.h5")
        run("full checkpoint", f"{OFTEN} -fsi_output kept.h5 -fsi_checkpoint tiny2/c.h5")
        run("after it", f"{ROD} -fsi_output kept.h5 -fsi_restart out/full-checkpoint/c.h5 -fsi_checkpoint after.h5")
    if comm.rank == 0:
        shutil.copy("whole.h5", "used0.h5")
    comm.Barrier()
    with held("used0.h5"):
        run("used result", f"{ROD} -fsi_output used0.h5 -fsi_restart whole.checkpoint.previous.h5")
    with held("whole.checkpoint.h5"):
        run("used checkpoint", f"{ROD} -fsi_output used0.h5 -fsi_restart whole.checkpoint.previous.h5 -fsi_checkpoint_steps 50")
    everybody = comm.gather(found)
    if everybody:
        Path("found.json").write_text(json.dumps(everybody))
