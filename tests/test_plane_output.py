"""Results in two dimensions: XDMF, lines of interfaces, info, xarray."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from helpers import computed, solve

import fsipetsc
from fsipetsc.output.file_layout import open_h5
from fsipetsc.output.info import info
from fsipetsc.output.reader import InterfaceLine

BLAST = "blast -fsi_h 0.125 -ts_max_time 0.3 -fsi_output_dt 0.05 -fsi_points 0.25,0.5".split()


@pytest.fixture(scope="module")
def blast(tmp_path_factory):
    """A pulse under a plate, on two ranks."""
    return computed(tmp_path_factory.mktemp("plane"), "blast.h5", *BLAST, ranks=2)


def numbers(item, folder):
    """The numbers that an item of an XDMF stands for, in the shape that it states."""
    shape = [int(n) for n in item.get("Dimensions").split()]
    if item.get("ItemType") == "Function":
        assert item.get("Function") == f"JOIN({', '.join(f'${k}' for k in range(len(item)))})"
        return np.stack([numbers(part, folder) for part in item], axis=-1).reshape(shape)
    corners, source = item
    start, stride, count = np.array(corners.text.split(), int).reshape(3, -1)
    file, name = source.text.split(":")
    with open_h5(folder / file) as opened:
        dataset = opened[name]
        assert dataset.shape == tuple(int(n) for n in source.get("Dimensions").split())
        assert dataset.dtype == "<f8" and ((start + stride * (count - 1)) < dataset.shape).all()
        slices = (slice(a, a + d * n, d) for a, d, n in zip(start, stride, count, strict=True))
        return dataset[tuple(slices)].reshape(shape)


def test_xdmf_has_the_numbers_of_all_frames(blast):
    folder = Path(blast.path).parent
    (series,) = ET.parse(folder / "blast.xdmf").getroot().iterfind("Domain/Grid")
    frames = series.findall("Grid")
    times = [float(frame.find("Time").get("Value")) for frame in frames]
    assert times == blast.time.tolist() and blast.nframes > 2
    for number, frame in enumerate(frames):
        for grid, layer in zip(frame.findall("Grid"), blast.layers, strict=True):
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
    for name in ("blast.1", "blast"):
        text = (tmp_path / f"{name}.xdmf").read_text()
        assert f">{name}.h5:/layer0" in text and text.count("h5:/") == text.count(f">{name}.h5:/")
    (tmp_path / "blast.xdmf").write_text("mine")
    done = solve(*words, 4, cwd=tmp_path)
    assert done.returncode == 4 and "blast.xdmf: is no XDMF of a result" in done.stderr
    assert (tmp_path / "blast.xdmf").read_text() == "mine"
    for name, steps in (("blast.1", 2), ("blast.2", 3), ("blast", 4)):
        assert fsipetsc.open_run(tmp_path / f"{name}.h5").summary["steps"] == steps


def test_lines_of_interfaces_and_info(blast):
    line, plate = blast.interface(0), blast.layers[1]
    assert line.name == blast.interfaces[0] == blast.interface(line.name).name and line.solid == 1
    assert np.array_equal(line.v, plate["v"][:, 0]) and np.ptp(line.displacement) > 1e-5
    with pytest.raises(IndexError):
        blast.interface(1)
    with pytest.raises(KeyError, match=r"gas \| plate"):
        blast.interface("nowhere")
    said = [" ".join(line.split()) for line in info(blast.path).splitlines()]
    assert {"dimension 2", "interfaces gas | plate", "-ts_max_steps no limit"} <= set(said)
    assert any(line.startswith("plate solid, 9 by 8 points, X = 0 … 1, Y = 1") for line in said)


def test_xarray(blast):
    """Dimensions with names, coordinates and units on everything."""
    pytest.importorskip("xarray")
    data, (_, plate) = blast.to_xarray(), blast.layers
    for name, variable in data.variables.items():
        assert variable.attrs.get("units") or variable.dtype.kind == "U", name
    assert data["plate.T"].dims == ("time", "Y_plate", "X_plate")
    assert np.array_equal(data["plate.y"], plate.y) and "plate.y" in data.coords
    points = [f"gas | plate at {X:g}, 1" for X in (0.25, 0.5)]
    assert blast.faces[-1] == "through no face"
    for name, along, names in (
        ("mass", "gas", ["gas"]),
        ("least_J", "layer", ["gas", "plate"]),
        ("energy_face", "face", [*blast.faces]),
        ("t_y_point", "point", points),
    ):
        found = data[f"series.{name}"]
        assert found.dims == ("step", along) and list(data[along].values) == names
        assert np.array_equal(found, blast.series[name])


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [0, 1])
def test_displacement_of_all_faces_of_a_curved_block(axis, side):
    """Along the normal of the reference map, of which the test has the derivatives."""
    xi, eta = np.linspace(0, 1, 21), np.linspace(0, 1, 17)[:, None]
    X, Y = xi + 0.2 * eta * (1 + xi), 1.5 * eta + 0.1 * np.sin(2 * xi)
    x, y = X + 0.1 * Y**2, Y + 0.05 * X * Y
    block = type("Block", (dict,), {"places": np.stack([X, Y], axis=-1)})
    fields = {"x": x, "y": y, "u": 0 * x, "v": 0 * x, "T": x + y}
    block = block({name: values[None] for name, values in fields.items()})
    line = InterfaceLine("gas | body", 1, block, axis, side)
    X, Y, x, y = (v[-side, :] if axis == 1 else v[:, -side] for v in (X, Y, x, y))
    assert np.array_equal(line.x[0], x)
    if axis == 0:
        tangent = 0.2 * (1 + side), 1.5
    else:
        tangent = 1 + 0.2 * side, 0.2 * np.cos(2 * xi)
    into = (1.0 if (axis == 0) == (side == 0) else -1.0) / np.hypot(*tangent)
    expected = into * ((x - X) * tangent[1] - (y - Y) * tangent[0])
    assert np.abs(line.displacement - expected).max() < 5e-3 * np.abs(expected).max()
