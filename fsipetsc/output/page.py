"""The commands `plot` and `report`: the pictures of a result one by one, a page that tells what
happened, a film, all pictures in HTML; and the curves over time: interfaces, balances, steps.
"""

import base64
import html
import io
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.figure import Figure

from fsipetsc.checks import Array, counted
from fsipetsc.errors import InputError
from fsipetsc.options import Option
from fsipetsc.output import drawing
from fsipetsc.output.drawing import USUAL, View, Wanted
from fsipetsc.output.file_layout import writing
from fsipetsc.output.info import info
from fsipetsc.output.quantities import chosen, labelled, there, unit_of
from fsipetsc.output.reader import Run, open_run
from fsipetsc.scheme.observables import PLACE, SERIES, drifts

WIDTH = 10.8  # inches, of a figure
PANELS, MAPS = 2.8, 4.4  # inches, heights of a row of curves, of maps over x and t
#: of a film [dots per inch], frames at most (of more, some are left out), length [s]
FILM_DPI, MOST_FRAMES, FILM_SECONDS = 100, 200, 10.0
HTML_DPI = 110  # of pictures in a page of HTML
CONTOURS = Option("contours", int, 0, "", "lines on each map", check="nonnegative")
TIMES = Option("times", "floats", (), "s", "")
PICTURES, FILMS = (".png", ".pdf", ".svg", ".jpg"), (".gif", ".mp4", ".webp")
TITLES = {"xt": "space and time", "ledgers": "balances", "steps": "time steps"}
#: panels that a page shows beside interfaces
ENERGY, DEPARTURE, STEP = "change of energy", "relative departure", "time step"
#: colours and line styles of curves in one panel, in turn
CURVES = {
    "color": [drawing.BLACK, drawing.ORANGE, drawing.BLUE, drawing.GREEN, drawing.PURPLE] * 4,
    "linestyle": ["-", "--", "-.", ":"] * 5,
}
HTML = """<!DOCTYPE html>
<meta charset="utf-8"><title>{title}</title>
<style>img {{ max-width: 100%; }} pre {{ white-space: pre-wrap; }}</style>
<h1>{title}</h1>
{pictures}
<pre>{text}</pre>
"""
#: height [inches], what is drawn on a figure of this height
Drawing = tuple[float, Callable[[Figure], None]]


def plot(path: str, given: Mapping[str, str]) -> str:
    """Do what the options ask for; return the files written, a line each. FileError, InputError."""
    wanted = Wanted(
        fields=[name.strip() for name in given["-fields"].split(",")] if "-fields" in given else (),
        times=TIMES.parse(given["-times"]) if "-times" in given else (),
        contours=CONTOURS.parse(given.get("-contours", "0")),
        streamlines="-streamlines" in given,
    )
    where, stem, done = Path(given.get("-o", os.curdir)), Path(path).stem, list[Path]()
    every, film = "-all" in given, "-animate" in given
    films = [kind for kind in FILMS if kind != ".mp4" or FFMpegWriter.isAvailable()]
    endings = () if every else films if film else PICTURES
    if where.suffix in {*PICTURES, *FILMS} - {*endings}:
        others = " (films: -animate; .mp4: with the program ffmpeg)" * (where.suffix in FILMS)
        endings = " or ".join(["a directory", *endings])
        raise InputError(f"plot: -o {where}: expected {endings}{others}")
    usual = [kind for kind in films if kind != ".webp"] if film else [".png"]
    targets = [where] if where.suffix in endings else [where / f"{stem}{kind}" for kind in usual]
    with open_run(path) as run, rc_context(drawing.STYLE), np.errstate(all="ignore"):
        for name, one in pictures(run, wanted).items() if every else ():
            labels = there(run).get(name, {"": TITLES.get(name, name)})  # of gases, of solids
            picture = drawn(run, "; ".join(dict.fromkeys(labels.values())), [one])
            done.append(drawing.save(picture, where / f"{stem}-{name}.png"))
        if film:
            done += [animate(run, target, wanted) for target in targets]
        if not done:
            done = [drawing.save(page(run, wanted), targets[0])]
    return "\n".join(map(str, done))


