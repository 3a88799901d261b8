"""Results in two dimensions: XDMF, lines of interfaces, info, xarray, recorded points."""

import xml.etree.ElementTree as ET
from collections import UserDict
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import computed

from fsipetsc.output.file_layout import open_h5
from fsipetsc.output.reader import InterfaceLine

#: gas | plate | gas, of which every kind of face is one: closed, and at rest but for a bump
BOX = """
from fsipetsc.blocks.conditions import Clamped
from fsipetsc.cases.common import *
from fsipetsc.cases.shocks import *

OPTIONS = blast.OPTIONS
DEFAULTS = {"fsi_h": 1 / 16, "ts_max_time": 0.2, "fsi_output_dt": 0.1}

def bump(X, Y):
    return 1 + 0.3 * np.exp(-40 * ((X - 0.4) ** 2 + (Y - 0.6) ** 2)), 0.0, 0.0, 1.0

def build(opt):
    gas, plate = gas_of(opt), elastic_of(opt, kappa_e=0.01, heat="coupled")
    return stack(
        opt,
        Layer("below", gas, (0, 1), bump, sides={(0, 0): Slip(), (0, 1): NoSlip()}),
        Layer("plate", plate, (1, 1.5), at_rest(), sides=Clamped()),
        Layer("above", gas, (1.5, 2.5), lambda X, Y: (1.0, 0.0, 0.0, 1.0), sides=Slip()),
        along=((0, 1.0),),
        lower=NoSlip(),
        upper=Slip(),
    )
"""

POINTS = "-fsi_probes", "0,1;0.3,1;1,1;0,1.5;0.3,1.5;1,1.5;0.4,0.6;0.5,1.25"


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A result of two ranks."""
    folder = tmp_path_factory.mktemp("box")
    (folder / "box2d.py").write_text(BOX)
    return computed(folder, "box.h5", "box2d.py", *POINTS, ranks=2)


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


def test_xdmf_has_the_numbers_of_all_frames(box):
    folder = Path(box.path).parent
    (series,) = ET.parse(folder / "box.xdmf").getroot().iterfind("Domain/Grid")
    frames = series.findall("Grid")
    times = [float(frame.find("Time").get("Value")) for frame in frames]
    assert times == box.time.tolist() and box.nframes > 2
    for number, frame in enumerate(frames):
        for grid, layer in zip(frame.findall("Grid"), box.layers, strict=True):
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


def test_recorded_nodes_are_those_of_the_frames_and_the_box_is_closed(box):
    """Of both interfaces at three X, and two places: in the gas, in the plate."""
    below, plate, _ = box.layers
    assert [name for name, _ in box.points[:6]] == ["plate"] * 6
    assert box.points[6:] == (("below", (0.375, 0.625)), ("plate", (0.5, 1.25)))
    last = {name: values[-1] for name, values in box.series.items() if name.endswith("_point")}
    frame = plate.frame(-1)
    for name in "xvTp":
        assert last[f"{name}_point"][6] == below[name][-1][10, 6], name
    assert last["p_point"][7] == -(frame["s_xx"][4, 8] + frame["s_yy"][4, 8]) / 2
    columns = [0, 5, 16]
    for k in range(2):
        line, here = box.interface(k), slice(3 * k, 3 * k + 3)
        for name in ("x", "y", "u", "v", "T"):
            expected = getattr(line, name)[-1, columns]
            assert np.array_equal(last[f"{name}_point"][here], expected), name
    for name in ("mass of 'below'", "mass of 'above'", "energy"):
        assert box.summary["departures"][name] < 4e-15, name
    moved = plate["y"][-1] - plate.Y[:, None]
    assert np.abs(moved).max() > 1e-4  # or it would be no test


def test_the_deflection_of_a_flat_face_is_along_y_whatever_its_direction():
    places = np.stack(np.broadcast_arrays([1.0, 0.5, 0.0], [[0.0], [1.0]]), axis=-1)
    plate = UserDict({name: places[None, ..., 1] + 0.1 for name in "xyuvT"})
    plate.places = places
    line = InterfaceLine(SimpleNamespace(layers=[plate]), "", 0, axis=1, side=0)
    assert line.displacement == pytest.approx(0.1 + np.zeros((1, 3)))
