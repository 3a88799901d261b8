"""What the README, the pages of docs/ and the options files under runs/ say can be done: names exist, code blocks run."""

from __future__ import annotations

import importlib.util
import re
import shlex

import numpy as np
import pytest
from helpers import REPOSITORY, compute, run, solve

import fsipetsc

pytest.importorskip("petsc4py")

PAGES = [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").glob("*.md"))]
#: what a reader meets first; the other pages
FIRST = [REPOSITORY / name for name in ("README.md", "docs/start.md", "docs/python.md", "docs/reliability.md")]
OTHERS = [*(page for page in PAGES if page not in FIRST), REPOSITORY / "docs" / "tutorial.ipynb"]
DOCUMENTS = {page.name: page.read_text() for page in PAGES}
OPTIONS_FILES = sorted((REPOSITORY / "runs").rglob("*.opts"))
#: files for which kernels would be compiled that no other test needs -> what makes do with those of others
ALONE = {
    **{"piston.opts": "-fsi_shock 1e-300", "panel_viscous.opts": "-fsi_dissipation 0"},
    **{"heat.opts": "-fsi_viscous wide"},
    **{"blast_shock.opts": "-fluid_mu 0 -fluid_kappa 0", "plane_mms.opts": "-solid_law log"},
}
#: stems of Open MPI's, PETSc's and other programs' options that the documents may name
FOREIGN = {"o", "n", "m", "help", "animate", "blocks", "all", "fields", "times", "compare", "options_left", "options_view"}
FOREIGN |= {"cost"}


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
    """Names of what is written like an option within code: fenced blocks and `…`."""
    blocks = re.findall(r"^```sh$(.*?)^```$", text, re.S | re.M)
    code = [line.split(" #")[0] for block in blocks for line in block.splitlines()]
    code += re.findall(r"`([^`\n]+)`", re.sub(r"^```\w*$.*?^```$", "", text, flags=re.S | re.M))
    return {name for piece in code for name in re.findall(r"(?<![\w(-])-([A-Za-z]\w*)\b(?!\.)", piece)}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_options_in_the_documents_exist(name):
    own = set(re.findall(r'Option\("(\w+)"', DOCUMENTS[name]))  # of a case that the page makes
    unknown = options_in(DOCUMENTS[name]) - known_options() - own
    assert not unknown


@pytest.mark.parametrize("name", DOCUMENTS)
def test_files_in_the_documents_exist(name):
    text = DOCUMENTS[name]
    folder = REPOSITORY if name == "README.md" else REPOSITORY / "docs"
    links = {link.split("#")[0] for link in re.findall(r"\]\(([\w./#-]+)\)", text)} - {""}
    missing = {link for link in links if not (folder / link).exists()}
    named = set(re.findall(r"(?<![\w/.])(?:scripts|runs|docs|tests|fsipetsc)/[\w./-]*\w", text))
    missing |= {name for name in named if not (REPOSITORY / name).exists() and not name.endswith("COUPLING.csv")}
    assert not missing


def test_every_page_is_in_the_site():
    config = (REPOSITORY / "mkdocs.yml").read_text()
    made = {"index.md", "tutorial.md"}
    assert set(re.findall(r": ([\w-]+\.md)", config)) - made == set(DOCUMENTS) - {"README.md"}


def test_the_page_of_options_is_that_of_the_table():
    """`scripts/docs` renews it."""
    spec = importlib.util.spec_from_file_location("hooks", REPOSITORY / "docs" / "hooks.py")
    hooks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hooks)
    assert DOCUMENTS["options.md"] == hooks.options_page()


@pytest.mark.parametrize("pages", [FIRST, pytest.param(OTHERS, marks=pytest.mark.long)], ids=["first", "others"])
def test_code_blocks_run(pages, tmp_path):
    """Commands a few steps, Python as it stands, each page from top to bottom; the notebook prints what it says it does."""
    done = run(REPOSITORY / "tests" / "page_program.py", tmp_path, *pages, cwd=tmp_path, env={"MPLBACKEND": "agg"})
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


