"""The table of options: reading, checking, defaults, and the help that comes from it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from fsipetsc.cases import load_case
from fsipetsc.errors import FileError, InputError
from fsipetsc.options import (
    COMMON,
    PETSC_OPTIONS,
    Option,
    defaults,
    given_options,
    groups,
    present,
    put,
    read_options,
    table,
)
from fsipetsc.stepping.solve import block_form
from fsipetsc.usage import options_help

petsc4py = pytest.importorskip("petsc4py")

OWN = (
    Option("solid_force", float, 0.0, "N/m³", "body force"),
    Option("solid_parts", "ints", (1, 2), "", "parts"),
    Option("solid_ratio", float, 0.5, "", "", check=lambda v: v < 1 or "a number below 1"),
    Option("solid_even", int, 2, "-", "even", check=lambda v: v % 2 == 0),
    Option("solid_law", str, "linear", "", "law", ("linear", "cubic")),
)


def make_case(**changes):
    case = {"NAME": "stub", "SUMMARY": "a stub", "OPTIONS": OWN}
    case["DEFAULTS"] = {"fsi_h": 0.0125, "ts_max_time": 2}
    return SimpleNamespace(**{**case, **changes})


@pytest.fixture
def database():
    """PETSc's database, left afterwards as it was found."""
    from petsc4py import PETSc

    before = present()
    yield PETSc.Options()
    put(before)


@pytest.fixture
def read(database):
    """A function that reads a case's options from a command line."""

    def reader(text="", case=None):
        given = given_options(text.split() if isinstance(text, str) else text)
        return read_options(case or make_case(), given)

    return reader


def test_defaults_come_from_the_case_and_then_from_the_table(read):
    opt = read()
    assert opt["fsi_h"] == 0.0125
    assert opt["ts_max_time"] == 2.0
    assert isinstance(opt["ts_max_time"], float)
    assert opt["fsi_order"] == 4
    assert opt["fsi_output"] == "stub.h5"
    assert opt["ts_rk_type"] == "4"
    assert opt["ts_dt"] is None
    assert set(opt) == {o.name for o in OWN + COMMON + PETSC_OPTIONS}


def test_every_type_is_converted(read):
    opt = read(
        "-fsi_order 6 -fsi_h 1e-3 -fsi_quiet -fsi_output_times 0,0.25,1 "
        "-solid_parts 3,-4 -solid_law cubic"
    )
    assert (opt["fsi_order"], opt["fsi_h"], opt["fsi_quiet"]) == (6, 1e-3, True)
    assert opt["fsi_output_times"] == (0.0, 0.25, 1.0)
    assert opt["solid_parts"] == (3, -4)
    assert opt["solid_law"] == "cubic"


@pytest.mark.parametrize("name", ["my result.h5", "my' result"])
def test_long_lists_and_values_with_blanks_arrive_whole(read, name):
    times = [i / 7 for i in range(500)]
    opt = read(
        ["-fsi_output_times", ",".join(map(repr, times)), "-fsi_output", name, "-fsi_cfl", "0.25"]
    )
    assert opt["fsi_output_times"] == tuple(times)
    assert (opt["fsi_output"], opt["fsi_order"], opt["fsi_cfl"]) == (name, 4, 0.25)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("-fsi_cfl abc", ["-fsi_cfl", "'abc'", "a number above 0"]),
        ("-fsi_cfl", ["-fsi_cfl needs a value"]),
        ("-fsi_h nan", ["-fsi_h", "[m]"]),
        ("-fsi_order 5", ["-fsi_order", "2, 4, 6, 8"]),
        ("-ts_max_steps 1e3", ["-ts_max_steps", "a whole number"]),
        ("-fsi_quiet maybe", ["-fsi_quiet", "true or false"]),
        ("-fsi_output_times 1,0.5", ["-fsi_output_times", "increase"]),
        ("-solid_ratio 2", ["-solid_ratio", "a number below 1"]),
        ("-ts_adapt_type basic", ["-ts_adapt_type", "'basic'", "none"]),
        ("0.1", ["unexpected argument '0.1'"]),
        ("-fsi_h 0.1 0.2", ["unexpected argument '0.2'"]),
        ("-fsi_ordr 4", ["-fsi_ordr", "did you mean -fsi_order?"]),
        ("-ts_max_tme 4", ["-ts_max_tme", "did you mean -ts_max_time?"]),
        ("-snes_type 2.0", ["-snes_type", "no effect"]),
        ("-fsi_h=0.1", ["without ="]),
        ("-xyzzy", ["-xyzzy", "-help"]),
        ("-xyzzy -fsi_ordr 4", ["-xyzzy", "-fsi_ordr"]),
    ],
)
def test_bad_input_is_refused_and_named(read, text, words):
    with pytest.raises(InputError) as caught:
        read(text)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_options_of_petsc_are_accepted(read, database):
    read("-ts_monitor -malloc_debug no")
    assert database.hasName("ts_monitor")
    assert given_options(["-log_view", ":log"]) == {"log_view": ":log"}
    assert not database.hasName("ts_monitor"), "an option of an earlier run"
    assert read("-ts_ssp_type rks3")["ts_type"] == "ssp"
    opt = read("-ts_rk_type 5dp -ts_view")
    assert (opt["ts_type"], opt["ts_rk_type"]) == ("rk", "5dp") and database.hasName("ts_view")


def test_time_step_has_the_name_that_this_petsc_knows(read, database):
    from petsc4py import PETSc

    assert read("-ts_time_step 0.25")["ts_dt"] == 0.25
    new = PETSc.Sys.getVersion() >= (3, 25)
    assert (database.hasName("ts_dt"), database.hasName("ts_time_step")) == (not new, new)


