"""Results in two dimensions: XDMF, lines of interfaces, info, pictures and the film."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from html import unescape

import numpy as np
import pytest
from helpers import PATIENCE, compute, solve

import fsipetsc

pytest.importorskip("petsc4py")
pytest.importorskip("matplotlib")
import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from test_plane_cases import BOX
from test_plots import assert_texts_apart

from fsipetsc.cli import main
from fsipetsc.output import file_layout, xdmf
from fsipetsc.output.info import info
from fsipetsc.output.plots import pictures, plot, style
from fsipetsc.output.plots.animation import animate
from fsipetsc.output.plots.maps import film, panels
from fsipetsc.output.plots.maps.quantities import MAPS

BLAST = "-fsi_h 0.125 -ts_max_time 0.3 -fsi_output_dt 0.05 -fsi_points 0.25,0.5"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of results: a plate between two gases, cut in two, one much higher than wide, one under a pulse, one of one dimension."""
    there = tmp_path_factory.mktemp("plane output")
    (there / "box2d.py").write_text(BOX)
    (there / "tall2d.py").write_text(BOX.replace("WIDTH = 1.0", "WIDTH = 0.25"))
    runs = {
        "tall": (str(there / "tall2d.py"), "-fsi_h 0.03125 -ts_max_time 0.05 -fsi_output_dt 0.02"),
        "box": (str(there / "box2d.py"), "-ts_max_time 0.6 -fsi_output_dt 0.2"),
        "blast": ("blast", BLAST),
        "pulse": ("pulse", "-fsi_h 0.1 -ts_max_steps 5"),
    }
    compute(2, there, runs)
    return there


@pytest.fixture(scope="module")
def box(folder):
    return fsipetsc.open_run(folder / "box.h5")


@pytest.fixture(scope="module")
def blast(folder):
    return fsipetsc.open_run(folder / "blast.h5")


def numbers(item, folder):
    """The numbers that an item of an XDMF stands for, in the shape that it states."""
    shape = [int(n) for n in item.get("Dimensions").split()]
    if item.get("ItemType") == "Function":
        assert item.get("Function") == f"JOIN({', '.join(f'${k}' for k in range(len(item)))})"
        return np.stack([numbers(part, folder) for part in item], axis=-1).reshape(shape)
    corners, source = item
    start, stride, count = np.array(corners.text.split(), int).reshape(3, -1)
    file, name = source.text.split(":")
    with file_layout.open_h5(folder / file, "r") as opened:
        dataset = opened[name]
        assert dataset.shape == tuple(int(n) for n in source.get("Dimensions").split())
        assert dataset.dtype == "<f8" and ((start + stride * (count - 1)) < dataset.shape).all()
        slices = (slice(a, a + d * n, d) for a, d, n in zip(start, stride, count, strict=True))
        return dataset[tuple(slices)].reshape(shape)


@pytest.mark.parametrize("name", ["box", "blast"])
def test_xdmf_has_the_numbers_of_all_frames(folder, name):
    result = fsipetsc.open_run(folder / f"{name}.h5")
    (series,) = ET.parse(folder / f"{name}.xdmf").getroot().iterfind("Domain/Grid")
    frames = series.findall("Grid")
    assert [float(frame.find("Time").get("Value")) for frame in frames] == result.time.tolist() and result.nframes > 2
    for number, frame in enumerate(frames):
        for grid, layer in zip(frame.findall("Grid"), result.layers, strict=True):
            fields, shape = layer.frame(number), (1, len(layer.Y), len(layer.X))
            assert grid.get("Name") == layer.name and grid.find("Topology").get("Dimensions") == "{} {} {}".format(*shape)
            assert np.array_equal(numbers(grid.find("Geometry/DataItem"), folder)[0], np.stack([fields["x"], fields["y"]], -1))
            given = {a.get("Name"): numbers(a.find("DataItem"), folder)[0] for a in grid.findall("Attribute")}
            assert np.array_equal(given.pop("velocity"), np.stack([fields["u"], fields["v"]], -1))
            assert set(given) == set(layer.fields) - {"x", "y"}
            for field, values in given.items():
                assert np.array_equal(values, fields[field]), (number, layer.name, field)


