"""What is made of a result in two dimensions: pictures, XDMF, lines of interfaces."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from helpers import run

import fsipetsc
from fsipetsc.output.file_layout import open_h5


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A pulse that has reached the plate."""
    folder = tmp_path_factory.mktemp("blast")
    options = "-fsi_h", 1 / 16, "-ts_max_time", 0.6, "-fsi_output_dt", 0.1, "-fsi_quiet"
    done = run("-m", "fsipetsc", "blast", *options, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "blast.h5"


def test_pictures(result, tmp_path):
    done = run("-m", "fsipetsc", "plot", result, "-o", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    names = {path.stem for path in tmp_path.glob("*.png")}
    assert {f"blast-{name}" for name in ("p", "rho", "stress", "interfaces", "ledgers", "steps")} <= names
    assert all(path.stat().st_size > 10_000 for path in tmp_path.glob("*.png"))


def test_the_line_of_an_interface(result):
    with fsipetsc.open_run(result) as found:
        line = found.interface("gas | plate")
        plate, gas = found.layers[1], found.layers[0]
        assert np.array_equal(line.y, plate["y"][:, 0]) and line.x.shape == (7, 17)
        assert np.abs(line.displacement[-1]).max() > 1e-4
        # at first the gas's pressure, 1, is what the plate is free of strain under; later that of the gas beside it
        assert np.allclose(line.pressure[0], 1.0, atol=1e-12)
        assert np.abs(line.pressure[-1] - gas["p"][-1, -1]).max() < 0.1
        with pytest.raises(KeyError):
            found.interface("plate | gas")


def test_xdmf_names_what_is_in_the_result(result):
    """Every piece of data that it names is there, of the size that it says, and holds the positions that the reader gives."""
    root = ElementTree.parse(result.with_suffix(".xdmf")).getroot()
    frames = root.findall("./Domain/Grid/Grid")
    with fsipetsc.open_run(result) as found, open_h5(result, "r") as file:
        assert [float(frame.find("Time").get("Value")) for frame in frames] == pytest.approx(found.time)
        grids = frames[-1].findall("Grid")
        assert len(grids) == len(found.layers)
        for grid, layer in zip(grids, found.layers, strict=True):
            for item in grid.iter("DataItem"):
                if item.get("ItemType") != "HyperSlab":
                    continue
                start, stride, count = np.array(item[0].text.split(), int).reshape(3, -1)
                name = item[1].text.strip().split(":")[1]
                part = file[name][tuple(slice(a, a + s * n, s) for a, s, n in zip(start, stride, count, strict=True))]
                assert part.shape == tuple(count) and np.isfinite(part).all()
                if part.shape[1] == 2 and np.array_equal(part[:, 0], layer["x"][-1].ravel()):
                    assert np.array_equal(part[:, 1], layer["y"][-1].ravel())
                    break
            else:
                pytest.fail(f"no positions of {layer.name}")
