"""Runs that begin with a frame of an earlier result (-fsi_initial): on the same grid, on others, on any number of ranks."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import REPOSITORY, compute, message, solve

import fsipetsc

pytest.importorskip("petsc4py")

from fsipetsc.cases import load_case
from fsipetsc.stepping.splines import interpolated

pytestmark = pytest.mark.mpi

WALLS = str(REPOSITORY / "tests" / "walls.py")
ROD = "-fsi_h 0.05 -ts_max_time 0.2 -fsi_output_dt 0.1"
PLANE = "-fsi_h 0.125 -fsi_order 2 -ts_max_time 0.1 -fsi_output_dt 0.05"
#: what begins with the middle frame of what: name -> source, case, options
STARTS = {
    "same": ("rod", "rod", ROD),
    "others": ("rod", "rod", "-fsi_h 0.04 -fsi_order 6 -ts_max_time 0.2"),
    "rigid": ("energy", "rod", ROD),
    "line": ("box", "box", "-fsi_h 0.05 -fsi_order 6 -ts_max_time 0.4"),
    "same_plane": ("plane", "plane_mms", PLANE),
    "finer": ("plane", "plane_mms", "-fsi_h 0.0625 -fsi_order 4 -ts_max_time 0.1"),
}
SOURCES = {
    "rod": ("rod", ROD),
    "energy": ("rod", f"{ROD} -fsi_coupling energy"),
    "box": ("box", "-fsi_h 0.1 -ts_max_time 0.4 -fsi_output_dt 0.2"),
    "plane": ("plane_mms", PLANE),
}
#: what is not possible: case, options, what is said
REFUSED = {
    "wall": ("mms", "-fsi_initial {rod}", ("the left end stands at x = 0.25", "reaches to")),
    "method": (WALLS, "-fsi_initial {rod}", ("of -fsi_coupling projection, energy or traditional, this run of conservative",)),
    "kinds": (
        *(WALLS, "-fsi_initial {rod} -fsi_coupling energy -walls_state solid"),
        ("has the layers fluid, solid, fluid; the case has solid",),
    ),
    "blocks": (WALLS, "-fsi_initial {box}", ("has the blocks",)),
    "dimension": ("blast", "-fsi_initial {rod}", ("1 dimension",)),
    "extents": ("blast", "-fsi_initial {plane}", ("block 'gas' is periodic along other axes than 'gas'",)),
    "frame": ("rod", "-fsi_initial {rod} -fsi_initial_frame 3", ("-fsi_initial_frame 3", "0 to 2")),
    "end": ("rod", "-fsi_initial {rod} -ts_max_time 0.2", ("expected more than t = 0.2",)),
    "times": (
        *("rod", "-fsi_initial {rod} -fsi_initial_frame 1 -fsi_output_times 0.05,0.15"),
        ("-fsi_output_times: 0.05 s would not be reached", "begins at t = 0.1 s"),
    ),
    "alone": ("rod", "-fsi_initial_time 1", ("-fsi_initial_time needs -fsi_initial",)),
    "both": ("rod", "-fsi_initial {rod} -fsi_initial_time 1 -fsi_initial_frame 1", ("both choose a frame",)),
    "none": ("rod", "-fsi_initial none.h5", ("FileError", "none.h5")),
    "foreign": ("rod", f"-fsi_initial {__file__}", ("FileError", "test_start.py")),
}
#: grids of exact data at t = 0, and orders of the runs that begin with them
GRIDS, ORDERS, ALONE = (0.1, 0.05), (2, 4, 6, 8), ("gas", "solid")


def runs(folder: Path) -> dict[str, tuple[str, str]]:
    found = dict(SOURCES)
    for name, (source, case, words) in STARTS.items():
        found[name] = case, f"{words} -fsi_initial {folder}/{source}.h5 -fsi_initial_frame 1"
    begun = found["rigid"][1]
    found["cut"] = "rod", f"{begun} -ts_max_steps 400 -fsi_checkpoint_steps 200"
    found["on"] = "rod", f"-fsi_restart {folder}/cut.checkpoint.previous.h5 -ts_max_steps 1000000000"
    return found


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> SimpleNamespace:
    """Folders of the runs on one rank and on three; on one those from exact data, too."""
    one, three = tmp_path_factory.mktemp("one"), tmp_path_factory.mktemp("three")
    exact = {}
    for layer, h in product(ALONE, GRIDS):
        exact[f"{layer}{h}"] = WALLS, f"-walls_state {layer} -fsi_h {h} -fsi_order 2 -ts_max_steps 1"
        for order in ORDERS:
            begun = f"-fsi_initial {one}/{layer}{h}.h5 -fsi_initial_time 0 -ts_max_steps 1"
            exact[f"{layer}{h}to{order}"] = WALLS, f"-walls_state {layer} -fsi_h 0.04 -fsi_order {order} {begun}"
    refused = {
        name: (case, words.format(**{source: one / f"{source}.h5" for source in SOURCES}))
        for name, (case, words, _) in REFUSED.items()
    }
    for ranks, folder, more in ((1, one, exact | refused), (3, three, {})):
        listed = runs(folder) | more
        done = compute(ranks, folder, listed)
        assert set(listed) - set(done) <= set(REFUSED), [file.read_text() for file in folder.glob("*.txt")]
    return SimpleNamespace(one=one, three=three)


def same(a: np.ndarray, b: np.ndarray) -> float:
    """The largest difference, over the largest number; what is not a number stands at the same places."""
    assert np.array_equal(np.isfinite(a), np.isfinite(b))
    return float(np.nanmax(np.abs(a - b)) / max(np.nanmax(np.abs(a)), 1e-300))


@pytest.mark.parametrize("name", ("same", "same_plane"))
def test_same_grid_same_fields(name, results):
    """But for what is computed from them once more, to round-off; and the time goes on."""
    source = STARTS[name][0]
    with fsipetsc.open_run(results.one / f"{source}.h5") as old, fsipetsc.open_run(results.one / f"{name}.h5") as new:
        assert new.time[0] == old.time[1] > 0 and list(new.time) == list(old.time[1:])
        assert f"begins with frame 1 of {results.one}/{source}.h5" in new.header["notes"][-1]
        for before, now in zip(old.layers, new.layers, strict=True):
            a, b = before.frame(1), now.frame(0)
            for field in now.fields:
                part = slice(None) if a[field].shape == b[field].shape else np.isfinite(a[field])
                other = slice(None) if a[field].shape == b[field].shape else np.isfinite(b[field])
                tolerance = 1e-13 if field.startswith("s_") or field == "u" else 4e-16
                if name == "same_plane":
                    # blocks keep energies, from which T and p follow; J begins anew as that of the grid, from
                    # which the integrated one differs by what Runge–Kutta loses
                    tolerance = 1e-8 if field == "J" else max(tolerance, 2e-15)
                assert same(a[field][part], b[field][other]) <= tolerance, field
        # … and so does the run: rounding alone has changed
        for before, now in zip(old.layers, new.layers, strict=True):
            a, b = before.frame(2)["T"], now.frame(1)["T"]
            assert same(a[np.isfinite(a)], b[np.isfinite(b)]) < (1e-8 if name == "same_plane" else 1e-11)


@pytest.mark.parametrize("name", (*STARTS, "cut", "on"))
def test_the_same_bits_on_three_ranks(name, results):
    with fsipetsc.open_run(results.one / f"{name}.h5") as one, fsipetsc.open_run(results.three / f"{name}.h5") as three:
        for a, b in zip(one.layers, three.layers, strict=True):
            for field in a.fields:
                assert a[field].tobytes() == b[field].tobytes(), (a.name, field)


def test_a_restart_of_what_began_so(results):
    """It goes on from the checkpoint, and needs the first result no more."""
    with fsipetsc.open_run(results.one / "rigid.h5") as whole, fsipetsc.open_run(results.one / "on.h5") as on:
        assert on.summary["steps"] == whole.summary["steps"] > 400
        for a, b in zip(whole.layers, on.layers, strict=True):
            assert all(a.frame(-1)[field].tobytes() == b.frame(-1)[field].tobytes() for field in a.fields)


def test_other_grids_go_on_where_the_first_was(results):
    """Orders, couplings and mappings change, and what is computed stays what it was, to the errors of the grids."""
    with fsipetsc.open_run(results.one / "rod.h5") as old:
        for name in ("others", "rigid"):
            with fsipetsc.open_run(results.one / f"{name}.h5") as new:
                assert new.time[0] == 0.1 and new.time[-1] == 0.2
                places = [run.series["x_interface"][-1] for run in (old, new)]
                assert np.abs(places[0] - places[1]).max() < 1e-4
    with fsipetsc.open_run(results.one / "plane.h5") as old, fsipetsc.open_run(results.one / "finer.h5") as new:
        assert new.errors["fluid"]["combined"] < old.errors["fluid"]["combined"]


@pytest.mark.parametrize("order", ORDERS)
def test_the_interpolation_has_the_order_of_the_scheme(order, results):
    """Of exact data at the points of one grid on another one; they have no interface, whose conditions would change them."""
    case, errors = load_case(WALLS), {h: 0.0 for h in GRIDS}
    for layer_alone, h in product(ALONE, GRIDS):
        with fsipetsc.open_run(results.one / f"{layer_alone}{h}to{order}.h5") as run:
            (layer,), (computed,) = case.build(run.options).layers, run.layers
            for name, exact in zip(
                ("rho", "u", "T") if layer.kind == "fluid" else ("u", "sigma", "T", "x"), layer.exact(computed.X, 0.0)
            ):
                errors[h] = max(errors[h], float(np.abs(computed.frame(0)[name] - exact).max()))
    coarse, fine = errors.values()
    assert 1e-14 < fine < coarse / 2 ** (order - 0.2), errors


@pytest.mark.parametrize("order", ORDERS)
def test_orders_of_the_splines(order):
    """Along a line and around a period; at points of both grids the numbers are what they were."""
    errors = {"line": [], "ring": []}
    places, turns = np.linspace(0, 1, 38), np.linspace(0, 1, 24, endpoint=False)
    for n in (24, 48):
        x, around = np.linspace(0, 1, n + 1), np.arange(n) / n
        line = np.stack([np.sin(9 * x), np.exp(3 * x)], axis=-1)
        found = interpolated(line, places * n, order)
        errors["line"].append(np.abs(found - np.stack([np.sin(9 * places), np.exp(3 * places)], axis=-1)).max())
        assert found[0].tobytes() == line[0].tobytes() and found[-1].tobytes() == line[-1].tobytes()
        ring, shifted = np.sin(4 * np.pi * around)[:, None], turns + 0.013
        found = interpolated(ring, shifted * n, order, True)
        errors["ring"].append(np.abs(found[:, 0] - np.sin(4 * np.pi * shifted)).max())
        some = interpolated(ring, shifted[3:5] * n, order, True)
        assert some.tobytes() == found[3:5].tobytes(), "what is asked for beside it must not matter"
        assert interpolated(ring, np.arange(n), order, True).tobytes() == ring.tobytes()
    for coarse, fine in errors.values():
        assert fine < coarse / 2 ** (order - 0.2), errors


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_fit(name, results):
    said = (results.one / f"{name}.txt").read_text()
    assert said.startswith(("InputError: ", "FileError: ")) and "\n" not in said
    for word in REFUSED[name][2]:
        assert word in said, said
    assert not (results.one / f"{name}.h5").exists(), "nothing is begun that has nothing to begin with"


def test_messages(results, tmp_path):
    """A file that is cut off, and commands that cannot begin with one, nor with a checkpoint."""
    rod, cut = results.one / "rod.h5", tmp_path / "cut.h5"
    cut.write_bytes(rod.read_bytes()[:3000])
    message(solve("rod", "-fsi_initial", cut, cwd=tmp_path), 4, "cut.h5", "damaged")
    for words in (("convergence", "mms"), ("stability", "box"), ("flutter",)):
        for name in ("-fsi_initial", "-fsi_restart"):
            done = solve(*words, name, rod, cwd=tmp_path)
            message(done, 2, f"{name}: this command begins with the data of the case")
            assert done.stdout == "", "at once"
