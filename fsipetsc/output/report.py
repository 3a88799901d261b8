"""A result as one HTML page that needs nothing else: a film with a slider, all pictures, ledgers, options, summary."""

from __future__ import annotations

import base64
import html
import io
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from fsipetsc.errors import FileError, InputError
from fsipetsc.output.info import info_sections
from fsipetsc.output.plots import pictures
from fsipetsc.output.plots.animation import frames, shades, some
from fsipetsc.output.plots.style import STYLE, drawing
from fsipetsc.output.reader import Run, open_run

FILM = 60  # frames under the slider; of more, some are left out
DPI = 110


def report(path: str | os.PathLike[str], outdir: str | os.PathLike[str] = ".") -> Path:
    """Write NAME.html in `outdir`; its path.

    Raises FileError if the result cannot be read or the page cannot be written, InputError without matplotlib.
    """
    try:
        matplotlib = drawing()
    except ImportError as error:
        raise InputError("report: matplotlib is not installed (pip install matplotlib)") from error
    target = Path(outdir) / f"{Path(path).stem}.html"
    with open_run(path) as run, matplotlib.rc_context({**STYLE, "savefig.dpi": DPI}), np.errstate(all="ignore"):
        text = _page(run)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise FileError(f"{target}: cannot write the report: {error.strerror or error}") from error
    return target


def _page(run: Run) -> str:
    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    chosen = some(run, FILM) if run.nframes > 1 else range(0)
    return template.substitute(
        title=html.escape(f"{run.case}: {Path(run.path).name}"),
        state="complete" if run.complete else html.escape(str(run.summary.get("status", "unfinished"))),
        film=json.dumps(list(_film(run, chosen))),
        times=json.dumps([float(run.time[frame]) for frame in chosen]),
        tables="\n".join(_table(title, rows) for title, rows in info_sections(run)),
        pictures="\n".join(_figure(name, draw) for name, draw in pictures(run)),
    )


def _film(run: Run, chosen: range) -> Iterator[str]:
    """Each frame as the address of a picture that is in the page itself."""
    if not chosen:
        return
    from PIL import Image

    palette = shades(run, chosen)
    for frame in frames(run, chosen):
        kept = io.BytesIO()
        Image.fromarray(frame).quantize(palette=palette, dither=0).save(kept, "PNG", optimize=True)
        yield _address(kept.getvalue())


def _figure(name: str, draw: Any) -> str:
    from matplotlib.figure import Figure

    figure, kept = Figure(), io.BytesIO()
    draw(figure)
    figure.savefig(kept, format="png")
    return f'<figure id="{name}"><img alt="{name}" src="{_address(kept.getvalue())}"></figure>'


def _address(picture: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"


def _table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    body = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows)
    opened = "" if title == "options" else " open"
    return f"<details{opened}><summary>{html.escape(title)}</summary><table>{body}</table></details>"
