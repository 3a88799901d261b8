"""What a result holds, as text."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from fsipetsc.output.reader import Run, open_run


def info(path: str | os.PathLike[str]) -> str:
    """Case, times, layers, series, options, summary and errors of a result. Raises FileError if it cannot be read."""
    with open_run(path) as run:
        parts = [
            [("file", os.fspath(path)), *_overview(run)],
            [("layers", ""), *_layers(run)],
            [("options", ""), *_entries({f"-{name}": value for name, value in run.options.items()})],
            [("summary", ""), *_entries(run.summary)],
        ]
        if run.errors:
            parts.append([("L2 errors", ""), *((f"  {kind}", _inline(values)) for kind, values in run.errors.items())])
    return "\n\n".join(_table(part) for part in parts)


def _overview(run: Run) -> list[tuple[str, str]]:
    steps = len(run.series["t"]) if "t" in run.series else 0
    created = run.header.get("created")
    state = "complete" if run.complete else run.summary.get("status", "unfinished: still running, or killed")
    rows = [("case", run.case), ("state", state)]
    if created:
        rows.append(("created", created))
    rows.append(("frames", f"{run.nframes}{_range(', t =', run.time)}"))
    rows.append(("time steps", f"{steps}{_range(', dt =', run.series['dt']) if 'dt' in run.series else ''}"))
    rows.append(("series", ", ".join(run.series) or "none"))
    rows.append(("interfaces", ", ".join(run.interfaces) or "none"))
    rows.extend(("note", note) for note in run.header.get("notes", ()))
    return rows


def _layers(run: Run) -> Iterable[tuple[str, str]]:
    for layer in run.layers:
        grid = f"{len(layer.X)} points{_range(', X =', layer.X)}, h = {layer.h:g}"
        yield f"  {layer.name}", f"{layer.kind}, {grid}; {', '.join(layer.fields)}"


def _range(label: str, values: np.ndarray) -> str:
    return f"{label} {np.nanmin(values):g} … {np.nanmax(values):g}" if np.isfinite(values).any() else ""


def _entries(entries: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    return ((f"  {name}", _text(value)) for name, value in entries.items() if value != "")


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
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _inline(entries: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {_text(value)}" for name, value in entries.items())


def _table(rows: Iterable[tuple[str, str]]) -> str:
    rows = list(rows)
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(f"{name:{width}}{value}".rstrip() for name, value in rows)
