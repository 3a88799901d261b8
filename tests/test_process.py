"""Many runs in one process: each is what it would be in a process of its own, and leaves nothing
behind. Streams that cannot be written: a run goes on, and what is printed for its own sake says so.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import PATIENCE, REPOSITORY, environment, run

import fsipetsc

pytest.importorskip("petsc4py")

SHORT = "-fsi_quiet -fsi_h 0.1"
#: (exit status, name of the result, arguments), in this order
RUNS = [
    (
        0,
        "rod",
        f"rod {SHORT} -ts_max_time 0.004 -rod_gravity -100 -fsi_output_dt 0.001 -ts_rk_type 3bs",
    ),
    (0, "plain", f"rod {SHORT} -ts_max_steps 30"),
    (2, "", "rod -fsi_h 0.1 -fsi_oder 4 -ts_max_steps 1"),
    (3, "", f"rod {SHORT} -fsi_cfl 9 -fsi_output_dt 0.002 -fsi_output failed.h5"),
    (2, "", f"helped/case.py {SHORT} -ts_max_steps 5"),
    (2, "", "mms -options_file missing_letter.opts"),
    (0, "again", f"rod {SHORT} -ts_max_steps 30"),
    (2, "", f"rod {SHORT} -ts_max_steps 3 -log_view"),
    (0, "last", f"rod {SHORT} -ts_max_steps 30"),
]
CASE = """
import helper_of_a_case
OPTIONS = ()
DEFAULTS = {"ts_max_time": 1}
def build(opt):
    raise ValueError("no")
"""


def _files(where: Path) -> None:
    (where / "missing_letter.opts").write_text("-fsi_order 6\nfsi_h 0.1\n")
    (where / "helped").mkdir()
    (where / "helped" / "helper_of_a_case.py").write_text("NUMBER = 5\n")
    (where / "helped" / "case.py").write_text(CASE)


def _arguments(name: str, text: str, runs: str = "") -> str:
    return f"{text} -fsi_output {runs}{name}.h5" if name else text


def _content(path: Path) -> dict[str, object]:
    """All numbers of a result, and the options that made it."""
    with fsipetsc.open_run(path) as result:
        options = {k: v for k, v in result.options.items() if k != "fsi_output"}
        arrays = {"t": result.time, **{name: result.series[name] for name in result.series}}
        for layer in result.layers:
            arrays |= {f"{layer.name} {field}": layer[field] for field in layer.fields}
        return {"options": options, **{name: np.asarray(v).tobytes() for name, v in arrays.items()}}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """name -> result of a run in a process of its own."""
    where = tmp_path_factory.mktemp("alone")
    _files(where)
    for status, name, text in RUNS:
        if name and name not in ("again", "study"):
            done = run("-m", "fsipetsc", *_arguments(name, text).split(), cwd=where)
            assert (done.returncode, done.stderr) == (status, "")
    return where


def test_runs_in_one_process_are_runs_in_processes_of_their_own(alone, tmp_path):
    _files(tmp_path)
    runs = [[status, _arguments(name, text)] for status, name, text in RUNS]
    (tmp_path / "runs.json").write_text(json.dumps(runs))
    done = run(REPOSITORY / "tests" / "many_runs_program.py", "runs.json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == []
    for path in alone.glob("*.h5"):
        assert _content(tmp_path / path.name) == _content(path), path.name
    assert _content(tmp_path / "again.h5") == _content(tmp_path / "plain.h5")


HOST = """
import petsc4py
petsc4py.init(["host", "-host_option", "7", "-fsi_order", "8"])
import os
from petsc4py import PETSc
from fsipetsc.cli import main
os.environ["PETSC_OPTIONS"] = "-ts_max_steps 2"
line = "rod -fsi_quiet -fsi_h 0.1".split()
assert main(line) == 0
assert main([*line, "-fsi_output", "it's 3.h5", "-ts_max_steps", "3"]) == 0
assert os.environ["PETSC_OPTIONS"] == "-ts_max_steps 2"
assert PETSc.Options().getAll() == {"host_option": "7", "fsi_order": "8"}
"""


def test_a_host_of_runs_keeps_its_own_options(tmp_path):
    """A process that uses PETSc itself: its options are not the run's, PETSC_OPTIONS are, and the
    command line comes last.
    """
    done = run("-c", HOST, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    for name, steps in (("rod", 2), ("it's 3", 3)):
        with fsipetsc.open_run(tmp_path / f"{name}.h5") as result:
            assert (result.summary["steps"], result.options["fsi_order"]) == (steps, 4)


# nobody reads what is printed, or it cannot be written

#: prints far more than what one who leaves after a line has read, in many writes
RUN = "rod -fsi_h 0.1 -ts_max_steps 300 -ts_monitor".split()
COMPUTES = f"{sys.executable} -m fsipetsc {' '.join(RUN)}"


def shell(line: str, cwd) -> tuple[int, str]:
    """(status, stderr) of a line for bash."""
    given = {"cwd": cwd, "env": environment(), "stdin": subprocess.DEVNULL, "timeout": PATIENCE}
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, **given)
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("line", "said"),
    [(f"{COMPUTES} >/dev/full", 1), (f"{COMPUTES} | head -n 0; exit ${{PIPESTATUS[0]}}", 0)],
)
def test_a_run_goes_on(line, said, tmp_path):
    status, err = shell(line, tmp_path)
    assert (status, err.count("\n")) == (0, said), err
    assert ("No space left on device" in err) == bool(said)
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["steps"] == 300


@pytest.mark.parametrize("arguments", ["rod -help", "stability -no_such"])
def test_what_prints_for_its_own_sake_says_that_it_cannot(arguments, tmp_path):
    status, err = shell(f"{sys.executable} -m fsipetsc {arguments} >/dev/full", tmp_path)
    assert status == (4 if "help" in arguments else 2)
    assert err.count("fsipetsc: error: ") == err.count("\n") == 1, err
