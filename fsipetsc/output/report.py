"""A result as one HTML page that needs nothing else: a film with a slider, tables, all pictures."""

from __future__ import annotations

import base64
import html
import io
import json
import os
from collections.abc import Sequence
from pathlib import Path
from string import Template

import numpy as np

from fsipetsc.output.file_layout import writing
from fsipetsc.output.info import info_sections
from fsipetsc.output.plots.film import images, some
from fsipetsc.output.plots.page import pictures
from fsipetsc.output.plots.scales import moment
from fsipetsc.output.plots.style import STYLE, needed
from fsipetsc.output.reader import Run, open_run

FILM = 60  # frames under the slider; of more, some are left out
DPI = 110


def report(path: str | os.PathLike[str], outdir: str | os.PathLike[str] = ".") -> Path:
    """Write NAME.html in `outdir`; its path.

    Raises FileError if the result cannot be read or the page cannot be written, InputError without
    matplotlib.
    """
    matplotlib = needed("report")
    target = Path(outdir) / f"{Path(path).stem}.html"
    style = {**STYLE, "savefig.dpi": DPI}
    with open_run(path) as run, matplotlib.rc_context(style), np.errstate(all="ignore"):
        text = _page(run)
    with writing(target, "the report"):
        target.write_text(text, encoding="utf-8")
    return target


def _page(run: Run) -> str:
    from matplotlib.figure import Figure

    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    frames = some(run, FILM) if run.nframes > 1 else range(0)
    drawn = []
    for name, draw in pictures(run):
        figure, kept = Figure(), io.BytesIO()
        draw(figure)
        figure.savefig(kept, format="png")
        drawn.append(f'<figure id="{name}"><img alt="{name}" src="{_address(kept)}"></figure>')
    return template.substitute(
        title=html.escape(f"{run.case}: {Path(run.path).name}"),
        state=html.escape(_state(run)),
        film=json.dumps(_film(run, frames)),
        times=json.dumps([moment(run, frame) for frame in frames]),
        tables="\n".join(_table(title, rows) for title, rows in _tables(run)),
        pictures="\n".join(drawn),
    )


def _state(run: Run) -> str:
    return "complete" if run.complete else str(run.summary.get("status", "unfinished"))


def _film(run: Run, frames: Sequence[int]) -> list[str]:
    """Each frame as the address of a picture that is in the page itself."""
    addresses = []
    for image in images(run, frames) if frames else ():
        kept = io.BytesIO()
        image.save(kept, "PNG", optimize=True)
        addresses.append(_address(kept))
    return addresses


def _address(picture: io.BytesIO) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}"


def _tables(run: Run) -> list[tuple[str, Sequence[tuple[str, str]]]]:
    """What the run came to, then the rest of what `info` says.

    The integrals at the start are left out: the pictures of ledgers begin with them.
    """
    tables = dict(info_sections(run))
    tables["summary"] = [row for row in tables["summary"] if not row[0].startswith("initial ")]
    first = ("summary", *(title for title in tables if title.endswith("errors")))
    return [(title, tables.pop(title)) for title in first] + list(tables.items())


def _table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    body = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows
    )
    opened = "" if title == "options" else " open"
    summary = f"<summary>{html.escape(title)}</summary>"
    return f"<details{opened}>{summary}<table>{body}</table></details>"
