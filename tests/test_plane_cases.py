"""A closed box in two dimensions, as a user meets it: on several ranks, with recorded points."""

from functools import cache

import numpy as np
import pytest
from helpers import assert_same_fields, computed, message, solve

#: gas | plate | gas, of which every kind of face is one: closed, and at rest but for a bump
BOX = """
import numpy as np
from fsipetsc.blocks.conditions import Clamped, NoSlip, Slip
from fsipetsc.blocks.layers import Layer, layers
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.solid import ElasticSolid

OPTIONS = ()
DEFAULTS = {"fsi_h": 1 / 16, "ts_max_time": 0.2, "fsi_output_dt": 0.1}
gas = Fluid(0.002, 0.003, 1.4, 1.0)
plate = ElasticSolid(10.0, 20.0, 0.01, 5.0, 1.0, p_ref=1.0)


def bump(X, Y):
    return 1 + 0.3 * np.exp(-40 * ((X - 0.4) ** 2 + (Y - 0.6) ** 2)), 0.0, 0.0, 1.0


def rest(X, Y):
    return 0.0, 0.0, 1.0, X, Y


def build(opt):
    return layers(
        Layer("below", gas, (0, 1), bump, sides={(0, 0): Slip(), (0, 1): NoSlip()}),
        Layer("plate", plate, (1, 1.5), rest, sides=Clamped()),
        Layer("above", gas, (1.5, 2.5), lambda X, Y: (1.0, 0.0, 0.0, 1.0), sides=Slip()),
        along=((0, 1.0),),
        lower=NoSlip(),
        upper=Slip(),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        units="none",
    )
"""


POINTS = "-fsi_points", "0,0.3,1", "-fsi_probes", "0.4,0.6;0.5,1.25"


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """box(ranks, partition): a result; on two ranks "balanced" lets both have parts of all."""
    folder = tmp_path_factory.mktemp("box")
    (folder / "box2d.py").write_text(BOX)

    @cache
    def result(ranks, partition="auto"):
        words = "box2d.py", *POINTS, "-fsi_partition", partition
        return computed(folder, f"{ranks}{partition}.h5", *words, ranks=ranks)

    return result


@pytest.mark.parametrize("several", [(4,), (2, "balanced")])
def test_ranks_make_no_difference(box, several):
    one, other = box(2), box(*several)
    watched = [name for name in one.series if name.endswith("_point")]
    assert len(watched) == 8 == one.series["p_point"].shape[1] == len(one.points)
    for name in ("t", "least_J", *watched):
        assert np.array_equal(one.series[name], other.series[name]), name
    assert_same_fields(one, other)


def test_recorded_nodes_are_those_of_the_frames_and_the_box_is_closed(box):
    """Of both interfaces at three X, and two places: in the gas, in the plate."""
    result = box(2)
    below, plate, _ = result.layers
    names = ["below | plate"] * 3 + ["plate | above"] * 3
    assert [name for name, _ in result.points[:6]] == names
    assert result.points[6:] == (("below", (0.375, 0.625)), ("plate", (0.5, 1.25)))
    last = {name: values[-1] for name, values in result.series.items() if name.endswith("_point")}
    frame = {name: plate[name][-1] for name in plate.fields}
    for name in "xvTp":
        assert last[f"{name}_point"][6] == below[name][-1][10, 6], name
    assert last["p_point"][7] == -(frame["s_xx"][4, 8] + frame["s_yy"][4, 8]) / 2
    columns = [0, 5, 16]
    for k in range(2):
        line, here = result.interface(k), slice(3 * k, 3 * k + 3)
        for name in ("x", "y", "u", "v", "T"):
            expected = getattr(line, name)[-1, columns]
            assert np.array_equal(last[f"{name}_point"][here], expected), name
        dx, dy = (np.gradient(v[-1], line.X, edge_order=2) for v in (line.x, line.y))
        size = (1 - 2 * k) * np.hypot(dx, dy)  # the plate is above the first interface
        for name, row in (("t_x", ("s_xx", "s_xy")), ("t_y", ("s_xy", "s_yy"))):
            x, y = (frame[s][-k] for s in row)
            expected = (x * dy - y * dx) / size
            gap = last[f"{name}_point"][here] - expected[columns]
            assert np.abs(gap).max() < 1e-4, name  # normals by differences of second order
    for name in ("mass", "energy"):
        kept = result.series[name]
        assert np.abs(kept / kept[0] - 1).max() < 4e-15, name
    moved = plate["y"][-1] - plate.Y[:, None]
    assert np.abs(moved).max() > 1e-4  # or it would be no test


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-fsi_points 3", "-fsi_points 3: there is no interface at this X"),
        ("-fsi_probes 0.5,0.5;x,1", "bad value 'x,1' for -fsi_probes: expected numbers"),
        ("-fsi_probes 0.5,9", "no block is there; the nearest node is 6.5 away"),
        ("-fsi_probes -0.4,1.1", "no block is there; the nearest node is 0.4"),
    ],
)
def test_nodes_that_there_are_not(words, said, tmp_path):
    (tmp_path / "box2d.py").write_text(BOX)
    message(solve("box2d.py", *words.split(), cwd=tmp_path), 2, said)