def test_interval_and_times_of_output_replace_each_other(read):
    case = make_case(DEFAULTS={"fsi_h": 0.1, "ts_max_time": 2.0, "fsi_output_dt": 0.02})
    assert read("-fsi_output_times 0.1,0.2", case)["fsi_output_dt"] is None
    both = read("-fsi_output_dt 0.5 -fsi_output_times 0.1,0.2", case)
    assert (both["fsi_output_dt"], both["fsi_output_times"]) == (0.5, (0.1, 0.2)), (
        "both given: both in force"
    )


def test_what_was_not_set_is_not_set_after_a_restart(database):
    """Though the case has a default; a value that there cannot be is refused."""
    case = make_case(DEFAULTS={"fsi_h": 0.1, "ts_max_time": 2.0, "fsi_output_dt": 0.02})
    assert read_options(case, {}, inherited={"fsi_output_dt": None})["fsi_output_dt"] is None
    with pytest.raises(InputError, match="bad default None of -fsi_order"):
        read_options(case, {}, inherited={"fsi_order": None})


def test_option_without_default_must_be_given(read):
    case = make_case(DEFAULTS={"ts_max_time": 1.0})
    with pytest.raises(InputError, match="-fsi_h must be given"):
        read("", case)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"DEFAULTS": {"fsi_hh": 1.0}}, ["fsi_hh", "did you mean -fsi_h?"]),
        ({"DEFAULTS": {"fsi_h": "fine"}}, ["-fsi_h", "'fine'", "a number above 0"]),
        ({"OPTIONS": (Option("fsi_h", float, 1.0, "", ""),)}, ["-fsi_h", "exists already"]),
        ({"OPTIONS": OWN + OWN[:1]}, ["-solid_force", "exists already"]),
        ({"OPTIONS": (Option("a", float, -1.0, "", "", check="positive"),)}, ["-a", "-1.0"]),
    ],
)
def test_faults_of_a_case_are_named(changes, words):
    with pytest.raises(InputError) as caught:
        table(make_case(**changes))
    for word in ["stub", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("name", "kind"), [("-fsi", int), ("a b", int), ("a", list), ("a", "vector")]
)
def test_option_that_could_never_be_read_is_refused(name, kind):
    with pytest.raises((TypeError, ValueError)):
        Option(name, kind, None, "", "")


def test_help_shows_every_option_with_type_default_unit_and_choices():
    text = options_help("stub", "stub", groups(make_case()))
    rows = {line.split()[0]: line for line in text.splitlines() if line.startswith("  -")}
    for name in [*defaults(make_case()), "ts_monitor", "log_view", "options_file", "malloc_debug"]:
        assert f"-{name}" in rows
    assert "0.0125 m" in rows["-fsi_h"] and "float" in rows["-fsi_h"]
    assert "2, 4, 6, 8" in rows["-fsi_order"] and "no limit" in rows["-ts_max_steps"]
    assert "0 N/m³" in rows["-solid_force"] and "stub.h5" in rows["-fsi_output"]
    assert max(map(len, text.splitlines())) <= 120
    text = options_help("verify", "verify", {}, in_loop=False)
    assert "-options_file_yaml" in text and "-log_view" in text and "-ts_monitor" not in text


@pytest.fixture
def here(tmp_path, monkeypatch, database):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_line_comes_last_and_files_where_they_are_named(here, monkeypatch):
    (here / "a.opts").write_text("# -options_file b\n-a 1 # more\n\n-b x\n-c\n")
    (here / "a.yaml").write_text("fsi:\n  h: 0.1\ntimes: [1, 2.50]\ntext: 'a: b'\n")
    in_file = {"a": "1", "b": "x", "c": ""}
    assert given_options(["-A", "2", "-options_file", "a.opts"]) == in_file
    assert given_options(["-options_file", "a.opts", "-a", "2"]) == {**in_file, "a": "2"}
    in_yaml = {"fsi_h": "0.1", "times": "1,2.50", "text": "a: b"}
    assert given_options(["-options_file", "a.yaml"]) == in_yaml
    monkeypatch.setenv("PETSC_OPTIONS", "-a\t2\n-d")
    assert given_options(["-a", "-3", "-help"]) == {"a": "-3", "d": ""}


FAULTY = {
    "none.opts": (FileError, "none.opts"),
    "three.opts": (InputError, "three.opts line 2"),
    "word.opts": (InputError, "word.opts line 1"),
    "brace.yaml": (InputError, "YAML"),
    "self.opts": (InputError, "self.opts: an options file cannot name another one"),
}


@pytest.mark.parametrize("name", FAULTY)
def test_faulty_file(name, here):
    (here / "three.opts").write_text("-a 1\n-b 2 3\n")
    (here / "word.opts").write_text("fsi_order 6\n")
    (here / "brace.yaml").write_text("a: {\n")
    (here / "self.opts").write_text("-a 1\n-b 2 -options_file self.opts\n")
    kind, words = FAULTY[name]
    with pytest.raises(kind, match=words) as caught:
        given_options(["-options_file", name])
    assert present() == {}
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("fsi_coupling", "energy", "energy: this case is made of blocks: expected conservative$"),
        ("fsi_viscous", "narrow", "narrow: with -fsi_coupling conservative it is wide; "),
    ],
)
def test_methods_that_blocks_do_not_have(name, value, said):
    opt = {**defaults(load_case("blast")), name: value}
    with pytest.raises(InputError, match=f"^-{name} {said}"):
        block_form(opt)
