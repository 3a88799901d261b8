"""What README, docs/ and runs/ say: names and links exist, code runs, numbers are measured."""

import contextlib
import importlib
import inspect
import io
import json
import re
import shlex
from functools import cache
from pathlib import Path

import pytest
from helpers import REPOSITORY, compute, program

DOCS = REPOSITORY / "docs"
PAGES = [REPOSITORY / "README.md", *sorted(DOCS.glob("*.md"))]
TEXTS = {page.name: page.read_text() for page in PAGES}
#: what a reader meets first; the code of the other pages compiles more kernels
FIRST = [page for page in PAGES if page.stem in ("README", "start", "commands", "checkpoints")]
OTHERS = [*(page for page in PAGES if page not in FIRST), DOCS / "tutorial.ipynb"]
OTHERS = [pytest.param(page, marks=pytest.mark.long) for page in OTHERS]
#: what makes a command short
SHORT = {
    "run": "-ts_max_steps 3 -fsi_quiet",
    "convergence": "-fsi_orders 2 -ts_max_time 0.01",
    "stability": "-stability_points 20",
    "modes": "-fsi_h 0.0625",
}
#: options files of which the kernels are compiled for other tests as well
OFTEN = {f"{name}.opts" for name in ("rod", "mms", "pulse", "box", "column", "blast")}
OPTIONS_FILES = {
    path.relative_to(REPOSITORY).as_posix(): path.read_text()
    for path in sorted((REPOSITORY / "runs").rglob("*.opts"))
}
#: cases of one's own
OWN_CASES = {path.relative_to(REPOSITORY).as_posix(): path for path in REPOSITORY.glob("runs/*.py")}
FENCED = re.compile(r"^```(\w*)$(.*?)^```$", re.S | re.M)
#: texts of the cases that stand in runs/ and of the templates
CASE_FILES = *OWN_CASES.values(), *REPOSITORY.glob("fsipetsc/cases/template*.py")
CASE_TEXTS = "\n".join(path.read_text() for path in CASE_FILES)


@cache
def known_options() -> frozenset[str]:
    """Names of options that -help of cases and commands tells, and of those of CASE_TEXTS."""
    from fsipetsc.cases import BUILT_IN
    from fsipetsc.cli import COMMANDS, main

    with contextlib.redirect_stdout(io.StringIO()) as said:
        for name in (*BUILT_IN, *COMMANDS, "convergence mms", *map(str, OWN_CASES.values())):
            assert main([*name.split(), "-help"]) == 0
    told = re.findall(r"(?<![\w-])-([A-Za-z]\w*)", said.getvalue())
    of_files = re.findall(r'Option\(\s*(?:\*\()?"(\w+)"', CASE_TEXTS)
    return frozenset(told) | frozenset(of_files) | {"n", "m", "help"}


@pytest.mark.parametrize("name", TEXTS)
def test_options_links_and_files_exist(name):
    """Options in `code` and in blocks for the shell may be of a case that the page makes."""
    text, folder = TEXTS[name], REPOSITORY if name == "README.md" else DOCS
    code = re.findall(r"`([^`\n]+)`", FENCED.sub("", text))
    for language, block in FENCED.findall(text):
        code += [line.split(" #")[0] for line in block.splitlines() if language == "sh"]
    named = {o for piece in code for o in re.findall(r"(?<![\w(-])-([A-Za-z]\w*)\b(?!\.)", piece)}
    assert not named - known_options() - set(re.findall(r'Option\("(\w+)"', text))
    for target, anchor in re.findall(r"\]\(([\w./-]*)(?:#([\w-]*))?\)", text):
        assert (folder / target).exists(), target
        headings = re.findall(r"^#+ (.*)$", TEXTS.get(Path(target).name or name, ""), re.M)
        anchors = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings]
        assert not anchor or anchor in anchors, f"{target}#{anchor}"
    named = re.findall(r"(?<![\w/.])((?:scripts|runs|docs|tests|fsipetsc)/[\w./-]*\w)", text)
    assert not [path for path in named if not (REPOSITORY / path).exists()]
    prose = FENCED.sub("", text).splitlines()
    assert not [line for line in prose if len(line) > 100 and not line.startswith("|")]


