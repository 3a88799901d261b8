"""Pictures, films and reports: the data that are drawn, what is said about them, their colours."""

import json
import re
from itertools import combinations, product
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from helpers import compute
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from PIL import Image

from fsipetsc.cli import main
from fsipetsc.output import quantities
from fsipetsc.output.plots import fields, page, series, style

PRESSED = "-fsi_coupling projection -solid_gruneisen 0.01"
RUNS = {
    "rod": ("rod", f"{PRESSED} -fsi_h 0.05 -ts_max_time 0.6 -fsi_output_dt 0.05"),
    "blast": ("blast", "-fsi_h 0.125 -ts_max_time 0.6 -fsi_output_dt 0.05"),
}
USUAL = {"u", "T", "p", "rho", "sigma", "strain", "xt", "interfaces", "ledgers", "steps"}
IN_PLANE = {"p", "rho", "u", "v", "T", "s_xx", "s_yy", "s_xy", "interfaces", "ledgers", "steps"}


def test_colours_are_white_at_rest_and_end_where_values_do():
    values = np.linspace(-1.0, 3.0, 101)
    scale = style.colours("fluid", values, np.zeros(3))
    assert (scale["vmin"], scale["vmax"]) == (-3.0, 3.0)
    spiked = np.append(np.tile(values, 10), 100.0)  # few points are far beyond the others
    assert style.colours("fluid", spiked, np.zeros(3))["vmax"] == pytest.approx(3.0)
    thrown = style.colours("solid", values - 1.0, np.full(3, 2.0), moving=True)
    assert (thrown["vmin"], thrown["vmax"]) == (-2.0, 2.0)  # not -2 to 6 with white at 2
    noise = 300.0 + 1e-13 * values  # what is almost constant has no stripes
    assert style.colours("solid", noise, noise)["vmax"] > 301.0


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name -> opened result."""
    return compute(1, tmp_path_factory.mktemp("drawn"), RUNS)


def figure_of(run, name):
    """A picture, laid out."""
    with matplotlib.rc_context(style.STYLE):
        figure = Figure()
        FigureCanvasAgg(figure)
        whole = {"page": lambda figure: page.page(figure, run)}
        (whole | dict(page.pictures(run)))[name](figure)
        figure.canvas.draw()
    return figure


def curves(figure, word=""):
    """(x, y) of the lines in the panel of which an axis has this label."""
    labels = {axes: f"{axes.get_ylabel()} {axes.get_xlabel()}" for axes in figure.axes}
    axes = next(axes for axes, label in labels.items() if word in label)
    return {line.get_label(): tuple(map(np.asarray, line.get_data())) for line in axes.lines}


def test_no_text_lies_on_another_or_is_cut_off(results, monkeypatch):
    """By more than a pixel. The power of ten above an axis may lie on all but the axis's label."""
    drawn, draw, powers = [], Text.draw, 0
    monkeypatch.setattr(Text, "draw", lambda text, of: drawn.append(text) or draw(text, of))
    for run, name in product(results.values(), ("page", "p", "interfaces", "ledgers", "steps")):
        drawn.clear()
        figure = figure_of(run, name)
        close = {axes.yaxis.get_offset_text() for axes in figure.axes}
        labels = {axes.yaxis.label for axes in figure.axes}
        shown = [text for text in {*drawn} if text.get_text().strip() and text.get_visible()]
        boxes = [text.get_window_extent().padded(-0.5) for text in shown]
        for (text, box), (other, its) in combinations(zip(shown, boxes), 2):
            may = {text, other} & close and not {text, other} & labels
            assert may or not box.overlaps(its), (name, text, other)
        powers += len(close.intersection(shown))
        assert np.array_equal(Bbox.union([figure.bbox, *boxes]), figure.bbox), name
    assert powers > 0


def test_a_frame_without_values_has_a_place_in_maps(results):
    run = results["rod"]
    layer = run.layers[1]
    values = layer["T"].copy()
    values[1], values[2, 3] = np.nan, np.nan
    x, found = fields.without_gaps(layer, values)
    assert np.array_equal(x[1], layer.x[1]) and np.isnan(found[1]).all()
    assert np.allclose(x[2], layer.x[2], atol=5e-4) and np.isfinite(found[2]).all()


def test_drawn_pressure_is_what_gas_and_solid_have_in_common(results):
    """The gas's p, and p − σ of the solid, which meet at the interfaces."""
    run = results["rod"]
    figure = figure_of(run, "p")
    frames = fields.frames_of(run, quantities.chosen(run, ["p"])[0])
    for axes, frame in zip(figure.axes, frames):
        assert axes.get_title(loc="left") == style.moment(run, frame)
        for line, layer in zip(axes.lines, run.layers, strict=True):
            of = layer.frame(frame)
            expected = of["p"] if layer.kind == "fluid" else of["p"] - of["sigma"]
            assert line.get_label() == layer.kind
            assert np.array_equal(line.get_data(), [of["x"], expected], equal_nan=True)
    assert np.ptp(run.layers[1]["p"]) > 1  # Pa: the solid's own pressure counts


