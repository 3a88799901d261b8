"""Pictures, films and reports: the data that are drawn, what is said about them, their colours."""

from __future__ import annotations

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import compute

import fsipetsc

matplotlib = pytest.importorskip("matplotlib")
pytest.importorskip("petsc4py")
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from fsipetsc.cli import main
from fsipetsc.output import quantities
from fsipetsc.output.plots import fields, page, series, style

RUNS = {
    "pulse": ("pulse", "-fsi_h 0.025 -ts_max_time 0.005 -fsi_output_dt 2.5e-4 -pulse_start 0.75"),
    "rod": ("rod", "-fsi_h 0.05 -ts_max_time 0.6 -fsi_output_dt 0.05 -solid_gruneisen 0.01"),
    "blast": ("blast", "-fsi_h 0.125 -ts_max_time 0.6 -fsi_output_dt 0.05"),
}
USUAL = {"u", "T", "p", "rho", "sigma", "strain", "xt", "interfaces", "ledgers", "steps"}
IN_PLANE = {"p", "rho", "u", "v", "T", "s_xx", "s_yy", "s_xy", "interfaces", "ledgers", "steps"}
#: what is drawn of each here
DRAWN = {
    "pulse": ("xt",),
    "rod": ("p", "interfaces", "ledgers", "steps"),
    "blast": ("p", "interfaces"),
}


def made_up(dimension=2, units="SI", frames=3):
    """A result of a gas under a solid; values of a frame are base + spread(frame) X, X in 0 … 1."""
    shape, up = (5, 4, 3)[-dimension:], "xyz"[dimension - 1]
    x = np.linspace(0.0, 1.0, np.prod(shape)).reshape(shape)

    def block(name, kind, names, spread, base):
        def frame(number):
            values = {field: base + spread(number) * x for field in names}
            places = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")[::-1]
            values.update(zip("xyz", [place.astype(float) for place in places]))
            values[up] = values[up] + (kind == "solid") * (shape[0] - 1)
            return values

        return SimpleNamespace(
            name=name, kind=kind, fields=names, shape=shape, X=x, rings=(), frame=frame
        )

    layers = (
        block("gas", "fluid", ("p", "T"), lambda k: 10.0 if k == 0 else 1.0, 5.0),
        block("plate", "solid", ("s_xx", "T"), lambda k: 1e-3 * k, -5.0),
    )
    time = 1e-4 * np.arange(frames)
    return SimpleNamespace(
        layers=layers, dimension=dimension, time=time, nframes=frames, header={"units": units},
        series={}, at=lambda t: int(np.argmin(np.abs(time - t))),
    )  # fmt: skip


def test_times_of_short_runs_have_prefixes():
    assert style.moment(made_up(), 2) == "t = 200 µs"
    assert style.moment(made_up(units="none"), 2) == "t = 0.0002"


def test_colours_are_white_at_rest_and_end_where_values_do():
    values = np.linspace(-1.0, 3.0, 101)
    scale = style.colours("fluid", values, np.zeros(3))
    assert (scale["vmin"], scale["vmax"]) == (-3.0, 3.0)
    spiked = np.append(np.tile(values, 10), 100.0)  # few points are far beyond the others
    assert style.colours("fluid", spiked, np.zeros(3))["vmax"] == pytest.approx(3.0)
    noise = 300.0 + 1e-13 * values  # what is almost constant has no stripes
    assert style.colours("solid", noise, noise)["vmax"] > 301.0


def test_the_first_frame_does_not_set_the_colours():
    run = made_up()
    quantity = quantities.chosen(run, ["p"])[0]
    scale = fields.View(run, quantity, [0, 1, 2]).scales["fluid"]
    assert scale["vmax"] == 10.0 + 5.0 and scale["vmin"] == 5.0  # at rest 10; then 5 … 6
    assert fields.View(run, quantity, [1, 2]).scales["solid"]["vmax"] < -4.99


