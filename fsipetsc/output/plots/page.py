"""The command `plot`: the pictures of a result one by one, or a page that tells what happened, or a
film.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

from fsipetsc.errors import InputError
from fsipetsc.options import Option, floats
from fsipetsc.output.file_layout import writing
from fsipetsc.output.plots import fields, series, style
from fsipetsc.output.plots.style import USUAL, Figure, FigureBase, Wanted
from fsipetsc.output.quantities import Quantity, chosen, there
from fsipetsc.output.reader import Run, open_run

WIDTH = 10.8  # inches, of a figure
PANELS, MAPS = 2.8, 4.4  # inches, heights of a row of curves, of maps over x and t
#: of a film [dots per inch], frames at most (of more, some are left out), length [s]
FILM_DPI, MOST_FRAMES, FILM_SECONDS = 100, 200, 10.0
LEAST_FRAMES = 5  # of fewer, profiles say more than maps over x and t
CONTOURS = Option("contours", int, 0, "", "lines on each map", check="nonnegative")
PICTURES = (".png", ".pdf", ".svg", ".jpg")

#: height [inches], what is drawn on a figure of this height
Drawing = tuple[float, Callable[[FigureBase], None]]


def plot(path: str, given: Mapping[str, str]) -> str:
    """Do what the options ask for (fsipetsc.cli); the files that have been written, a line each.
    FileError; InputError for options that cannot be followed.
    """
    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter
    from matplotlib.figure import Figure

    names, probes = (given.get(name, "") for name in ("-fields", "-probes"))
    wanted = Wanted(
        fields=[name.strip() for name in names.split(",") if names],
        times=floats(given["-times"], "times", "s") if "-times" in given else (),
        contours=int(CONTOURS.parse(given.get("-contours", "0"))),
        streamlines="-streamlines" in given,
        probes=[floats(place, "probes", "m") for place in probes.split(";") if probes],
    )
    where, every, film = Path(given.get("-o", os.curdir)), "-all" in given, "-animate" in given
    films = (".gif", ".mp4") if FFMpegWriter.isAvailable() else (".gif",)
    endings = films if film else PICTURES
    is_file = where.suffix in endings
    if every and (film or is_file):
        raise InputError("plot: -all writes several pictures: expected a directory, no -animate")
    if where.suffix and not (every or is_file or where.is_dir()):
        there = "a directory that is there, or a file that ends with"
        needs = "; .mp4 needs ffmpeg" * (film and len(films) == 1)
        ends = " or ".join(endings) + needs
        raise InputError(f"plot: -o {where}: expected {there} {ends}")
    stem, written = Path(path).stem, []
    with open_run(path) as run, rc_context(style.STYLE), np.errstate(all="ignore"):
        if film:
            targets = [where] if is_file else [where / f"{stem}{end}" for end in films]
            animate(run, targets, wanted)
            return "\n".join(map(str, targets))
        whole = {"": partial(page, run=run, wanted=wanted)}
        for name, draw in (pictures(run, wanted) if every else whole).items():
            figure = Figure()
            draw(figure)
            target = where / (f"{stem}-{name}.png" if name else f"{stem}.png")
            written.append(str(style.save(figure, where if is_file else target)))
    return "\n".join(written)


def pictures(run: Run, wanted: Wanted = USUAL) -> dict[str, Callable[[Figure], None]]:
    """Name -> drawing function of each picture that this run has the data for."""
    found: dict[str, tuple[str, Drawing]] = {}
    quantities = chosen(run, wanted.fields)
    if run.nframes:
        every = quantities if wanted.fields else there(run)
        found = {q.name: (q.title, _at_times(run, q, wanted)) for q in every}
    if run.dimension == 1 and run.nframes >= LEAST_FRAMES:
        found["xt"] = "space and time", _over_time(run, quantities)
    probed = series.probed(run, quantities, wanted.probes)
    for name, panels in {**series.panels(run), "probes": probed}.items():
        if panels:
            bound = run.summary.get("bound") if name == "steps" else None
            title = f"steps, bounded by {bound} at the end" if bound else name
            found[name] = title, _curves(run, panels)
    return {
        name: partial(_draw, run=run, title=title, drawings=[drawing])
        for name, (title, drawing) in found.items()
    }


def page(figure: Figure, run: Run, wanted: Wanted = USUAL) -> None:
    """Fields over space and time, below them probes, interfaces, energy, departures and steps."""
    quantities, drawings = chosen(run, wanted.fields), []
    if run.dimension == 1 and not wanted.times and run.nframes >= LEAST_FRAMES:
        drawings.append(_over_time(run, quantities))
    elif run.nframes:
        drawings += [_at_times(run, quantity, wanted) for quantity in quantities]
    if panels := series.probed(run, quantities, wanted.probes):
        drawings.append(_curves(run, panels))
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


def _at_times(run: Run, quantity: Quantity, wanted: Wanted) -> Drawing:
    """Profiles or maps."""
    view = fields.View(run, quantity, fields.frames_of(run, quantity, wanted.times), wanted)
    return fields.sizes(view, len(view.frames))[2], partial(fields.draw, view=view)


def _over_time(run: Run, quantities: Sequence[Quantity]) -> Drawing:
    """Maps over x and t."""
    return MAPS, partial(fields.draw_over_time, run=run, quantities=quantities)


def _curves(run: Run, panels: list[series.Panel], columns: int = 3) -> Drawing:
    """Panels of curves over time."""
    draw = partial(series.draw, run=run, panels=panels, columns=columns)
    return PANELS * -(-len(panels) // columns), draw


# a film: maps, or in one dimension profiles, one frame after the other


def animate(run: Run, targets: Sequence[Path], wanted: Wanted = USUAL) -> None:
    """Draw a result as a film, into files that end with .gif or .mp4. FileError, InputError."""
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.figure import Figure

    if run.nframes < 2:
        raise InputError(f"-animate: there are {run.nframes} frames: expected two or more")
    chosen(run, wanted.fields)  # an error comes before the film
    step, figure, writers = -(-run.nframes // MOST_FRAMES), Figure(dpi=FILM_DPI), []
    with ExitStack() as films:
        for frame in drawn(figure, run, range(0, run.nframes, step), wanted):
            for target in targets if frame == 0 else ():  # the figure has its size now
                writer = PillowWriter if target.suffix == ".gif" else FFMpegWriter
                writers.append(writer(fps=max(1.0, run.nframes / step / FILM_SECONDS)))
                films.enter_context(writing(target, "the film"))
                films.enter_context(writers[-1].saving(figure, target, FILM_DPI))
            for writer in writers:
                writer.grab_frame()


def drawn(figure: Figure, run: Run, frames: Sequence[int], wanted: Wanted = USUAL) -> Iterator[int]:
    """Each frame, once it is on the figure; scales and colours are the same in all. InputError."""
    views = [fields.View(run, q, frames, wanted) for q in chosen(run, wanted.fields)]
    _, width, height = fields.sizes(views[0], 1)
    size = (10.8, 3.4) if run.dimension == 1 else (len(views) * (width + 1.2), height + 0.9)
    figure.set_size_inches(*size)
    grid = figure.subplots(1, len(views), squeeze=False)[0]
    titles = {frame: style.of_run(run, style.moment(run, frame)) for frame in frames}
    title = style.set_title(figure, max(titles.values(), key=len))  # the layout has room for each
    for frame in frames:
        for axes, view in zip(grid, views):
            for artist in [*axes.lines, *axes.collections, *axes.patches]:
                artist.remove()
            pictures = view.draw(axes, frame)
            if frame == frames[0]:
                fields.draw_bars(figure, view, pictures, axes)
        if frame == frames[0]:
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # only what is drawn moves from now on
        title.set_text(titles[frame])
        yield frame
