"""Runs that cannot go on, or are not allowed to start: exit status, one message that helps, and what is left on disk."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, environment, mpirun, run

import fsipetsc

pytest.importorskip("petsc4py")


def solve(*args: object, **more):
    """`python -m fsipetsc *args` without mpiexec."""
    return run("-m", "fsipetsc", *args, **more)


def message(done, status: int) -> str:
    """The program's one message; asserts the status, and that there is nothing else on stderr but the launcher's words."""
    assert done.returncode == status, done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith("fsipetsc: error: ")]
    assert len(lines) == 1, done.stderr
    for word in ("Traceback", "PETSC ERROR", "Warning"):
        assert word not in done.stderr
    return lines[0]


# --- bad input: status 2 ----------------------------------------------------------------------------------------------

BAD_INPUT = {
    "unknown case": ("rood", ["'rood'; did you mean 'rod'? There are rod, "]),
    "unknown case like none": ("xyzzy", ["'xyzzy'. There are rod, "]),
    "unknown option": ("rod -fsi_flux roe", ["-fsi_flux"]),
    "misspelt option": ("rod -fsi_oder 4", ["-fsi_oder", "did you mean -fsi_order?"]),
    "misspelt material": ("rod -fluid_my 0.1", ["-fluid_my", "did you mean -fluid_mu?"]),
    "misspelt PETSc option": ("rod -ts_max_tim 1", ["-ts_max_tim", "did you mean -ts_max_time?"]),
    "unsupported order": ("rod -fsi_order 5", ["-fsi_order", "'5'", "2, 4, 6, 8"]),
    "h that misses an interface": ("rod -fsi_h 0.03", ["-fsi_h 0.03", "'rod'", "0.02941176", "0.03030303"]),
    "h of zero": ("rod -fsi_h 0", ["-fsi_h", "above 0"]),
    "too few points": ("rod -fsi_order 8 -fsi_h 0.1", ["11 points", "8/4", "16", "-fsi_h", "-fsi_order"]),
    "negative viscosity": ("rod -fluid_mu -1", ["-fluid_mu", "not below 0"]),
    "no density": ("rod -solid_density 0", ["-solid_density", "above 0", "kg/m3"]),
    "negative modulus": ("mms -solid_modulus -10", ["-solid_modulus", "above 0"]),
    "no heat capacity": ("pulse -solid_alpha 0", ["-solid_alpha", "above 0"]),
    "gamma of one": ("rod -fluid_gamma 1", ["-fluid_gamma", "above 1"]),
    "not a number": ("rod -rod_p0 nan", ["-rod_p0", "'nan'"]),
    "wall inside the rod": ("rod -rod_wall 1.5", ["'1.5'", "-rod_wall", "below 1"]),
    "top inside the rod": ("rod -rod_top 1.5", ["'1.5'", "-rod_top", "above 2"]),
    "pulse outside": ("pulse -pulse_start 7", ["-pulse_start 7"]),
    "far too fine": ("rod -fsi_h 1e-9", ["'below'", "cells", "-fsi_h", "too many"]),
    "far too long": ("rod -rod_top 1e308", ["'above'", "1e+308", "too many"]),
    "far too much to spare": ("rod -fsi_spare 2147483647", ["-fsi_spare", "too many"]),
    "file name": (f"rod -fsi_output {'x' * 252}.h5", ["-fsi_output", "at most 150 bytes"]),
    "times beyond the end": ("box -fsi_output_times 7", [": 7 would not be reached", "-ts_max_time 2"]),  # no unit
    "output directory": ("rod -fsi_output no/such/dir/x.h5", ["no/such/dir"]),
}


@pytest.mark.parametrize("name", BAD_INPUT)
def test_bad_input(name, tmp_path):
    line, words = BAD_INPUT[name]
    done = solve(*line.split(), cwd=tmp_path)
    text = message(done, 4 if name == "output directory" else 2)
    for word in words:
        assert word in text
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == [], "nothing is left behind"


@pytest.mark.mpi
@pytest.mark.parametrize("name", ["unknown option", "h that misses an interface", "too few points", "output directory"])
def test_bad_input_on_two_ranks(name, tmp_path):
    line, words = BAD_INPUT[name]
    done = mpirun(2, "-m", "fsipetsc", *line.split(), cwd=tmp_path)
    text = message(done, 4 if name == "output directory" else 2)
    for word in words:
        assert word in text
    assert "MPI_ABORT" not in done.stderr


# --- the computation fails: status 3 ----------------------------------------------------------------------------------


def assert_readable(path: Path, status: str, reached: float) -> None:
    """A result that can be opened, with frames and series up to the end."""
    with fsipetsc.open_run(path) as result:
        assert result.summary["status"] == status
        assert result.nframes >= 1
        assert result.time[0] == 0.0
        assert len(result.series["t"]) >= result.summary["steps"] - 1, "all steps but one that failed"
        assert 0 < result.summary["t"] <= reached
        for layer in result.layers:
            for field in layer.fields:
                assert np.isfinite(layer[field][-1]).sum() > 1


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_a_step_beyond_the_stability_limit(ranks, tmp_path):
    done = mpirun(ranks, "-m", "fsipetsc", *"rod -fsi_h 0.05 -fsi_cfl 5 -fsi_output_dt 0.002".split(), cwd=tmp_path)
    text = message(done, 3)
    for word in ("in layer '", "at x = ", "(X = ", "t = ", ", step ", "what was computed before is in"):
        assert word in text
    assert any(f" {field} " in text for field in ("rho", "T", "u", "x_X"))
    assert_readable(tmp_path / "rod.h5", "failed", 3.0)


def test_a_failure_within_a_burst_loses_nothing(tmp_path):
    """Neither steps of the series nor of the summary, as if they had been made one by one."""
    found = []
    for burst in (1, 64):
        line = f"rod -fsi_h 0.025 -ts_max_time 0.5 -ts_dt 3e-4 -fsi_burst {burst} -fsi_output {burst}.h5".split()
        message(run("-m", "fsipetsc", *line, cwd=tmp_path), 3)
        with fsipetsc.open_run(tmp_path / f"{burst}.h5") as result:
            series = {name: result.series[name].tolist() for name in ("t", "dt", "x_interface", "mass")}
            said = [result.summary[name] for name in ("steps", "rhs_evaluations", "dt_min", "dt_max", "message")]
            found.append((series, said))
    assert len(found[0][0]["t"]) > 2
    assert str(found[0]).replace("1.h5", "") == str(found[1]).replace("64.h5", "")


def test_the_message_is_the_same_on_any_number_of_ranks(tmp_path):
    line = "rod -fsi_h 0.05 -fsi_cfl 5 -fsi_output x.h5".split()
    texts = {message(mpirun(n, "-m", "fsipetsc", *line, cwd=tmp_path), 3) for n in (1, 3)}
    assert len(texts) == 1


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_a_layer_that_becomes_too_short(ranks, tmp_path):
    """With a wall close under the rod there is soon no room for the 16 points of the 8/4 operator."""
    line = "rod -fsi_h 0.0125 -fsi_order 8 -rod_wall 0.81 -rod_top 3".split()
    text = message(mpirun(ranks, "-m", "fsipetsc", *line, cwd=tmp_path), 3)
    for word in ("'below'", "too short", "t = ", ", step ", "x = ", "needs 16 points"):
        assert word in text
    assert_readable(tmp_path / "rod.h5", "failed", 0.5)


def test_a_boundary_that_jumps_over_the_grid(tmp_path):
    """A free end that flies off faster than the gas can follow: whatever fails is named, and nothing hangs."""
    line = "rod -fsi_h 0.05 -rod_gravity -1e6 -ts_max_time 0.01".split()
    assert "layer '" in message(solve(*line, cwd=tmp_path), 3)


BROKEN = """
import sys
from mpi4py import MPI
from fsipetsc.cli import main
from fsipetsc.stepping import run