def test_three_dimensions_are_drawn_in_the_middle():
    run = made_up(3)
    view = fields.View(run, quantities.chosen(run, ["p"])[0], [1, 2])
    pictures = view.draw(Figure().subplots(), 1)
    for layer, name in zip(run.layers, ("p", "s_xx")):
        values = layer.frame(1)
        assert np.allclose(pictures[layer.kind].get_array().reshape(5, 3), values[name][:, 2])
        assert np.array_equal(pictures[layer.kind].get_coordinates()[..., 1], values["z"][:, 2])
    assert view.labels == ("x  [m]", "z  [m]")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name -> opened result."""
    files = compute(1, tmp_path_factory.mktemp("drawn"), RUNS)
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.fixture(scope="module")
def figures(results):
    """(run, picture) -> the figure, laid out; "page" is one of them."""
    drawn = {}
    with matplotlib.rc_context(style.STYLE):
        for name, result in results.items():
            names = dict(page.pictures(result))
            assert set(names) == (USUAL if result.dimension == 1 else IN_PLANE)
            names["page"] = lambda figure, result=result: page.page(figure, result)
            for picture in (*DRAWN[name], "page"):
                figure = drawn[name, picture] = Figure()
                FigureCanvasAgg(figure)
                names[picture](figure)
                figure.canvas.draw()
    return drawn


def curves(axes):
    return [(line.get_label(), *map(np.asarray, line.get_data())) for line in axes.lines]


def labelled(figure, word):
    """The panel of which an axis has this label."""
    labels = {axes: f"{axes.get_ylabel()} {axes.get_xlabel()}" for axes in figure.axes}
    return next(axes for axes, label in labels.items() if word in label)


def test_no_text_lies_on_another_or_is_cut_off(figures):
    for key, figure in figures.items():
        renderer, written = figure.canvas.get_renderer(), [figure._suptitle]
        for axes in (axes for axes in figure.axes if axes.get_visible()):
            written += [axes._left_title, axes.xaxis.label, axes.yaxis.label]
            for axis in (axes.xaxis, axes.yaxis):
                low, high = sorted(axis.get_view_interval())
                inside = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
                written += [label for t in inside for label in (t.label1, t.label2)]
        boxes = [
            (text.get_text(), text.get_window_extent(renderer))
            for text in written
            if text.get_text().strip() and text.get_visible()
        ]
        for i, (text, box) in enumerate(boxes):
            assert -1 < box.x0 and box.x1 < figure.bbox.width + 1, (key, text)
            assert -1 < box.y0 and box.y1 < figure.bbox.height + 1, (key, text)
            for other, its in boxes[:i]:
                beside = box.x0 >= its.x1 - 1 or its.x0 >= box.x1 - 1
                assert beside or box.y0 >= its.y1 - 1 or its.y0 >= box.y1 - 1, (key, text, other)


def test_drawn_pressure_is_what_gas_and_solid_have_in_common(results, figures):
    """The gas's p, and p − σ of the solid, which meet at the interfaces."""
    run, figure = results["rod"], figures["rod", "p"]
    frames = fields.frames_of(run, quantities.chosen(run, ["p"])[0])
    for axes, frame in zip(figure.axes, frames):
        assert axes.get_title(loc="left") == style.moment(run, frame)
        drawn = curves(axes)
        assert [kind for kind, *_ in drawn] == ["fluid", "solid", "fluid"]
        for (_, x, y), layer in zip(drawn, run.layers):
            of = layer.frame(frame)
            expected = of["p"] if layer.kind == "fluid" else of["p"] - of["sigma"]
            assert np.array_equal(x, of["x"], equal_nan=True)
            assert np.array_equal(y, expected, equal_nan=True)
    assert np.ptp(run.layers[1]["p"]) > 1  # Pa: the solid's own pressure counts


def test_a_transmitted_wave_is_seen_over_space_and_time(figures):
    """Colours of the solid reach over what occurs there, and of the gas."""
    for picture in figures["pulse", "xt"].axes[0].collections:
        low, high = picture.get_clim()
        drawn = picture.get_array()
        assert drawn.min() >= 1.3 * low and drawn.max() <= 1.3 * high
        assert high - low < 5 * np.ptp(drawn)


def test_maps_are_on_the_grid_as_it_is(results):
    run = results["blast"]
    quantity, frame = quantities.chosen(run, ["p"])[0], run.nframes - 1
    view, axes = fields.View(run, quantity, [0, frame]), Figure().subplots()
    pictures = view.draw(axes, frame)
    edges = [line.get_xydata() for line in axes.lines]
    for layer, name in zip(run.layers, ("p", "s_xx"), strict=True):
        of, corners = layer.frame(frame), pictures[layer.kind].get_coordinates()
        assert np.array_equal(corners, np.stack([of["x"], of["y"]], -1))
        assert np.array_equal(pictures[layer.kind].get_array().reshape(layer.shape), of[name])
    for row in (0, -1):
        face = np.stack([of["x"][row], of["y"][row]], axis=-1)
        assert any(np.array_equal(edge, face) for edge in edges)
    assert axes.get_ylim()[1] > of["y"].max() and axes.get_aspect() == 1.0
    assert pictures["fluid"].get_cmap() != pictures["solid"].get_cmap()


