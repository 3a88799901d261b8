"""Pictures: the data that are drawn, what is said about them, and that no text lies on another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from helpers import REPOSITORY, compute, run, solve

import fsipetsc
from fsipetsc.errors import FileError

pytest.importorskip("matplotlib")
pytest.importorskip("petsc4py")
import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fsipetsc.output.plots import interfaces, pictures, plot, profiles, quantities, scales, space_time, steps, style

USUAL = {"u", "T", "p", "rho", "sigma", "strain", "xt", "interfaces", "traces", "residuals", "momentum", "steps", "balance"}
DRAWN = {
    "pulse": {"p", "T", "rho", "xt", "traces", "interfaces"},
    "rod": {"u", "T", "p", "xt", "residuals", "momentum", "balance", "steps"},
    "box": {"xt", "balance"},
    "piston": {"xt", "strain"},
}
RUNS = {
    "pulse": ("pulse", "-fsi_h 0.025 -ts_max_time 0.005 -fsi_output_dt 2.5e-4 -pulse_start 0.75 -solid_density 2"),
    "rod": ("rod", "-fsi_h 0.05 -ts_max_time 0.6 -fsi_output_dt 0.05 -solid_gruneisen 0.01"),
    "box": ("box", "-fsi_h 0.05 -fsi_check 1e-3"),
    "piston": (str(REPOSITORY / "runs" / "piston.py"), ""),
}
PRESSURE = next(q for q in quantities.PROFILES if q.name == "p")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name -> opened result."""
    files = compute(1, tmp_path_factory.mktemp("drawn"), RUNS)
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.fixture(scope="module")
def figures(results):
    """(run, picture) -> the figure, laid out; every kind at least once."""
    drawn = {}
    with matplotlib.rc_context(style.STYLE):
        for name, result in results.items():
            names = dict(pictures(result))
            paper = result.options["fsi_coupling"] != "conservative"
            assert set(names) == (USUAL if paper else USUAL - {"residuals", "momentum"})
            for picture in DRAWN[name]:
                figure = drawn[name, picture] = Figure()
                FigureCanvasAgg(figure)
                names[picture](figure)
                figure.canvas.draw()
    return drawn


def lines(axes):
    return [(line.get_label(), *map(np.asarray, line.get_data())) for line in axes.lines]


def test_titles_name_the_run(figures):
    for (name, _), figure in figures.items():
        title = figure.get_suptitle() if hasattr(figure, "get_suptitle") else figure._suptitle.get_text()
        h = {"pulse": "0.025 m", "rod": "0.05 m", "box": "0.05", "piston": "0.025 m"}[name]
        assert title.startswith(f"{name}, ")
        assert f"(order 4/2, h = {h}, 1 rank)" in title.replace("\n", " ")