ranks, frame = [int(rank) for rank in sys.argv[1:]], run._Run._frame


def broken(self, t):
    if t > 0.0035 and MPI.COMM_WORLD.rank in ranks:
        raise MemoryError
    frame(self, t)


run._Run._frame = broken
sys.exit(main("rod -fsi_h 0.1 -fsi_output_dt 0.001 -ts_max_time 0.01 -fsi_quiet".split()))
"""


@pytest.mark.parametrize(
    "ranks", [[0], pytest.param([0, 1], marks=pytest.mark.mpi), pytest.param([1], marks=pytest.mark.mpi)], ids=str
)
def test_any_error_leaves_what_was_computed(ranks, tmp_path):
    """If all ranks meet it; where one of two is alone, it ends the other, who cannot write without it."""
    n = max(ranks) + 1
    done = mpirun(n, "-c", BROKEN, *ranks, cwd=tmp_path)
    assert done.returncode == 3, done.stderr
    assert done.stderr.count("fsipetsc: error: out of memory") == 1
    if len(ranks) < n:
        return
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        np.testing.assert_allclose(result.time, [0.0, 0.001, 0.002, 0.003])
        assert result.series["t"][-1] == pytest.approx(0.004)
        assert (result.summary["status"], result.summary["message"]) == ("failed", "MemoryError")
        assert len(result.series["t"]) == result.summary["steps"]


# --- signals ----------------------------------------------------------------------------------------------------------

LONG = "rod -fsi_h 0.025 -fsi_output_dt 0.001 -ts_max_time 1000 -fsi_output long.h5".split()


def started(ranks: int, cwd: Path) -> subprocess.Popen[str]:
    """A long run that has saved some frames."""
    command = [sys.executable, "-m", "fsipetsc", *LONG]
    if ranks > 1:
        command = ["mpiexec", "-n", str(ranks), *command]
    process = subprocess.Popen(
        command, cwd=cwd, env=environment(), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        try:
            with fsipetsc.open_run(cwd / "long.h5") as result:
                if result.nframes > 2:
                    return process
        except fsipetsc.errors.FileError:
            pass
        time.sleep(0.2)
    process.kill()
    raise AssertionError(f"no frames: {process.communicate()}")


ALONE = """
from dataclasses import replace
import numpy as np
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "alone", rod.OPTIONS, rod.DEFAULTS


