"""What MkDocs makes when it builds the site (scripts/docs): the front page, the page of the tutorial, links."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent


<<<<<<< HEAD
def options_page() -> str:
    """docs/options.md, from the table of options: those of every run, of the cases, and of PETSc."""
    from fsipetsc.cases import BUILT_IN, load_case
    from fsipetsc.options import groups
    from fsipetsc.options.tables import AT_START, IN_LOOP, IN_SOURCES

    cases = {name: load_case(name) for name in BUILT_IN}
    common = {heading: rows for heading, rows in groups(cases["box"]).items() if not heading.startswith("Case ")}
    lines = [
        "# Options",
        "",
        "Made from the table of options by `scripts/docs`; `python -m fsipetsc CASE -help` says the same in a terminal, with",
        "the defaults of that case. A bool without a value is true; ints and floats are lists such as `0.1,0.25`. Options come",
        "from the command line, `-options_file`, YAML or `PETSC_OPTIONS`; the last one given counts. What is not listed here",
        "is refused.",
    ]
    for heading, rows in common.items():
        lines += ["", f"## {heading}", "", *_table(rows)]
    lines += ["", "## More of PETSc", "", *_table((*IN_SOURCES, *IN_LOOP, *AT_START))]
    for name, case in cases.items():
        lines += ["", f"## Case `{name}`", "", f"{case.SUMMARY[0].upper()}{case.SUMMARY[1:]}."]
        if case.DEFAULTS:
            set_here = ", ".join(f"`-{key} {_said(value)}`" for key, value in case.DEFAULTS.items())
            lines += ["", f"Its defaults: {set_here}."]
        if case.OPTIONS:
            lines += ["", *_table(case.OPTIONS)]
    return "\n".join(lines) + "\n"


def _table(rows: Any) -> list[str]:
    lines = ["| option | type | default | meaning |", "|---|---|---|---|"]
    for option in rows:
        default = "" if option.default in (None, ..., "") else f"`{_said(option.default)}`".replace("box.h5", "CASE.h5")
        choices = f" ({', '.join(map(str, option.choices))})" if option.choices else ""
        meaning = f"{option.help}{choices}".replace("|", "\\|")
        lines.append(f"| `-{option.name}` | {option.kind} | {default} {option.unit} | {meaning} |".replace("  ", " "))
    return lines


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return ",".join(map(_said, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


=======
>>>>>>> docs
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


def inside(markdown: str) -> str:
    """Links to files that are not pages become their names: the site has no copy of the code. The notebook is a page."""
    markdown = markdown.replace("](tutorial.ipynb)", "](tutorial.md)")
    return re.sub(r"\[([^\]]*)\]\((?:\.\./|CITATION)[^)]*\)", r"\1", markdown)


def on_files(files: Any, config: Any) -> Any:
    from mkdocs.structure.files import File

    tutorial, pictures = notebook_page()
    for name, content in {"index.md": front_page(), "tutorial.md": tutorial, **pictures}.items():
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    return inside(markdown)

