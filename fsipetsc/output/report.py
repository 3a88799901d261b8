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

import numpy as np

from fsipetsc.output.info import info_sections
from fsipetsc.output.places import writing
from fsipetsc.output.plots import complain, drawn, whole
from fsipetsc.output.plots.animation import frames, shades, some
from fsipetsc.output.plots.frames import check_drawable
from fsipetsc.output.plots.style import STYLE, needed
from fsipetsc.output.reader import Run, open_run

FILM = 60  # frames under the slider; of more, some are left out
DPI = 110


def report(path: str | os.PathLike[str], outdir: str | os.PathLike[str] = ".") -> Path:
    """Write NAME.html in `outdir`; its path.

    Raises FileError if the result cannot be read or the page cannot be written, InputError without matplotlib. Of a damaged
    result what can be drawn is in the page; the error names the rest.
    """
    matplotlib = needed("report")
    target = Path(outdir) / f"{Path(path).stem}.html"
    with open_run(path) as run, matplotlib.rc_context({**STYLE, "savefig.dpi": DPI}), np.errstate(all="ignore"):
        check_drawable(run)
        faults: list[str] = []
        text = _page(run, faults)
    with writing(target, "the report"):
        target.write_text(text, encoding="utf-8")
    complain(path, faults, f"the rest is in {target}")
    return target


def _page(run: Run, faults: list[str]) -> str:
    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    chosen = some(run, FILM) if run.nframes > 1 else range(0)
    return template.substitute(
        title=html.escape(f"{run.case}: {Path(run.path).name}"),
        state="complete" if run.complete else html.escape(str(run.summary.get("status", "unfinished"))),
        film=json.dumps(list(whole(_film(run, chosen), faults, "film"))),
        times=json.dumps([float(run.time[frame]) for frame in chosen]),
        tables="\n".join(_table(title, rows) for title, rows in info_sections(run)),
        pictures="\n".join(_figure(name, picture) for name, picture in drawn(run, faults)),
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


def _figure(name: str, picture: bytes) -> str:
    return f'<figure id="{name}"><img alt="{name}" src="{_address(picture)}"></figure>'


def _address(picture: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"


def _table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    body = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows)
    opened = "" if title == "options" else " open"
    return f"<details{opened}><summary>{html.escape(title)}</summary><table>{body}</table></details>"