def build(opt):
    problem = rod.build(opt)
    below, solid, above = problem.layers

    def forcing(X, t):  # of the layer that only one rank has
        if t > 0.002:
            raise ValueError("no force is known")
        return np.zeros((4, len(X)))

    return replace(problem, layers=(below, replace(solid, forcing=forcing), above))
"""


@pytest.mark.mpi
@pytest.mark.parametrize("shared", [0, 1])
def test_an_error_of_one_rank_alone_ends_all(shared, tmp_path):
    """It is said once, and nobody waits for a rank that has left."""
    (tmp_path / "alone.py").write_text(ALONE)
    options = ("-fsi_h", "0.05", "-ts_max_time", "0.1", "-fsi_quiet", "-fsi_shared_memory", shared)
    done = mpirun(2, "-m", "fsipetsc", "alone.py", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("fsipetsc: error: ") == 1 and "no force is known" in done.stderr


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_signal_to_one_rank_while_it_starts_ends_all(ranks, tmp_path):
    """At any moment: nobody waits for a rank that has left. (Before MPI is there, the launcher speaks, not the program.)"""
    command = ["mpiexec", "-n", str(ranks), sys.executable, "-m", "fsipetsc", *LONG, "-fsi_quiet"]
    for number, delay in ((signal.SIGINT, 0.3), (signal.SIGHUP, 0.7), (signal.SIGTERM, 1.2)):
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, cwd=tmp_path, env=environment(), text=True, stdout=pipe, stderr=pipe)
        end = time.monotonic() + 30
        while len(started_ranks := ranks_of(process.pid)) < ranks and time.monotonic() < end:
            time.sleep(0.01)  # the list of the system may lack somebody who was in it before
        time.sleep(delay)
        os.kill(started_ranks[-1], number)
        _, err = process.communicate(timeout=60)
        assert process.returncode == 128 + number, err
        assert err.count("fsipetsc: error: ") <= 1 and "Traceback" not in err


SIGNALLED = """
import os, sys
from fsipetsc import cli

start, number = cli.start_mpi, int(sys.argv.pop(1))


def signalled():
    os.kill(os.getpid(), number)  # it waits until all ranks can be told
    return start()


cli.start_mpi = signalled
sys.exit(cli.main())
"""


UNHEARD = """
import os, signal
from contextlib import suppress
from dataclasses import replace
from fsipetsc.cases import rod

NAME, OPTIONS, DEFAULTS = "unheard", rod.OPTIONS, rod.DEFAULTS
signalled = 0