def test_the_kernel_of_the_page_of_code_is_what_is_printed():
    """Without blanks and ends of lines."""
    from fsipetsc.materials.fluid import Fluid
    from fsipetsc.operators.slopes import Stencil
    from fsipetsc.scheme.gas_sweep import gas_kernels
    from fsipetsc.scheme.gas_terms import convection_of

    gas = Fluid(0.0, 0.0, 1.4, 287.0).equations(2)
    kernels = gas_kernels(gas, 2, convection_of("entropy", gas), False, False, Stencil(2, 3))
    (page,) = (text for language, text in FENCED.findall(TEXTS["code.md"]) if language == "c")
    assert "".join(page.split("{", 1)[1].split()) in "".join(kernels.near_pairs.text.split())


def test_where_to_add_something_is_true():
    """Of each row the files are there, and what is named beside them stands in one of them."""
    lines = TEXTS["code.md"].split("## To add …")[1].splitlines()
    rows = [line.split("|")[1:4] for line in lines if line.startswith("| a")]
    assert len(rows) >= 10
    for what, write, register in rows:
        told = re.findall(r"`([^`]+)`", write + register)
        paths = [REPOSITORY / name for name in told if name.startswith("fsipetsc/")]
        files = [f for p in paths for f in (p.glob("*.py") if p.is_dir() else [p])]
        texts = [file.read_text() for file in files]
        for name in told if paths else ():  # a law of one's own is in the case alone
            word = name.removeprefix("-")
            found = name.startswith(("fsipetsc/", "runs")) or any(word in text for text in texts)
            assert found, f"{what}: {name}"


def test_the_site_has_all_public_names_with_all_arguments():
    """Docstrings tell arguments, or attributes of what users do not make themselves."""
    import fsipetsc
    from fsipetsc.blocks import conditions

    hooks = program("hooks", "docs")
    for name, members in hooks.MEMBERS.items():
        module, _, last = name.rpartition(".")
        of = getattr(importlib.import_module(module), last)
        known = {*dir(of), *vars(of).get("__annotations__", ())}
        assert known >= {*members.split()}, name
    names = {name for found in hooks.public_names().values() for name in found}
    assert {f"fsipetsc.{n}" for n in fsipetsc.__all__} - names == {"fsipetsc.__version__"}
    made = {n: of for n, of in vars(conditions).items() if isinstance(of, type)}
    kinds = {n for n, of in made.items() if issubclass(of, conditions.Condition)} - {"Condition"}
    assert {f"{conditions.__name__}.{n}" for n in kinds} <= names
    for name in names - {"fsipetsc.REQUIRED"}:
        module, _, last = name.rpartition(".")
        made = getattr(importlib.import_module(module), last)
        text = inspect.getdoc(made)
        if "Attributes:" in text or "Exit status" in text or module.endswith("elementary"):
            continue  # what users do not make, and what a sentence tells
        arguments = re.split(r"^(?:Returns|Raises):$", text.partition("Args:\n")[2], flags=re.M)[0]
        told = set(re.findall(r"^    (\w+): ", arguments, re.M))
        told |= {"T", "heat_flux"} if re.search("`(SolidEnd|Warm)`", text) else set()
        told |= {"x", "velocity"} if "`Moving`" in text else set()
        assert told == set(inspect.signature(made).parameters), name


def test_each_option_has_a_page_that_names_it():
    """Those of every run are named in a page; a case and a command have pages, too."""
    made = program("hooks", "docs").options_page()
    assert re.findall(r"^\| `-\w+`.*\) \|$", made, re.M) == re.findall(r"^\| `-.*$", made, re.M)
    assert "Pages: ." not in made and "| `-fsi_h` | float |" in made


def code_of(page):
    """(language, content, what it prints or None) of fenced blocks, or of a notebook's cells."""
    if page.suffix == ".md":
        return [(*found, None) for found in FENCED.findall(TEXTS[page.name])]
    cells = [c for c in json.loads(page.read_text())["cells"] if c["cell_type"] == "code"]
    said = ["".join("".join(o.get("text", "")) for o in cell["outputs"]) for cell in cells]
    return [("python", "".join(cell["source"]), out) for cell, out in zip(cells, said, strict=True)]


def run_python(content, expected, names):
    """Python that begins with `# NAME.py` is that file; else it prints what is told."""
    if file := re.match(r"\s*# (\w+\.py)\n", content):
        Path(file[1]).write_text(content)
        return
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(content, names)
    said, told = out.getvalue(), re.findall(r"^# prints (.*)$", content, re.M)
    assert not told or told == [line.strip() for line in said.splitlines()], said
    assert expected in (None, said), said