def boxes(figure):
    """(text, bounding box) of everything that is written in a figure."""
    renderer = figure.canvas.get_renderer()
    texts = [figure._suptitle, figure._supxlabel, figure._supylabel]
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        texts += [axes.title, axes._left_title, axes.xaxis.label, axes.yaxis.label]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            texts += [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
        legend = axes.get_legend()
        if legend is not None and legend.get_bbox_to_anchor().bounds[2:] == (0, 0):  # above its panel
            texts += legend.get_texts()
    found = [t for t in texts if t is not None and t.get_text().strip() and t.get_visible()]
    return [(t.get_text(), t.get_window_extent(renderer)) for t in found]


def assert_texts_apart(key, figure):
    """No text lies on another or is cut off."""
    written = boxes(figure)
    width, height = figure.bbox.width, figure.bbox.height
    for text, box in written:
        if box.width:
            assert -1 < box.x0 and box.x1 < width + 1 and -1 < box.y0 and box.y1 < height + 1, (key, text)
    for i, (text, box) in enumerate(written):
        for other, its in written[:i]:
            apart = box.x0 >= its.x1 - 1 or its.x0 >= box.x1 - 1 or box.y0 >= its.y1 - 1 or its.y0 >= box.y1 - 1
            assert apart, (key, text, other)


def test_no_text_lies_on_another_or_is_cut_off(figures):
    for key, figure in figures.items():
        assert_texts_apart(key, figure)


def test_drawn_pressure_is_what_gas_and_solid_have_in_common(results, figures):
    """The gas's p, and p − σ of the solid, which meet at the interfaces."""
    run, figure = results["rod"], figures["rod", "p"]
    chosen, _ = profiles.frames(run, PRESSURE)
    for axes, frame in zip(figure.axes, chosen):
        drawn = lines(axes)
        assert [kind for kind, _, _ in drawn] == ["fluid", "solid", "fluid"]
        for (_, x, y), layer in zip(drawn, run.layers):
            fields = layer.frame(frame)
            expected = fields["p"] if layer.kind == "fluid" else fields["p"] - fields["sigma"]
            assert np.array_equal(x, fields["x"], equal_nan=True)
            assert np.allclose(1e3 * y, expected, rtol=1e-12, equal_nan=True)  # kPa
        below, rod, above = (y[np.isfinite(y)] for _, _, y in drawn)
        assert below[-1] == pytest.approx(rod[0], rel=2e-3) and rod[-1] == pytest.approx(above[0], rel=2e-3)
    assert np.ptp(run.layers[1]["p"]) > 1  # Pa: the solid's own pressure counts


def test_pressure_over_space_and_time(results, figures):
    run, axes = results["rod"], figures["rod", "xt"].axes[2]
    for picture, layer in zip(axes.collections, run.layers):
        values = np.ma.filled(picture.get_array(), np.nan).reshape(-1, len(layer.X))
        load = layer["p"] if layer.kind == "fluid" else layer["p"] - layer["sigma"]
        for row, frame in zip(values[[0, -1]], load[[0, -1]]):
            known = np.isfinite(frame)
            assert np.allclose(1e3 * row[known], frame[known])  # kPa


def test_small_waves_are_drawn_as_the_difference_from_rest(results, figures):
    run = results["pulse"]
    figure = figures["pulse", "p"]
    assert "less 100000 Pa" in figure._supylabel.get_text() and figure._supylabel.get_text().endswith("[Pa]")
    frame = profiles.frames(run, PRESSURE)[0][0]
    expected = [f["p"] - 1e5 if layer.kind == "fluid" else f["p"] - f["sigma"] - 1e5
                for layer in run.layers for f in [layer.frame(frame)]]  # fmt: skip
    for (_, _, y), values in zip(lines(figure.axes[0]), expected):
        assert np.allclose(y, values, atol=1e-9, equal_nan=True)
    assert "less 300 K" in figures["pulse", "T"]._supylabel.get_text()
    assert "less 300 K" in figures["pulse", "traces"].axes[2].get_ylabel().replace("\n", " ")
    assert "less" not in figures["rod", "p"]._supylabel.get_text()


def test_profiles_show_the_extreme_and_no_flat_start(results, figures):
    for name in ("u", "T", "p"):
        quantity = next(q for q in quantities.PROFILES if q.name == name)
        run, values = results["rod"], [quantity.values(layer) for layer in results["rod"].layers]
        chosen, extreme = profiles.frames(run, quantity)
        assert len(chosen) == 4 and chosen[0] > 0 and chosen[-1] == run.nframes - 1
        rest = 1e5 if name == "p" else 300.0 if name == "T" else 0.0
        assert extreme == np.argmax(np.max([np.nanmax(np.abs(v - rest), axis=1) for v in values], axis=0))
        titles = [axes.get_title(loc="left") for axes in figures["rod", name].axes]
        assert f"t = {run.time[extreme]:.4g} s, extreme" in titles


def test_the_domain_ends_where_it_ends(figures, results):
    """The ghost points behind the walls, which come and go, are outside of what is shown."""
    for name, ends in {"rod": (0, 6), "box": (0, 3)}.items():
        shown = figures[name, "xt"].axes[0].get_xlim()
        h = results[name].options["fsi_h"]
        assert shown[0] <= ends[0] and shown[1] >= ends[1] and np.abs(np.subtract(shown, ends)).max() < 0.35 * h
    back = results["piston"].layers[1].x[:, -1]
    assert figures["piston", "xt"].axes[0].get_xlim()[1] == back.max()


def test_nothing_happens_in_light_colors(figures):
    """Two thirds of the rod's domain stay at rest: they are not to be black."""
    for axes in figures["rod", "xt"].axes[:3]:
        picture = axes.collections[-1]  # of the gas above
        colors = picture.cmap(picture.norm(picture.get_array()))[..., :3]
        assert np.median(colors @ [0.299, 0.587, 0.114]) > 0.6 or axes is figures["rod", "xt"].axes[0]


def test_frames_are_joined_smoothly():
    time = np.array([0.0, 0.9, 2.0, 3.1, 4.0, 5.0])
    rows = np.stack([np.sin(time), 2 * time, np.full(6, np.nan)], axis=1)
    rows[2:4, 2] = 7.0
    fine, t = space_time.refined(rows, time), space_time.refined(time[:, None], time)[:, 0]
    parts = (len(fine) - 1) // 5
    assert parts >= 40 and np.array_equal(fine[::parts][np.isfinite(rows)], rows[np.isfinite(rows)])
    assert np.allclose(fine[:, 1], 2 * t)
    assert np.abs(fine[:, 0] - np.sin(t)).max() < 0.5 * np.abs(np.interp(t, time, rows[:, 0]) - np.sin(t)).max()
    assert np.nanmax(np.abs(fine[:, 2] - 7.0)) < 1e-14


def test_strain(results):
    strain = next(q for q in quantities.PROFILES if q.name == "strain")
    X = np.linspace(1, 2, 11)
    assert np.allclose(strain.solid({"X": X, "x": 3 + 1.25 * X}), 0.25)
    assert np.allclose(strain.solid({"X": X, "x": X**2}), 2 * X - 1)  # to its ends
    layer = results["rod"].layers[1]
    assert np.allclose(strain.values(layer, 3), strain.values(layer)[3], rtol=0, atol=1e-15)


def test_steps_without_the_comb_before_saved_times(results, figures):
    run = results["rod"]
    dt, free = run.series["dt"], steps.unhurried(run)
    assert np.abs(np.diff(dt)).max() > 0.05 * dt.mean()  # the comb is there
    assert np.count_nonzero(~free) <= 2 * run.nframes
    ((_, _, y),) = lines(figures["rod", "steps"].axes[0])
    assert len(y) == free.sum() and np.abs(np.diff(y)).max() < 0.001 * y.mean()


def test_balances_are_those_that_hold(results, figures):
    from fsipetsc.cases import load_case
    from fsipetsc.scheme.conservation_check import drifts

    drawn = {name: [label for label, _, _ in lines(figures[name, "balance"].axes[0])] for name in ("rod", "box")}
    assert drawn["rod"] == ["mass of 'below'", "momentum"]  # the upper end is open: nothing else is kept
    assert drawn["box"][:4] == ["mass of 'left'", "mass of 'right'", "momentum along x", "energy"]
    assert drawn["box"][-1] == "-fsi_check"
    run = results["rod"]
    initial = {name.removeprefix("initial_"): v for name, v in run.summary.items() if name.startswith("initial_")}
    expected = drifts(load_case("rod").build(run.options).invariants, initial, run.series)
    for label, _, y in lines(figures["rod", "balance"].axes[0]):
        assert np.nanmax(y) == np.abs(expected[label]).max() < 1e-2


def test_residuals_and_momentum(results, figures):
    run = results["rod"]
    for axes, name in zip(figures["rod", "residuals"].axes, interfaces.RESIDUALS):
        for (_, _, y), column in zip(lines(axes), run.series[name].T):
            size = np.abs(column)
            assert not size.any() or np.nanmax(y) == size.max()
    force, momentum = figures["rod", "momentum"].axes
    for axes, name in ((force, "force"), (momentum, "momentum")):
        ((_, t, y),) = lines(axes)
        unit = 1e3 if "[kPa]" in axes.get_ylabel() else 1.0
        assert np.array_equal(t, run.series["t"]) and np.allclose(unit * y, run.series[name])


@pytest.mark.parametrize(
    ("values", "unit", "label", "drawn"),
    [
        ([0.0, 2e5], "Pa", "q  [kPa]", [0.0, 200.0]),
        ([300.0, 300.0004], "K", "q, less 300 K  [µK]", [0.0, 400.0]),
        ([1000.0, 1200.0], "K", "q  [K]", [1000.0, 1200.0]),
        ([2e-3, 4e-3], "kg/m³", "q  [10⁻³ kg/m³]", [2.0, 4.0]),
        ([-1e5, -1e5 + 3], "Pa", "q, less -100000 Pa  [Pa]", [0.0, 3.0]),
        ([5.0, 5.0], "K", "q  [K]", [5.0, 5.0]),
        ([0.0, np.nan], "K", "q  [K]", [0.0, np.nan]),
    ],
)  # fmt: skip
def test_scales(results, values, unit, label, drawn):
    values = np.array(values)
    scale = scales.scaled(results["rod"], "q", unit, values, start=values[:1])
    assert scale.label == label
    assert np.allclose(scale(values), drawn, rtol=1e-6, equal_nan=True)


def test_interfaces_that_hardly_move_are_drawn_as_displacements():
    x = np.array([[1.0, 2.0], [1.0 + 1e-5, 2.0]])
    label, drawn = interfaces.moved("where", "how far", x)
    assert label == "how far" and np.allclose(drawn, [[0, 0], [1e-5, 0]])
    assert interfaces.moved("where", "how far", x * [[1], [1.5]])[0] == "where"


def test_command_says_what_it_wrote(results, tmp_path):
    done = solve("plot", results["box"].path, "-all", "-o", tmp_path / "new" / "folder")
    assert done.returncode == 0 and done.stderr == ""
    written = done.stdout.split()
    assert sorted(written) == sorted(map(str, (tmp_path / "new" / "folder").iterdir())) and len(written) > 10
    assert all(open(name, "rb").read(4) == b"\x89PNG" for name in written)


def test_pictures_need_no_backend(results, tmp_path):
    done = run("-m", "fsipetsc", "plot", results["piston"].path, "-o", tmp_path, env={"MPLBACKEND": "nosuch"})
    assert (done.returncode, done.stderr) == (0, "")
    assert list(tmp_path.glob("*.png"))


def test_pictures_that_cannot_be_written(results):
    with pytest.raises(FileError, match="cannot write"):
        plot(results["box"].path, results["box"].path)


def test_rows_of_a_picture_ascend(figures):
    """pcolormesh needs cells that do not fold over."""
    for name in ("rod", "piston"):
        for picture in figures[name, "xt"].axes[1].collections:
            x, t = np.moveaxis(picture._coordinates, -1, 0)
            assert all((a < b).all() for a, b in pairwise(x.T)) and all((a < b).all() for a, b in pairwise(t))


# the page


@pytest.fixture(scope="module")
def pages(results, tmp_path_factory):
    """Name of a run -> its page, laid out."""
    from fsipetsc.output.plots import page

    drawn = {}
    with matplotlib.rc_context(style.STYLE):
        for name, result in results.items():
            figure, faults = Figure(), []
            FigureCanvasAgg(figure)
            page.draw(figure, result, faults=faults)
            assert faults == []
            figure.canvas.draw()
            drawn[name] = figure
    return drawn


def test_a_page_tells_the_story(results, pages):
    """Maps of three fields, interfaces, energy, departures and what bounded the steps; no text on another."""
    for name, figure in pages.items():
        labels = [axes.get_ylabel() or axes.get_xlabel() for axes in figure.axes]
        for word in ("change of energy", "time step", "interface"):
            assert any(word in label for label in labels), (name, labels)
        assert ("relative departure" in labels) == (name != "pulse" or bool(results[name].header["laws"]))
        assert_texts_apart(name, figure)
    steps_of = pages["rod"].axes[-1] if "time step" in pages["rod"].axes[-1].get_ylabel() else None
    axes = steps_of or next(axes for axes in pages["rod"].axes if "time step" in axes.get_ylabel())
    named = [text.get_text() for text in axes.get_legend().get_texts()]
    assert named == list(dict.fromkeys(what for _, what in results["rod"].summary["limits"])) and named
    begin = [patch.get_extents().x0 for patch in axes.patches]
    assert begin == sorted(begin) and len(begin) == len(results["rod"].summary["limits"])
    energy = next(axes for axes in pages["rod"].axes if "change of energy" in axes.get_ylabel())
    ((_, _, y),) = lines(energy)
    change = results["rod"].series["energy"] - results["rod"].summary["initial_energy"]
    assert np.allclose(y / np.abs(y).max(), change / np.abs(change).max())


def test_plot_in_the_format_of_the_name(results, tmp_path):
    from fsipetsc.cli import main

    for name, begins in (("a.pdf", b"%PDF"), ("a.svg", b"<?xml"), ("a.png", b"\x89PNG")):
        words = ["plot", results["box"].path, "--fields", "T,sigma", "--times", "0.1,0.5", "-o", str(tmp_path / "x" / name)]
        assert main(words) == 0
        assert (tmp_path / "x" / name).read_bytes().startswith(begins)
    text = (tmp_path / "x" / "a.svg").read_text()
    assert "temperature T" in text and "stress" in text and "velocity" not in text
    frames = {results["box"].time[results["box"].at(t)] for t in (0.1, 0.5)}
    assert all(f"t = {t:.4g}" in text for t in frames)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-fields q", "-fields q: expected some of u, T, p, rho, sigma, strain"),
        ("-times a", "-times a: expected times"),
        ("-all -animate", "-all and -animate are two things"),
        ("-o x.jpg", "-o x.jpg: expected a name that ends with .png, .pdf, .svg"),
        ("-o x.bmp", "-o x.bmp: expected a name that ends with .png, .pdf, .svg"),
        ("-animate -o x.pdf", "expected a name that ends with .gif, .mp4"),
        ("-times", "-times needs times with commas"),
    ],
)
def test_plot_says_what_it_cannot_do(results, words, said, capsys):
    from fsipetsc.cli import main

    assert main(["plot", results["box"].path, *words.split()]) == 2
    assert said in capsys.readouterr().err


def test_films_need_ffmpeg_for_mp4_alone(results, tmp_path, monkeypatch, capsys):
    from fsipetsc.cli import main
    from fsipetsc.output.plots import animation

    monkeypatch.setattr(animation.shutil, "which", lambda name: None)
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    assert main(["plot", results["pulse"].path, "-animate", "-o", str(tmp_path / "a.mp4")]) == 2
    said = capsys.readouterr().err
    assert "ffmpeg is not installed" in said and ".gif" in said and not list(tmp_path.iterdir())


def test_a_film_as_mp4(results, tmp_path):
    from fsipetsc.output.plots.animation import animate, ffmpeg

    try:
        ffmpeg()
    except fsipetsc.errors.InputError:
        pytest.skip("no ffmpeg")
    film = animate(results["pulse"].path, tmp_path / "a.mp4", ("u", "T"))
    assert film.read_bytes()[4:8] == b"ftyp" and film.stat().st_size > 5000
    (tmp_path / "taken.mp4").mkdir()
    with pytest.raises(FileError, match="ffmpeg cannot write"):
        animate(results["pulse"].path, tmp_path / "taken.mp4")