def signal_to(rank, number=signal.SIGHUP):
    if os.environ.get("OMPI_COMM_WORLD_RANK", os.environ.get("PMI_RANK", str(rank))) == str(rank):
        os.kill(os.getpid(), number)


def build(opt):
    SIGNAL
    problem = rod.build(opt)
    below, solid, above = problem.layers
    return replace(problem, layers=(replace(below, initial=initial(below.initial)), solid, above))


def initial(function):
    def fields(X):
        SECOND
        return function(X)

    return fields
"""
SWALLOWED = "with suppress(BaseException): signal_to({rank})"


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
@pytest.mark.parametrize("words", [SWALLOWED, "signal_to({rank})"], ids=["swallowed", "taken for an error of the case file"])
@pytest.mark.parametrize("place", ["SIGNAL", "SECOND"])
def test_a_signal_whose_exception_is_not_heard_is(place, words, ranks, tmp_path):
    """To the last rank, in a user's function; all end in order, before the first step or after it, but there is no other."""
    rank = ranks - 1 if place == "SIGNAL" else 0  # which has the first layer
    text = UNHEARD.replace(place, words.format(rank=rank)).replace("SIGNAL", "pass").replace("SECOND", "pass")
    (tmp_path / "unheard.py").write_text(text)
    done = mpirun(ranks, "-m", "fsipetsc", "unheard.py", *LONG[1:], "-fsi_quiet", cwd=tmp_path, timeout=60)
    assert message(done, 129) == "fsipetsc: error: stopped by SIGHUP before the first step"
    assert "MPI_ABORT" not in done.stderr


@pytest.mark.mpi
def test_an_error_in_the_initial_data_of_one_rank_alone_ends_all(tmp_path):
    """What the error holds of the rank's arrays is let go: PETSc would wait at its end for ranks with other objects."""
    text = UNHEARD.replace("SIGNAL", "pass").replace("SECOND", "raise ValueError('no density is known')")
    (tmp_path / "unheard.py").write_text(text)
    line = "unheard.py -fsi_h 0.025 -fsi_partition physics -fsi_quiet".split()
    done = mpirun(2, "-m", "fsipetsc", *line, cwd=tmp_path, timeout=60)
    assert message(done, 2).endswith("ValueError: no density is known")


HOLE = """
import os, signal, sys
from contextlib import suppress
from fsipetsc import cli
from fsipetsc.stepping.integrator import Integrator

start = Integrator.start


def started(self):
    start(self)
    with suppress(BaseException):
        os.kill(os.getpid(), signal.SIGHUP)


Integrator.start = started
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_time 1000 -fsi_quiet".split()))
"""


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
def test_a_signal_not_heard_just_before_the_time_loop_ends_it_at_its_first_step(ranks, tmp_path):
    done = mpirun(ranks, "-c", HOLE, cwd=tmp_path, timeout=60)
    assert "stopped by SIGHUP at t = " in message(done, 129)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["status"], result.summary["steps"]) == ("stopped", 1)


TAKEN = """
import ctypes, os, signal, sys
from fsipetsc import cli
from fsipetsc.stepping import run

start, header = cli.start_mpi, run._Run._header
ignore = ctypes.CDLL(None).signal
ignore.argtypes, ignore.restype = (ctypes.c_int, ctypes.c_void_p), ctypes.c_void_p


def taken():
    world = start()
    ignore(signal.SIGHUP, int(signal.SIG_IGN))  # Python does not know
    return world


def signalled(self):
    os.kill(os.getpid(), signal.SIGHUP)
    return header(self)


cli.start_mpi, run._Run._header = taken, signalled
sys.exit(cli.main("rod -fsi_h 0.1 -ts_max_steps 2 -fsi_quiet".split()))
"""


def test_a_library_that_answers_a_signal_itself_does_not_keep_it(tmp_path):
    """UCX, below some MPI, wants SIGHUP for itself."""
    done = run("-c", TAKEN, cwd=tmp_path, timeout=60)
    assert message(done, 129) == "fsipetsc: error: stopped by SIGHUP before the first step"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("words", ["rod", "stability"])