def lifted(layer):
    """A block in three dimensions, of which the middle plane is this layer's."""

    def frame(number):
        flat = layer.frame(number)
        flat["z"] = flat["y"]
        return {name: np.stack([v - 1, v, v + 1], axis=1) for name, v in flat.items()}

    return SimpleNamespace(kind=layer.kind, X=layer.X, frame=frame)


def test_maps_are_on_the_grid_as_it_is_in_three_dimensions_in_the_middle(results):
    run = results["blast"]
    assert set(dict(page.pictures(run))) == IN_PLANE
    quantity, last = quantities.chosen(run, ["p"])[0], run.nframes - 1
    view, axes = fields.View(run, quantity, [0, last]), Figure().subplots()
    pictures = view.draw(axes, last)
    edges = [line.get_xydata() for line in axes.lines]
    boxes = SimpleNamespace(layers=[*map(lifted, run.layers)], dimension=3, header=run.header)
    view3 = fields.View(boxes, quantity, [0, last])
    pictures3 = view3.draw(Figure().subplots(), last)
    assert view.labels == ("x", "y") and view3.labels == ("x", "z")
    for layer, name in zip(run.layers, ("p", "s_xx"), strict=True):
        of = layer.frame(last)
        for drawn in (pictures[layer.kind], pictures3[layer.kind]):
            assert np.array_equal(drawn.get_coordinates(), np.stack([of["x"], of["y"]], -1))
            assert np.array_equal(drawn.get_array().reshape(layer.shape), of[name])
    for row in (0, -1):
        face = np.stack([of["x"][row], of["y"][row]], axis=-1)
        assert any(np.array_equal(edge, face) for edge in edges)
    assert axes.get_ylim()[1] > of["y"].max() and axes.get_aspect() == 1.0
    assert pictures["fluid"].get_cmap() != pictures["solid"].get_cmap()
    assert view.scales == fields.View(run, quantity, [last]).scales, "the pulse does not set them"
    assert run.layers[0].frame(0)["p"].max() > view.scales["fluid"]["vmax"]


def test_ledgers_steps_and_residuals(results):
    run = results["rod"]
    ledgers, interfaces, steps = (figure_of(run, n) for n in ("ledgers", "interfaces", "steps"))
    ((t, y),) = curves(ledgers, "change of energy\n[J\u00a0m⁻²]").values()
    change = run.series["energy"] - run.summary["initial_energy"]
    some = slice(None, None, max(1, len(change) // style.MAX_POINTS))
    assert np.array_equal(t, run.series["t"][some]) and np.allclose(y, change[some])
    kept = curves(ledgers, "relative departure")
    assert list(kept) == ["mass of 'below'"]  # the upper end is open
    largest = np.abs(series.departures(run)["mass of 'below'"]).max()
    assert np.nanmax(kept["mass of 'below'"][1]) == largest < 1e-2
    ((_, y), *_) = curves(interfaces, "|residual|, stress").values()
    assert np.nanmax(y) == np.abs(run.series["residual_stress"][:, 0]).max()
    assert np.abs(np.diff(run.series["dt"])).max() > 0.05 * run.series["dt"].mean()  # the comb
    ((_, y),) = curves(steps).values()
    assert np.abs(np.diff(y)).max() < 0.01 * y.mean()


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
    assert main(["plot", results["rod"].path, "-all", "-o", str(tmp_path / "run1.0")]) == 0
    written = capsys.readouterr().out.split()
    assert sorted(written) == sorted(map(str, (tmp_path / "run1.0").iterdir()))
    assert {f"rod-{name}.png" for name in USUAL} == {path.split("/")[-1] for path in written}


def test_plot_says_what_it_cannot_do(results, capsys, here):
    for words, said in (
        ("-fields q", "-fields q: expected some of u, T, p, rho, sigma, strain"),
        ("-animate -fields q", "-fields q: expected some of u, T, p, rho, sigma, strain"),
        ("-times a", "bad value 'a' for -times: expected numbers"),
        ("-all -animate", "-all writes several pictures"),
        ("-all -o x.png", "expected a directory"),
        ("-o x.bmp", "or a file that ends with .png"),
        ("-animate -o x.png", "or a file that ends with .gif"),
    ):
        assert main(["plot", results["rod"].path, *words.split()]) == 2
        assert said in capsys.readouterr().err and list(here.iterdir()) == []


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


def test_report(results, tmp_path):
    """The slider has a picture for each frame; everything is in the page itself."""
    run = results["rod"]
    assert main(["report", run.path, "-o", str(tmp_path)]) == 0
    text = (tmp_path / "rod.html").read_text()
    (found,) = re.findall(r"const film = (\[.*?\]), times = (\[.*?\]);", text)
    assert len(json.loads(found[0])) == run.nframes
    assert json.loads(found[1])[:2] == ["t = 0 s", "t = 50 ms"]
    assert all(f"-{name}" in text for name in run.options)
    told = [text.index(word) for word in ("<summary>summary", "time steps", "<summary>options")]
    assert told == sorted(told)
    sources = re.findall(r'src="([^"]*)"', text) + json.loads(found[0])
    assert not re.search(r"href=[\"'](?!data:)|url\(|<link [^>]*stylesheet|<script src", text)
    assert len(sources) > 10 and all(s.startswith("data:image/png;base64,") for s in sources)
