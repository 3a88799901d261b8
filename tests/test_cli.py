"""The command line as users and scripts meet it: texts, exit status, one message on one rank and on two."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from helpers import environment, mpirun, run

from fsipetsc.cases import BUILT_IN, load_case
from fsipetsc.errors import InputError

#: the program with a stand-in for the solver: it prints the options, or does what the case's option -do says
DRIVER = """
import json, sys, types

def run_case(case, options, comm):
    exec(options["do"], {"comm": comm, "case": case, "options": options})
    if comm.rank == 0:
        print(json.dumps(options), flush=True)

for name in ("fsipetsc.stepping", "fsipetsc.stepping.run"):
    sys.modules[name] = types.ModuleType(name)
sys.modules["fsipetsc.stepping.run"].run_case = run_case
from fsipetsc.cli import main
sys.exit(main())
"""
CASE = """
from fsipetsc.options import Option

SUMMARY = "a stub"
OPTIONS = (Option("solid_force", float, 0.0, "N", "force"), Option("do", str, "", "", "what to do"))
DEFAULTS = {"fsi_h": 0.1, "ts_max_time": 1.0}


def build(opt):
    return opt["no_such_option"]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty directory with the driver and a case file, as the working directory."""
    (tmp_path / "driver.py").write_text(DRIVER)
    (tmp_path / "stub.py").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def one_message(done, status, *words):
    """Assert the exit status and that stderr holds one message of ours, no traceback, with all the words."""
    assert done.returncode == status, done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith("fsipetsc: error: ")]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert "Traceback" not in done.stderr
    assert "PETSC ERROR" not in done.stderr


def run_stub(*args, **more):
    return run("driver.py", "stub.py", *args, **more)


def test_overview_lists_cases_and_commands_without_importing_the_solver():
    """So that it takes no time that could be noticed: nothing but the standard library, and little of ours."""
    code = "import sys; old = set(sys.modules); from fsipetsc.cli import main; main([]); "
    done = run("-c", code + "print(*sorted(set(sys.modules) - old), file=sys.stderr)")
    assert done.returncode == 0
    for word in ("Cases", "rod", "mms", "pulse", "Commands", "info RUN.h5", "plot RUN.h5"):
        assert word in done.stdout
    loaded = done.stderr.split()
    assert {name.split(".")[0] for name in loaded} <= {"fsipetsc", *sys.stdlib_module_names}
    assert len(loaded) < 120


@pytest.mark.parametrize("flag", ["-h", "-help", "--help"])
def test_help_flags(flag, here):
    assert "Cases" in run("-m", "fsipetsc", flag).stdout
    text = run("-m", "fsipetsc", "stub.py", flag, "-fsi_h", "x").stdout
    assert "-solid_force" in text
    assert "0.1 m" in text
    assert "plot RUN.h5 [-o DIR]" in run("-m", "fsipetsc", "plot", flag).stdout


@pytest.mark.parametrize("flag", ["--version", "-version"])
def test_version(flag):
    done = run("-m", "fsipetsc", flag)
    assert (done.returncode, done.stdout.split()[0], len(done.stdout.split())) == (0, "fsipetsc", 2)


def test_summaries_in_the_overview_are_those_of_the_modules():
    pytest.importorskip("numba")
    from fsipetsc.cases import summaries

    for name, summary in summaries().items():
        if summary:
            assert load_case(name).SUMMARY == summary


def test_run_gets_typed_options_from_everywhere(here):
    (here / "a.opts").write_text("# comment\n-fsi_order 6  # more\n\n-fsi_cfl 0.5\n")
    (here / "b.yaml").write_text("fsi:\n  spare: 3\nfsi_output_times: [0.1, 0.5]\nfsi_quiet: true\n")
    args = ["-options_file", "a.opts", "-options_file", "b.yaml", "-fsi_cfl", 0.7, "-solid_force", -10]
    done = run_stub(*args, env={"PETSC_OPTIONS": "-fsi_cfl 0.6 -ts_dt 0.25"})
    assert (done.returncode, done.stderr) == (0, "")
    opt = json.loads(done.stdout)
    assert (opt["fsi_order"], opt["fsi_spare"], opt["fsi_quiet"]) == (6, 3, True)
    assert (opt["fsi_cfl"], opt["ts_dt"], opt["solid_force"]) == (0.7, 0.25, -10.0)
    assert opt["fsi_output_times"] == [0.1, 0.5]


BAD_INPUT = {
    "unknown option": (["-fsi_ordr", 4], 2, ["-fsi_ordr", "did you mean -fsi_order?"]),
    "unknown option of PETSc's": (["-ts_max_tme", 4], 2, ["did you mean -ts_max_time?"]),
    "two dashes": (["--fsi_cfl", 0.5], 2, ["--fsi_cfl", "write -fsi_cfl"]),
    "bad value": (["-fsi_cfl", "abc"], 2, ["-fsi_cfl", "'abc'", "a number above 0"]),
    "positional argument": (["foo"], 2, ["'foo'"]),
    "no options file": (["-options_file", "no.opts"], 4, ["no.opts", "No such file"]),
    "directory as options file": (["-options_file", "."], 4, ["directory"]),
    "options file not named": (["-options_file"], 2, ["-options_file needs"]),
    "no YAML file": (["-options_file_yaml", "no.yaml"], 4, ["no.yaml", "No such file"]),
    "bad options file": (["-options_file", "bad.opts"], 2, ["bad.opts, line 2", "'fsi_order'"]),
    "two options in a line": (["-options_file", "two.opts"], 2, ["two.opts, line 1"]),
    "bad YAML file": (["-options_file", "bad.yaml"], 2, ["bad.yaml"]),
    "bad value for PETSc": (["-malloc_debug", "foo"], 2, ["foo"]),
}


@pytest.mark.parametrize("name", BAD_INPUT)
def test_bad_input(name, here):
    (here / "bad.opts").write_text("-fsi_h 0.1\nfsi_order 6\n")
    (here / "two.opts").write_text("-fsi_h 0.1 -fsi_order 6\n")
    (here / "bad.yaml").write_text("fsi_h: [0.1\nfsi_order: 6\n")
    args, status, words = BAD_INPUT[name]
    one_message(run_stub(*args), status, *words)


def test_bad_words_in_the_environment(here):
    one_message(run_stub(env={"PETSC_OPTIONS": "fsi_h 3"}), 2, "'fsi_h'", "PETSC_OPTIONS")
    for flag in ("-h", "-help", "--help"):  # it would be passed over in silence
        one_message(run_stub(env={"PETSC_OPTIONS": f"-fsi_order 6 {flag}"}), 2, f"{flag} in PETSC_OPTIONS", "command line")
    (here / "help.opts").write_text("-fsi_order 6\n-help\n")
    one_message(run_stub("-options_file", "help.opts"), 2, "-help (options file help.opts, line 2)")


@pytest.mark.parametrize("args", [["rdo"], ["inf", "x.h5"], ["stub"], ["no.py"], ["no/case.py"]])
def test_unknown_case_or_command(args, here):
    hint = {"rdo": "'rod'", "inf": "'info'", "stub": "'stub.py'"}.get(args[0], args[0])
    one_message(run("-m", "fsipetsc", *args), 2, hint)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["info"], ["one result file", "info RUN.h5"]),
        (["info", "a.h5", "b.h5"], ["2 were given"]),
        (["info", "-x", "a.h5"], ["-x"]),
        (["plot", "a.h5", "-o"], ["-o needs"]),
    ],
)
def test_bad_arguments_of_commands(args, words):
    one_message(run("-m", "fsipetsc", *args), 2, *words)


@pytest.mark.parametrize("command", ["info", "plot"])
def test_commands_report_a_file_that_is_not_there(command, here):
    pytest.importorskip("fsipetsc.output.plots")
    pytest.importorskip("fsipetsc.output.info")
    one_message(run("-m", "fsipetsc", command, "no.h5"), 4, "no.h5")


FAULTY_FILES = {
    "syntax": ("x = 1\nx = = 2\n", ["line 2", "invalid syntax"]),
    "import": ("import math\nimport no_such_module\n", ["line 2", "no_such_module"]),
    "name": ("\n\nundefined\n", ["line 3", "NameError", "undefined"]),
    "deep": ("import json\n\njson.loads('{')\n", ["line 3", "JSONDecodeError"]),
    "exit": ("raise SystemExit(3)\n", ["line 1", "SystemExit"]),
    "option": ("from fsipetsc.options import Option\nOPTIONS = (Option('-a', int, 1, '', ''),)\n", ["line 2", "'-a'"]),
    "no build": (CASE.replace("def build", "def bild"), ["does not define", "build(opt)"]),
    "no options": (CASE.replace("OPTIONS =", "OPTION ="), ["does not define", "OPTIONS"]),
    "options": ("build = print\n\nOPTIONS = (1,)\n", ["line 3", "OPTIONS", "number 1 is 1"]),
    "build": ("OPTIONS = ()\nbuild = 3\n", ["line 2", "build", "function"]),
    "defaults": ("OPTIONS = ()\nbuild = print\nDEFAULTS = {'fsi_hh': 1}\n", ["line 3", "did you mean -fsi_h?"]),
    "own names": (CASE.replace("solid_force", "fsi_h"), ["line 5", "exists already"]),
    "beside": ("import math\nimport beside_a_faulty_case\n", ["line 2: ", "beside_a_faulty_case.py, line 3: NameError"]),
    "syntax beside": ("import syntax_beside_a_faulty_case\n", ["line 1: ", "syntax_beside_a_faulty_case.py, line 2: invalid"]),
    "from": ("from math import nothing\n", ["line 1", "ImportError", "'nothing'"]),
    "encoding": ("# coding: nonsense\n", ["faulty.py: unknown encoding: nonsense"]),
    "null": ("x = 1\0\n", ["null bytes"]),
    **{
        f"name {name!r}": (f"OPTIONS = ()\ndef build(opt): ...\nNAME = {name!r}\n", ["line 3", "NAME", "without a directory"])
        for name in ("a/b", "../up", "/tmp/x", ".", "..", "a\nb", "a\0b", "a\udcffb")
    },
    "no name": ("OPTIONS = ()\ndef build(opt): ...\nNAME = ''\n", ["line 3", "NAME", "a text"]),
}


@pytest.mark.parametrize("name", FAULTY_FILES)
def test_faulty_case_file(name, here):
    text, words = FAULTY_FILES[name]
    (here / "faulty.py").write_text(text)
    (here / "beside_a_faulty_case.py").write_text("def f():\n    x = 1\n    undefined\n\nf()\n")
    (here / "syntax_beside_a_faulty_case.py").write_text("x = 1\nx = = 2\n")
    with pytest.raises(InputError) as caught:
        load_case("faulty.py")
    for word in ["case file faulty.py", *words]:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (here / "__pycache__").exists()


def test_a_pipe_is_no_case_file(here):
    """It could be read once, by one rank; and a pipe that nobody writes into would be waited for."""
    os.mkfifo(here / "pipe.py")
    one_message(run("-m", "fsipetsc", "pipe.py"), 2, "pipe.py: not a regular file")
    with pytest.raises(InputError, match="null"):
        load_case("a\0.py")


def test_case_file_may_leave_out_what_has_a_default(here):
    (here / "small-case.py").write_text("OPTIONS = ()\ndef build(opt): pass\n")
    case = load_case("small-case.py")
    assert (case.NAME, case.SUMMARY, case.DEFAULTS) == ("small-case", "", {})


def test_case_file_finds_its_neighbours_from_any_directory(here, monkeypatch):
    (here / "neighbour_of_stub.py").write_text("NUMBER = 5\n")
    (here / "stub.py").write_text(CASE + "\nfrom neighbour_of_stub import NUMBER\n")
    monkeypatch.chdir(here.parent)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert load_case(str(here / "stub.py")).NUMBER == 5


def test_unknown_name_lists_the_cases():
    with pytest.raises(InputError, match=", ".join(BUILT_IN)):
        load_case("xyzzy")


RAISED = {
    "from fsipetsc.errors import ComputationError as E; raise E('T <= 0')": (3, ["T <= 0"]),
    "from fsipetsc.errors import FileError as E; raise E('disk')": (4, ["disk"]),
    "open('/no/such/file')": (4, ["/no/such/file: No such file"]),
    "raise MemoryError": (3, ["out of memory", "-fsi_h"]),
    "raise KeyboardInterrupt": (130, ["interrupted"]),
    "import no_such_package": (1, ["no_such_package"]),
    "case.build(options)": (2, ["stub.py, line 10", "KeyError"]),
    "1 / 0": (1, ["ZeroDivisionError", "-fsi_debug"]),
    "from petsc4py import PETSc; PETSc.TS().create().setType('nix')": (1, ["PETSc error 86", "Unknown TS type: nix"]),
}


@pytest.mark.parametrize("code", RAISED)
def test_every_kind_of_error_is_one_message_and_its_status(code, here):
    status, words = RAISED[code]
    one_message(run_stub("-do", code), status, *words)


def test_debug_shows_the_traceback(here):
    done = run_stub("-do", "1 / 0", "-fsi_debug")
    assert done.returncode == 1
    assert done.stderr.startswith("Traceback")
    assert done.stderr.splitlines()[-1].startswith("fsipetsc: error: ")


@pytest.mark.parametrize("line", ["info no.h5", "plot no.h5", "convergence mms -no 1", "stability -no 1", "bench -no 1"])
def test_every_command_shows_the_traceback(line, here):
    done = run("-m", "fsipetsc", *line.split(), "-fsi_debug")
    assert done.returncode == (4 if "no.h5" in line else 2), done.stderr
    assert done.stderr.startswith("Traceback")
    assert done.stderr.splitlines()[-1].startswith("fsipetsc: error: ")


def test_the_option_that_shows_the_traceback_counts_wherever_it_is_given(here):
    (here / "debug.opts").write_text("-fsi_debug\n")
    done = run("-m", "fsipetsc", "stability", "-no", 1, env={"PETSC_OPTIONS": "-options_file debug.opts"})
    assert done.stderr.startswith("Traceback")
    one_message(run("-m", "fsipetsc", "stability", "-no", 1, "-fsi_debug", "no"), 2, "-no")


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


@pytest.mark.parametrize(("line", "status"), [("rod", 1), ("stability", 1), ("mine.py -help", 2)])
def test_who_lacks_a_package_is_told_how_to_get_it(line, status, here):
    (here / "without.py").write_text(WITHOUT)
    (here / "mine.py").write_text("from fsipetsc.problem import Problem\nimport mpi4py\n")
    words = ["scripts/setup", "pip install '.[solver]'", "mpi4py"]
    one_message(run("without.py", *line.split()), status, *words)


HELP_OF_ALL = """
import contextlib, io, json, sys
from fsipetsc.cli import main

