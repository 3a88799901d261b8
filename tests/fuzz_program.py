"""Inputs at random, valid and invalid: COUNT [SEED]. Each must run, or end with a documented status and one message.

Options on the command line, in options files and in YAML, case files that are damaged, damaged results and checkpoints, and
the commands. All in one process, as a notebook would; runs make one step at most, on coarse grids, of kernels that every
run has. Prints what went wrong, at most one input, made as simple as Hypothesis can; the status is 1 then.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import tempfile
import traceback
from collections import Counter
from functools import cache
from pathlib import Path

from faulty_cases import RIGHT
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st
from hypothesis.database import InMemoryExampleDatabase
from said import parted

from fsipetsc.cases import BUILT_IN, load_case
from fsipetsc.cli import COMMANDS, main
from fsipetsc.errors import FsiError
from fsipetsc.options import table

STATUSES = {0, 2, 3, 4}
NEVER = re.compile(r"Traceback|PETSC ERROR|Segmentation|Fatal Python|unexpected [A-Za-z]+(Error|Exception|Warning)")
#: cases whose steps are cheap and of the kernels that every run has
CASES = [name for name in BUILT_IN if name in ("rod", "mms", "pulse", "box", "blast")]
#: options whose other values compile kernels of their own, ask for much memory, or end the process's PETSc
LEFT_ALONE = {"fsi_viscous", "fsi_convection", "fsi_dissipation", "fsi_shock", "fsi_h", "fsi_spare"}
LEFT_ALONE |= {"fsi_debug"}  # it asks for the traceback
LAST = ["-fsi_h", "0.125", "-ts_max_steps", "1", "-ts_max_time", "0.001", "-fsi_output_dt", "1"]

JUNK = st.one_of(
    st.text(st.characters(blacklist_categories=["Cs"]), max_size=12),
    st.sampled_from(["nan", "inf", "-inf", "1e400", "-1", "0", "1e-300", "0x10", "1,2", ",", "3.5", "true", "--"]),
    st.sampled_from(["'", '"', "%s", "\\", "${HOME}", "~", "#", ": ", "[", "{a: b}", "!!python/object:os.system {}", "\n"]),
    st.integers(-(2**70), 2**70).map(str),
    st.floats().map(repr),
)


def fitting(option: object) -> st.SearchStrategy[str]:
    """Values of the right kind, at the edges of what is allowed, too."""
    if option.choices:
        return st.sampled_from([str(choice) for choice in option.choices])
    numbers = st.one_of(st.floats(1e-3, 10.0), st.sampled_from([0.0, -1.0, 1e12, 1e-12])).map(repr)
    kinds = {
        "int": st.integers(-2, 20).map(str),
        "float": numbers,
        "bool": st.sampled_from(["", "true", "0", "no", "maybe"]),
        "ints": st.lists(st.integers(-1, 9).map(str), max_size=3).map(",".join),
        "floats": st.lists(numbers, max_size=3).map(",".join),
    }
    return kinds.get(option.kind, st.sampled_from(["a", "x.h5", "/", "/dev/null", "none/x.h5"]))


@cache
def options_of(case: str) -> st.SearchStrategy[list[tuple[str, str]]]:
    """Some options of a case with values, most of them of the right kind. (Made once: that costs more than many draws.)"""
    known = [option for option in table(load_case(case)).values() if option.name not in LEFT_ALONE]
    names = [st.sampled_from([option.name, option.name.upper(), option.name[:-1]]) for option in known]
    values = [st.one_of(fitting(option), JUNK) for option in known]
    return st.lists(st.one_of([st.tuples(*pair) for pair in zip(names, values)]), max_size=4)


A_CASE, WHERE = st.sampled_from(CASES), st.sampled_from(["words", "file", "yaml", "junk"])
JUNK_FILE = st.tuples(st.sampled_from(["some.opts", "some.yaml"]), st.binary(max_size=60))


@st.composite
def a_run(draw: st.DrawFn) -> tuple[list[str], dict[str, bytes]]:
    """(words, files) of a run whose options are somewhere: on the command line, in a file, in YAML."""
    case, where = draw(A_CASE), draw(WHERE)
    if where == "junk":
        name, content = draw(JUNK_FILE)
        return [case, "-options_file", name], {name: content}
    options = draw(options_of(case))
    if where == "words":
        return [case, *(word for name, value in options for word in (f"-{name}", value))], {}
    name, line = ("some.opts", "-{} {}") if where == "file" else ("some.yaml", "{}: {}")
    text = "\n".join(line.format(*option) for option in options)
    return [case, "-options_file", name], {name: text.encode(errors="replace")}


PUT = st.one_of(st.sampled_from(["", "0", "-1", "None", "1e400", "X", "t", "(", "'", "\n", "np.nan", "[]"]), JUNK)


@st.composite
def a_case_file(draw: st.DrawFn) -> tuple[list[str], dict[str, bytes]]:
    """A case file of which words are lost, doubled or replaced."""
    text = RIGHT
    for _ in range(draw(st.integers(1, 3))):
        begin = draw(st.integers(0, len(text) - 1))
        length = draw(st.integers(0, 8))
        put = draw(PUT)
        text = text[:begin] + put + text[begin + length :]
    return ["mine.py"], {"mine.py": text.encode(errors="replace")}


@st.composite
def a_damaged_file(draw: st.DrawFn) -> tuple[list[str], dict[str, bytes]]:
    """A result or a checkpoint of which bytes are changed or cut off, and a command that reads it."""
    name = draw(st.sampled_from(sorted(GOOD)))
    content = bytearray(GOOD[name])
    for _ in range(draw(st.integers(0, 3))):
        content[draw(st.integers(0, len(content) - 1))] = draw(st.integers(0, 255))
    cut = draw(st.one_of(st.just(len(content)), st.integers(0, len(content))))
    if name.endswith("checkpoint.h5"):
        return ["box", "-fsi_restart", "given.h5"], {"given.h5": bytes(content[:cut])}
    return [draw(st.sampled_from(["info", "info", "diff"])), "given.h5"], {"given.h5": bytes(content[:cut])}


WORDS = st.lists(
    st.one_of(st.sampled_from([*COMMANDS, *CASES, "-help", "-o", "-fsi_h", "-ts_dt", "new.py", "none.h5"]), JUNK), max_size=4
)


@st.composite
def words(draw: st.DrawFn) -> tuple[list[str], dict[str, bytes]]:
    """Anything: names of commands and cases, options, nonsense."""
    found = draw(WORDS)
    first = found[0] if found else ""
    return ([] if first in ("bench", "convergence", "stability", "flutter", "plot", "report") else found), {}


GOOD: dict[str, bytes] = {}
SEEN: Counter[int] = Counter()


def answer(arguments: list[str]) -> tuple[int, str]:
    """(status, what is said on stderr); what is printed is dropped."""
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        status = main(arguments)
    return status, said.getvalue()


def check(found: tuple[list[str], dict[str, bytes]]) -> None:
    arguments, files = found
    runs = bool(arguments) and (arguments[0] in CASES or arguments[0].endswith(".py"))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, content in files.items():
            Path(name).write_bytes(content)
        full = [*arguments, *(LAST if runs and "-fsi_restart" not in arguments else ()), *(["-fsi_quiet"] if runs else ())]
        try:
            status, said = answer(full)
        finally:
            os.chdir("/")
    SEEN[status] += 1
    errors = [line for line in said.splitlines() if line.startswith("fsipetsc: error: ")]
    assert status in STATUSES, (full, files, status, said)
    users, rest = parted(said)  # the traceback of a function of the case file
    assert not users or files.keys() == {"mine.py"}, (full, files, status, said)
    assert not NEVER.search(rest), (full, files, status, said)
    assert len(errors) == (status != 0), (full, files, status, said)


def prepare() -> None:
    """A good result and a good checkpoint."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        status, said = answer(["box", *LAST, "-fsi_checkpoint_steps", "1", "-fsi_quiet"])
        assert status == 0, said
        for name in ("box.h5", "box.checkpoint.h5"):
            GOOD[name] = Path(name).read_bytes()
        os.chdir("/")


def go(count: int, begin: int) -> int:
    """Status of the program."""
    prepare()
    kinds = ((a_run(), 0.5), (a_case_file(), 0.25), (a_damaged_file(), 0.15), (words(), 0.1))
    for kind, part in kinds:
        often = settings(
            max_examples=max(1, round(part * count)),
            deadline=None,
            database=InMemoryExampleDatabase(),
            suppress_health_check=list(HealthCheck),
        )
        try:
            seed(begin)(often(given(kind)(check)))()
        except FsiError:
            raise
        except Exception:
            print(traceback.format_exc(limit=-1)[-4000:])
            return 1
    print(f"{sum(SEEN.values())} inputs; status: " + ", ".join(f"{status}: {n}" for status, n in sorted(SEEN.items())))
    return 0


if __name__ == "__main__":
    sys.exit(go(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
