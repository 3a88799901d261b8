"""What a result holds, as text, and as one HTML page that needs nothing else: a film with a
slider, tables, all pictures.
"""

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

from fsipetsc.checks import duration
from fsipetsc.options import INT_MAX
from fsipetsc.output.file_layout import damage, writing
from fsipetsc.output.plots.page import drawn, pictures
from fsipetsc.output.plots.style import STYLE, moment
from fsipetsc.output.quantities import is_si, unit_of
from fsipetsc.output.reader import Run, open_run

Rows = list[tuple[str, str]]
FILM = 60  # frames under the slider; of more, some are left out
DPI, FILM_DPI = 110, 80
#: entry of a summary -> label; the most important first
LABELS = {
    "status": "ended",
    "message": "message",
    "t": "time reached",
    "departures": "conserved",
    "J_error": "departure of J",
    "lost_energy": "lost energy of solids",
    "steps": "time steps",
    "bound": "step bounded by",
    "wall_time": "wall time of the steps",
    "ranks": "ranks",
    "points": "points",
    "interfaces": "interfaces",
    "rhs_evaluations": "right-hand sides",
    "versions": "versions",
}


def info(path: str | os.PathLike[str]) -> str:
    """Return case, times, layers, series, options, summary and errors of a result. FileError."""
    with open_run(path) as run:
        (_, first), *parts = info_sections(run).items()
    tables = [[("file", os.fspath(path)), *first]]
    tables += ([(title, ""), *((f"  {k}", text) for k, text in rows)] for title, rows in parts)
    return "\n\n".join(map(table, tables))


def table(rows: Rows) -> str:
    """Write names and texts below each other."""
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(f"{name:{width}}{value}".rstrip() for name, value in rows)


def info_sections(run: Run) -> dict[str, Rows]:
    """Return title -> rows of name and text, of what there is to say about a result. FileError."""
    with damage(run.path):
        parts = {
            "run": _overview(run),
            "layers": _layers(run),
            "energy that came in": _through(run),
            "options": [(f"-{k}", _text(value)) for k, value in run.options.items() if value != ""],
            "summary": summary_rows({**run.summary, "interfaces": None}, _second(run)),
            f"{run.options.get('fsi_norm', 'L2')} errors": error_rows(run.errors),
        }
        return {title: rows for title, rows in parts.items() if rows}


def _overview(run: Run) -> Rows:
    dt, x = run.series.get("dt", np.empty(0)), run.series.get("x_interface", ())
    places = ", ".join(run.interfaces) or "none"
    if len(x):  # in one dimension
        named = zip(run.interfaces, x[-1])
        places = ", ".join(f"{name} at x = {value:.6g}" for name, value in named)
        places += f" at t = {run.series['t'][-1]:g}"
    state = run.summary.get("status", "unfinished: still running, or killed")
    rows = [
        ("case", run.case),
        ("state", "complete" if run.complete else str(state)),
        ("dimension", str(run.dimension) if run.dimension > 1 else ""),
        ("created", run.header.get("created", "")),
        ("frames", f"{run.nframes}{_range(', t =', run.time, _second(run))}"),
        ("time steps", f"{len(dt)}{_range(', dt =', dt, _second(run))}"),
        ("series", ", ".join(run.series) or "none"),
        ("interfaces", places),
        *(("point", f"{name} at {', '.join(f'{x:.6g}' for x in X)}") for name, X in run.points),
        *(("note", note) for note in run.header.get("notes", ())),
    ]
    return [(name, text) for name, text in rows if text]


def _layers(run: Run) -> Rows:
    rows = []
    for layer in run.layers:
        axes = "XYZ"[: run.dimension]
        grid = layer.size + "".join(_range(f", {name} =", getattr(layer, name)) for name in axes)
        spacing = f", h = {layer.h:g}" * (run.dimension == 1)
        rows.append((layer.name, f"{layer.kind}, {grid}{spacing}; {', '.join(layer.fields)}"))
    return rows


def _through(run: Run) -> Rows:
    """Tell, of each face through which energy came in, how much, and how much of it was heat."""
    if "energy_face" not in run.series:
        return []
    sums = (run.series[name].sum(axis=0) for name in ("energy_face", "heat_face"))
    unit = f" {unit_of('energy_face', run)}" * is_si(run)
    found = zip(run.faces, *sums)
    return [(name, f"{e:.6g}{unit}, of it heat {q:.6g}{unit}") for name, e, q in found if e]


def _range(label: str, values: Any, unit: str = "") -> str:
    finite = np.asarray(values)[np.isfinite(values)]
    return f"{label} {finite.min():g} … {finite.max():g}{unit}" if finite.size else ""


def _second(run: Run) -> str:
    """Return the unit of times after a space, or nothing where a case is dimensionless."""
    return " s" * is_si(run)


def summary_rows(summary: Mapping[str, Any], unit: str) -> Rows:
    """Return results of a run in the order of LABELS. unit: what comes after a time."""
    written = {
        "t": lambda t: _text(t) + unit,
        "departures": lambda of: ", ".join(f"{name} to {size:.1e}" for name, size in of.items()),
        "wall_time": duration,
    }
    known = {name: value for name, value in summary.items() if value not in ("", None, {}, [])}
    return [(LABELS[k], written.get(k, _text)(known[k])) for k in LABELS if k in known]


def error_rows(errors: Mapping[str, Any]) -> Rows:
    """Return the rows of a table of errors, by kind of layer."""
    return [(kind, _text(values)) for kind, values in errors.items()]


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_text(entry)}" for name, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value[:6])) + ", …" * (len(value) > 6) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    return {None: "none", INT_MAX: "no limit"}.get(value, str(value))


# the page


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
        first = "summary", "errors"
        tables = sorted(info_sections(run).items(), key=lambda of: not of[0].endswith(first))
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
    """Return a figure as the address of a picture that is in the page itself."""
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
