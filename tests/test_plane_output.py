"""Results in two dimensions: XDMF, lines of interfaces, info."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from helpers import compute, solve

import fsipetsc

pytest.importorskip("petsc4py")
from test_plane_cases import BOX

from fsipetsc.output import file_layout, xdmf
from fsipetsc.output.info import info

BLAST = "-fsi_h 0.125 -ts_max_time 0.3 -fsi_output_dt 0.05 -fsi_points 0.25,0.5"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of results: a plate between two gases, cut in two, one under a pulse, one of one dimension."""
    there = tmp_path_factory.mktemp("plane output")
    (there / "box2d.py").write_text(BOX)
    runs = {
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


def slab(item, folder):
    """The numbers that an XDMF HyperSlab stands for, in the shape that it states."""
    shape = [int(n) for n in item.get("Dimensions").split()]
    corners, source = item
    start, stride, count = np.array(corners.text.split(), int).reshape(3, 2)
    file, name = source.text.split(":")
    with file_layout.open_h5(folder / file, "r") as opened:
        dataset = opened[name]
        assert dataset.shape == tuple(int(n) for n in source.get("Dimensions").split()) and dataset.dtype == "<f8"
        assert ((start + stride * (count - 1)) < dataset.shape).all()
        rows, columns = (slice(a, a + d * n, d) for a, d, n in zip(start, stride, count, strict=True))
        return dataset[rows, columns].reshape(shape)


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
            assert np.array_equal(slab(grid.find("Geometry/DataItem"), folder)[0], np.stack([fields["x"], fields["y"]], -1))
            given = {a.get("Name"): slab(a.find("DataItem"), folder)[0] for a in grid.findall("Attribute")}
            assert np.array_equal(given.pop("velocity"), np.stack([fields["u"], fields["v"]], -1))
            assert set(given) == set(layer.fields) - {"x", "y"}
            for field, values in given.items():
                assert np.array_equal(values, fields[field]), (number, layer.name, field)


def test_xdmf_goes_with_its_result(tmp_path):
    """A second run of the same name keeps the result and the XDMF of the first; what is no XDMF is left alone."""
    words = "blast", "-fsi_h", "0.125", "-fsi_quiet", "-fsi_checkpoint_steps", "2", "-ts_max_steps"
    for steps in (2, 3):
        assert solve(*words, steps, cwd=tmp_path).returncode == 0
    for name, steps in (("blast.1", 2), ("blast", 3)):
        text = (tmp_path / f"{name}.xdmf").read_text()
        assert f">{name}.h5:/segment" in text and text.count("h5:/") == text.count(f">{name}.h5:/")
        assert fsipetsc.open_run(tmp_path / f"{name}.h5").summary["steps"] == steps
    (tmp_path / "blast.xdmf").write_text("mine")
    there = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert {"blast.checkpoint.h5", "blast.1.checkpoint.h5"} < there.keys()
    done = solve(*words, 2, cwd=tmp_path)
    assert done.returncode == 4 and "blast.xdmf" in done.stderr
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == there, "a run that is refused changes nothing"


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


def test_a_line_that_is_bent():
    """Under a hydrostatic stress the traction is the pressure along the normal, at second order; a linear temperature has
    its gradient, whatever the grid.
    """
    from fsipetsc.output.interface_line import along_edge

    def error(n, upper):
        X, h = np.linspace(0, 1, n), 0.1
        x, y = X + 0.1 * np.sin(3 * X), 0.2 * np.cos(4 * X)
        fields = {name: np.zeros((1, n)) for name in ("u", "v", "T", "s_xy")}
        fields.update(x=x[None], y=y[None], s_xx=np.full((1, n), -2.0), s_yy=np.full((1, n), -2.0))
        # rows within the solid, sheared and bent; T is linear in x and y
        Y = np.array([0.0, -h, -2 * h]) * (1 if upper else -1)
        fields = {name: np.stack([f] * 3) for name, f in fields.items()}
        fields["x"] = fields["x"] + 0.2 * Y[:, None, None] + Y[:, None, None] ** 2
        fields["y"] = fields["y"] + Y[:, None, None] * (1.5 + 0.3 * X)
        fields["T"] = 1 + 0.7 * fields["x"] - 0.4 * fields["y"]
        line = along_edge("a | b", 0, fields, X, Y, 3.0)
        assert not line.Y.any() and np.array_equal(line.x[0], x)
        assert np.allclose(line.heat, 3.0 * (0.7 * line.n_x - 0.4 * line.n_y), rtol=0, atol=1e-12)
        slope = np.array([0.8 * np.sin(4 * X), 1 + 0.3 * np.cos(3 * X)])
        exact = -2.0 * slope / np.hypot(*slope) * (1 if upper else -1)
        return np.abs(np.array([line.t_x[0], line.t_y[0]]) - exact).max()

    for upper in (True, False):
        assert error(41, upper) < 5e-3 and 3.5 < error(41, upper) / error(81, upper) < 4.5


def test_info_and_repr_say_the_grid(box):
    said = info(box.path).splitlines()
    assert any(line.startswith("interfaces  below | plate at y = 1.00") and "on average at t = 0.6" in line for line in said)
    assert any(line.split() == ["dimension", "2"] for line in said)
    assert ["-ts_max_steps", "no", "limit"] in [line.split() for line in said]
    assert any("plate" in line and "17 by 9 points" in line for line in said)
    assert "plate (17 by 9 points)" in repr(box) and "17 by 9 points" in repr(box.layers[1])


def test_xarray(folder, blast):
    """Dimensions with names, coordinates and units on everything; the file opened by its engine is the same."""
    xarray = pytest.importorskip("xarray")
    data = xarray.open_dataset(folder / "blast.h5", engine="fsipetsc")
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
    assert np.array_equal(traction, blast.series["t_y_point"]) and data.identical(blast.to_xarray())
