"""Runs the code blocks of documents as a reader would who goes from top to bottom, in one process: FOLDER PAGE.md ...

Commands are called in their own words, but for the launcher, and shortened: a few steps, coarse grids. Each page has a
folder of its own in FOLDER. Python that begins with `# NAME.py` is that file, and `# NAME.py, goes on` more of it. What
`# prints …` says, and what stands in a notebook, must be what is printed. Prints what went wrong, a block for each;
`scripts/…` must exist, `#` begins a comment, and what is in [ ] may be left out.
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
    "bench": "",
    "flutter": "-fsi_h 0.0625 -panel_thickness 0.1 -flutter_machs 2 -flutter_lambdas 500,600 -ts_max_time 4",
}
#: what may be said beside success: a treatment that does not keep its promise, a run too short for a limit cycle
VERDICTS = {"stability": (0, 3), "flutter": (0, 3)}


def blocks(text: str) -> list[tuple[str, str, str | None]]:
    """(language, content, None) of each fenced block."""
    return [(*found, None) for found in re.findall(r"^```(\w*)\n(.*?)^```$", text, re.S | re.M)]


def cells(text: str) -> list[tuple[str, str, str | None]]:
    """("python", content, what it printed) of a notebook's cells of code."""
    code = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    printed = ["".join("".join(output.get("text", "")) for output in cell["outputs"]) for cell in code]
    return [("python", "".join(cell["source"]), text) for cell, text in zip(code, printed, strict=True)]


def main(folder: str, *pages: str) -> None:
    for page in pages:
        place = Path(folder, Path(page).stem)
        place.mkdir()
        (place / "runs").symlink_to(REPOSITORY / "runs")
        os.chdir(place)
        names: dict[str, object] = {"__name__": "__main__"}
        for language, content, expected in (cells if page.endswith(".ipynb") else blocks)(Path(page).read_text()):
            try:
                if language == "python" and (named := re.match(r"# (\w+\.py)(, goes on)?\n", content)):
                    with open(named[1], "a" if named[2] else "w") as file:
                        file.write(content[named.end() :])
                elif language == "python":
                    with contextlib.redirect_stdout(io.StringIO()) as said:
                        exec(content, names)
                    told = re.findall(r"^# prints (.*)$", content, re.M)
                    assert not told or told == [line.strip() for line in said.getvalue().splitlines()], said.getvalue()
                    assert expected in (None, said.getvalue()), said.getvalue()
                elif language == "sh":
                    for line in content.splitlines():
                        command(line)
            except BaseException as error:
                traceback.print_exc()
                print(f"{Path(page).name}: {error!r} in\n{content}", flush=True)


def command(line: str) -> None:
    """One line of a shell."""
    from fsipetsc.cli import COMMANDS
    from fsipetsc.cli import main as fsipetsc

    words = shlex.split(re.sub(r"\[[^]]*\]", "", line), comments=True)
    if words[:1] == ["mpiexec"]:
        words = words[3:]
    if words[:1] == ["."]:
        words = words[1:]
    if not words:
        return
    if words[0].startswith("scripts/"):
        assert (REPOSITORY / words[0]).exists(), words[0]
        if words[0] != "scripts/run":
            return
        words = ["python", "-m", "fsipetsc", *words[1:]]
    assert words[:3] == ["python", "-m", "fsipetsc"], line
    words = words[3:]
    kind = words[0] if words[0] in COMMANDS else "run"
    if kind == "plot" and PLOTTED:
        return  # a few seconds each; the words are the same
    if kind == "plot":
        PLOTTED.append(words[1])
    of_result = kind == "flutter" and words[-1].endswith(".h5")
    if "-help" not in words and not of_result:
        words += SHORT.get(kind, "").split()
        if "-sweep" in words:
            words += SHORT["stability -sweep"].split()
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = fsipetsc(words)
    assert status in VERDICTS.get(kind, (0,)), said.getvalue()


PLOTTED: list[str] = []

if __name__ == "__main__":
    warnings.filterwarnings("ignore", "FigureCanvasAgg is non-interactive")
    main(*sys.argv[1:])
