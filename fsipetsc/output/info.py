"""What a result holds, as text: the command `info`, and the summary that a run ends with."""

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from fsipetsc.checks import duration
from fsipetsc.options import shown
from fsipetsc.output.file_layout import damage
from fsipetsc.output.quantities import is_si
from fsipetsc.output.reader import Layer, Run, open_run

Rows = list[tuple[str, str]]


def info(path: str | os.PathLike[str]) -> str:
    """Return case, times, layers, series, options, summary and errors of a result. FileError."""
    with open_run(path) as run, damage(run.path):
        parts = {
            "layers": [(layer.name, _layer(layer)) for layer in run.layers],
            "options": [(f"-{k}", _text(value)) for k, value in run.options.items() if value != ""],
            "summary": summary_rows({**run.summary, "interfaces": None}, " s" * is_si(run)),
            f"{run.options.get('fsi_norm', 'L2')} errors": summary_rows(run.errors),
        }
        tables = [[("file", os.fspath(path)), *_overview(run)]]
    for title, rows in parts.items():
        tables += [[(title, ""), *((f"  {k}", text) for k, text in rows)]] * bool(rows)
    return "\n\n".join(map(table, tables))


def table(rows: Iterable[Iterable[object]], justify: Any = str.ljust) -> str:
    """Write rows below each other, in columns two blanks apart."""
    cells = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join("  ".join(map(justify, line, widths)).rstrip() for line in cells)


def _overview(run: Run) -> Rows:
    dt, x = run.series.get("dt", np.empty(0)), run.series.get("x_interface", ())
    places, s = ", ".join(run.interfaces) or "none", " s" * is_si(run)
    if len(x):  # in one dimension
        named = (f"{name} at x = {value:.6g}" for name, value in zip(run.interfaces, x[-1]))
        places = f"{', '.join(named)} at t = {run.series['t'][-1]:g}"
    state = run.summary.get("status", "unfinished: still running, or killed")
    rows = [
        ("case", run.case),
        ("state", "complete" if run.complete else str(state)),
        ("dimension", str(run.dimension)),
        ("created", run.header.get("created", "")),
        ("frames", f"{run.nframes}{_range(', t =', run.time, s)}"),
        ("time steps", f"{len(dt)}{_range(', dt =', dt, s)}"),
        ("series", ", ".join(run.series) or "none"),
        ("interfaces", places),
        *(("point", text) for text in run.columns["point"]),
        *(("note", note) for note in run.header.get("notes", ())),
    ]
    return [(name, text) for name, text in rows if text]


def _layer(layer: Layer) -> str:
    ranges = (_range(f", {x} =", getattr(layer, x)) for x in "XYZ"[: len(layer.shape)])
    return f"{layer.kind}, {layer.size}{''.join(ranges)}; {', '.join(layer.fields)}"


def _range(label: str, values: Any, unit: str = "") -> str:
    finite = np.asarray(values)[np.isfinite(values)]
    return f"{label} {finite.min():g} … {finite.max():g}{unit}" if finite.size else ""


def summary_rows(summary: Mapping[str, Any], unit: str = "") -> Rows:
    """Return entries of Run.summary, or Run.errors, but for what is empty. unit: of a time."""
    written = {
        "t": lambda t: _text(t) + unit,
        "departures": lambda of: ", ".join(f"{name} {size:.1e}" for name, size in of.items()),
        "wall_time": duration,
    }
    shown = (k for k, v in summary.items() if v not in ("", None, {}, []))
    names = (name for name in shown if not name.startswith("initial_"))
    return [(name, written.get(name, _text)(summary[name])) for name in names]


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_text(entry)}" for name, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value[:6])) + ", …" * (len(value) > 6) or "none"
    return f"{value:.6g}" if isinstance(value, float) else shown(value)
