"""What README and the options files under runs/ say can be done: names exist, snippets run, options are accepted."""

from __future__ import annotations

import csv
import re
import shlex

import numpy as np
import pytest
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")

README = (REPOSITORY / "README.md").read_text()
OPTIONS_FILES = sorted((REPOSITORY / "runs").rglob("*.opts"))
#: stems of Open MPI's, PETSc's and other programs' options that the documents may name
FOREIGN = {"o", "n", "m", "help", "animate"}


def known_options() -> set[str]:
    """Every option of the built-in cases and of the commands, without dash."""
    from fsipetsc import cli
    from fsipetsc.cases import BUILT_IN, load_case
    from fsipetsc.options import table
    from fsipetsc.options.petsc_names import AT_START, IN_LOOP, IN_SOURCES

    names = {option.name for case in BUILT_IN for option in table(load_case(case)).values()}
    for command in cli.COMMANDS.values():
        if command.options:
            listed = cli._named(command.options)
            for sections in (listed(["mms"]), listed([])) if callable(listed) else (listed,):
                names |= {option.name for options in sections.values() for option in options}
    return names | {option.name for option in AT_START + IN_LOOP + IN_SOURCES} | FOREIGN


def options_in(text: str) -> set[str]:
    """Names of what is written like an option within code: indented blocks and `…`."""
    code = [line.split(" #")[0] for line in text.splitlines() if line.startswith("    ")]
    code += re.findall(r"`([^`]+)`", text)
    return {name for piece in code for name in re.findall(r"(?<![\w-])-([A-Za-z]\w*)\b(?!\.)", piece)}


def test_options_in_the_readme_exist():
    unknown = options_in(README) - known_options()
    assert not unknown


def test_files_in_the_readme_exist():
    named = set(re.findall(r"\]\(([\w./-]+)\)", README))
    named |= set(re.findall(r"(?:scripts|runs|docs|tests|fsipetsc)/[\w./-]*\w", README))
    missing = {name for name in named if not (REPOSITORY / name).exists() and not name.endswith("COUPLING.csv")}
    assert not missing


def test_no_line_of_the_readme_needs_scrolling():
    long = [line for line in README.splitlines() if len(line) > 150 and not line.startswith("|")]
    assert not long


def command_line(text: str) -> list[str]:
    """Words behind `python -m fsipetsc` of the first command in an options file's header."""
    line = next(line for line in text.splitlines() if "python -m fsipetsc" in line)
    return shlex.split(line.split("python -m fsipetsc", 1)[1].split("&&")[0])


def stated_steps(text: str) -> int:
    """The number of steps that a header states, 0 if none."""
    found = re.search(r"([\d,]+) steps", text)
    return int(found[1].replace(",", "")) if found else 0


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    """(results, folder) of every options file's own command, a few steps of it, and of what the README's snippet reads."""
    folder = tmp_path_factory.mktemp("runs")
    runs = {
        "readme": ("rod", "-fsi_h 0.1 -ts_max_steps 5"),
        "start": ("rod", README.split("mpiexec -n 2 python -m fsipetsc rod ", 1)[1].split("\n")[0]),
        "piston": (str(REPOSITORY / "runs" / "piston.py"), ""),
        "turn": (str(REPOSITORY / "runs" / "piston.py"), "-fsi_h 0.0125"),
    }
    for path in OPTIONS_FILES:
        text = path.read_text()
        case, *rest = command_line(text)
        if case == "convergence":
            continue
        assert rest[:2] == ["-options_file", str(path.relative_to(REPOSITORY))], path
        given = [line.split(" #")[0] for line in text.splitlines() if line and not line.startswith("#")]
        limit = "" if 0 < stated_steps(text) < 5000 else "-ts_max_steps 3"
        runs[path.stem + path.parent.name] = (case, " ".join([*given, *rest[2:], limit]))
    return compute(1, folder, runs), folder


@pytest.mark.parametrize("path", OPTIONS_FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_options_file(started, path):
    results, folder = started
    text = path.read_text()
    case = command_line(text)[0]
    assert text.startswith("# "), "says on top what it shows"
    names = {line.split()[0][1:] for line in text.splitlines() if line.startswith("-")}
    assert names <= known_options()
    if case == "convergence":
        return
    name = path.stem + path.parent.name
    assert name in results, (folder / f"{name}.txt").read_text()


def test_snippet_of_the_readme(started, monkeypatch):
    results, folder = started
    results["readme"].rename(folder / "rod.h5")
    monkeypatch.chdir(folder)
    lines = README.split("    import fsipetsc\n", 1)[1].split("\n\n", 1)[0]
    snippet = "import fsipetsc\n" + "\n".join(line[4:] for line in lines.splitlines())
    names: dict[str, object] = {}
    exec(snippet, names)
    assert names["run"].case == "rod"


def test_steps_are_those_that_headers_state(started):
    """Of the runs that take less than a second; steps are the same everywhere."""
    results, _ = started
    texts = {path.stem + path.parent.name: path.read_text() for path in OPTIONS_FILES}
    texts["piston"] = (REPOSITORY / "runs" / "piston.py").read_text()
    held = {name for name, text in texts.items() if 0 < stated_steps(text) < 5000}
    assert held >= {"boxruns", "mmsruns", "pulseruns", "adaptiveruns", "piston"}
    for name in held:
        with fsipetsc.open_run(results[name]) as run:
            assert run.complete and run.summary["steps"] == stated_steps(texts[name]), name


def test_positions_that_the_readme_tells(started):
    results, _ = started
    with fsipetsc.open_run(results["start"]) as run:
        ends = re.search(r"its ends are at x = ([\d.]+) and ([\d.]+)", README).groups()
        assert [f"{x:.4f}" for x in run.summary["interfaces"].values()] == list(ends)
    with fsipetsc.open_run(results["turn"]) as run:
        turn = re.search(r"It turns at x = ([\d.]+);", README)[1]
        assert f"{run.series['x_interface'].min():.5f}" == turn


def test_speed_that_the_readme_tells():
    """The range of the ratios to another program is that of docs/performance.csv."""
    with open(REPOSITORY / "docs" / "performance.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["ranks"] == "1"]
    least, most = (pick(rows, key=lambda row: float(row["ratio"])) for pick in (min, max))
    sentence = " ".join(re.search(r"That is [^.]*\.[^.]*\.[^.]*what a serial", README)[0].split())
    told = re.search(r"That is ([\d.]+) \(order (\d), ([\d,]+) points\) to ([\d.]+) times \(order (\d), ([\d,]+)\)", sentence)
    expected = [(f"{float(r['ratio']):.1f}", r["order"], f"{int(r['points']):,}") for r in (least, most)]
    assert told.groups() == (*expected[0], *expected[1])


def test_points_that_the_readme_tells(started):
    results, _ = started
    with fsipetsc.open_run(results["boxruns"]) as run:
        counts = [sum(int(np.isfinite(layer["T"][frame]).sum()) for layer in run.layers) for frame in (0, -1)]
        stored = sum(len(layer.X) for layer in run.layers)
        assert f"({counts[0]}, {counts[1]} in the end and {stored} for `box`)" in README
        assert run.summary["points"] == counts[1]
