"""Many runs in one process; streams that cannot be written; signals while modules load."""

import json
import signal
import sys

import pytest
from helpers import REPOSITORY, launch, message, mpirun, run, well

import fsipetsc

SHORT = "-fsi_quiet -fsi_h 0.1"
PAPER = "-fsi_coupling projection"
_OTHER = "-ts_max_time 0.004 -rod_gravity -100 -fsi_output_dt 0.001 -ts_rk_type 3bs"
#: name of the result -> arguments of runs that end well
WELL = {"other": f"rod {SHORT} {PAPER} {_OTHER}", "plain": f"rod {SHORT} {PAPER} -ts_max_steps 30"}
#: what is run in one process, in this order: exit status, arguments
RUNS = [
    *([0, f"{text} -fsi_output {name}.h5"] for name, text in WELL.items()),
    [2, "rod -fsi_h 0.1 -fsi_oder 4 -ts_max_steps 1"],
    [3, f"rod {SHORT} {PAPER} -fsi_cfl 9 -fsi_output_dt 0.002 -fsi_output failed.h5"],
    [2, f"helped/case.py {SHORT} -ts_max_steps 5"],
    [2, "mms -options_file missing_letter.opts"],
    [2, f"rod {SHORT} -ts_max_steps 3 -log_view"],
    [0, f"{WELL['plain']} -fsi_output again.h5"],
]
CASE = """
import helper_of_a_case
OPTIONS = ()
DEFAULTS = {"ts_max_time": 1}
def build(opt):
    raise ValueError("no")
"""


def test_runs_in_one_process_are_runs_in_processes_of_their_own(tmp_path):
    """Also in a process that uses PETSc itself, with options of its own."""
    (tmp_path / "missing_letter.opts").write_text("-fsi_order 6\nfsi_h 0.1\n")
    (tmp_path / "helped").mkdir()
    (tmp_path / "helped" / "helper_of_a_case.py").write_text("NUMBER = 5\n")
    (tmp_path / "helped" / "case.py").write_text(CASE)
    done = well(run(REPOSITORY / "tests" / "many_runs_program.py", json.dumps(RUNS), cwd=tmp_path))
    assert json.loads(done.stdout) == []
    for name, text in WELL.items():
        words = f"{text} -fsi_output alone.h5".split()
        well(run("-m", "fsipetsc", *words, cwd=tmp_path))
        for other in (name, *(["again"] if name == "plain" else [])):
            found = fsipetsc.compare(tmp_path / "alone.h5", tmp_path / f"{other}.h5")
            assert found.equal and not found.options and len(found.differences) > 15, other


PROGRAM = f"{sys.executable} -m fsipetsc"
#: prints far more than what one who leaves after a line has read, in many writes
COMPUTES = f"{PROGRAM} rod -fsi_h 0.1 -ts_max_steps 300 -ts_monitor"


@pytest.mark.parametrize("into", [">/dev/full", "| head -n 0; exit ${PIPESTATUS[0]}"])
def test_a_run_goes_on_where_nothing_can_be_printed(into, tmp_path):
    done = launch(["bash", "-c", f"{COMPUTES} {into}"], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(tmp_path / "rod.h5") as result:
        assert result.complete and result.summary["steps"] == 300


LOADING = """
import runpy, signal, sys

module, number = sys.argv[1], int(sys.argv[2])


class Signals:
    def find_spec(self, name, path=None, target=None):
        if name == module:
            signal.raise_signal(number)


sys.meta_path.insert(0, Signals())
sys.argv[1:] = "rod", "-fsi_h", "0.1", "-ts_max_steps", "1"
runpy.run_module("fsipetsc", run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize(
    ("module", "number"),
    [("options", 2), ("options", 15), ("paper.outer_ends", 15), ("stepping.progress", 2)],
)
def test_a_signal_while_modules_load_is_one_line(module, number, tmp_path):
    """128 + signal, before the run can be stopped in order; on two ranks the launcher says more."""
    ranks = 2 if module == "paper.outer_ends" else 1
    words = "-c", LOADING, f"fsipetsc.{module}", number
    done = mpirun(2, *words, cwd=tmp_path) if ranks > 1 else run(*words, cwd=tmp_path)
    assert message(done, 128 + number).endswith(f"error: stopped by {signal.Signals(number).name}")
    assert "KeyboardInterrupt" not in done.stderr and not list(tmp_path.iterdir())