def run_command(line):
    """A line for the shell, for a few steps, on a coarse grid; what is in [ ] is left out."""
    from fsipetsc.cli import COMMANDS, main

    line = re.sub(r"^scripts/run", "python -m fsipetsc", re.sub(r"\[[^]]*\]", "", line))
    words = shlex.split(re.sub(r"^(mpiexec -n \d+|\.) ", "", line), comments=True)
    if not words or words[0] == "export" or words[0].startswith("scripts/"):
        return
    assert words[:3] == ["python", "-m", "fsipetsc"], words
    words = words[3:]
    kind = words[0] if words[0] in COMMANDS else "run"
    if "-help" not in words and not words[-1].endswith(".h5"):
        words += SHORT.get(kind, "").split()
    with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(said):
        status = main(words)
    broken = status == 3 and kind == "stability"  # a coupling does not keep its promise
    assert status == 0 or broken, said.getvalue()


@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize("page", [*FIRST, *OTHERS])
def test_code_runs(page, here, monkeypatch, quick_pictures):
    monkeypatch.setenv("MPLBACKEND", "agg")
    (here / "runs").symlink_to(REPOSITORY / "runs")
    names = {"__name__": "__main__"}
    for language, content, expected in code_of(page):
        if language == "python":
            run_python(content, expected, names)
        for line in content.splitlines() if language == "sh" else ():
            run_command(line)


def words_of(name):
    """What a file of options says to run: the words after `python -m fsipetsc`."""
    command = r"python -m fsipetsc (.*?)(?: &&.*)?$"
    case, *words = shlex.split(re.search(command, OPTIONS_FILES[name], re.M)[1])
    return [str(REPOSITORY / case) if case.endswith(".py") else case, *words]


def test_each_case_has_an_options_file():
    """Its first line says what it is, and it has only options of its case, which can be built."""
    from fsipetsc.cases import BUILT_IN, load_case
    from fsipetsc.options import read_options

    for name, text in OPTIONS_FILES.items():
        assert re.match(r"# .*\.\n", text), name
        given = set(re.findall(r"^-(\w+)", text, re.M))
        assert given and given <= known_options(), name
        assert f"-options_file {name}" in " ".join(words_of(name))
        if (case := words_of(name)[0]) != "convergence":
            words = dict(re.findall(r"^-(\w+) *([^#\n]*)", text, re.M))
            module = load_case(str(OWN_CASES.get(case, case)))
            module.build(read_options(module, words))
    assert set(BUILT_IN) <= {words_of(name)[0] for name in OPTIONS_FILES}


@pytest.mark.parametrize("often", [True, pytest.param(False, marks=pytest.mark.long)])
def test_options_files_run(often, tmp_path):
    """A few steps; or all that the header states, if fewer than 5,000, and as many as it states."""
    # on several ranks less is compiled; many steps are faster on one
    runs, steps = {1: {}, 2: {}}, {}
    for path, text in OPTIONS_FILES.items():
        name, (case, *words) = path.replace("/", "_"), words_of(path)
        if case == "convergence" or often != (Path(path).name in OFTEN):
            continue
        stated = re.search(r"([\d,]+) steps", text)
        count = int(stated[1].replace(",", "")) if stated else 0
        steps[name] = count if 0 < count < 5000 else 3
        given = [line.split(" #")[0] for line in text.splitlines() if line.startswith("-")]
        limit = "" if steps[name] == count else "-ts_max_steps 3"
        ranks = 1 if steps[name] > 3 else 2
        words = [*given, *words[2:], limit]
        runs[ranks][name] = (str(OWN_CASES.get(case, case)), " ".join(words))
    results = compute(1, tmp_path, runs[1]) | compute(2, tmp_path, runs[2])
    assert {name: result.summary["steps"] for name, result in results.items()} == steps


def test_numbers_that_pages_tell(tmp_path, monkeypatch):
    monkeypatch.delenv("CFLAGS", raising=False)  # many steps
    start, piston = TEXTS["start.md"], str(REPOSITORY / "runs" / "piston.py")
    command = re.search(r"python -m fsipetsc rod (-fsi_order.*)$", start, re.M)[1]
    runs = {"rod": ("rod", command), "turn": (piston, "-fsi_h 0.0125")}
    results = compute(1, tmp_path, runs)
    rod = " and ".join(f"{x:.4f}" for x in results["rod"].summary["interfaces"].values())
    assert f"its ends are at x = {rod}" in start
    assert f"it turns at x = {results['turn'].series['x_interface'].min():.5f};" in start