def test_no_line_of_the_readme_needs_scrolling():
    long = [line for line in DOCUMENTS["README.md"].splitlines() if len(line) > 150 and not line.startswith("|")]
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
    """(results, folder) of every options file's own command, a few steps of it."""
    folder = tmp_path_factory.mktemp("runs")
    runs = {
        "start": ("rod", DOCUMENTS["start.md"].split("mpiexec -n 2 python -m fsipetsc rod ", 1)[1].split("\n")[0]),
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
        runs[path.stem + path.parent.name] = (case, " ".join([*given, *rest[2:], limit, ALONE.get(path.name, "")]))
    return compute(1, folder, runs), folder


@pytest.mark.long
@pytest.mark.parametrize("name", ALONE)
def test_options_files_that_kernels_are_compiled_for(name, tmp_path):
    """As they stand."""
    path = REPOSITORY / "runs" / name
    done = solve(command_line(path.read_text())[0], "-options_file", path, "-ts_max_steps", 3, "-fsi_quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


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


def test_steps_are_those_that_headers_state(started):
    """Of the runs that take less than a second; steps are the same everywhere."""
    results, _ = started
    texts = {path.stem + path.parent.name: path.read_text() for path in OPTIONS_FILES}
    texts["piston"] = (REPOSITORY / "runs" / "piston.py").read_text()
    held = {name for name, text in texts.items() if 0 < stated_steps(text) < 5000}
    assert held >= {"boxruns", "mmsruns", "pulseruns", "piston"}
    for name in held:
        with fsipetsc.open_run(results[name]) as run:
            assert run.complete and run.summary["steps"] == stated_steps(texts[name]), name


def test_positions_that_a_page_tells(started):
    results, _ = started
    with fsipetsc.open_run(results["start"]) as run:
        ends = re.search(r"its ends are at x = ([\d.]+) and ([\d.]+)", DOCUMENTS["start.md"]).groups()
        assert [f"{x:.4f}" for x in run.summary["interfaces"].values()] == list(ends)
    with fsipetsc.open_run(results["turn"]) as run:
        turn = re.search(r"It turns at x = ([\d.]+);", DOCUMENTS["start.md"])[1]
        assert f"{run.series['x_interface'].min():.5f}" == turn


def test_speed_that_pages_tell():
    """Ratios to other programs in README and parallel.md are those of the tables of performance.md."""
    readme, page = (REPOSITORY / "README.md").read_text(), DOCUMENTS["performance.md"]

    def rows_of(heading):
        rows = page.split(heading)[1].split("\n## ")[0].splitlines()
        return [row.split("|")[2:-1] for row in rows if re.match(r"\| [\d/]+ \|", row)]

    ratios = [float(row[-1]) for row in rows_of("## Two dimensions")]
    assert len(ratios) >= 4
    found = f"{min(ratios):.1f} to {max(ratios):.1f} times"
    assert f"in two dimensions {found} the time" in readme
    assert f"take {found}" in DOCUMENTS["parallel.md"]
    steps = {row[0].strip(): float(row[2]) for row in reversed(rows_of("## One dimension"))}
    rod, blocks = steps["rod, the paper's method"], min(v for k, v in steps.items() if "gas" in k)
    assert f"{rod:.0f} µs with the paper's couplings, {blocks:.0f} µs with the conservative one" in readme


def test_points_that_a_page_tells(started):
    results, _ = started
    with fsipetsc.open_run(results["boxruns"]) as run:
        counts = [sum(int(np.isfinite(layer["T"][frame]).sum()) for layer in run.layers) for frame in (0, -1)]
        stored = sum(len(layer.X) for layer in run.layers)
        assert f"({counts[0]}, {counts[1]} in the end and {stored} for `box`)" in DOCUMENTS["results.md"]
        assert run.summary["points"] == counts[1]
