"""The command line as users and scripts meet it: texts, options and what becomes of them."""

from types import SimpleNamespace

import pytest
from helpers import run, solve

import fsipetsc
from fsipetsc import options

CASE = SimpleNamespace(
    NAME="stub",
    SUMMARY="a stub",
    OPTIONS=(
        options.Option("solid_parts", "ints", (1, 2), "", "parts"),
        options.Option("solid_law", str, "linear", "-", "law", ("linear", "cubic")),
    ),
    DEFAULTS={"fsi_h": 0.0125, "ts_max_time": 2, "fsi_output_dt": 0.02},
)


@pytest.fixture
def read():
    """Reads a case's options from a command line; PETSc's database is left as it was found."""
    before = options.present()

    def reader(text):
        words = text.split() if isinstance(text, str) else text
        return options.read_options(CASE, options.given_options(words))

    yield reader
    options.put(before)


def test_every_type_is_converted_and_long_lists_and_blanks_arrive_whole(read):
    name = "my' result.h5"
    times = [i / 7 for i in range(500)]
    text = "-fsi_order 6 -fsi_h 1e-3 -fsi_quiet -solid_parts 3,-4 -solid_law cubic"
    listed = ",".join(map(repr, times))
    opt = read([*text.split(), "-fsi_output_times", listed, "-fsi_output", name])
    assert (opt["fsi_order"], opt["fsi_h"], opt["fsi_quiet"]) == (6, 1e-3, True)
    assert (opt["solid_parts"], opt["solid_law"], opt["fsi_output"]) == ((3, -4), "cubic", name)
    assert opt["fsi_output_times"] == tuple(times) and CASE.OPTIONS[1].unit == ""


def test_options_of_petsc_are_accepted(read):
    from petsc4py import PETSc

    database = PETSc.Options()
    read("-ts_monitor -options_left no")
    assert database.hasName("ts_monitor")
    assert read("-ts_ssp_type rks3")["ts_type"] == "ssp"
    assert not database.hasName("ts_monitor"), "an option of an earlier run"
    opt = read("-ts_rk_type 5dp -ts_view")
    assert (opt["ts_type"], opt["ts_rk_type"]) == ("rk", "5dp") and database.hasName("ts_view")
    assert read("-ts_time_step 0.25")["ts_dt"] == 0.25  # it has the name that this PETSc knows
    new = PETSc.Sys.getVersion() >= (3, 25)
    assert (database.hasName("ts_dt"), database.hasName("ts_time_step")) == (not new, new)


def test_interval_and_times_of_output_replace_each_other(read):
    """And what was not set is not set after a restart, though the case has a default."""
    assert read("-fsi_output_times 0.1,0.2")["fsi_output_dt"] is None
    both = read("-fsi_output_dt 0.5 -fsi_output_times 0.1,0.2")
    assert (both["fsi_output_dt"], both["fsi_output_times"]) == (0.5, (0.1, 0.2))
    again = options.read_options(CASE, {}, inherited={"fsi_output_dt": None})
    assert again["fsi_output_dt"] is None


def test_overview_lists_cases_and_commands_without_importing_the_solver():
    code = "import sys; old = set(sys.modules); from fsipetsc.cli import main; main([]); "
    done = run("-c", code + "print(*sorted(set(sys.modules) - old), file=sys.stderr)")
    assert done.returncode == 0
    loaded = {name.split(".")[0] for name in done.stderr.split()}
    assert not loaded & {"petsc4py", "mpi4py", "scipy", "h5py", "matplotlib"}
    assert max(map(len, done.stdout.splitlines())) <= 100


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("", ["Cases", "rod", "mms", "pulse", "Commands", "info RUN.h5", "plot RUN.h5"]),
        ("-h", ["Cases"]),
        ("rod -help -fsi_h x", ["-rod_gravity", "float -10 [m/s2]", "2, 4, 6, 8", "-fsi_h float"]),
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
