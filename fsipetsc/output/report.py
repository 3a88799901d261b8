"""A result as one HTML page that needs nothing else: a film with a slider, tables, all pictures."""

import base64
import html
import io
import json
import os
from collections.abc import Mapping, Sequence
from itertools import starmap
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from fsipetsc.output.file_layout import writing
from fsipetsc.output.info import info_sections
from fsipetsc.output.plots.page import drawn, pictures
from fsipetsc.output.plots.style import STYLE, moment
from fsipetsc.output.reader import open_run

FILM = 60  # frames under the slider; of more, some are left out
DPI, FILM_DPI = 110, 80
_FIRST = "summary", "errors"  # endings of the titles of tables that come first


def report(path: str, given: Mapping[str, str]) -> Path:
    """Write NAME.html, in the folder of -o if it is given; its path. FileError."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    target = Path(given.get("-o", os.curdir)) / f"{Path(path).stem}.html"
    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    style = {**STYLE, "savefig.dpi": DPI}
    with open_run(path) as run, rc_context(style), np.errstate(all="ignore"):
        step, moving = -(-run.nframes // FILM) or 1, Figure()
        frames = range(0, run.nframes, step) if run.nframes > 1 else ()
        film = [_png(moving, FILM_DPI) for _ in (drawn(moving, run, frames) if frames else ())]
        shown = []
        for name, draw in pictures(run).items():
            draw(figure := Figure())
            image = f'<img alt="{name}" src="{_png(figure, DPI)}">'
            shown.append(f'<figure id="{name}">{image}</figure>')
        # what the run came to, then the rest of what `info` says
        tables = sorted(info_sections(run).items(), key=lambda of: not of[0].endswith(_FIRST))
        state = "complete" if run.complete else str(run.summary.get("status", "unfinished"))
        text = template.substitute(
            title=html.escape(f"{run.case}: {Path(run.path).name}"),
            state=html.escape(state),
            film=json.dumps(film),
            times=json.dumps([moment(run, frame) for frame in frames]),
            tables="\n".join(starmap(_table, tables)),
            pictures="\n".join(shown),
        )
    with writing(target, "the report"):
        target.write_text(text, encoding="utf-8")
    return target


def _png(figure: Any, dpi: int) -> str:
    """A figure as the address of a picture that is in the page itself."""
    kept = io.BytesIO()
    figure.savefig(kept, format="png", dpi=dpi)
    return f"data:image/png;base64,{base64.b64encode(kept.getvalue()).decode()}"


def _table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    body = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows
    )
    opened = "" if title == "options" else " open"
    summary = f"<summary>{html.escape(title)}</summary>"
    return f"<details{opened}>{summary}<table>{body}</table></details>"