def test_ledgers_steps_and_residuals(results, figures):
    run, ledgers = results["rod"], figures["rod", "ledgers"]
    ((_, t, y),) = curves(labelled(ledgers, "change of energy  [J m⁻²]"))
    change = run.series["energy"] - run.summary["initial_energy"]
    some = slice(None, None, max(1, len(change) // style.MAX_POINTS))
    assert np.array_equal(t, run.series["t"][some]) and np.allclose(y, change[some])
    kept = curves(labelled(ledgers, "relative departure"))
    assert [label for label, *_ in kept] == ["mass of 'below'"]  # the upper end is open
    for label, _, y in kept:
        assert np.nanmax(y) == np.abs(series.departures(run)[label]).max() < 1e-2
    ((_, _, y), *_) = curves(labelled(figures["rod", "interfaces"], "|residual|, stress"))
    assert np.nanmax(y) == np.abs(run.series["residual_stress"][:, 0]).max()
    assert np.abs(np.diff(run.series["dt"])).max() > 0.05 * run.series["dt"].mean()  # the comb
    ((_, _, y),) = curves(figures["rod", "steps"].axes[0])
    assert np.abs(np.diff(y)).max() < 0.01 * y.mean()


def test_the_interface_that_moved_most_comes_first():
    def line(k):
        return SimpleNamespace(
            name="abc"[k], X=np.arange(3.0), displacement=np.array([[0.0, (1, -3, 2)[k], np.nan]])
        )

    run = SimpleNamespace(
        dimension=2, nframes=2, time=np.zeros(2), interfaces="abc", interface=line, series={}
    )
    assert [panel.label[-1] for panel in series.interface_panels(run)] == ["b", "c", "a"]


def test_plot_in_the_format_of_the_name(results, tmp_path, capsys):
    for name, begins in (("a.pdf", b"%PDF"), ("a.svg", b"<?xml")):
        words = "--fields T,sigma --times 0.1,0.5 -o".split()
        target = tmp_path / "x" / name
        assert main(["plot", results["rod"].path, *words, str(target)]) == 0
        assert target.read_bytes().startswith(begins)
    text = (tmp_path / "x" / "a.svg").read_text()
    assert "temperature T" in text and "stress" in text and "velocity" not in text
    assert "t = 100 ms" in text and "t = 500 ms" in text
    capsys.readouterr()
    assert main(["plot", results["pulse"].path, "-all", "-o", str(tmp_path / "run1.0")]) == 0
    written = capsys.readouterr().out.split()
    assert sorted(written) == sorted(map(str, (tmp_path / "run1.0").iterdir()))
    assert {f"pulse-{name}.png" for name in USUAL} == {path.split("/")[-1] for path in written}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-fields q", "-fields q: expected some of u, T, p, rho, sigma, strain"),
        ("-times a", "bad value 'a' for -times: expected numbers"),
        ("-all -animate", "-all and -animate are two things"),
        ("-o x.jpg", "-o x.jpg: expected a directory, or a name that ends with .png, .pdf, .svg"),
        ("-all -o x.png", "-o x.png: expected a directory"),
        ("-animate -fields q", "-fields q: expected some of u, T, p, rho, sigma, strain"),
    ],
)
def test_plot_says_what_it_cannot_do(results, words, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["plot", results["rod"].path, *words.split()]) == 2
    assert said in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_film_and_a_file_where_a_directory_should_be(results, tmp_path, capsys):
    run = results["blast"]
    assert main(["plot", run.path, "-animate", "-o", str(tmp_path)]) == 0
    with Image.open(tmp_path / "blast.gif") as moving:
        assert moving.n_frames == run.nframes
        first = np.asarray(moving.convert("RGB"))
        moving.seek(moving.n_frames - 1)
        last = np.asarray(moving.convert("RGB"))
    assert first.shape == last.shape and (first != last).any(axis=-1).mean() > 0.1
    (tmp_path / "text").write_text("a text")
    assert main(["plot", run.path, "-o", str(tmp_path / "text")]) == 4
    said = capsys.readouterr().err
    assert "cannot write the " in said and said.endswith("text is not a directory\n"), said


def test_only_what_is_drawn_moves_in_a_film():
    run, places = made_up(), []
    run.case, run.options, run.summary, run.complete = "made up", {}, {}, True
    with matplotlib.rc_context(style.STYLE):
        figure = Figure()
        FigureCanvasAgg(figure)
        for frame in page.drawn(figure, run, range(run.nframes)):
            figure.canvas.draw()
            assert figure._suptitle.get_text() == f"made up, {style.moment(run, frame)}"
            boxes = [axes.get_position().bounds for axes in figure.axes]
            places.append([figure._suptitle.get_position(), *boxes])
    assert len(places[0]) > 2 and places[0] == places[1] == places[2]


def test_report(results, tmp_path):
    """The slider has a picture for each frame; everything is in the page itself."""
    run = results["pulse"]
    assert main(["report", run.path, "-o", str(tmp_path)]) == 0
    text = (tmp_path / "pulse.html").read_text()
    (found,) = re.findall(r"const film = (\[.*?\]), times = (\[.*?\]);", text)
    assert len(json.loads(found[0])) == run.nframes
    assert json.loads(found[1])[:2] == ["t = 0 s", "t = 250 µs"]
    assert all(f"-{name}" in text for name in run.options)
    told = [text.index(word) for word in ("<summary>summary", "time steps", "<summary>options")]
    assert told == sorted(told)
    sources = re.findall(r'src="([^"]*)"', text) + json.loads(found[0])
    assert not re.search(r"href=[\"'](?!data:)|url\(|<link [^>]*stylesheet|<script src", text)
    assert len(sources) > 10 and all(s.startswith("data:image/png;base64,") for s in sources)
