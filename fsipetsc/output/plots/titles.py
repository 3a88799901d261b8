"""Titles: what a picture shows and of which run, broken into lines that fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fsipetsc.operators.sbp import operator
from fsipetsc.output.plots.scales import unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fsipetsc.output.reader import Run


def of_run(run: Run, what: str) -> str:
    """What is shown, then case, order, grid spacing, ranks, and whether the run came to its end."""
    facts = []
    if "fsi_order" in run.options:
        facts.append(f"order {operator(run.options['fsi_order']).name}")
    if "fsi_h" in run.options:
        facts.append(f"h = {run.options['fsi_h']:g}{unit_of(run, 'm')}")
    ranks = run.summary["ranks"] if "ranks" in run.summary else None
    if ranks:
        facts.append(f"{ranks} rank{'s' * (ranks > 1)}")
    if not run.complete:
        facts.append("unfinished")
    return f"{run.case}, {what}" + (f"  ({', '.join(facts)})" if facts else "")


def set_title(figure: Figure, title: str) -> None:
    """The title of the whole figure, at the top left; what would be cut off begins a new line."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    if not hasattr(figure.canvas, "get_renderer"):
        FigureCanvasAgg(figure)
    text = figure.suptitle("", fontsize=10, x=0.01, ha="left", weight="bold")

    def fits(line: str) -> bool:
        text.set_text(line)
        return text.get_window_extent(figure.canvas.get_renderer()).width <= 0.98 * figure.bbox.width

    lines: list[str] = []
    for part in [title] if fits(title) else title.replace("  (", "\n(").split("\n"):
        lines.append("")
        for word in part.split(" "):
            longer = f"{lines[-1]} {word}".lstrip()
            if lines[-1] and not fits(longer):
                lines.append(word)
            else:
                lines[-1] = longer
    text.set_text("\n".join(lines))
