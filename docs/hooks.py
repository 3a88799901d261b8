"""What MkDocs makes when it builds the site (scripts/docs): the front page, the page of the
tutorial, links.
"""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent


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
    """Links to files that are not pages become their names: the site has no copy of the code. The
    notebook is a page.
    """
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
