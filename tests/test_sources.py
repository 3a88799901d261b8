"""Options from wherever they may come, whatever is written there: read as meant, or refused in one message."""

from __future__ import annotations

import random

import pytest

from fsipetsc.cases import rod
from fsipetsc.errors import FsiError, InputError
from fsipetsc.options import check_petsc, publish, read_options, table
from fsipetsc.options.petsc_names import AT_START, IN_LOOP
from fsipetsc.options.sources import given_options

pytest.importorskip("petsc4py")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def texts(*words, environment=""):
    return {name: one.text for name, one in given_options(words, {"PETSC_OPTIONS": environment}).items()}


def test_the_command_line_comes_last_and_files_where_they_are_named(here):
    (here / "a.opts").write_text("! a comment\n-a 1 # more\n\n-b 'x y'\n-c\n")
    (here / ".petscrc").write_text("-a 0\n-z 0\n")
    assert texts("-a", "-3", environment="-a 2 -d") == {"a": "-3", "z": "0", "d": ""}
    assert texts("-a", "2", "-options_file", "a.opts") == {"a": "1", "b": "x y", "c": "", "z": "0"}
    assert texts("-skip_petscrc", "-A", "1", "-help") == {"a": "1"}


def test_yaml(here):
    (here / "a.yaml").write_text("fsi:\n  h: 0.1\n  output: {dt: 1e-3}\ntimes: [1, 2.50]\nquiet:\ntext: 'a: b'\n")
    expected = {"fsi_h": "0.1", "fsi_output_dt": "1e-3", "times": "1,2.50", "quiet": "", "text": "a: b"}
    assert texts("-options_file", "a.yaml") == texts("-options_file_yaml", "a.yaml") == expected


FAULTY = {
    "itself.opts": ("-options_file itself.opts\n", "names itself"),
    "there.opts": ("-options_file back.opts\n", "names itself"),
    "back.opts": ("-options_file there.opts\n", "names itself"),
    "itself.yaml": ("options_file: itself.yaml\n", "names itself"),
    "quote.opts": ("-a 1\n-b 'x\n", "line 2"),
    "list.yaml": ("- 1\n", "line 1"),
    "deep.yaml": ("a: [[1]]\n", "list of numbers or words"),
    "key.yaml": ("1 2: 3\n", "name of an option"),
    "brace.yaml": ("a: {\n", "brace.yaml, line 2"),
    "alias.opts": ("alias -a -b\n", "'alias' is not an option"),
}


@pytest.mark.parametrize("name", FAULTY)
def test_faulty_file(name, here):
    for file, (text, _) in FAULTY.items():
        (here / file).write_text(text)
    with pytest.raises(InputError, match=FAULTY[name][1]) as caught:
        texts("-options_file", name)
    assert "\n" not in str(caught.value)


def test_a_quotation_mark_that_stands_alone(here):
    assert texts("-fsi_output", "a 'b", "-fsi_order", "6") == {"fsi_output": "a 'b", "fsi_order": "6"}
    with pytest.raises(InputError, match="never closed in PETSC_OPTIONS"):
        texts(environment="-fsi_output 'a b -fsi_order 6")


#: what may stand behind an option, as a slip or in earnest
VALUES = (
    *("", "1", "0", "-1", "0.5", "1e-3", "2.0", "nan", "inf", "-inf", "1e400", "1e308", "true"),
    *("no", "x", "a b", "'", '"', "a ' b", "2147483648"),
    *("1,2", ",", "0.1,0.2", "basic", "rk", "fused", "ssp", "5dp", "rks3", "ascii:f", ":f", ":f:ascii_xml", ":", "::", "f:g:h"),
    *("nosuch", "/nonexistent/h", "-help", "--", "-", "=", "a=b", "\N{GREEK SMALL LETTER MU}", "\udcff", "x" * 3000),
    *("9" * 5000, "\0", "a\nb", "%s%n", "$HOME", "~", "1_0", "0x10", "None", "[1]", "{}"),
)
#: names of PETSc's, right ones and others
FOREIGN = """
python history options_view options_left options_gui options_string_yaml prefix_push log_summary log_trace log_all
ts_view ts_adapt_monitor ts_adapt_wnormtype ts_init_time ts_monitor_solution_vtk ts_exact_final_time ts_save_trajectory
ts_max_reject ts_final_time ts_time_step snes_type ksp_monitor pc_type mat_type vec_type dm_view malloc_dmp malloc_test
fp_trap on_error_abort start_in_debugger viewer_hdf5_collective draw_pause random_type citations info_exclude v display x
version h fsi_h=1 fsi-h options_file
""".split()


#: what is right: the defaults, where there are any
SOUND = {
    option.name: ",".join(map(str, option.default)) if isinstance(option.default, tuple) else str(option.default)
    for option in table(rod).values()
    if option.default not in (None, ...)
}


def line_of(pick: random.Random, names: list[str]) -> list[str]:
    words: list[str] = []
    for _ in range(pick.randint(1, 3)):
        name = pick.choice(names)
        if pick.random() < 0.15:  # a slip of the finger
            cut = pick.randrange(len(name))
            name = pick.choice([name[:cut] + name[cut + 1 :], name[:cut] + pick.choice("aeo_xT") + name[cut:], name.upper()])
        words.append(pick.choice(["-"] * 12 + ["--", ""]) + name)
        if name in SOUND and pick.random() < 0.7:
            words.append(SOUND[name])
        elif pick.random() < 0.8:
            words.append(pick.choice(VALUES))
    return words


def outcome(words: list[str], in_environment: bool) -> str:
    """Read a line as a run does and let PETSc's time integrator follow it; the message, or "" if it is accepted."""
    from petsc4py import PETSc

    try:
        if in_environment:
            given = given_options([], {"PETSC_OPTIONS": " ".join(words)})
        else:
            given = given_options(words, {})
        check_petsc(given)
        given = {"fsi_quiet": given_options(["-fsi_quiet"], {})["fsi_quiet"], **given}
        options = read_options(rod, given)
    except FsiError as error:
        assert error.status in (2, 4)
        return str(error)
    known = {*table(rod), "ts_time_step", "ts_final_time", *(option.name for option in AT_START + IN_LOOP)}
    assert known >= set(given), "every name is in a table"
    publish(options)
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setRHSFunction(lambda ts, t, u, f: f.set(0), PETSc.Vec().createSeq(1))
    if options["ts_type"] == "fused":
        PETSc.Options().setValue("ts_type", "rk")
    PETSc.Options().setValue("ts_adapt_type", "none")
    ts.setFromOptions()
    ts.destroy()
    return ""


def fuzz(seed: int, count: int) -> tuple[int, int]:
    """(lines accepted, lines refused) of `count` lines; raises what should not happen, naming the line."""
    pick, refused = random.Random(seed), 0
    names = [option.name for option in (*table(rod).values(), *AT_START, *IN_LOOP)] + FOREIGN
    for _ in range(count):
        words = line_of(pick, names)
        try:
            message = outcome(words, pick.random() < 0.3)
        except Exception as error:
            raise AssertionError(f"{words}: {type(error).__name__}: {error}") from error
        assert "\n" not in message, (words, message)
        refused += bool(message)
    return count - refused, refused


def test_any_line_is_read_or_refused_in_one_message(here):
    from petsc4py import PETSc

    database = PETSc.Options()
    before = database.getAll()
    accepted, refused = fuzz(seed=7, count=300)
    assert accepted > 10 and refused > 100
    for name in set(database.getAll()) - set(before):
        database.delValue(name)
