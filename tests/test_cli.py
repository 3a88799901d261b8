"""The command line as users and scripts meet it: texts, options, arguments, every kind of error."""

import sys

import pytest
from helpers import message, run, solve

import fsipetsc


def test_overview_lists_cases_and_commands_without_importing_the_solver():
    """So that it takes no time that could be noticed: nothing but the standard library."""
    code = "import sys; old = set(sys.modules); from fsipetsc.cli import main; main([]); "
    done = run("-c", code + "print(*sorted(set(sys.modules) - old), file=sys.stderr)")
    assert done.returncode == 0
    for word in ("Cases", "rod", "mms", "pulse", "Commands", "info RUN.h5", "plot RUN.h5"):
        assert word in done.stdout
    loaded = {name.split(".")[0] for name in done.stderr.split()}
    assert loaded <= {"fsipetsc", *sys.stdlib_module_names}
    assert max(map(len, done.stdout.splitlines())) <= 100


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("", ["Cases"]),
        ("-h", ["Cases"]),
        ("rod -help -fsi_h x", ["-rod_gravity", "-10 m/s2", "2, 4, 6, 8", "-fsi_h float"]),
        ("plot --help", ["plot RUN.h5 [-o DIR|FILE]"]),
        ("compile rod -help", ["compile CASE [-option value ...]", "-rod_gravity", "-log_view"]),
        ("--version", [f"fsipetsc {fsipetsc.__version__}\n"]),
    ],
)
def test_texts_are_printed_once(line, words):
    one, two = (solve(*line.split(), ranks=ranks) for ranks in (1, 2))
    assert (one.returncode, two.returncode, two.stdout) == (0, 0, one.stdout)
    for word in words:
        assert word in one.stdout


def test_run_gets_typed_options_from_everywhere(here):
    """The command line comes last, and files where they are named."""
    (here / "a.opts").write_text("# -options_file b\n-fsi_order 2  # more\n\n-fsi_cfl 0.5\n")
    (here / "b.yaml").write_text("fsi:\n  norm: L1\n  quiet: true\nfsi_output_times: [0.1, 0.5]\n")
    files = "-options_file a.opts -options_file b.yaml"
    words = f"rod -FSI_Order 6 {files} -fsi_cfl 0.7 -rod_gravity -10 -fsi_h 0.1 -ts_max_steps 1"
    given = {"PETSC_OPTIONS": "-fsi_cfl 0.6 -ts_dt 2e-5"}
    done = run("-m", "fsipetsc", *words.split(), env=given)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    with fsipetsc.open_run("rod.h5") as result:
        opt = result.options
        assert result.series["t"].tolist() == [2e-5]
    assert (opt["fsi_order"], opt["fsi_norm"], opt["fsi_quiet"]) == (2, "L1", True)
    assert (opt["fsi_cfl"], opt["ts_dt"], opt["rod_gravity"]) == (0.7, 2e-5, -10.0)
    assert list(opt["fsi_output_times"]) == [0.1, 0.5]


#: the program where packages of the extra "solver" are missing
WITHOUT = """
import sys
sys.modules |= dict.fromkeys(("scipy", "mpi4py", "petsc4py"))
from fsipetsc.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(("line", "package"), [("rod", "mpi4py"), ("mine.py -help", "mpi4py")])
def test_who_lacks_a_package_is_told_how_to_get_it(line, package, here):
    (here / "mine.py").write_text("from fsipetsc.problem import Problem\nimport mpi4py\n")
    words = f"needs the Python package {package}", "scripts/setup"
    said = message(run("-c", WITHOUT, *line.split()), 2, *words)
    assert ("mine.py, line 2: case file mine.py: " in said) == ("mine.py" in line), said
