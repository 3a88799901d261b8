"""The command `plot`: the pictures of a result one by one, or a page that tells what happened, or a
film; and the curves over time: interfaces, balances, the time step, probes.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.checks import Array, counted
from fsipetsc.errors import InputError
from fsipetsc.options import Option
from fsipetsc.output.file_layout import columns_of, writing
from fsipetsc.output.plots import fields, style
from fsipetsc.output.plots.style import USUAL, Figure, FigureBase, Wanted
from fsipetsc.output.quantities import Quantity, chosen, there, unit_of, written
from fsipetsc.output.reader import Run, open_run
from fsipetsc.scheme.conservation_check import Drifts
from fsipetsc.scheme.observables import SERIES

WIDTH = 10.8  # inches, of a figure
PANELS, MAPS = 2.8, 4.4  # inches, heights of a row of curves, of maps over x and t
#: of a film [dots per inch], frames at most (of more, some are left out), length [s]
FILM_DPI, MOST_FRAMES, FILM_SECONDS = 100, 200, 10.0
LEAST_FRAMES = 5  # of fewer, profiles say more than maps over x and t
CONTOURS = Option("contours", int, 0, "", "lines on each map", check="nonnegative")
TIMES, PROBE = Option("times", "floats", (), "s", ""), Option("probes", "floats", (), "m", "")
PICTURES = (".png", ".pdf", ".svg", ".jpg")
INTERFACE_POINTS = (0.25, 0.5, 0.75)  # of an interface, whose deflection is drawn as a curve
DEPARTURE = "relative departure"
SPAN = 1e8  # of a logarithmic axis at most

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
        times=TIMES.parse(given["-times"]) if "-times" in given else (),
        contours=int(CONTOURS.parse(given.get("-contours", "0"))),
        streamlines="-streamlines" in given,
        probes=[PROBE.parse(place) for place in probes.split(";") if probes],
    )
    where, every, film = Path(given.get("-o", os.curdir)), "-all" in given, "-animate" in given
    films = (".gif", ".mp4") if FFMpegWriter.isAvailable() else (".gif",)
    endings = films if film else PICTURES
    is_file = where.suffix in endings
    if every and (film or is_file):
        raise InputError("plot: -all writes several pictures: expected a directory, no -animate")
    if where.suffix and not (every or is_file or where.is_dir()):
        needs = "; .mp4 needs ffmpeg" * (film and len(films) == 1)
        ends = f"or a file that ends with {' or '.join(endings)}{needs}"
        raise InputError(f"plot: -o {where}: expected a directory that is there, {ends}")
    stem, done = Path(path).stem, []
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
            done.append(str(style.save(figure, where if is_file else target)))
    return "\n".join(done)


def pictures(run: Run, wanted: Wanted = USUAL) -> dict[str, Callable[[Figure], None]]:
    """Return name -> drawing function of each picture that this run has the data for."""
    found: dict[str, tuple[str, Drawing]] = {}
    quantities = chosen(run, wanted.fields)
    if run.nframes:
        every = quantities if wanted.fields else there(run)
        found = {q.name: (q.title, _at_times(run, q, wanted)) for q in every}
    if run.dimension == 1 and run.nframes >= LEAST_FRAMES:
        found["xt"] = "space and time", _over_time(run, quantities)
    probes = probed(run, quantities, wanted.probes)
    for name, panels in {**all_panels(run), "probes": probes}.items():
        if panels:
            bound = run.summary.get("bound") if name == "steps" else None
            title = f"steps, bounded by {bound} at the end" if bound else name
            found[name] = title, _curves(run, panels)
    return {
        name: partial(_draw, run=run, title=title, drawings=[drawing])
        for name, (title, drawing) in found.items()
    }


def page(figure: Figure, run: Run, wanted: Wanted = USUAL) -> None:
    """Draw fields over space and time, and probes, interfaces, energy, departures, steps."""
    quantities, drawings = chosen(run, wanted.fields), []
    if run.dimension == 1 and not wanted.times and run.nframes >= LEAST_FRAMES:
        drawings.append(_over_time(run, quantities))
    elif run.nframes:
        drawings += [_at_times(run, quantity, wanted) for quantity in quantities]
    if panels := probed(run, quantities, wanted.probes):
        drawings.append(_curves(run, panels))
    interfaces, ledgers, steps = all_panels(run).values()
    told = [panel for panel in ledgers if panel.label in ("change of energy", DEPARTURE)]
    if panels := [*interfaces[:1], *reversed(told), *steps]:
        drawings.append(_curves(run, panels, columns=len(panels)))
    end = style.moment(run, -1) if run.nframes else "no frame"
    _draw(figure, run, f"{end}, {len(run.series.get('t', ())):,} steps", drawings)


def _draw(figure: Figure, run: Run, title: str, drawings: Sequence[Drawing]) -> None:
    """Place drawings below each other, and the title."""
    heights = [height for height, _ in drawings] or [1.0]
    figure.set_size_inches(WIDTH, 0.5 + sum(heights))
    parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for part, (_, draw) in zip(parts, drawings):
        draw(part)
    style.set_title(figure, style.of_run(run, title))


def _at_times(run: Run, quantity: Quantity, wanted: Wanted) -> Drawing:
    view = fields.View(run, quantity, fields.frames_of(run, quantity, wanted.times), wanted)
    return fields.sizes(view, len(view.frames))[2], partial(fields.draw, view=view)


def _over_time(run: Run, quantities: Sequence[Quantity]) -> Drawing:
    return MAPS, partial(fields.draw_over_time, run=run, quantities=quantities)


# curves over time


class Panel(NamedTuple):
    """Curves over time with one axis: names -> (nsteps,), over t; logarithmic: of their sizes."""

    label: str
    unit: str
    t: Array
    curves: dict[str, Array]
    logarithmic: bool = False


def all_panels(run: Run) -> dict[str, list[Panel]]:
    """Return what there is to draw of interfaces, of ledgers, and of the steps.

    Of interfaces how they move, in two dimensions first the one that moves most, then what holds
    there. Of ledgers by how much has departed what must be kept, then the ledgers. Of steps the
    largest of some each, for those before a saved time share what is left.
    """
    found: dict[str, list[Panel]] = {"interfaces": [], "ledgers": [], "steps": []}
    if run.dimension == 2 and run.nframes > 1:
        lines = [run.interface(k) for k in range(len(run.interfaces))]
        for line in sorted(lines, key=lambda line: -np.nanmax(np.abs(line.displacement))):
            points = [round(part * (len(line.s) - 1)) for part in INTERFACE_POINTS]
            curves = {f"s = {line.s[point]:.3g}": line.displacement[:, point] for point in points}
            found["interfaces"].append(Panel(f"deflection,\n{line.name}", "m", run.time, curves))
    t = run.series.get("t", np.empty(0))
    if len(t) < 2:
        return found
    if departed := departures(run):
        found["ledgers"].append(Panel(DEPARTURE, "", t, departed, logarithmic=True))
    for name, one in SERIES.items():
        if one.label and name in run.series:
            label, values, start = one.label.replace("*", name[-1]), run.series[name], 0.0
            if name == "x_interface" or label.startswith("change"):
                start = np.asarray(run.summary.get(f"initial_{name}", values[0]))
            names = columns_of(run.header).get(one.of, [name])
            curves = dict(zip(names, (values - start).reshape(len(t), -1).T))
            unit, apart = written(unit_of(name, run)), name.startswith("residual")
            panel = Panel(label, unit, t, curves, logarithmic=apart)
            found["interfaces" if one.of == "interface" else "ledgers"].append(panel)
    at, dt = envelope(t, run.series["dt"], len(t) // 4)
    found["steps"].append(Panel("time step", "s", at, {"dt": dt}))
    return found


def probed(run: Run, quantities: Sequence[Quantity], places: Sequence[Any]) -> list[Panel]:
    """Return what the nodes nearest to places have in the saved frames. InputError."""
    if any(len(at) != run.dimension for at in places):
        raise InputError(f"-probes: expected {counted(run.dimension, 'number')} for each place")
    panels = [Panel(q.title, q.unit, run.time, {}) for q in quantities if places]
    for (panel, q), at in product(zip(panels, quantities), places):
        layers = [layer for layer in run.layers if layer.kind in q.labels]
        away = [np.linalg.norm(layer.places - at, axis=-1) for layer in layers]
        layer, near = min(zip(layers, away), key=lambda of: of[1].min())
        frames = ({"X": layer.X, **layer.frame(k)} for k in range(run.nframes))
        values = [q.values(layer.kind, of).flat[np.argmin(near)] for of in frames]
        panel.curves["at " + ", ".join(f"{x:.4g}" for x in at)] = np.array(values)
    return panels


def departures(run: Run) -> dict[str, Array]:
    """Return name of what must not change in this run -> its relative departure, (nsteps,). Of a
    result that goes on from another nothing is known.
    """
    laws, prefix, first = run.header.get("laws"), "initial_", run.series["dt"][0]
    initial = {k.removeprefix(prefix): v for k, v in run.summary.items() if k.startswith(prefix)}
    if not laws or not initial or run.series["t"][0] > 1.5 * first:
        return {}
    return Drifts(laws, initial).go_on(run.series)


def _curves(run: Run, panels: list[Panel], columns: int = 3) -> Drawing:
    """Return panels of curves over time, so many beside each other."""
    draw = partial(_draw_curves, run=run, panels=panels, columns=columns)
    return PANELS * -(-len(panels) // columns), draw


def _draw_curves(figure: FigureBase, run: Run, panels: list[Panel], columns: int) -> None:
    for axes, panel in zip(style.panels(figure, len(panels), columns).flat, panels):
        some = slice(None, None, max(1, len(panel.t) // style.MAX_POINTS))
        axes.set_prop_cycle(**style.CURVES)
        for name, values in panel.curves.items():
            t, shown = panel.t[some], values[some]
            if panel.logarithmic:
                t, shown = envelope(panel.t, np.abs(values))
                shown = np.where(shown > 0, shown, np.nan)
            axes.plot(t, shown, label=name)
        if panel.logarithmic:
            axes.set_yscale("log")
            axes.set_ylim(bottom=max(axes.get_ylim()[0], axes.get_ylim()[1] / SPAN))
        if panel.label == "time step":
            axes.set_ylim(bottom=0.0)
        style.label_y(axes, style.labelled(run, panel.label, panel.unit))
        if len(panel.curves) > 1 or panel.logarithmic:
            style.legend_above(axes)  # else its one name says nothing
        style.time_axis(axes, run)


def envelope(t: Array, values: Array, parts: int = 300) -> tuple[Array, Array]:
    """Return the largest value in each of so many equal parts of the steps, and its time."""
    pieces = np.array_split(np.arange(len(t)), max(1, min(parts, len(t))))
    at = np.array([piece[np.argmax(values[piece])] for piece in pieces])
    return t[at], values[at]


# a film: maps, or in one dimension profiles, one frame after the other


def animate(run: Run, targets: Sequence[Path], wanted: Wanted = USUAL) -> None:
    """Draw a result as a film, into files that end with .gif or .mp4. FileError, InputError."""
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.figure import Figure

    if run.nframes < 2:
        raise InputError(f"-animate: there are {run.nframes} frames: expected two or more")
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
    """Yield each frame once it is on the figure; all have the same scales. InputError."""
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
