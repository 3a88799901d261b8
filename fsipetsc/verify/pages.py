"""A picture and a page of an entry of the command `verify`."""

from __future__ import annotations

from pathlib import Path

from fsipetsc.errors import FileError
from fsipetsc.verify.entry import Entry, Measured, Row


def picture(entry: Entry, rows: list[Row], last: Measured | None, path: Path) -> None:
    """Ours over the reference, of the last run, and errors over the grid spacing. FileError."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    curve = last.curve if last else None
    figure = Figure(figsize=(10.0 if curve else 6.0, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 2 if curve else 1, squeeze=False)[0]
    if curve:
        thick = {"color": "0.6", "linewidth": 3, "label": "reference"}
        axes[0].plot(curve.x_reference, curve.reference, **thick)
        axes[0].plot(curve.x, curve.ours, ".", markersize=4, label="computed")
        axes[0].set(xlabel=curve.words[0], ylabel=curve.words[1])
        axes[0].legend(frameon=False)
    for row in rows:
        axes[-1].loglog(row.spacings, row.errors, "o-", label=f"{row.quantity}, order {row.order}")
    axes[-1].set(xlabel="grid spacing h", ylabel="error")
    spacings = sorted({h for row in rows for h in row.spacings})
    axes[-1].set_xticks([], minor=True)
    axes[-1].set_xticks(spacings, [f"{h:.3g}" for h in spacings])
    axes[-1].legend(frameon=False, fontsize="x-small")
    figure.suptitle(entry.title, fontsize="medium")
    try:
        figure.savefig(path, dpi=75)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None


def page(entry: Entry, rows: list[Row], folder: Path) -> None:
    """FOLDER/NAME.md: the problem, the table, the picture. FileError."""
    lines = [f"# {entry.title}", "", entry.text.strip(), "", f"Reference: {entry.source}.", ""]
    lines += _table(entry, rows) if rows else ["Only `-verify_level full` runs this.", ""]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{entry.name}.md").write_text("\n".join(lines), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{folder}: cannot write the page: {error.strerror}") from None


def _table(entry: Entry, rows: list[Row]) -> list[str]:
    """Lines of the table, and the picture."""
    lines = ["| quantity | order | grid spacings | errors | observed orders | verdict |"]
    lines += ["|---|---:|---|---|---|---|"]
    for row in rows:
        spacings, observed = (
            ", ".join(f"{v:.4g}" for v in values) for values in (row.spacings, row.observed)
        )
        errors = ", ".join(f"{error:.2e}" for error in row.errors)
        words = row.quantity, str(row.order), spacings, errors, observed, row.verdict
        lines.append(f"| {' | '.join(words)} |")
    return [*lines, "", f"![{entry.title}]({entry.name}.png)", ""]
