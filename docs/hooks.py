"""What MkDocs makes when it builds the site (scripts/docs): the front page, the tutorial, pages of
public names and of the options of cases and commands, links.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
PUBLIC, PUBLIC_ROW = "\n## What is public\n", re.compile(r"^\| (\w.*?) \| (`.*`) \| (.*) \|$", re.M)
#: public class -> its attributes and methods that have a text of their own
MEMBERS = {
    "fsipetsc.Run": "at interface to_xarray close",
    "fsipetsc.output.reader.Layer": "size frame",
    "fsipetsc.output.differences.Comparison": "equal",
    "fsipetsc.Fluid": "sound_speed cv",
    "fsipetsc.Solid": "pressure sound_speed",
    "fsipetsc.materials.solid.ElasticSolid": "K",
    "fsipetsc.mesh_files.Grid": "faces",
}


def front_page() -> str:
    """The README as the site's first page."""
    text = (DOCS.parent / "README.md").read_text()
    return re.sub(r"\]\(docs/", "](", text)


def notebook_page() -> tuple[str, dict[str, bytes]]:
    """docs/tutorial.ipynb as a page, with what its cells printed; its pictures by name."""
    parts, pictures = [], {}
    for cell in json.loads((DOCS / "tutorial.ipynb").read_text())["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            if "text" in output:
                parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
            elif "image/png" in output["data"]:
                name = f"tutorial-{len(pictures)}.png"
                pictures[name] = base64.b64decode(output["data"]["image/png"])
                parts.append(f"![What the cell draws]({name})")
    return "\n\n".join(parts) + "\n", pictures


def linked(names: str) -> str:
    """Public names, in groups of one module each, with links to their texts."""
    groups = []
    for group in names.split("; "):
        module, colon, words = group.rpartition(": ")
        path = module.strip("`") or "fsipetsc"
        groups.append(module + colon + re.sub(r"`([A-Za-z]\w*)`", rf"[`\1`][{path}.\1]", words))
    return "; ".join(groups)


def public_names() -> dict[tuple[str, str], list[str]]:
    """(page, its links) -> full names, from the table of commands.md."""
    rows = PUBLIC_ROW.findall(texts()["commands.md"].split(PUBLIC)[1])
    return {(page, of): re.findall(r"`\]\[(.*?)\]", linked(names)) for page, names, of in rows}


def reference_pages() -> dict[str, str]:
    """Pages of public names by file, to which mkdocstrings adds the docstrings."""
    pages = {}
    for (heading, about), names in public_names().items():
        parts = [f"# {heading}", f"Examples: {about}."]
        for name in names:
            members = MEMBERS.get(name, "").replace(" ", ", ")
            parts.append(f"::: {name}\n    options:\n      members: [{members}]")
        pages[f"reference-{heading.split()[0].lower()}.md"] = "\n\n".join(parts) + "\n"
    return pages


@cache
def texts() -> dict[str, str]:
    """The pages of docs by name."""
    return {path.name: path.read_text() for path in sorted(DOCS.glob("*.md"))}


def pages_that_name(word: str) -> list[str]:
    """Links to the pages that name an option, with its dash, or a case or command, in code."""
    found = re.compile(rf"(`|fsipetsc |scripts/run |(?<!\w)(?=-)){word}\b")
    names = (name for name, text in texts().items() if word in text and found.search(text))
    return [f"[{name.removesuffix('.md')}]({name})" for name in names]


def options_page() -> str:
    """All options, of every run, of built-in cases and of commands, from the tables of -help."""
    from fsipetsc.cases import BUILT_IN, load_case
    from fsipetsc.cli import COMMANDS
    from fsipetsc.options import COMMON, PETSC_OPTIONS, REQUIRED

    shared = {option.name for option in COMMON + PETSC_OPTIONS}
    parts = ["# All options", "Cases have defaults of their own, which `CASE -help` prints."]

    def add(title: str, about: str, options: Iterable[Any], known: Iterable[str] = ()) -> None:
        rows = []
        for o in options:
            choices = f": {', '.join(map(str, o.choices))}" if o.choices else ""
            default = "" if o.default in (None, REQUIRED) else o.default
            pages = ", ".join(pages_that_name(f"-{o.name}") or known)
            what = f"{default} | {o.unit} | {o.help}{choices} | {pages}"
            rows.append(f"| `-{o.name}` | {o.kind} | {what} |")
        head = "| option | type | default | unit | meaning | pages |\n|---|---|---|---|---|---|"
        if rows:
            parts.extend([f"## {title}", about, "\n".join([head, *rows])])

    def add_own(name: str, summary: str, options: Iterable[Any]) -> None:
        known = pages_that_name(name)
        about = f"{summary[:1].upper()}{summary[1:]}. Pages: {', '.join(known)}."
        add(name, about, [o for o in options if o.name not in shared], known)

    add("Every run", "Options of the program.", COMMON)
    add("PETSc's", "Options of PETSc that every run takes.", PETSC_OPTIONS)
    for name in BUILT_IN:
        case = load_case(name)
        add_own(name, case.SUMMARY, case.OPTIONS)
    for name, command in COMMANDS.items():
        if found := not command.by_one and command.find("OPTIONS"):
            add_own(name, command.summary, found)
    return "\n\n".join(parts) + "\n"


def series_table() -> str:
    """The table of all series that results may have."""
    from fsipetsc.scheme.observables import TABLE

    rows = ["| series | unit | one for each | what it is |", "|---|---|---|---|"]
    for one in TABLE:
        first, *more = one.names(3)
        name, what = f"`{first}`" + ", …" * bool(more), one.what.replace("|", "∣")
        rows.append(f"| {name} | {one.unit} | {one.of or 'run'} | {what} |")
    return "\n".join(rows) + "\n"


def made_pages() -> dict[str, str]:
    """Pages that are no files of docs, but for the tutorial, by name."""
    return {"index.md": front_page(), "options-all.md": options_page(), **reference_pages()}


def inside(markdown: str) -> str:
    """Links to files that are not pages become their names: the site has no copy of the code. The
    notebook is a page.
    """
    markdown = markdown.replace("](tutorial.ipynb)", "](tutorial.md)")
    return re.sub(r"\[([^\]]*)\]\((?:\.\./|CITATION)[^)]*\)", r"\1", markdown)


def on_files(files: Any, config: Any) -> Any:
    from mkdocs.structure.files import File

    tutorial, pictures = notebook_page()
    for name, content in {**made_pages(), "tutorial.md": tutorial, **pictures}.items():
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    if page.file.src_uri == "commands.md":
        before, public = markdown.split(PUBLIC)
        shown = PUBLIC_ROW.sub(lambda row: row[0].replace(row[2], linked(row[2])), public)
        markdown = before + PUBLIC + shown
    if page.file.src_uri == "results.md":
        markdown = markdown.replace("\n## While", f"\n{series_table()}\n## While", 1)
    return inside(markdown)