def test_xdmf_goes_with_its_result(tmp_path):
    """A second run of the name keeps the result and the XDMF of the first; another file is left."""
    words = "blast", "-fsi_h", "0.125", "-fsi_quiet", "-ts_max_steps"
    for steps in (2, 3):
        assert solve(*words, steps, cwd=tmp_path).returncode == 0
    for name, steps in (("blast.1", 2), ("blast", 3)):
        text = (tmp_path / f"{name}.xdmf").read_text()
        assert f">{name}.h5:/layer0" in text and text.count("h5:/") == text.count(f">{name}.h5:/")
        assert fsipetsc.open_run(tmp_path / f"{name}.h5").summary["steps"] == steps
    (tmp_path / "blast.xdmf").write_text("mine")
    done = solve(*words, 2, cwd=tmp_path)
    assert done.returncode == 4 and "blast.xdmf: is no XDMF of a result" in done.stderr
    assert (tmp_path / "blast.xdmf").read_text() == "mine"
    for name, steps in (("blast.2", 3), ("blast", 2)):
        assert fsipetsc.open_run(tmp_path / f"{name}.h5").summary["steps"] == steps


def test_one_dimension_has_no_xdmf(folder):
    assert (folder / "pulse.h5").exists() and not xdmf.name_beside(folder / "pulse.h5").exists()


def test_interfaces_are_lines(box):
    below, plate, above = box.layers
    for k, (row, gas, edge) in enumerate(((0, below, -1), (-1, above, 0))):
        line = box.interface(k)
        assert line.name == box.interfaces[k] == box.interface(line.name).name and line.solid == 1
        for name in ("x", "y", "u", "v", "T"):
            assert np.array_equal(getattr(line, name), plate[name][:, row])
        assert np.array_equal(line.displacement, plate["y"][:, row] - plate.Y[row]) and np.ptp(line.displacement) > 1e-5
        out = 1.0 if row else -1.0
        assert np.allclose(line.n_x**2 + line.n_y**2, 1.0) and (out * line.n_y > 0.9).all()
        # at rest under the pressure 1; later the gas's, but for friction and what both sides' operators differ by
        assert np.allclose(line.t_y[0], -out, atol=1e-12) and np.allclose(line.t_x[0], 0.0, atol=1e-12)
        inner = slice(2, -2)
        assert np.abs(line.pressure[:, inner] - gas["p"][:, edge, inner]).max() < (0.05 if k == 0 else 0.01)
    assert np.abs(below["p"][-1, -1] - 1.0).max() > 0.05  # or it would be no test
    with pytest.raises(IndexError):
        box.interface(2)
    with pytest.raises(KeyError, match=r"below \| plate"):
        box.interface("nowhere")


def test_no_lines_in_one_dimension(folder):
    with fsipetsc.open_run(folder / "pulse.h5") as result, pytest.raises(IndexError):
        result.interface(0)


def test_info_and_repr_say_the_grid(box):
    said = info(box.path).splitlines()
    assert any(line.startswith("interfaces  below | plate at y = 1.00") and "on average at t = 0.6" in line for line in said)
    assert any(line.split() == ["dimension", "2"] for line in said)
    assert ["-ts_max_steps", "no", "limit"] in [line.split() for line in said]
    assert any("plate" in line and "17 by 9 points" in line for line in said)
    assert "plate (17 by 9 points)" in repr(box) and "17 by 9 points" in repr(box.layers[1])


@pytest.fixture(scope="module")
def figures(folder, box, blast):
    """(run, picture) -> the figure, laid out."""
    drawn = {}
    with matplotlib.rc_context(style.STYLE), np.errstate(all="ignore"), fsipetsc.open_run(folder / "tall.h5") as tall:
        for name, result in (("box", box), ("tall", tall), ("blast", blast)):
            for picture, draw in pictures(result):
                figure = drawn[name, picture] = Figure()
                FigureCanvasAgg(figure)
                draw(figure)
                figure.canvas.draw()
    return drawn


def test_pictures_can_be_read(figures):
    names = {"p", "rho", "v", "T", "stress", "interfaces", "ledgers", "steps"}
    assert set(figures) == {(case, name) for case in ("box", "tall", "blast") for name in names}
    for key, figure in figures.items():
        assert_texts_apart(key, figure)


def test_maps_are_on_the_grid_as_it_is_with_two_scales(blast):
    gas, plate = blast.layers
    pair, frame = MAPS[0], blast.nframes - 1
    scales = [panels.colors(blast, quantity, [frame]) for quantity in (pair.gas, pair.solid)]
    axes = Figure().subplots()
    meshes = panels.panel(axes, blast, frame, scales)
    for mesh, layer, name in zip(meshes, (gas, plate), ("p", "s_xx"), strict=True):
        corners = mesh.get_coordinates()
        assert np.array_equal(corners[..., 0], layer["x"][frame]) and np.array_equal(corners[..., 1], layer["y"][frame])
        assert np.allclose(mesh.get_array(), layer[name][frame].reshape(mesh.get_array().shape), rtol=0, atol=1e-14)
    limits = [mesh.get_clim() for mesh in meshes]
    assert limits[0][1] >= gas["p"].max() > 1.5 and limits[1][1] < 0 and meshes[0].get_cmap() != meshes[1].get_cmap()
    edges = [line.get_xydata() for line in axes.lines]
    for row in (0, -1):
        face = np.stack([plate["x"][frame, row], plate["y"][frame, row]], axis=-1)
        assert any(np.array_equal(edge, face) for edge in edges)


