"""The command `plot`: the pictures of a result one by one, or a page that tells what happened, or a
film.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.options.option import floats
from fsipetsc.output.file_layout import writing
from fsipetsc.output.plots import fields, series, style
from fsipetsc.output.plots.style import Figure, FigureBase
from fsipetsc.output.quantities import Quantity, chosen, there
from fsipetsc.output.reader import Run, open_run

WIDTH = 10.8  # inches, of a figure
PANELS, MAPS = 2.8, 4.4  # inches, heights of a row of curves, of maps over x and t
#: of a film [dots per inch], frames at most (of more, some are left out), length [s]
FILM_DPI, MOST_FRAMES, FILM_SECONDS = 100, 200, 10.0
LEAST_FRAMES = 5  # of fewer, profiles say more than maps over x and t
PICTURES = (".png", ".pdf", ".svg", ".jpg")

#: height [inches], what is drawn on a figure of this height
Drawing = tuple[float, Callable[[FigureBase], None]]


def plot(path: str, given: Mapping[str, str]) -> str:
    """Do what the options ask for (fsipetsc.cli); the files that have been written, a line each.

    Raises FileError if the result cannot be read or a file cannot be written, InputError for
    options that cannot be followed.
    """
    times = floats(given["-times"], "times", "s") if "-times" in given else ()
    names = tuple(map(str.strip, given["-fields"].split(","))) if "-fields" in given else ()
    where, every, film = Path(given.get("-o", os.curdir)), "-all" in given, "-animate" in given
    is_file = where.suffix == ".gif" if film else where.suffix in PICTURES
    if every and (film or is_file):
        raise InputError("plot: -all writes several pictures: expected a directory, no -animate")
    if where.suffix and not (every or is_file or where.is_dir()):
        ends = ".gif" if film else " or ".join(PICTURES)
        there = "a directory that is there, or a file that ends with"
        raise InputError(f"plot: -o {where}: expected {there} {ends}")
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    stem, written = Path(path).stem, []
    with open_run(path) as run, rc_context(style.STYLE), np.errstate(all="ignore"):
        if film:
            return str(animate(run, where if is_file else where / f"{stem}.gif", names))
        whole = {"": partial(page, run=run, names=names, times=times)}
        for name, draw in (pictures(run, times) if every else whole).items():
            figure = Figure()
            draw(figure)
            target = where / (f"{stem}-{name}.png" if name else f"{stem}.png")
            written.append(str(style.save(figure, where if is_file else target)))
    return "\n".join(written)


def pictures(run: Run, times: Sequence[float] = ()) -> dict[str, Callable[[Figure], None]]:
    """Name -> drawing function of each picture that this run has the data for."""
    found: dict[str, tuple[str, Drawing]] = {}
    if run.nframes:
        found = {q.name: (q.title, _at_times(run, q, times)) for q in there(run)}
    if run.dimension == 1 and run.nframes >= LEAST_FRAMES:
        found["xt"] = "space and time", _over_time(run, chosen(run, ()))
    for name, panels in series.panels(run).items():
        if panels:
            bound = run.summary.get("bound") if name == "steps" else None
            title = f"steps, bounded by {bound} at the end" if bound else name
            found[name] = title, _curves(run, panels)
    return {
        name: partial(_draw, run=run, title=title, drawings=[drawing])
        for name, (title, drawing) in found.items()
    }


def page(figure: Figure, run: Run, names: Sequence[str] = (), times: Sequence[float] = ()) -> None:
    """Fields over space and time, below them interfaces, energy, departures and steps.

    names: of the fields, times: of profiles or maps. InputError for a field that there is not.
    """
    quantities, drawings = chosen(run, names), []
    if run.dimension == 1 and not times and run.nframes >= LEAST_FRAMES:
        drawings.append(_over_time(run, quantities))
    elif run.nframes:
        drawings += [_at_times(run, quantity, times) for quantity in quantities]
    interfaces, ledgers, steps = series.panels(run).values()
    told = [panel for panel in ledgers if panel.label in ("change of energy", series.DEPARTURE)]
    if panels := [*interfaces[:1], *reversed(told), *steps]:
        drawings.append(_curves(run, panels, columns=len(panels)))
    end = style.moment(run, -1) if run.nframes else "no frame"
    _draw(figure, run, f"{end}, {len(run.series.get('t', ())):,} steps", drawings)


def _draw(figure: Figure, run: Run, title: str, drawings: Sequence[Drawing]) -> None:
    """Drawings below each other, and the title."""
    heights = [height for height, _ in drawings] or [1.0]
    figure.set_size_inches(WIDTH, 0.5 + sum(heights))
    parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for part, (_, draw) in zip(parts, drawings):
        draw(part)
    style.set_title(figure, style.of_run(run, title))


def _at_times(run: Run, quantity: Quantity, times: Sequence[float]) -> Drawing:
    """Profiles or maps."""
    view = fields.View(run, quantity, fields.frames_of(run, quantity, times))
    return fields.sizes(view, len(view.frames))[2], partial(fields.draw, view=view)


def _over_time(run: Run, quantities: Sequence[Quantity]) -> Drawing:
    """Maps over x and t."""
    return MAPS, partial(fields.draw_over_time, run=run, quantities=quantities)


def _curves(run: Run, panels: list[series.Panel], columns: int = 3) -> Drawing:
    """Panels of curves over time."""
    draw = partial(series.draw, run=run, panels=panels, columns=columns)
    return PANELS * -(-len(panels) // columns), draw


# a film: maps, or in one dimension profiles, one frame after the other


def animate(run: Run, target: Path, names: Sequence[str] = ()) -> Path:
    """Draw a result as the GIF `target`; names: fields that are shown.

    FileError if the film cannot be written, InputError for a result of less than two frames,
    and for a field that there is not.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.figure import Figure

    if run.nframes < 2:
        raise InputError(f"-animate: there are {run.nframes} frames: expected two or more")
    chosen(run, names)  # an error comes before the film
    step, figure = -(-run.nframes // MOST_FRAMES), Figure(dpi=FILM_DPI)
    writer = PillowWriter(fps=max(1.0, run.nframes / step / FILM_SECONDS))
    with writing(target, "the film"), writer.saving(figure, target, FILM_DPI):
        for _ in drawn(figure, run, range(0, run.nframes, step), names):
            writer.grab_frame()
    return target


def drawn(
    figure: Figure, run: Run, frames: Sequence[int], names: Sequence[str] = ()
) -> Iterator[int]:
    """Each frame, once it is on the figure; scales and colours are the same in all. InputError."""
    views = [fields.View(run, quantity, frames) for quantity in chosen(run, names)]
    _, width, height = fields.sizes(views[0], 1)
    size = (10.8, 3.4) if run.dimension == 1 else (len(views) * (width + 1.2), height + 0.9)
    figure.set_size_inches(*size)
    grid = figure.subplots(1, len(views), squeeze=False)[0]
    titles = {frame: style.of_run(run, style.moment(run, frame)) for frame in frames}
    title = style.set_title(figure, max(titles.values(), key=len))  # the layout has room for each
    for frame in frames:
        for axes, view in zip(grid, views):
            for artist in [*axes.lines, *axes.collections]:
                artist.remove()
            pictures = view.draw(axes, frame)
            if frame == frames[0]:
                fields.draw_bars(figure, view, pictures, axes)
        if frame == frames[0]:
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # only what is drawn moves from now on
        title.set_text(titles[frame])
        yield frame