def report(path: str, given: Mapping[str, str]) -> Path:
    """Write NAME.html, with all pictures and what `info` prints, in the folder of -o. FileError."""
    target, shown = Path(given.get("-o", os.curdir)) / f"{Path(path).stem}.html", []
    with open_run(path) as run, rc_context(drawing.STYLE), np.errstate(all="ignore"):
        for name, one in pictures(run).items():
            drawn(run, name, [one]).savefig(kept := io.BytesIO(), dpi=HTML_DPI)
            coded = base64.b64encode(kept.getvalue()).decode()
            shown.append(f'<img alt="{name}" src="data:image/png;base64,{coded}">')
        title = html.escape(f"{run.case}: {Path(run.path).name}")
    text = HTML.format(title=title, pictures="\n".join(shown), text=html.escape(info(path)))
    with writing(target, "the report"):
        target.write_text(text, encoding="utf-8")
    return target


def page(run: Run, wanted: Wanted = USUAL) -> Figure:
    """Draw fields over space and time, and interfaces, energy, departures, steps."""
    end = drawing.moment(run, -1) if run.nframes else "no frame"
    title = f"{end}, {len(run.series.get('t', ())):,} steps"
    return drawn(run, title, [*pictures(run, wanted, every=False).values()])


def pictures(run: Run, wanted: Wanted = USUAL, every: bool = True) -> dict[str, Drawing]:
    """Return name -> drawing: of every picture that the run has the data for, or of the page's."""
    found, names = dict[str, Drawing](), chosen(run, wanted.fields)
    over_time = run.dimension == 1 and run.nframes >= 5  # of fewer, profiles say more
    if run.nframes and (every or wanted.times or not over_time):
        for name in there(run) if every and not wanted.fields else names:
            view = View(run, name, drawing.frames_of(run, name, wanted.times), wanted)
            found[name] = view.size(len(view.frames))[2], partial(drawing.draw, view=view)
    if over_time and (every or not wanted.times):
        found["xt"] = MAPS, partial(drawing.draw_over_time, run=run, names=names)
    rows, columns = all_panels(run), 3
    if not every:
        told = {panel.label: panel for panel in [*rows["ledgers"], *rows["steps"]]}
        of_page = [told[label] for label in (ENERGY, DEPARTURE, STEP) if label in told]
        rows, columns = {"told": [*rows["interfaces"][:1], *of_page]}, 4
    for name, panels in rows.items():
        if panels:
            curves = partial(_draw_curves, run=run, panels=panels, columns=columns)
            found[name] = PANELS * -(-len(panels) // columns), curves
    return found


def drawn(run: Run, title: str, drawings: Sequence[Drawing]) -> Figure:
    """Return a figure of drawings below each other, with the title."""
    heights = [height for height, _ in drawings] or [1.0]
    figure = Figure(figsize=(WIDTH, 0.5 + sum(heights)))
    parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for part, (_, draw) in zip(parts, drawings):
        draw(part)
    figure.suptitle(drawing.of_run(run, title), **drawing.TITLE)
    return figure


class Panel(NamedTuple):
    """Curves over time with one axis: names -> (nsteps,), over t; logarithmic: of their sizes."""

    label: str
    unit: str
    t: Array
    curves: dict[str, Array]
    logarithmic: bool = False


def all_panels(run: Run) -> dict[str, list[Panel]]:
    """Return the panels of interfaces, of recorded points, of balances, and of the time step.

    In two dimensions deflections come first, the largest before the others. Departures from laws
    come before totals. Of some steps each the longest is drawn: those to saved times are shorter.
    """
    found: dict[str, list[Panel]] = {"interfaces": [], "points": [], "ledgers": [], "steps": []}
    if run.dimension == 2 and run.nframes > 1:
        lines = [run.interface(k) for k in range(len(run.interfaces))]
        for line in sorted(lines, key=lambda line: -np.nanmax(np.abs(line.displacement))):
            points = [round(part * (len(line.s) - 1)) for part in (0.25, 0.5, 0.75)]
            curves = {f"s = {line.s[point]:.3g}": line.displacement[:, point] for point in points}
            found["interfaces"].append(Panel(f"deflection,\n{line.name}", "m", run.time, curves))
    t = run.series.get("t", np.empty(0))
    if len(t) < 2:
        return found
    of_start = [name for name in run.summary if name.startswith("initial_")]
    initial = {name.removeprefix("initial_"): run.summary[name] for name in of_start}
    if initial and (departed := drifts(run.header.get("laws", {}), initial, run.series)):
        found["ledgers"].append(Panel(DEPARTURE, "", t, departed, logarithmic=True))
    for name, one in SERIES.items():
        if one.label and name in run.series:
            label, start = one.label.replace("*", name.removesuffix("_point")[-1]), 0.0
            if name == "x_interface" or label.startswith("change"):
                start = initial.get(name, run.series[name][0])
            columns = (run.series[name] - start).reshape(len(t), -1).T
            curves = dict(zip(run.columns.get(one.of, [name]), columns))
            panel = Panel(label, unit_of(name, run), t, curves, name.startswith("residual"))
            found[f"{one.of}s" if one.kind == PLACE else "ledgers"].append(panel)
    at, dt = envelope(t, run.series["dt"], max(2, len(t) // 4))
    found["steps"].append(Panel(STEP, "s", at, {"dt": dt}))
    return found


def _draw_curves(figure: Figure, run: Run, panels: list[Panel], columns: int) -> None:
    times = np.concatenate([run.time, run.series.get("t", [])])
    for axes, panel in zip(drawing.panels(figure, len(panels), columns), panels):
        axes.set_prop_cycle(**CURVES)
        for name, values in panel.curves.items():
            t = panel.t
            if panel.logarithmic:
                t, values = envelope(t, np.abs(values))
                values = np.where(values > 0, values, np.nan)  # else matplotlib warns of zeros
            axes.plot(t, values, label=name)
        if panel.logarithmic:
            axes.set_yscale("log")
            axes.margins(y=0.0)  # decades, which follow, are margin enough
            low, high = np.log10(axes.get_ylim())
            axes.set_ylim(10.0 ** np.floor(max(low, high - 8.0)), 10.0 ** np.ceil(high))
            axes.yaxis.set_minor_formatter("")  # labels of less than two decades would touch
        if panel.label == STEP:
            axes.set_ylim(0.0, 1.05 * panel.curves["dt"].max())
        drawing.label_y(axes, labelled(run, panel.label, panel.unit))
        if len(panel.curves) > 1 or panel.logarithmic:
            drawing.legend_above(axes)  # else its one name says nothing
        axes.locator_params(axis="x", nbins=4)
        axes.set(xlim=(times.min(), times.max()), xlabel=labelled(run, "t", "s"))


def envelope(t: Array, values: Array, parts: int = 300) -> tuple[Array, Array]:
    """Return the largest value in each of so many equal parts of the steps, and its time."""
    pieces = np.array_split(np.arange(len(t)), max(1, min(parts, len(t))))
    at = np.array([piece[np.argmax(values[piece])] for piece in pieces])
    return t[at], values[at]


def animate(run: Run, target: Path, wanted: Wanted = USUAL) -> Path:
    """Draw a film, all frames with the same scales; return it. FileError."""
    if run.nframes < 2:
        raise InputError(f"-animate: {counted(run.nframes, 'frame')}: expected two or more")
    frames = range(0, run.nframes, -(-run.nframes // MOST_FRAMES))
    views = [View(run, name, frames, wanted) for name in chosen(run, wanted.fields)]
    _, width, height = views[0].size(1)
    plane, width = run.dimension > 1, max(width, 4.0) + 1.2  # of a bar's label, at least
    figure = Figure(figsize=(len(views) * width, height + 0.9) if plane else (WIDTH, 3.4))
    panels = [*zip(figure.subplots(1, len(views), squeeze=False)[0], views)]
    title = figure.suptitle(drawing.of_run(run, drawing.moment(run, -1)), **drawing.TITLE)
    for axes, view in panels:
        view.draw(axes, 0)
        if plane:
            drawing.draw_bars(figure, view, axes)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # only what is drawn moves from now on
    rate = max(1.0, len(frames) / FILM_SECONDS)
    film = FFMpegWriter(rate) if target.suffix == ".mp4" else PillowWriter(rate)
    with writing(target, "the film"), rc_context({"savefig.bbox": "standard"}):
        film.setup(figure, target, FILM_DPI)
        for frame in frames:
            for axes, view in panels:
                axes.clear()
                view.draw(axes, frame)
            title.set_text(drawing.of_run(run, drawing.moment(run, frame)))
            film.grab_frame()
        film.finish()  # not after an error, as film.saving does it
    return target
