"""Runs the code of documents from top to bottom, in one process: FOLDER PAGE.md … NOTEBOOK.ipynb …

Commands are shortened: a few steps, coarse grids. Each page has a folder of its own in FOLDER.
Python that begins with `# NAME.py` is that file. What `# prints …` says, and what a notebook shows,
must be what is printed. Prints what went wrong.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import sys
import traceback
import warnings
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
#: what makes a command short
SHORT = {
    "run": "-ts_max_steps 3 -fsi_quiet",
    "convergence": "-fsi_orders 2 -ts_max_time 0.01",
    "stability": "-stability_points 20",
    "stability -sweep": "-density_ratios 1 -stiffness_ratios 1",
    "flutter": "-fsi_h 0.0625 -panel_thickness 0.1 -flutter_machs 2 -flutter_lambdas 500,600 "
    "-ts_max_time 4",
}
#: may end with 3: a coupling breaks its promise, a run is too short for two modes
VERDICTS = "stability", "flutter"
_plotted: list[str] = []


def code_of(page: str) -> list[tuple[str, str, str | None]]:
    """(language, content, what it prints or None) of fenced blocks, or of a notebook's cells."""
    text = Path(page).read_text()
    if page.endswith(".md"):
        return [(*found, None) for found in re.findall(r"^```(\w*)\n(.*?)^```$", text, re.S | re.M)]
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    said = ["".join("".join(o.get("text", "")) for o in cell["outputs"]) for cell in cells]
    return [("python", "".join(cell["source"]), out) for cell, out in zip(cells, said, strict=True)]


def main(folder: str, *pages: str) -> None:
    for page in pages:
        place = Path(folder, Path(page).stem)
        place.mkdir()
        (place / "runs").symlink_to(REPOSITORY / "runs")
        os.chdir(place)
        names: dict[str, object] = {"__name__": "__main__"}
        for language, content, expected in code_of(page):
            try:
                if language == "python":
                    python(content, expected, names)
                elif language == "sh":
                    for line in content.splitlines():
                        command(shlex.split(re.sub(r"\[[^]]*\]", "", line), comments=True))
            except BaseException as error:
                traceback.print_exc()
                print(f"{Path(page).name}: {error!r} in\n{content}", flush=True)


def python(content: str, expected: str | None, names: dict[str, object]) -> None:
    if file := re.match(r"# (\w+\.py)\n", content):
        Path(file[1]).write_text(content)
        return
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(content, names)
    said, told = out.getvalue(), re.findall(r"^# prints (.*)$", content, re.M)
    assert not told or told == [line.strip() for line in said.splitlines()], said
    assert expected in (None, said), said


def command(words: list[str]) -> None:
    """A line for the shell, by its words; what is in [ ] is left out."""
    from fsipetsc.cli import COMMANDS
    from fsipetsc.cli import main as fsipetsc

    if words[:1] == ["mpiexec"]:
        words = words[3:]
    if words[:1] == ["."]:
        words = words[1:]
    if not words or words[0] == "export":
        return
    if words[0].startswith("scripts/"):
        assert (REPOSITORY / words[0]).exists(), words[0]
        if words[0] != "scripts/run":
            return
        words = ["python", "-m", "fsipetsc", *words[1:]]
    assert words[:3] == ["python", "-m", "fsipetsc"], words
    words = words[3:]
    kind = words[0] if words[0] in COMMANDS else "run"
    if kind == "plot" and _plotted:
        return  # a few seconds each; the words are the same
    if kind == "plot":
        _plotted.append(words[1])
    if "-help" not in words and not words[-1].endswith(".h5"):
        sweep = SHORT["stability -sweep"] if "-sweep" in words else ""
        words += f"{SHORT.get(kind, '')} {sweep}".split()
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = fsipetsc(words)
    assert status == 0 or (status == 3 and kind in VERDICTS), said.getvalue()


if __name__ == "__main__":
    warnings.filterwarnings("ignore", "FigureCanvasAgg is non-interactive")
    main(*sys.argv[1:])
