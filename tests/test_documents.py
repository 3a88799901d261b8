"""What README, docs/ and runs/ say: names and links exist, code runs, numbers are measured."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from functools import cache
from pathlib import Path

import pytest
from helpers import REPOSITORY, compute, run

import fsipetsc

pytest.importorskip("petsc4py")

DOCS = REPOSITORY / "docs"
PAGES = [REPOSITORY / "README.md", *sorted(DOCS.glob("*.md"))]
TEXTS = {page.name: page.read_text() for page in PAGES}
#: what a reader meets first; the code of the other pages compiles more kernels
FIRST = [page for page in PAGES if page.stem in ("README", "start", "commands", "checkpoints")]
OTHERS = [*(page for page in PAGES if page not in FIRST), DOCS / "tutorial.ipynb"]
#: options files that need kernels of their own
ALONE = {f"{name}.opts" for name in ("piston", "panel_viscous", "heat", "blast_shock", "plane_mms")}
OPTIONS_FILES = sorted((REPOSITORY / "runs").rglob("*.opts"))
FENCED = re.compile(r"^```(\w*)$(.*?)^```$", re.S | re.M)


@cache
def known_options() -> frozenset[str]:
    """Names of options that -help of all cases and commands tells."""
    from fsipetsc.cases import BUILT_IN
    from fsipetsc.cli import COMMANDS, main

    with contextlib.redirect_stdout(io.StringIO()) as said:
        for name in (*BUILT_IN, *COMMANDS, "convergence mms"):
            assert main([*name.split(), "-help"]) == 0
    return frozenset(re.findall(r"(?<![\w-])-([A-Za-z]\w*)", said.getvalue())) | {"n", "m", "help"}


@pytest.mark.parametrize("name", TEXTS)
def test_options_exist(name):
    """Those in `code` and in blocks for the shell, or of a case that the page makes."""
    code = re.findall(r"`([^`\n]+)`", FENCED.sub("", TEXTS[name]))
    for language, block in FENCED.findall(TEXTS[name]):
        code += [line.split(" #")[0] for line in block.splitlines() if language == "sh"]
    named = {o for piece in code for o in re.findall(r"(?<![\w(-])-([A-Za-z]\w*)\b(?!\.)", piece)}
    assert not named - known_options() - set(re.findall(r'Option\("(\w+)"', TEXTS[name]))


@pytest.mark.parametrize("name", TEXTS)
def test_links_and_files_exist(name):
    folder = REPOSITORY if name == "README.md" else DOCS
    for target, anchor in re.findall(r"\]\(([\w./-]*)(?:#([\w-]*))?\)", TEXTS[name]):
        assert (folder / target).exists(), target
        headings = re.findall(r"^#+ (.*)$", TEXTS.get(Path(target).name or name, ""), re.M)
        anchors = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings]
        assert not anchor or anchor in anchors, f"{target}#{anchor}"
    named = re.findall(r"(?<![\w/.])((?:scripts|runs|docs|tests|fsipetsc)/[\w./-]*\w)", TEXTS[name])
    assert not [path for path in named if not (REPOSITORY / path).exists()]
    prose = FENCED.sub("", TEXTS[name]).splitlines()
    assert not [line for line in prose if len(line) > 100 and not line.startswith("|")]


def test_every_page_is_in_the_site():
    listed = set(re.findall(r": ([\w-]+\.md)", (REPOSITORY / "mkdocs.yml").read_text()))
    assert listed == set(TEXTS) - {"README.md"} | {"index.md", "tutorial.md"}


def test_the_page_of_options_has_the_table():
    """Names, types and defaults."""
    from fsipetsc.cases import load_case
    from fsipetsc.options import table

    rows = re.findall(r"^\| `-(\w+)` \| (\w+) \|(?: `([^`]*)`)? \|", TEXTS["options.md"], re.M)
    case = load_case("box")
    options = {o.name: o for o in table(case).values() if o not in case.OPTIONS}
    assert {name: kind for name, kind, _ in rows} == {n: str(o.kind) for n, o in options.items()}
    for name, _, told in rows:
        default = options[name].default
        said = str(default).lower() if isinstance(default, bool) else str(default)
        if name not in case.DEFAULTS and name != "fsi_output":
            assert told == ("" if default in (None, ...) else said.removesuffix(".0")), name


@pytest.mark.parametrize("pages", [FIRST, pytest.param(OTHERS, marks=pytest.mark.long)])
def test_code_blocks_run(pages, tmp_path):
    """Commands for a few steps, Python as it stands, each page from top to bottom."""
    program = REPOSITORY / "tests" / "page_program.py"
    done = run(program, tmp_path, *pages, cwd=tmp_path, env={"MPLBACKEND": "agg"})
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.long)])
def test_options_files_run(alone, tmp_path):
    """A few steps; or all that the header states, if fewer than 5,000, and as many as it states."""
    runs, steps = {}, {}
    for path in OPTIONS_FILES:
        text, name = path.read_text(), path.stem + path.parent.name
        command = re.search(r"python -m fsipetsc (.*?)(?: &&.*)?$", text, re.M)[1]
        case, *words = shlex.split(command)
        if case == "convergence" or alone != (path.name in ALONE):
            continue
        assert words[:2] == ["-options_file", str(path.relative_to(REPOSITORY))]
        stated = re.search(r"([\d,]+) steps", text)
        count = int(stated[1].replace(",", "")) if stated else 0
        steps[name] = count if 0 < count < 5000 else 3
        given = [line.split(" #")[0] for line in text.splitlines() if line.startswith("-")]
        limit = "" if steps[name] == count else "-ts_max_steps 3"
        runs[name] = (case, " ".join([*given, *words[2:], limit]))
    many = {name: run for name, run in runs.items() if steps[name] > 3}
    few = {name: run for name, run in runs.items() if name not in many}
    # on several ranks less is compiled; many steps are faster on one
    results = compute(1, tmp_path, many) | compute(2, tmp_path, few)
    assert set(results) == set(runs), [path.read_text() for path in tmp_path.glob("*.txt")]
    assert {n: fsipetsc.open_run(path).summary["steps"] for n, path in results.items()} == steps


def test_numbers_that_pages_tell(tmp_path):
    start, piston = TEXTS["start.md"], str(REPOSITORY / "runs" / "piston.py")
    command = re.search(r"python -m fsipetsc rod (-fsi_order.*)$", start, re.M)[1]
    runs = {"rod": ("rod", command), "turn": (piston, "-fsi_h 0.0125")}
    results = {name: fsipetsc.open_run(path) for name, path in compute(1, tmp_path, runs).items()}
    rod = " and ".join(f"{x:.4f}" for x in results["rod"].summary["interfaces"].values())
    assert f"its ends are at x = {rod}" in start
    assert f"it turns at x = {results['turn'].series['x_interface'].min():.5f};" in start


def test_speed_that_the_readme_tells():
    """It is that of the tables of performance.md."""
    readme, page = TEXTS["README.md"], TEXTS["performance.md"]
    rows = [row.split(" | ")[1:] for row in page.splitlines() if row.startswith("| 4/2 ")]
    ratios = [float(row[-1].rstrip(" |")) for row in rows if len(row) == 6]
    times = f"{min(ratios):.1f} to {max(ratios):.1f} times"
    assert f"in two dimensions {times} the time" in readme and f"takes {times} as long" in page
    steps = {row[0]: row[2] for row in reversed(rows) if len(row) == 4}
    paper, blocks = steps["rod, the paper's method"], steps["gas, solid, divergence"]
    assert f"{paper} µs a step with the paper's method, {blocks} µs on blocks" in readme