said = {}
for line in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(out):
        status = main([*line.split(), "-help"])
    said[line] = status, out.getvalue()
print(json.dumps(said))
"""
#: a case file that uses numba itself
COMPILED_CASE = """
import numba
from numba import float64, njit, types
from fsipetsc.options import Option
from fsipetsc.physics.own_laws import transport_law
from fsipetsc.problem import Problem
OPTIONS = (Option("own_speed", float, 2.5, "m/s", "speed"),)

@njit
def one(X, t):
    return X

@numba.njit("f8(f8)", cache=True)
def two(X):
    return X

@numba.vectorize([float64(float64)])
def three(x):
    return x

def build(opt):
    raise ValueError
"""


def test_help_needs_no_compiler(here):
    """Without numba -help of every case and command is what it is with it, and a last line says what is missing."""
    (here / "mine.py").write_text(COMPILED_CASE)
    (here / "without.py").write_text(WITHOUT.split("from fsipetsc")[0] + HELP_OF_ALL)
    (here / "with.py").write_text(HELP_OF_ALL)
    lines = json.dumps([*BUILT_IN, "mine.py", "convergence mms", "convergence", "stability", "bench"])
    complete, without = (run(program, lines) for program in ("with.py", "without.py"))
    assert (complete.stderr, without.stderr) == ("", "")
    expected = json.loads(complete.stdout)
    for line, (status, text) in json.loads(without.stdout).items():
        assert expected[line][0] == status == 0, text
        said, last = text.rsplit("\n\n", 1)
        assert said == expected[line][1].rstrip("\n")
        assert last.startswith("To run, this needs the Python package numba") and "scripts/setup" in last
    assert "2.5 m/s" in expected["mine.py"][1]


def test_reader_that_closes_early_is_no_error(here):
    command = [sys.executable, "-m", "fsipetsc", "stub.py", "-help"]
    with subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 0


@pytest.mark.mpi
class TestOnTwoRanks:
    """One message and one status whatever the number of ranks, and nobody waits for a rank that has gone."""

    @pytest.mark.parametrize("name", ["unknown option", "bad options file", "no options file", "bad YAML file"])
    def test_bad_input(self, name, here):
        (here / "bad.opts").write_text("-fsi_h 0.1\nfsi_order 6\n")
        (here / "bad.yaml").write_text("fsi_h: [0.1\nfsi_order: 6\n")
        args, status, words = BAD_INPUT[name]
        one_message(mpirun(2, "driver.py", "stub.py", *args), status, *words)

    def test_unknown_case(self, here):
        one_message(mpirun(2, "-m", "fsipetsc", "rdo"), 2, "'rod'")

    @pytest.mark.parametrize("args", [[], ["stub.py", "-help"], ["--version"]])
    def test_texts_are_printed_once(self, args, here):
        done = mpirun(2, "-m", "fsipetsc", *args)
        assert done.returncode == 0
        assert done.stdout == run("-m", "fsipetsc", *args).stdout

    def test_run(self, here):
        done = mpirun(2, "driver.py", "stub.py", "-fsi_order", 8)
        assert (done.returncode, done.stderr) == (0, "")
        assert json.loads(done.stdout)["fsi_order"] == 8

    @pytest.mark.parametrize("rank", [0, 1])
    def test_one_rank_fails_alone(self, rank, here):
        code = f"comm.rank == {rank} and 1 / 0; comm.barrier()"
        done = mpirun(2, "driver.py", "stub.py", "-do", code)
        one_message(done, 1, "ZeroDivisionError")

    @pytest.mark.slow
    def test_one_rank_fails_alone_with_an_error_said_to_be_common(self, here):
        code = "from fsipetsc.errors import ComputationError as E\nif comm.rank == 1: raise E('T <= 0')\ncomm.barrier()"
        done = mpirun(2, "driver.py", "stub.py", "-do", code)
        one_message(done, 3, "T <= 0")

    @pytest.mark.parametrize("code", ["1 / 0", "from fsipetsc.errors import ComputationError as E; raise E('T <= 0')"])
    def test_all_ranks_fail(self, code, here):
        done = mpirun(2, "driver.py", "stub.py", "-do", f"comm.barrier(); {code}")
        one_message(done, 3 if "Computation" in code else 1)
        assert "MPI_ABORT" not in done.stderr, "an error of all ranks ends in order"

    def test_ranks_disagree_about_the_error(self, here):
        code = "from fsipetsc.errors import *; raise (FileError, InputError)[comm.rank]('rank %d' % comm.rank)"
        one_message(mpirun(2, "driver.py", "stub.py", "-do", code), 4, "rank 0")


def test_helpers_do_not_leave_the_callers_petsc_options(monkeypatch):
    monkeypatch.setenv("PETSC_OPTIONS", "-nonsense")
    assert "PETSC_OPTIONS" not in environment()
    assert os.environ["PETSC_OPTIONS"] == "-nonsense"
