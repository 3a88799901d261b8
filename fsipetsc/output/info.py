"""What a result holds, as text."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from fsipetsc.checks import duration
from fsipetsc.options.option import INT_MAX
from fsipetsc.output.reader import BlockLayer, Layer, Run, open_run


def _three_digits(value: float) -> str:
    return f"{value:.3g}"


def info(path: str | os.PathLike[str]) -> str:
    """Case, times, layers, series, options, summary and errors of a result. Raises FileError if it cannot be read."""
    with open_run(path) as run:
        (_, first), *parts = info_sections(run)
    tables = [_table([("file", os.fspath(path)), *first])]
    tables += [_table([(title, ""), *((f"  {name}", text) for name, text in rows)]) for title, rows in parts]
    return "\n\n".join(tables)


def info_sections(run: Run) -> list[tuple[str, list[tuple[str, str]]]]:
    """(title, rows of name and text) of what there is to say about a result."""
    parts = [
        ("run", _overview(run)),
        ("layers", list(_layers(run))),
        ("options", list(_entries({f"-{name}": value for name, value in run.options.items()}))),
        ("summary", list(_summary(run.summary))),
    ]
    if run.errors:
        norm = run.options.get("fsi_norm", "L2")  # results of earlier versions have none
        parts.append((f"{norm} errors", [(kind, _inline(values)) for kind, values in run.errors.items()]))
    return parts


def _overview(run: Run) -> list[tuple[str, str]]:
    steps = len(run.series["t"]) if "t" in run.series else 0
    created = run.header.get("created")
    state = "complete" if run.complete else run.summary.get("status", "unfinished: still running, or killed")
    rows = [("case", run.case), ("state", state)]
    if run.dimension > 1:
        rows.append(("dimension", str(run.dimension)))
    if created:
        rows.append(("created", created))
    rows.append(("frames", f"{run.nframes}{_range(', t =', run.time)}"))
    rows.append(("time steps", f"{steps}{_range(', dt =', run.series['dt']) if 'dt' in run.series else ''}"))
    rows.append(("series", ", ".join(run.series) or "none"))
    rows.append(("interfaces", _positions(run)))
    if run.points:
        rows.append(("points", ", ".join(f"{name} at {_place(X)}" for name, X in run.points)))
    rows.extend(("note", note) for note in run.header.get("notes", ()))
    return rows


def _layers(run: Run) -> Iterable[tuple[str, str]]:
    """Active points come and go where a layer meets a fixed end; those held in reserve for it are stored, too."""
    for layer in run.layers:
        if isinstance(layer, BlockLayer):
            ranges = [_range(f", {name} =", getattr(layer, name)) for name in "XYZ"[: run.dimension]]
            yield layer.name, f"{layer.kind}, {layer.size}{''.join(ranges)}; {', '.join(layer.fields)}"
            continue
        grid = f"{len(layer.X)} points{_active(layer, run.nframes)}{_range(', X =', layer.X)}, h = {layer.h:g}"
        yield layer.name, f"{layer.kind}, {grid}; {', '.join(layer.fields)}"


def _place(X: Iterable[float]) -> str:
    return ", ".join(f"{name} = {x:.6g}" for name, x in zip("XYZ", X))


def _active(layer: Layer, nframes: int) -> str:
    """How many points were part of the layer in the first and in the last frame, if not all of them."""
    if not nframes:
        return ""
    counts = [int(np.isfinite(layer.frame(frame)[layer.fields[0]]).sum()) for frame in (0, nframes - 1)]
    if counts == [len(layer.X)] * 2:
        return ""
    return f" with those in reserve, {' … '.join(str(n) for n in dict.fromkeys(counts))} active"


def _positions(run: Run) -> str:
    """Where the interfaces are at the end."""
    if (run.dimension == 2 or run.blocks) and run.summary.get("interfaces"):
        axis, heights = " xyz"[run.dimension], run.summary["interfaces"].items()
        mean = " on average" * (run.dimension > 1)
        return ", ".join(f"{name} at {axis} = {y:.6g}{mean}" for name, y in heights) + f" at t = {run.summary['t']:g}"
    if not len(run.series.get("x_interface", ())):
        return ", ".join(run.interfaces) or "none"
    last = zip(run.interfaces, np.atleast_1d(run.series["x_interface"][-1]))
    return ", ".join(f"{name} at x = {x:.6g}" for name, x in last) + f" at t = {run.series['t'][-1]:g}"


def _range(label: str, values: np.ndarray) -> str:
    return f"{label} {np.nanmin(values):g} … {np.nanmax(values):g}" if np.isfinite(values).any() else ""


def _entries(entries: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    return ((name, _text(value)) for name, value in entries.items() if value != "")


def _summary(entries: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    """What a run came to, in the order of LABELS; what is not there stands behind, as it is called."""
    part = entries.get("part")
    if isinstance(part, Mapping) and part.get("steps") == entries.get("steps"):  # no restart before
        entries = {name: value for name, value in entries.items() if name != "part"}
    named = [(name, *LABELS[name]) for name in LABELS if entries.get(name) not in ("", None, {})]
    for name, label, written in named:
        try:
            yield label, written(entries[name])
        except (AttributeError, KeyError, TypeError, ValueError):  # of a damaged file
            yield label, _text(entries[name])
    more = {name.replace("_", " "): value for name, value in entries.items() if name not in LABELS}
    yield from _entries(more)


def _seconds(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_seconds(number)}" for name, number in value.items())
    return duration(value)


def _part(value: Mapping[str, Any]) -> str:
    return f"{value['steps']} steps in {duration(value['wall_time'])}"


def _bounds(changes: Iterable[tuple[float, str]]) -> str:
    return ", ".join(f"{what} from t = {t:.6g}" for t, what in changes)


def _departures(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} to {size:.1e}" for name, size in values.items())


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return _inline(value)
    if isinstance(value, (list, tuple)):
        head = ", ".join(map(_text, value[:6]))
        return f"{head}, … ({len(value)})" if len(value) > 6 else head or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return "none"
    if value == INT_MAX:
        return "no limit"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _inline(entries: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {_text(value)}" for name, value in entries.items())


def _table(rows: Iterable[tuple[str, str]]) -> str:
    rows = list(rows)
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(f"{name:{width}}{value}".rstrip() for name, value in rows)


#: entry of a summary -> what it is called, how its value is written; what a reader asks first stands first
LABELS: dict[str, tuple[str, Callable[[Any], str]]] = {
    "status": ("ended", str),
    "message": ("message", str),
    "t": ("time reached", _text),
    "departures": ("conserved", _departures),
    "J_error": ("largest departure of J from the grid's volume", _three_digits),
    "steps": ("time steps", str),
    "rejected_steps": ("steps made anew", str),
    "dt_min": ("shortest step", _three_digits),
    "dt_max": ("longest step", _three_digits),
    "limits": ("bounds of the step", _bounds),
    "wall_time": ("time for the steps", _seconds),
    "wall_time_total": ("time for all", _seconds),
    "phases": ("of it", _seconds),
    "part": ("since the restart", _part),
    "ranks": ("ranks", str),
    "points": ("points", str),
    "interfaces": ("interfaces", _text),
    "rhs_evaluations": ("right-hand sides", str),
}
