"""Pictures, films and reports: the data that are drawn, what is said about them, their colours."""

import os
import re
from itertools import combinations, product

import matplotlib
import numpy as np
import pytest
from helpers import compute, computed, solve, well
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from PIL import Image, ImageSequence

from fsipetsc.cli import main
from fsipetsc.output import drawing, page
from fsipetsc.output.reader import open_run

PRESSED = "-fsi_coupling projection -solid_gruneisen 0.01"
RUNS = {
    "rod": ("rod", f"{PRESSED} -fsi_h 0.05 -ts_max_time 0.4 -fsi_output_dt 0.1"),
    "blast": ("blast", "-fsi_h 0.125 -ts_max_time 0.6 -fsi_output_dt 0.2 -fsi_probes 0.5,0.5"),
}
CURVES = {"interfaces", "ledgers", "steps"}
USUAL = {"u", "T", "p", "rho", "sigma", "strain", "xt"} | CURVES
IN_PLANE = {"p", "rho", "u", "v", "T", "s_xx", "s_yy", "s_xy", "schlieren", "points"} | CURVES


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name -> opened result."""
    return compute(1, tmp_path_factory.mktemp("drawn"), RUNS)


def figure_of(run, name):
    with matplotlib.rc_context(drawing.STYLE):
        one = [] if name == "page" else [page.pictures(run)[name]]
        figure = page.drawn(run, name, one) if one else page.page(run)
        FigureCanvasAgg(figure).draw()
    return figure


def test_no_text_lies_on_another_or_is_cut_off(results, monkeypatch):
    """By more than a pixel. The power of ten above an axis may lie on all but the axis's label."""
    drawn, draw, powers = [], Text.draw, 0
    monkeypatch.setattr(Text, "draw", lambda text, of: drawn.append(text) or draw(text, of))
    for case, name in [*product(["rod"], ("page", "p", *CURVES)), ("blast", "page")]:
        drawn.clear()
        figure = figure_of(results[case], name)
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


def test_drawn_pressure_is_what_gas_and_solid_have_in_common(results):
    """The gas's p, and p − σ of the solid, which meet at the interfaces."""
    run = results["rod"]
    figure = figure_of(run, "p")
    frames = drawing.frames_of(run, "p")
    for axes, frame in zip(figure.axes, frames):
        assert axes.get_title() == drawing.moment(run, frame)
        for line, layer in zip(axes.lines, run.layers, strict=True):
            of = layer.frame(frame)
            expected = of["p"] if layer.kind == "fluid" else of["p"] - of["sigma"]
            assert line.get_label() == drawing.NAMES[layer.kind]
            assert np.array_equal(line.get_data(), [of["x"], expected], equal_nan=True)
    assert np.ptp(run.layers[1]["p"]) > 1  # Pa: the solid's own pressure counts
    nodes = f"order 4, {run.summary['points']:,} nodes, 1 rank"  # none in reserve
    assert nodes in drawing.of_run(run, "p")


def test_maps_are_on_the_grid(results):
    run = results["blast"]
    assert {*page.pictures(run)} == IN_PLANE
    last = run.nframes - 1
    view, axes = drawing.View(run, "p", [0, last]), Figure().subplots()
    view.draw(axes, last)
    edges = [line.get_xydata() for line in axes.lines if line.get_linewidth() > 0.5]
    for drawn, layer in zip(axes.collections, run.layers, strict=True):
        of = layer.frame(last)
        expected = of["p"] if layer.kind == "fluid" else 0.5 * (of["s_xx"] + of["s_yy"])
        assert np.array_equal(drawn.get_coordinates(), np.stack([of["x"], of["y"]], -1))
        assert np.array_equal(drawn.get_array().reshape(layer.shape), expected)
    for row in (0, -1):
        face = np.stack([of["x"][row], of["y"][row]], axis=-1)
        assert sum(np.array_equal(edge, face) for edge in edges) == 2, "in white and in black"
    assert axes.get_ylim()[1] > of["y"].max() and axes.get_aspect() == 1.0
    colours = {label: scale["cmap"] for label, scale in view.bars.items()}
    assert colours == {"pressure p": "viridis", "mean stress in solids, white: −1": "PuOr_r"}
    curves = {of.label: of.curves["gas at 0.5, 0.5"][-1] for of in page.all_panels(run)["points"]}
    assert curves["pressure p"] == run.layers[0]["p"][-1, 4, 4]


def test_a_ring_and_what_has_no_interface(results, tmp_path, quick_pictures):
    ring = computed(tmp_path, "ring.h5", "ring", "-ts_max_steps", 1)
    assert page.page(ring, drawing.Wanted(streamlines=True)).subfigs
    pulse = computed(tmp_path, "pulse.h5", "pulse", "-ts_max_steps", 1)
    gas, solid = drawing.View(pulse, "T", [0, 1]).bars  # whose values are not alike
    assert "gas: temperature T less 300" in gas and solid.startswith("solid: temperature T")
    one = open_run(results["rod"].path)
    assert one.series.pop("x_interface").size and figure_of(one, "xt").axes


