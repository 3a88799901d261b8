"""The command line as users and scripts meet it: texts, options and arguments, on one rank and on
two.
"""

from __future__ import annotations

import json
import os
import sys

import h5py
import pytest
from helpers import message, mpirun, run, solve
from stub_case import run_stub, start_stub

from fsipetsc.cli import main
from fsipetsc.output import checkpoint_file


def test_overview_lists_cases_and_commands_without_importing_the_solver():
    """So that it takes no time that could be noticed: nothing but the standard library, and little
    of ours.
    """
    code = "import sys; old = set(sys.modules); from fsipetsc.cli import main; main([]); "
    done = run("-c", code + "print(*sorted(set(sys.modules) - old), file=sys.stderr)")
    assert done.returncode == 0
    for word in ("Cases", "rod", "mms", "pulse", "Commands", "info RUN.h5", "plot RUN.h5"):
        assert word in done.stdout
    loaded = done.stderr.split()
    assert {name.split(".")[0] for name in loaded} <= {"fsipetsc", *sys.stdlib_module_names}
    assert len(loaded) < 120
    assert max(map(len, done.stdout.splitlines())) <= 100


@pytest.mark.parametrize("flag", ["-h", "-help", "--help"])
def test_help_flags(flag, here):
    assert "Cases" in solve(flag).stdout
    text = solve("stub.py", flag, "-fsi_h", "x").stdout
    assert "-solid_force" in text
    assert "0.1 m" in text
    assert "plot RUN.h5 [-o DIR|FILE]" in solve("plot", flag).stdout


@pytest.mark.parametrize("flag", ["--version", "-version"])
def test_version(flag):
    done = solve(flag)
    assert (done.returncode, done.stdout.split()[0], len(done.stdout.split())) == (0, "fsipetsc", 2)


def test_run_gets_typed_options_from_everywhere(here):
    (here / "a.opts").write_text("# comment\n-fsi_order 6  # more\n\n-fsi_cfl 0.5\n")
    (here / "b.yaml").write_text(
        "fsi:\n  norm: L1\nfsi_output_times: [0.1, 0.5]\nfsi_quiet: true\n"
    )
    args = "-options_file a.opts -options_file b.yaml -fsi_cfl 0.7 -solid_force -10".split()
    done = start_stub(*args, env={"PETSC_OPTIONS": "-fsi_cfl 0.6 -ts_dt 0.25"})
    assert (done.returncode, done.stderr) == (0, "")
    again = run_stub(*args, petsc_options="-fsi_cfl 0.6 -ts_dt 0.25")
    opt = json.loads(done.stdout)
    assert (again.returncode, again.stderr, json.loads(again.stdout)) == (0, "", opt)
    assert (opt["fsi_order"], opt["fsi_norm"], opt["fsi_quiet"]) == (6, "L1", True)
    assert (opt["fsi_cfl"], opt["ts_dt"], opt["solid_force"]) == (0.7, 0.25, -10.0)
    assert opt["fsi_output_times"] == [0.1, 0.5]


BAD_INPUT = {
    "unknown option": (["-fsi_ordr", 4], 2, ["-fsi_ordr", "did you mean -fsi_order?"]),
    "no options file": (["-options_file", "no.opts"], 4, ["no.opts"]),
    "bad options file": (["-options_file", "bad.opts"], 2, ["bad.opts line 2"]),
    "too late": (["-options_file", "log.opts"], 2, ["-log_view works from the start of PETSc"]),
}


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
@pytest.mark.parametrize("name", BAD_INPUT)
def test_bad_input(name, ranks, here):
    """One message and one status on any number of ranks; nobody waits for one that has gone."""
    (here / "log.opts").write_text("-log_view\n")
    (here / "bad.opts").write_text("-fsi_h 0.1\nfsi_order 6\n")
    args, status, words = BAD_INPUT[name]
    if name == "unknown option":  # in processes of their own
        done = mpirun(ranks, "driver.py", "stub.py", *args)
    else:
        done = run_stub(*args, ranks=ranks)
    message(done, status, *words)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["info"], ["RUN.h5 is missing"]),
        (["info", "a.h5", "b.h5"], ["b.h5"]),
        (["info", "-x", "a.h5"], ["-x"]),
        (["plot", "a.h5", "-o"], ["-o needs a value", "plot RUN.h5 [-o DIR"]),
        (["plot", "a.h5", "-out", "b"], ["unexpected argument '-out'"]),
        (["diff", "a.h5", ""], ["unexpected argument ''"]),
    ],
)
def test_bad_arguments_of_commands(args, words):
    message(solve(*args), 2, *words)


