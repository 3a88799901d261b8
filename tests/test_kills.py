"""Runs that are stopped or killed go on as if nothing had been; what the signals do that ask for a checkpoint."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, environment, message, mpirun, solve
from kill_cycles import alive, cycles, descendants, ranks_of
from test_restart import differences

import fsipetsc
from fsipetsc.output import checkpoint_file

pytest.importorskip("petsc4py")

pytestmark = pytest.mark.mpi

#: in some seconds
LINE = "rod -ts_max_time 2 -fsi_output_dt 0.02 -fsi_quiet".split()
SLOW = """
import time
from dataclasses import replace
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "slow", rod.OPTIONS, rod.DEFAULTS


def build(opt):
    problem = rod.build(opt)
    below, solid, above = problem.layers
    return replace(problem, layers=(replace(below, forcing=forcing), solid, above))


def forcing(X, t):
    if t > 0:
        open("asked", "w").close()
        time.sleep(600)
    return 0 * X, 0 * X, 0 * X
"""
FULL = """
import errno, os, sys
from fsipetsc import cli
from fsipetsc.output import checkpoint_file

put, made = checkpoint_file._put, []


def full(descriptor, content):
    made.append(1)
    if len(made) > 2:
        os.write(descriptor, content[: len(content) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    put(descriptor, content)


checkpoint_file._put = full
sys.exit(cli.main())
"""


#: seconds that a launcher leaves its ranks to end after it was told to: its usual one is short where much else runs
LEFT = {f"{name}_MCA_odls_base_sigkill_timeout": "4" for name in ("OMPI", "PRTE")}


def begin(ranks: int, folder: Path, *words: object, env: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
    command = ["mpiexec", "-n", str(ranks)] * (ranks > 1) + [sys.executable, "-m", "fsipetsc", *map(str, words)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=folder, env=environment(env), text=True, stdout=pipe, stderr=pipe)


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + PATIENCE
    while not path.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.005)
    assert path.exists(), process.communicate()


def wait_for_frames(path: Path, process: subprocess.Popen[str]) -> None:
    """Until the run makes steps: until then it does not listen to all signals."""
    end = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < end:
        with suppress(fsipetsc.errors.FileError), fsipetsc.open_run(path) as result:
            if result.nframes > 1:
                return
        time.sleep(0.02)
    raise AssertionError(process.communicate())


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    done = solve(*LINE, "-fsi_output", "whole.h5", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "whole.h5"


def test_a_run_that_a_signal_stopped_goes_on(whole, tmp_path):
    """The signal comes to the last rank; 128 + signal, a checkpoint of the last step; then on another number of ranks."""
    output, ranks, number = tmp_path / "rod.h5", 2, signal.SIGINT
    process = begin(ranks, tmp_path, *LINE, "-fsi_output", output, "-fsi_checkpoint_wall", 0.1)
    wait_for(tmp_path / "rod.checkpoint.h5", process)
    os.kill(ranks_of(process.pid, output)[-1], number)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + number, err
    assert err.count(f"stopped by {number.name} at t = ") == 1 and f"the checkpoint in {tmp_path}" in err
    done = solve(*LINE, "-fsi_output", output, "-fsi_restart", "auto", cwd=tmp_path)  # more ranks than cores would take long
    assert (done.returncode, done.stderr) == (0, "")
    assert differences(whole, output, same_ranks=False) == []


def test_usr1_asks_for_a_checkpoint_and_the_run_goes_on(tmp_path):
    """Once without any option for checkpoints; the next time the earlier one is kept. No other run may write there."""
    process = begin(2, tmp_path, *LINE, "-ts_max_time", 1000, "-fsi_output", tmp_path / "rod.h5", env=LEFT)
    wait_for(tmp_path / "rod.h5", process)
    wait_for_frames(tmp_path / "rod.h5", process)
    steps = []
    for path in (tmp_path / "rod.checkpoint.h5", tmp_path / "rod.checkpoint.previous.h5"):
        os.kill(ranks_of(process.pid, tmp_path / "rod.h5")[-1], signal.SIGUSR1)
        wait_for(path, process)
        steps.append(checkpoint_file.read(tmp_path / "rod.checkpoint.h5").header["memory"]["steps"])
    assert steps[0] < steps[1]
    other = "-fsi_output", "other.h5", "-fsi_checkpoint", "rod.checkpoint.h5"
    message(solve(*LINE, *other, cwd=tmp_path), 4, "rod.checkpoint.h5: another run writes its checkpoints (process ")
    assert not (tmp_path / "other.h5").exists()
    process.terminate()  # mpiexec, which kills its ranks later, and has a status of its own
    _, err = process.communicate(timeout=PATIENCE)
    # Open MPI 5's launcher passes on nothing that is said after it was told to end
    assert err.count("stopped by SIGTERM at t = ") == 1 or not err, err
    assert checkpoint_file.read(tmp_path / "rod.checkpoint.h5").header["memory"]["steps"] > steps[1]


def test_a_launcher_that_kills_soon_loses_no_checkpoint(tmp_path):
    """mpiexec as it is gives ranks that are to end a second: whatever they had time for, what is there goes on."""
    process = begin(2, tmp_path, *LINE, "-ts_max_time", 1000, "-fsi_checkpoint_wall", 0.1)
    path = tmp_path / "rod.checkpoint.h5"
    wait_for(path, process)
    everybody, before = [process.pid, *descendants(process.pid)], checkpoint_file.read(path).header["memory"]
    process.terminate()
    process.communicate(timeout=PATIENCE)
    end = time.monotonic() + PATIENCE
    while alive(everybody) and time.monotonic() < end:
        time.sleep(0.01)
    assert process.returncode != 0 and not alive(everybody)
    after = checkpoint_file.read(path).header["memory"]
    assert after["steps"] >= before["steps"]
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.nframes > 0
    done = solve(*LINE, "-ts_max_time", after["t"] + 0.05, "-fsi_restart", "auto", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and len(result.series["t"]) == result.summary["steps"] > after["steps"]


def test_a_second_sigint_ends_at_once(tmp_path):
    """Also while a step takes for ever."""
    (tmp_path / "slow.py").write_text(SLOW)
    process = begin(1, tmp_path, "slow.py", "-fsi_quiet", "-fsi_mapping", "rigid")
    wait_for(tmp_path / "asked", process)
    process.send_signal(signal.SIGINT)
    time.sleep(1.0)
    assert process.poll() is None, "the first one lets the step end"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT  # 130 in a shell


def test_the_wall_limit_ends_a_run_in_time(tmp_path):
    begun = time.monotonic()
    done = solve(*LINE[:-1], "-ts_max_time", 1000, "-fsi_wall_limit", 2.5, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert "ended by -fsi_wall_limit at t = " in done.stdout
    assert "-fsi_restart rod.checkpoint.h5 goes on" in done.stdout
    assert time.monotonic() - begun < PATIENCE
    header = checkpoint_file.read(tmp_path / "rod.checkpoint.h5").header
    assert header["memory"]["wall_time"] < 2.5 and header["memory"]["steps"] > 0


def test_a_full_disk_in_the_middle_of_a_checkpoint(tmp_path):
    """One message, status 4; the checkpoint before is whole and goes on, the result is readable."""
    (tmp_path / "full.py").write_text(FULL)
    words = "-fsi_h", "0.05", "-ts_max_time", "0.05", "-fsi_checkpoint_steps", "20", "-fsi_quiet"
    for ranks in (1, 3):
        named = *words, "-fsi_output", f"{ranks}.h5"
        done = mpirun(ranks, "full.py", "rod", *named, cwd=tmp_path)
        kept = f"the one before is kept in {tmp_path}/{ranks}.checkpoint.h5"
        message(done, 4, f"{ranks}.checkpoint.h5: the checkpoint cannot be written: No space left on device", kept)
        assert checkpoint_file.read(tmp_path / f"{ranks}.checkpoint.h5").header["memory"]["steps"] == 40
        done = solve("rod", *named, "-fsi_restart", "auto", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
    assert differences(tmp_path / "1.h5", tmp_path / "3.h5", same_ranks=False) == []


def test_killed_again_and_again(tmp_path):
    """Few times; scripts/soak does it many times, docs/reliability.md says what came of it."""
    assert len(cycles(tmp_path, "rod", 3, 1)) == 4


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_run_that_fails_leaves_a_good_state(ranks, tmp_path):
    """As a frame and as a checkpoint, from which it goes on with shorter steps."""
    words = "rod -fsi_h 0.05 -ts_max_time 0.05 -fsi_cfl 3 -fsi_quiet".split()
    done = solve(*words, cwd=tmp_path, ranks=ranks)
    said = message(done, 3, "what was computed before is in", ", a good state of step ", "rod.checkpoint.h5")
    header = checkpoint_file.read(tmp_path / "rod.checkpoint.h5").header
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.time[-1] == header["memory"]["t"]
        assert header["memory"]["steps"] < result.summary["steps"], said
        assert all(np.isfinite(result.layers[1][name][-1]).all() for name in ("u", "T"))
    done = solve(*words[:1], "-fsi_restart", "auto", "-fsi_cfl", 0.8, "-fsi_quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and (np.diff(result.time) > 0).all() and len(result.series["t"]) == result.summary["steps"]


def test_a_step_that_leaves_the_domain_is_made_again_shorter(tmp_path):
    """With step-size control that tolerates everything but states that are none."""
    words = "rod -fsi_h 0.05 -ts_max_time 0.02 -fsi_cfl 200 -fsi_quiet".split()
    control = "-ts_rk_type 5dp -ts_adapt_type basic -ts_rtol 1e9 -ts_atol 1e9".split()
    done = solve(*words, *control, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.summary["rejected_steps"] > 0
        assert (result.layers[0]["T"][-1][np.isfinite(result.layers[0]["T"][-1])] > 0).all()