@pytest.mark.usefixtures("quick_pictures")
def test_plot_in_the_format_of_the_name(results, tmp_path, capsys, monkeypatch):
    run = results["rod"]
    words = "--fields T,sigma --times 0.1,0.3 -o".split()
    assert main(["plot", run.path, *words, str(tmp_path / "x" / "a.svg")]) == 0
    text = (tmp_path / "x" / "a.svg").read_text()
    assert text.startswith("<?xml") and "t = 0.1 s" in text and "t = 0.3 s" in text
    assert "temperature T" in text and "stress" in text and "velocity" not in text
    words = "-fields p -times 0 -contours 3 -o".split()
    assert main(["plot", results["blast"].path, *words, str(tmp_path / "b.svg")]) == 0
    text = (tmp_path / "b.svg").read_text()
    assert re.search("ContourSet|LineCollection", text)
    capsys.readouterr()
    monkeypatch.setattr(page, "drawn", lambda *_: Figure())  # the report has them all
    words = "-all -fields T -o".split()
    assert main(["plot", run.path, *words, str(tmp_path / "run1.0")]) == 0
    written = capsys.readouterr().out.split()
    assert sorted(written) == sorted(map(str, (tmp_path / "run1.0").iterdir()))
    assert {f"rod-{name}.png" for name in {"T", "xt"} | CURVES} == {*map(os.path.basename, written)}
    assert {*page.pictures(run)} == USUAL
    assert main(["plot", run.path, "-all", "-o", str(tmp_path / "all.png")]) == 2
    assert "expected a directory" in capsys.readouterr().err


@pytest.mark.usefixtures("quick_pictures")
def test_film_and_a_file_where_a_directory_should_be(results, tmp_path, capsys):
    run = results["blast"]
    assert main(["plot", run.path, "-animate", "-o", str(tmp_path)]) == 0
    assert {*os.listdir(tmp_path)} - {"blast.mp4"} == {"blast.gif"}  # with ffmpeg both
    with Image.open(tmp_path / "blast.gif") as moving:
        assert moving.n_frames == run.nframes
        first, *_, last = (np.asarray(of.convert("RGB")) for of in ImageSequence.Iterator(moving))
    assert first.shape == last.shape and (first != last).any(axis=-1).mean() > 0.1
    (tmp_path / "text").write_text("a text")
    assert main(["plot", run.path, "-o", str(tmp_path / "text")]) == 4
    assert "text/blast.png: cannot write the picture: " in capsys.readouterr().err


def test_report(results, tmp_path, quick_pictures):
    """All pictures and what `info` says, which are in the page itself."""
    run = results["rod"]
    assert main(["report", run.path, "-o", str(tmp_path)]) == 0
    text = (tmp_path / "rod.html").read_text()
    assert all(f"-{name}" in text for name in run.options) and "time steps" in text
    assert text.count('src="data:image/png;base64,') == text.count("src=") == len(USUAL)
    assert not re.search(r"href=|url\(|<link |<script", text)


# a case before it runs: the command geometry, and -fsi_check


def test_layers_are_those_that_run(tmp_path):
    """Places of nodes, where the spacing does not divide a gas, too; the first step of the run."""
    line = "rod -fsi_h 0.0625 -rod_top 3.03 -ts_max_steps 1"
    result = computed(tmp_path, "a.h5", *line.split())
    done = well(solve(*line.split(), "-fsi_check", cwd=tmp_path))
    told = re.findall(r"(?:gas|solid), (\d+) nodes\n +axis 0 +spacing ([\d.]+) m", done.stdout)
    grids = [layer.X[np.isfinite(layer.x[0])] for layer in result.layers]
    assert told == [(str(X.size), f"{(X[-1] - X[0]) / (X.size - 1):.4g}") for X in grids]
    assert f"first step: {result.series['dt'][0]:.3g} s, by sound in " in done.stdout
    assert os.listdir(tmp_path) == ["a.h5"]


def test_the_command_draws_and_compiles_nothing(here, capsys, monkeypatch, quick_pictures):
    """In one and three dimensions; a table, and a picture that is no blank page."""
    monkeypatch.setenv("CC", "no-compiler")  # whose libraries nobody has
    for line in ("geometry rod", "geometry box_mms -box_dimension 3"):
        assert main(line.split()) == 0
    told = r"^all +[\d,]+ nodes, spacing .*\npicture in (\S+\.png)$"
    paths = re.findall(told, capsys.readouterr().out, re.M)
    assert len(paths) == 2
    for path in paths:
        picture = np.asarray(Image.open(here / path).convert("RGB")).reshape(-1, 3)
        assert len(np.unique((picture / 255.0).round(1), axis=0)) > 20
    assert sorted(os.listdir(here)) == ["box_mms-geometry.png", "rod-geometry.png"]