@pytest.mark.parametrize(
    "command",
    ["info {}", "plot {}", "plot {} -all", "plot {} -animate", "report {}", "diff {} no.h5"],
)
def test_commands_that_read_a_result_say_what_a_file_is_instead(command, here, capsys):
    """One line, status 4, and nothing is written."""
    pytest.importorskip("matplotlib")
    files = {
        "no.h5": "there is no such file",
        "folder.h5": "is no regular file",
        "text.h5": "is not an HDF5 file",
        "other.h5": "is not a result of fsipetsc",
        "a.checkpoint.h5": "is a checkpoint of fsipetsc, not a result",
    }
    (here / "folder.h5").mkdir()
    (here / "text.h5").write_text("a text, longer than the signature of HDF5")
    h5py.File(here / "other.h5", "w").close()
    checkpoint_file.write(here / "a.checkpoint.h5", checkpoint_file.pack({}, {}))
    before = sorted(os.listdir(here))
    for name, reason in files.items():
        assert main(command.format(name).split()) == 4
        said = capsys.readouterr()
        assert (
            said.err.startswith(f"fsipetsc: error: {name}: {reason}") and said.err.count("\n") == 1
        ), said.err
        assert said.out == ""
    assert sorted(os.listdir(here)) == before


def test_a_result_is_no_case(here, capsys):
    (here / "rod.h5").touch()
    assert main(["rod.h5"]) == 2
    assert (
        "'rod.h5' is no case; results are for commands: info rod.h5, plot rod.h5"
        in capsys.readouterr().err
    )


#: the program where packages of the extra "solver" are missing
WITHOUT = """
import sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("numba", "mpi4py", "petsc4py"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Finder())
from fsipetsc.cli import main
sys.exit(main())
"""


@pytest.mark.parametrize(("line", "status"), [("rod", 2), ("stability", 2), ("mine.py -help", 2)])
def test_who_lacks_a_package_is_told_how_to_get_it(line, status, here):
    (here / "without.py").write_text(WITHOUT)
    (here / "mine.py").write_text("from fsipetsc.problem import Problem\nimport mpi4py\n")
    package = "numba" if "mine.py" in line else "mpi4py"
    words = [f"needs the Python package {package}", "scripts/setup"]
    said = message(run("without.py", *line.split()), status, *words)
    assert ("case file mine.py: " in said) == ("mine.py" in line), said


@pytest.mark.mpi
@pytest.mark.parametrize("args", [[], ["stub.py", "-help"], ["--version"]])
def test_texts_are_printed_once(args, here):
    done = solve(*args, ranks=2)
    assert done.returncode == 0
    assert done.stdout == solve(*args).stdout


# every kind of error

RAISED = {
    "from fsipetsc.errors import ComputationError as E; raise E('T <= 0')": (3, ["T <= 0"]),
    "open('/no/such/file')": (4, ["/no/such/file: No such file"]),
    "raise KeyboardInterrupt": (130, ["stopped by SIGINT"]),
    "import no_such_package": (2, ["needs the Python package no_such_package"]),
}
#: of the program itself
FAULTS = {
    "1 / 0": ["unexpected ZeroDivisionError"],
    "from petsc4py import PETSc; PETSc.TS().create().setType('nix')": [
        "PETSc error 86",
        "Unknown TS type: nix",
    ],
}


@pytest.mark.parametrize("code", RAISED)
def test_every_kind_of_error_is_one_message_and_its_status(code, here):
    status, words = RAISED[code]
    message(run_stub("-do", code), status, *words)


@pytest.mark.parametrize("code", FAULTS)
def test_an_error_of_the_program_shows_its_traceback_first(code, here):
    own = "petsc4py" in code  # where PETSc waits for all ranks that there are
    done = (start_stub if own else run_stub)("-do", code)
    assert done.returncode == 1 and done.stderr.startswith("Traceback")
    last = done.stderr.splitlines()[-1]
    assert last.startswith("fsipetsc: error: ") and all(word in last for word in FAULTS[code])


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("code", "status"),
    [
        ("1 / 0", 1),
        ("from fsipetsc.errors import ComputationError as E; raise E('T <= 0')", 3),
        ("from fsipetsc.errors import *; raise (FileError, InputError)[comm.rank]('a')", 4),
    ],
)
def test_all_ranks_fail_perhaps_with_different_errors(code, status, here):
    done = run_stub("-do", f"comm.barrier(); {code}", ranks=2)
    assert (done.returncode, done.stderr.count("fsipetsc: error: ")) == (status, 1), done.stderr
    assert "MPI_ABORT" not in done.stderr, "an error of all ranks ends in order"
    if status != 1:
        message(done, status)
