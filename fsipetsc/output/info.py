"""What a result holds, as text."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from fsipetsc.checks import duration
from fsipetsc.options import INT_MAX
from fsipetsc.output.file_layout import damage
from fsipetsc.output.reader import Layer, Run, open_run
from fsipetsc.output.units import is_si, unit_of

Rows = list[tuple[str, str]]


def info(path: str | os.PathLike[str]) -> str:
    """Case, times, layers, series, options, summary and errors of a result. FileError."""
    with open_run(path) as run:
        (_, first), *parts = info_sections(run).items()
    tables = [[("file", os.fspath(path)), *first]]
    tables += ([(title, ""), *((f"  {k}", text) for k, text in rows)] for title, rows in parts)
    return "\n\n".join(map(table, tables))


def table(rows: Rows) -> str:
    """Names and texts below each other."""
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(f"{name:{width}}{value}".rstrip() for name, value in rows)


def info_sections(run: Run) -> dict[str, Rows]:
    """Title -> rows of name and text, of what there is to say about a result. FileError."""
    with damage(run.path):
        parts = {
            "run": _overview(run),
            "layers": [(layer.name, _of_layer(run, layer)) for layer in run.layers],
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


def _of_layer(run: Run, layer: Layer) -> str:
    """The grid and fields of a layer."""
    axes = "XYZ"[: run.dimension]
    grid = layer.size + "".join(_range(f", {name} =", getattr(layer, name)) for name in axes)
    spacing = f", h = {layer.h:g}" * (run.dimension == 1)
    return f"{layer.kind}, {grid}{spacing}; {', '.join(layer.fields)}"


def _through(run: Run) -> Rows:
    """Of each face through which energy came in, how much, and how much of it was heat."""
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
    """The unit of times, after a space; none where a case is dimensionless."""
    return " s" * is_si(run)


def summary_rows(summary: Mapping[str, Any], unit: str) -> Rows:
    """Results of a run in the order of LABELS. unit: what comes after a time."""
    written = {
        "t": lambda t: _text(t) + unit,
        "departures": lambda of: ", ".join(f"{name} to {size:.1e}" for name, size in of.items()),
        "J_error": "{:.3g}".format,
        "lost_energy": "{:.3g}".format,
        "wall_time": duration,
    }
    known = {name: value for name, value in summary.items() if value not in ("", None, {}, [])}
    return [(LABELS[k], written.get(k, _text)(known[k])) for k in LABELS if k in known]


def error_rows(errors: Mapping[str, Any]) -> Rows:
    """The rows of a table of errors, by kind of layer."""
    return [(kind, _text(values)) for kind, values in errors.items()]


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_text(entry)}" for name, entry in value.items())
    if isinstance(value, (list, tuple)):
        head = ", ".join(map(_text, value[:6]))
        return f"{head}, … ({len(value)})" if len(value) > 6 else head or "none"
    if isinstance(value, float):
        return f"{value:.6g}"
    words = {True: "yes", False: "no"} if isinstance(value, bool) else {INT_MAX: "no limit"}
    return "none" if value is None else words.get(value, str(value))


#: entry of a summary -> label; the most important first
LABELS = {
    "status": "ended",
    "message": "message",
    "t": "time reached",
    "departures": "conserved",
    "J_error": "departure of J",
    "lost_energy": "lost energy of solids",
    "steps": "time steps",
    "rejected_steps": "rejected steps",
    "bound": "step bounded by",
    "wall_time": "wall time of the steps",
    "ranks": "ranks",
    "points": "points",
    "interfaces": "interfaces",
    "rhs_evaluations": "right-hand sides",
    "versions": "versions",
}
