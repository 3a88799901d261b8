"""The cases in two dimensions, as a user meets them: against results of the program before blocks
(tests/frozen), on several ranks, with points that are recorded at each step.
"""

from __future__ import annotations

import numpy as np
import pytest
from frozen_references import frozen, scheme_error
from helpers import computed, message, solve

pytest.importorskip("petsc4py")

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
WIDTH = 1.0


def bump(X, Y):
    return 1 + 0.3 * np.exp(-40 * ((X - 0.4) ** 2 + (Y - 0.6) ** 2)), 0.0, 0.0, 1.0


def rest(X, Y):
    return 0.0, 0.0, 1.0, X, Y


def build(opt):
    return layers(
        Layer("below", gas, (0, 1), bump, sides={(0, 0): Slip(), (0, 1): NoSlip()}),
        Layer("plate", plate, (1, 1.5), rest, sides=Clamped()),
        Layer("above", gas, (1.5, 2.5), lambda X, Y: (1.0, 0.0, 0.0, 1.0), sides=Slip()),
        along=((0, WIDTH),),
        lower=NoSlip(),
        upper=Slip(),
        h=opt["fsi_h"],
        order=opt["fsi_order"],
        units="none",
    )
"""


def of_command(name, folder):
    """The result of the command that made a reference, run by this program."""
    words = frozen(name).command.split()[3:]
    return computed(folder, f"{name}.h5", *words)


def departures(name, result, without=None):
    """{layer: {field: largest difference}} from a reference, at the nodes that both have; without: of a row, its Y."""
    found = {}
    for layer, fields in frozen(name).fields.items():
        most = found[layer] = dict.fromkeys(fields.keys() - {"X", "Y"}, 0.0)
        seen = 0
        pieces = [block for block in result.layers if block.name.rstrip(" 123") == layer]
        for block in pieces:
            X, Y = (fields[axis] for axis in ("X", "Y"))
            columns, rows = (_among(old, new) for old, new in ((X, block.X), (Y, block.Y)))
            now, seen = block.frame(-1), seen + len(columns[0]) * len(rows[0])
            for field in most:
                gap = fields[field][np.ix_(rows[0], columns[0])]
                gap = gap - now[field][np.ix_(rows[1], columns[1])]
                gap[Y[rows[0]] == without] = 0.0
                most[field] = max(most[field], float(np.abs(gap).max()))
        assert seen >= X.size * Y.size, "all nodes of the reference have been held against some"
    return found


def _among(old, new):
    """(numbers of those of old that new has, their numbers in new)."""
    near = np.abs(old[:, None] - new) < 1e-9
    return np.flatnonzero(near.any(axis=1)), near[near.any(axis=1)].argmax(axis=1)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_manufactured_solution_has_the_errors_that_it_had(order, tmp_path):
    name = f"plane_mms-{order}-16"
    errors = frozen(name).facts["errors"]
    with of_command(name, tmp_path) as result:
        for kind in ("fluid", "solid"):
            ratio = result.errors[kind]["combined"] / errors[kind]["combined"]
            assert abs(ratio - 1.0) < 0.02, (kind, ratio)  # measured 7e-4, 3e-3, 1.6e-3


def test_a_wave_in_a_viscous_gas_is_the_same(tmp_path):
    """No slip walls, no motion of the grid that counts: to round-off after 200 steps."""
    with of_command("wave-viscous-16", tmp_path) as result:
        for layer, fields in departures("wave-viscous-16", result).items():
            assert max(fields.values()) < 1e-11, (layer, fields)


def test_a_blast_differs_by_no_more_than_the_errors_of_the_scheme(tmp_path):
    """Slip walls at the sides are constraints now, and were weak conditions."""
    bounds = scheme_error("blast-4-16", "blast-4-32")
    with of_command("blast-4-16", tmp_path) as result:
        for layer, fields in departures("blast-4-16", result).items():
            for field in fields.keys() - {"J"}:
                assert fields[field] < 1.5 * bounds[layer][field], (layer, field)
        assert np.abs(result.layers[0]["J"][-1] - 1.0).max() > 1e-4  # or the plate has not moved


@pytest.mark.long
@pytest.mark.parametrize("name", ["tube-x-40", "tube-elastic-40"])
def test_shocks_have_no_larger_errors(name, tmp_path):
    errors = frozen(name).facts["errors"]
    with of_command(name, tmp_path) as result:
        for kind, found in result.errors.items():
            assert found["combined"] < 1.1 * errors[kind]["combined"], kind


@pytest.mark.long
@pytest.mark.parametrize("name", ["oblique", "panel"])
def test_flows_over_solids_differ_by_no_more_than_twice_the_errors(name, tmp_path):
    """Slip walls, dissipation; the panel's ends in joined blocks, where it is that in all but its motion along itself, 3.

    But for the open face above the panel: waves pass it by characteristics now, and by the flux of Lax and Friedrichs then.
    """
    open_face = 0.5 if name == "panel" else None
    bounds = scheme_error(f"{name}-16", f"{name}-32")
    with of_command(f"{name}-16", tmp_path) as result:
        for layer, fields in departures(f"{name}-16", result, open_face).items():
            for field in fields.keys() - {"J"}:
                times = 3.0 if (layer, field) == ("panel", "u") else 2.0
                assert fields[field] < times * bounds[layer][field], (layer, field)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """Results of the box on 1, 2, 4 ranks, and on two that have parts of all blocks."""
    folder = tmp_path_factory.mktemp("box")
    (folder / "box2d.py").write_text(BOX)
    words = "box2d.py", "-fsi_points", "0,0.3,1", "-fsi_probes", "0.4,0.6;0.5,1.25"
    results = {n: computed(folder, f"{n}.h5", *words, ranks=n) for n in (1, 2, 4)}
    even = "-fsi_partition", "balanced"
    return {**results, "2 even": computed(folder, "even.h5", *words, *even, ranks=2)}


@pytest.mark.mpi
@pytest.mark.parametrize("n", [2, 4, "2 even"])
def test_ranks_make_no_difference(box, n):
    one, several = box[1], box[n]
    watched = [name for name in one.series if name.endswith("_point")]
    assert len(watched) == 8 == one.series["p_point"].shape[1] == len(one.points)
    for name in ("t", "least_J", *watched):
        assert np.array_equal(one.series[name], several.series[name]), name
    for a, b in zip(one.layers, several.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)


def test_recorded_nodes_are_those_of_the_frames(box):
    """Of both interfaces at three X, and two places: in the gas, in the plate."""
    result = box[1]
    below, plate, _ = result.layers
    names = ["below | plate"] * 3 + ["plate | above"] * 3
    assert [name for name, _ in result.points[:6]] == names
    assert result.points[6:] == (("below", (0.375, 0.625)), ("plate", (0.5, 1.25)))
    last = {name: values[-1] for name, values in result.series.items() if name.endswith("_point")}
    for name, series in (("x", "x_point"), ("v", "v_point"), ("T", "T_point"), ("p", "p_point")):
        assert last[series][6] == below[name][-1][10, 6], name
    frame = {name: plate[name][-1] for name in plate.fields}
    assert last["p_point"][7] == -(frame["s_xx"][4, 8] + frame["s_yy"][4, 8]) / 2
    assert last["t_x_point"][6] == last["t_y_point"][7] == 0.0
    for k, line in enumerate(result.interface(n) for n in range(2)):
        for place, column in enumerate((0, 5, 16)):
            number = 3 * k + place
            for name in ("x", "y", "u", "v", "T"):
                assert last[f"{name}_point"][number] == getattr(line, name)[-1, column], name
            for name in ("t_x", "t_y"):
                gap = last[f"{name}_point"][number] - getattr(line, name)[-1, column]
                assert abs(gap) < 1e-4, (name, number)  # normals by differences of second order there
    assert np.ptp(result.series["t_y_point"], axis=0)[1] > 1e-5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-fsi_points 3", "-fsi_points 3: there is no interface at this X"),
        ("-fsi_probes 0.5", "-fsi_probes 0.5: expected X,Y, and ; between several"),
        ("-fsi_probes 0.5,0.5;x,1", "-fsi_probes x,1: expected X,Y"),
        ("-fsi_probes 0.5,9", "-fsi_probes 0.5,9: no block is there; the nearest node is 6.5 away"),
    ],
)
def test_nodes_that_there_are_not(words, said, tmp_path):
    (tmp_path / "box2d.py").write_text(BOX)
    message(solve("box2d.py", *words.split(), cwd=tmp_path), 2, said)


def test_a_closed_box_keeps_mass_and_energy(box):
    result = box[1]
    for name in ("mass", "energy"):
        kept = result.series[name]
        assert np.abs(kept / kept[0] - 1).max() < 4e-15, name
    moved = result.layers[1]["y"][-1] - result.layers[1].Y[:, None]
    assert np.abs(moved).max() > 1e-4  # or it would be no test