def test_bars_show_what_there_is(figures, blast):
    """The colors are symmetric about rest, but no pressure below 0 is offered, nor any that does not occur."""
    p, chosen = blast.layers[0]["p"], panels.chosen_frames(blast, MAPS[0].gas, MAPS[0].solid, None)
    (bar,) = (axes for axes in figures["blast", "p"].axes if axes.get_xlabel().startswith("gas"))
    assert np.allclose(bar.get_xlim(), (p[chosen].min(), p[chosen].max())) and bar.get_xlim()[0] > 0.5


def test_ledgers_begin_at_the_start(figures, blast):
    axes = {a.get_ylabel().split(",")[0].split("  [")[0]: a for a in figures["blast", "ledgers"].axes if a.lines}
    assert set(axes) == {"mass", "energy", "momentum", "entropy", "least J", "departure of J"}
    (mass,) = axes["mass"].lines
    exponent = 1e-15 if "⁻¹⁵" in axes["mass"].get_ylabel() else 1e-18
    assert np.allclose(mass.get_ydata() * exponent, blast.series["mass"][:, 0] - blast.summary["initial_mass"], atol=1e-20)
    assert len(axes["momentum"].lines) == len(axes["least J"].lines) == 2


def test_film(folder, blast, tmp_path):
    done = solve("plot", folder / "blast.h5", "-animate", "-o", tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, [str(tmp_path / "blast.gif")])
    with Image.open(tmp_path / "blast.gif") as moving:
        assert moving.n_frames == blast.nframes
        first = np.asarray(moving.convert("RGB"))
        moving.seek(moving.n_frames - 1)
        last = np.asarray(moving.convert("RGB"))
    assert first.shape == last.shape and (first != last).any(axis=-1).mean() > 0.1
    # the bars have the colors of the maps up to their end, not some that a frame happens to have
    for shade in (0.6, 0.8, 1.0):
        color = 255 * np.array(matplotlib.colormaps["RdBu_r"](shade)[:3])
        assert (np.abs(last - color).max(axis=-1) <= 4).any(), shade


def test_what_is_written_in_a_film_can_be_read(folder, monkeypatch):
    kept = []
    monkeypatch.setattr(film, "set_title", lambda figure, title: kept.append(figure))
    with matplotlib.rc_context(style.STYLE), fsipetsc.open_run(folder / "tall.h5") as tall:
        for _ in film.film(tall, [1, 2]):
            assert_texts_apart("film", kept[0])


#: put into a page: moves the slider, plays the film for a while, and tells what became of it
PROBE = """<script>
const seen = {said, frames: film.length, moved: []};
for (const k of [0, Math.floor(film.length / 2)]) {
  slider.value = k; slider.dispatchEvent(new Event("input")); seen.moved.push(frame.src === film[k]);
}
play.click();
const begin = +slider.value;
setTimeout(() => {
  play.click();
  seen.played = (+slider.value - begin + film.length) % film.length;
  seen.follows = frame.src === film[slider.value] && time.value === "t = " + times[slider.value].toPrecision(4);
  seen.loaded = [...document.images].every(image => image.complete && image.naturalWidth > 0);
  document.body.dataset.seen = JSON.stringify(seen);
}, 300);
</script>"""
LISTEN = """<script>const said = []; addEventListener("error", e => said.push(e.message));
for (const kind of ["error", "warn", "log"]) console[kind] = (...words) => said.push(words.join(" "));</script>"""


def test_the_report_in_a_browser(folder, blast, tmp_path):
    """Nothing is complained of; the slider and the button move the picture."""
    browser = shutil.which("chromium") or shutil.which("google-chrome") or pytest.skip("no browser")
    assert solve("report", folder / "blast.h5", "-o", tmp_path).returncode == 0
    page = (tmp_path / "blast.html").read_text()
    (tmp_path / "probed.html").write_text(page.replace("<head>", "<head>" + LISTEN).replace("</body>", PROBE + "</body>"))
    words = "--headless --no-sandbox --disable-gpu --virtual-time-budget=2000 --enable-logging=stderr --dump-dom".split()
    place = [f"--user-data-dir={tmp_path}/profile", f"file://{tmp_path}/probed.html"]
    done = subprocess.run([browser, *words, *place], capture_output=True, text=True, timeout=PATIENCE, check=False)
    (seen,) = re.findall(r'data-seen="(.*?)"', done.stdout)
    seen = json.loads(unescape(seen))
    assert 0 < seen.pop("played") < seen.pop("frames") == blast.nframes, done.stderr
    assert seen == {"said": [], "moved": [True, True], "follows": True, "loaded": True} and "CONSOLE" not in done.stderr