def test_a_signal_that_comes_while_mpi_starts_is_named(words, number, tmp_path):
    done = run("-c", SIGNALLED, int(number), words, cwd=tmp_path)
    when = " before the first step" if words == "rod" else ""
    assert message(done, 128 + number) == f"fsipetsc: error: stopped by {signal.Signals(number).name}{when}"


LATE = """
import os, signal, sys
from fsipetsc.cli import main
from fsipetsc.stepping import run

last = run._Run._last_frame


def signalled(self):
    os.kill(os.getpid(), signal.SIGTERM)
    last(self)


run._Run._last_frame = signalled
sys.exit(main("rod -fsi_h 0.1 -ts_max_steps 3 -fsi_quiet".split()))
"""


def test_a_signal_behind_the_last_step_is_not_said_to_come_before_the_first(tmp_path):
    text = message(run("-c", LATE, cwd=tmp_path), 143)
    assert text == "fsipetsc: error: SIGTERM came while the result was being written"
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert (result.summary["steps"], len(result.series["t"])) == (3, 3)


@pytest.mark.mpi
def test_ranks_end_in_order_when_their_launcher_is_killed(tmp_path):
    process = started(2, tmp_path)
    ranks = ranks_of(process.pid)
    process.kill()
    process.communicate(timeout=30)
    end = time.monotonic() + 30
    while any(Path(f"/proc/{rank}").exists() for rank in ranks) and time.monotonic() < end:
        time.sleep(0.05)
    left = [rank for rank in ranks if Path(f"/proc/{rank}").exists()]
    for rank in left:
        os.kill(rank, signal.SIGKILL)
    assert len(ranks) == 2 and left == []
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        ended = "status" in result.summary
        assert result.nframes > 2
    if ended:  # MPI has let them: it aborts ranks that have lost their launcher, and now and then is faster than they are
        assert_readable(tmp_path / "long.h5", "stopped", 1000.0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_ends_the_run_in_order(number, tmp_path):
    process = started(1, tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    text = message(subprocess.CompletedProcess([], process.returncode, out, err), 128 + number)
    assert signal.Signals(number).name in text
    assert "long.h5" in text
    assert_readable(tmp_path / "long.h5", "stopped", 1000.0)
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        assert not result.complete
        assert result.time[-1] == result.series["t"][-1] == result.summary["t"], "the last state is saved"


def ranks_of(pid: int) -> list[int]:
    """Processes of the program that a launcher has started, by /proc: its first thread, another, or a launcher below it."""
    found = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, listed.read_text().split()):
            ours = b"\0-m\0fsipetsc\0" in Path(f"/proc/{child}/cmdline").read_bytes()
            found += ranks_of(child) or [child] * ours
    return found


@pytest.mark.mpi
@pytest.mark.parametrize("rank", [0, 1])
def test_a_signal_to_one_rank_stops_all(rank, tmp_path):
    process = started(2, tmp_path)
    ranks = ranks_of(process.pid)
    if len(ranks) != 2:
        process.terminate()
        process.communicate(timeout=PATIENCE)
        pytest.skip("the ranks are not to be found below the launcher")
    os.kill(ranks[rank], signal.SIGTERM)
    out, err = process.communicate(timeout=PATIENCE)
    message(subprocess.CompletedProcess([], process.returncode, out, err), 143)
    assert_readable(tmp_path / "long.h5", "stopped", 1000.0)


def test_a_killed_run_leaves_its_frames(tmp_path):
    process = started(1, tmp_path)
    time.sleep(1.0)
    process.kill()
    process.communicate(timeout=PATIENCE)
    assert process.returncode == -signal.SIGKILL
    with fsipetsc.open_run(tmp_path / "long.h5") as result:
        assert not result.complete
        assert result.nframes > 2
        np.testing.assert_allclose(result.time, 0.001 * np.arange(result.nframes))
        assert np.isfinite(result.layers[1]["u"]).all()
        assert result.series["t"][-1] >= result.time[-1]
    done = solve("info", "long.h5", cwd=tmp_path)
    assert done.returncode == 0
    assert "unfinished" in done.stdout


def test_an_earlier_result_is_kept(tmp_path):
    for _ in range(2):
        done = solve(*"rod -fsi_h 0.1 -ts_max_steps 2".split(), cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
    assert "kept the earlier rod.h5 as" in done.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rod.1.h5", "rod.h5"]
