"""Memory stays flat over a long run."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from helpers import environment

pytest.importorskip("petsc4py")


def start(steps: int, directory) -> subprocess.Popen:
    options = f"-fsi_h 0.1 -fsi_order 2 -fsi_output_dt 0.004 -ts_max_time 1000 -ts_max_steps {steps} -fsi_quiet"
    command = [sys.executable, "-m", "fsipetsc", "rod", *options.split(), "-fsi_output", f"{directory}/{steps}.h5"]
    return subprocess.Popen(command, env=environment())


@pytest.mark.slow
def test_memory_is_flat(tmp_path):
    """From 40,000 steps, when all buffers have been full once, to 120,000, with 13,000 frames: less than 3 MB more."""
    processes = [start(steps, tmp_path) for steps in (40_000, 120_000)]
    peaks = []
    for process in processes:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss / (1024 if sys.platform != "darwin" else 1024**2))  # MB
    assert peaks[1] - peaks[0] < 3.0, peaks