@pytest.mark.long
def test_film_and_report_of_one_dimension(folder, tmp_path):
    """The slider of the page has a picture for each frame; everything is in the page itself."""
    assert solve("plot", folder / "pulse.h5", "-animate", "-o", tmp_path).returncode == 0
    done = solve("report", folder / "pulse.h5", "-o", tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, [str(tmp_path / "pulse.html")]), done.stderr
    with fsipetsc.open_run(folder / "pulse.h5") as result, Image.open(tmp_path / "pulse.gif") as moving:
        page = (tmp_path / "pulse.html").read_text()
        (pictures,) = re.findall(r"const film = (\[.*?\]), times = (\[.*?\]);", page)
        assert len(json.loads(pictures[0])) == moving.n_frames == result.nframes
        assert json.loads(pictures[1]) == list(result.time)
        assert all(f"-{name}" in page for name in result.options)
        sources = re.findall(r'src="([^"]*)"', page) + json.loads(pictures[0])
        assert not re.search(r"href=[\"'](?!data:)|url\(|<link [^>]*stylesheet|<script src", page)
        assert len(sources) > 10 and all(source.startswith("data:image/png;base64,") for source in sources)


@pytest.mark.long
def test_one_layer_alone_and_chosen_times(folder, tmp_path):
    """No interface, no gas, and times that are asked for; beside a result with a gas."""
    case = BOX.split("def build")[0] + (
        "def build(opt):\n"
        "    layer = Layer('plate', plate, (0, 0.5), rest, sides=Clamped())\n"
        "    return layers(layer, along=((0, 1),), h=1 / 16, lower=Free(1.1), upper=Free(1.0), units='none')\n"
    )
    (tmp_path / "alone.py").write_text(case.replace("import Clamped, NoSlip, Slip", "import Clamped, Free"))
    assert solve("alone.py", "-ts_max_time", "0.1", "-fsi_quiet", cwd=tmp_path).returncode == 0
    drawn = {path.stem for path in plot(tmp_path / "alone.h5", tmp_path, times=[0.0, 0.1])}
    with fsipetsc.open_run(tmp_path / "alone.h5") as result:
        figure = Figure()
        dict(pictures(result))["p"](figure)
        assert figure._suptitle.get_text().startswith("alone, stress in solids  (")  # and no gas
    assert drawn == {f"alone-{name}" for name in ("p", "rho", "v", "T", "stress", "ledgers", "steps")}
    assert animate(tmp_path / "alone.h5", tmp_path).stat().st_size > 1000
    for names in ((folder / "blast.h5", tmp_path / "alone.h5"), (tmp_path / "alone.h5", folder / "blast.h5")):
        assert main(["plot", str(names[0]), "-compare", str(names[1]), "-o", str(tmp_path / "both.svg")]) == 0
        page = (tmp_path / "both.svg").read_text()
        assert "gas: pressure p" in page and "solid: stress" in page, names


def test_xarray(blast):
    """Dimensions with names, coordinates and units on everything."""
    pytest.importorskip("xarray")
    data = blast.to_xarray()
    gas, plate = blast.layers
    names = [layer.name for layer in blast.layers]
    field = data[f"{gas.name}.p"]
    assert field.dims == ("time", f"Y_{gas.name}", f"X_{gas.name}") and np.array_equal(field, gas["p"])
    assert np.array_equal(data[f"{plate.name}.y"], plate.y) and f"{plate.name}.y" in data.coords
    for name, variable in data.variables.items():
        assert variable.attrs.get("units") or variable.dtype.kind == "U", name
    assert data["series.mass"].dims == ("step", "gas") and list(data["gas"].values) == [gas.name]
    assert data["series.mass"].attrs["units"] == ("kg m-1" if data["time"].attrs["units"] == "s" else "1")
    assert data["series.least_J"].dims == ("step", "layer") and list(data["layer"].values) == names
    traction = data["series.t_y_point"]
    assert traction.dims == ("step", "point")
    assert list(data["point"].values) == [f"{gas.name} | {plate.name} at {X:g}, 1" for X in (0.25, 0.5)]
    assert np.array_equal(traction, blast.series["t_y_point"])
