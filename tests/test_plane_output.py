"""Results in two dimensions: XDMF, lines of interfaces, info."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from helpers import compute, solve

import fsipetsc

pytest.importorskip("petsc4py")
from test_plane_cases import BOX

from fsipetsc.output import file_layout
from fsipetsc.output.info import info
from fsipetsc.output.reader import InterfaceLine

BLAST = "-fsi_h 0.125 -ts_max_time 0.3 -fsi_output_dt 0.05 -fsi_points 0.25,0.5"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of results: a plate between two gases, cut in two, and one under a pulse."""
    there = tmp_path_factory.mktemp("plane output")
    (there / "box2d.py").write_text(BOX)
    runs = {
        "box": (str(there / "box2d.py"), "-ts_max_time 0.6 -fsi_output_dt 0.2"),
        "blast": ("blast", BLAST),
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
    times = [float(frame.find("Time").get("Value")) for frame in frames]
    assert times == result.time.tolist() and result.nframes > 2
    for number, frame in enumerate(frames):
        for grid, layer in zip(frame.findall("Grid"), result.layers, strict=True):
            fields, shape = layer.frame(number), (1, len(layer.Y), len(layer.X))
            assert grid.get("Name") == layer.name
            assert grid.find("Topology").get("Dimensions") == "{} {} {}".format(*shape)
            places = numbers(grid.find("Geometry/DataItem"), folder)[0]
            assert np.array_equal(places, np.stack([fields["x"], fields["y"]], -1))
            attributes = grid.findall("Attribute")
            given = {a.get("Name"): numbers(a.find("DataItem"), folder)[0] for a in attributes}
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


def test_interfaces_are_lines(box):
    plate = box.layers[1]
    for k, row in enumerate((0, -1)):
        line = box.interface(k)
        assert line.name == box.interfaces[k] == box.interface(line.name).name and line.solid == 1
        assert np.array_equal(line.v, plate["v"][:, row]) and np.ptp(line.displacement) > 1e-5
    with pytest.raises(IndexError):
        box.interface(2)
    with pytest.raises(KeyError, match=r"below \| plate"):
        box.interface("nowhere")


def test_info_and_repr_say_the_grid(box):
    said = info(box.path).splitlines()
    assert any(line.startswith("interfaces  below | plate, ") for line in said)
    assert any(line.split() == ["dimension", "2"] for line in said)
    assert ["-ts_max_steps", "no", "limit"] in [line.split() for line in said]
    assert any("plate" in line and "17 by 9 points" in line for line in said)
    assert "plate (17 by 9 points)" in repr(box) and "17 by 9 points" in repr(box.layers[1])


def test_xarray(blast):
    """Dimensions with names, coordinates and units on everything."""
    pytest.importorskip("xarray")
    data = blast.to_xarray()
    gas, plate = blast.layers
    names = [layer.name for layer in blast.layers]
    field = data[f"{gas.name}.p"]
    assert field.dims == ("time", f"Y_{gas.name}", f"X_{gas.name}")
    assert np.array_equal(field, gas["p"])
    assert np.array_equal(data[f"{plate.name}.y"], plate.y) and f"{plate.name}.y" in data.coords
    for name, variable in data.variables.items():
        assert variable.attrs.get("units") or variable.dtype.kind == "U", name
    assert data["series.mass"].dims == ("step", "gas") and list(data["gas"].values) == [gas.name]
    units = "kg m-1" if data["time"].attrs["units"] == "s" else "1"
    assert data["series.mass"].attrs["units"] == units
    assert data["series.least_J"].dims == ("step", "layer") and list(data["layer"].values) == names
    assert data["series.energy_face"].dims == ("step", "face")
    assert list(data["face"].values) == [*blast.faces] and blast.faces[-1] == "through no face"
    traction = data["series.t_y_point"]
    assert traction.dims == ("step", "point")
    names = [f"{gas.name} | {plate.name} at {X:g}, 1" for X in (0.25, 0.5)]
    assert list(data["point"].values) == names
    assert np.array_equal(traction, blast.series["t_y_point"])


# the line of a face of a curved block


class Block(dict):
    """A sheared block, deformed: its fields in one frame."""

    def __init__(self):
        xi, eta = np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 17))
        self.X, self.Y = xi + 0.2 * eta * (1 + xi), 1.5 * eta + 0.1 * np.sin(2 * xi)
        self.places = np.stack([self.X, self.Y], axis=-1)
        x, y = self.X + 0.1 * self.Y**2, self.Y + 0.05 * self.X * self.Y
        found = {"x": x, "y": y, "u": 0 * x, "v": 0 * x, "T": x + y}
        super().__init__({name: values[None] for name, values in found.items()})


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [0, 1])
def test_displacement_of_all_faces(axis, side):
    """Along the normal of the reference map, of which the test has the derivatives."""
    block = Block()
    line = InterfaceLine("gas | body", 1, block, axis, side)
    along = block["x"][0, -1 if side else 0] if axis == 1 else block["x"][0, :, -1 if side else 0]
    assert np.array_equal(line.x[0], along)
    xi, eta = np.linspace(0, 1, 21), np.linspace(0, 1, 17)
    if axis == 0:
        tangent = 0.2 * (1 + side) + 0.0 * eta, 1.5 + 0.0 * eta
    else:
        tangent = 1 + 0.2 * side + 0.0 * xi, 0.2 * np.cos(2 * xi)
    into = (1.0 if (axis == 0) == (side == 0) else -1.0) / np.hypot(*tangent)
    X, Y = (values[-side, :] if axis == 1 else values[:, -side] for values in (block.X, block.Y))
    expected = into * ((line.x - X) * tangent[1] - (line.y - Y) * tangent[0])
    assert np.abs(line.displacement - expected).max() < 5e-3 * np.abs(expected).max()
