"""Runs of blocks with a scheme that solves no equations (stub_scheme.py).

Steps, ranks, checkpoints, results, messages.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("petsc4py")

from helpers import REPOSITORY, mpirun

import fsipetsc
from fsipetsc.output.differences import compare
from fsipetsc.output.info import info

pytestmark = pytest.mark.mpi
TESTS = REPOSITORY / "tests"
DIMENSIONS = (1, 2, 3)
RANKS = (1, 2, 3, 4)


def jobs() -> dict[str, list]:
    """Name -> [ranks, options]; in this order, as some go on from others."""
    found: dict[str, list] = {}
    for d in DIMENSIONS:
        for n in RANKS if d == 2 else (1, 2, 4):
            found[f"{d}d_{n}"] = [n, {"case_dimension": d}]
    for n, partition in ((2, "balanced"), (3, "balanced"), (4, "physics")):
        found[f"2d_{partition}_{n}"] = [n, {"fsi_partition": partition}]
    rk = {"ts_type": "rk", "ts_rk_type": "4"}
    for n in (1, 3):
        found[f"rk_{n}"] = [n, rk]
        found[f"timed_{n}"] = [n, {"case_timed": True}]
    for name, options in (("fused", {}), ("3bs", {"ts_type": "rk", "ts_rk_type": "3bs"})):
        found[f"{name}_whole"] = [1, options]
        half = {**options, "ts_max_steps": 5, "fsi_checkpoint_steps": 5}
        found[f"{name}_half"] = [2, half]
        for n in (1, 3):
            checkpoint = f"{name}_half.checkpoint.h5"
            found[f"{name}_rest_{n}"] = [n, {"fsi_restart": checkpoint, "ts_max_steps": 1000}]
    found["fails"] = [2, {"case_fails": True}]
    found["fault"] = [2, {"case_fault": True}]
    found["grids"] = [1, {"fsi_restart": "fused_half.checkpoint.h5", "case_dimension": 3}]
    found["many"] = [4, {"case_dimension": 1, "fsi_order": 6}]
    return found


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> tuple[Path, dict[str, tuple[int, str]]]:
    """Folder of the results, and name -> (status, message)."""
    folder = tmp_path_factory.mktemp("blocks")
    asked = jobs()
    told = [[n, {"fsi_output": f"{name}.h5", **options}] for name, (n, options) in asked.items()]
    (folder / "jobs.json").write_text(json.dumps(told))
    done = mpirun(4, "-m", "mpi4py", TESTS / "block_run_program.py", "jobs.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    return folder, dict(zip(asked, map(tuple, said), strict=True))


def assert_same_fields(runs, one: str, other: str) -> None:
    folder, said = runs
    for name in (one, other):
        assert said[name] == (0, ""), said[name]
    with (
        fsipetsc.open_run(folder / f"{one}.h5") as a,
        fsipetsc.open_run(folder / f"{other}.h5") as b,
    ):
        assert np.array_equal(a.time, b.time) and a.nframes > 2
        assert np.array_equal(a.series["dt"], b.series["dt"])
        for layer in a.layers:
            for field in layer.fields:
                assert np.array_equal(layer[field], b.blocks[layer.name][field]), (
                    layer.name,
                    field,
                )


@pytest.mark.parametrize(("d", "ranks"), [(1, 2), (1, 4), (2, 2), (2, 3), (2, 4), (3, 2), (3, 4)])
def test_same_bits_on_any_number_of_ranks(runs, d, ranks):
    assert_same_fields(runs, f"{d}d_1", f"{d}d_{ranks}")


@pytest.mark.parametrize("name", ["2d_balanced_2", "2d_balanced_3", "2d_physics_4"])
def test_same_bits_however_blocks_are_shared(runs, name):
    assert_same_fields(runs, "2d_1", name)


@pytest.mark.parametrize("method", ["rk", "timed"])
def test_same_bits_by_petscs_methods_and_with_data_in_time(runs, method):
    assert_same_fields(runs, f"{method}_1", f"{method}_3")


def test_the_fused_method_is_petscs(runs):
    """Up to round-off: the sums are in another order."""
    folder, _ = runs
    found = compare(folder / "2d_1.h5", folder / "rk_1.h5").differences
    fields = [entry for entry in found if ":" in entry.name]
    assert 0.0 < max(entry.largest for entry in fields) < 1e-14


@pytest.mark.parametrize("method", ["fused", "3bs"])
@pytest.mark.parametrize("ranks", [1, 3])
def test_a_restart_goes_on_with_the_same_bits(runs, method, ranks):
    """Also on other ranks."""
    folder, said = runs
    name = f"{method}_rest_{ranks}"
    assert said[name] == (0, ""), said[name]
    with (
        fsipetsc.open_run(folder / f"{method}_whole.h5") as a,
        fsipetsc.open_run(folder / f"{name}.h5") as b,
    ):
        assert b.summary["part"]["steps"] < b.summary["steps"] == a.summary["steps"]
        for layer in a.layers:
            for field in layer.fields:
                assert np.array_equal(layer[field][-1], b.blocks[layer.name][field][-1]), field


def test_what_came_in_is_of_the_step(runs):
    """Each unit a second, by rank 0."""
    folder, _ = runs
    for name in ("2d_1", "2d_3", "rk_3"):
        with fsipetsc.open_run(folder / f"{name}.h5") as run:
            assert np.allclose(run.series["energy_in"], run.series["dt"], rtol=1e-12)
            assert run.series["mass_in"].shape == (len(run.series["t"]), 2)
            assert np.allclose(run.series["impulse_y"], run.series["dt"], rtol=1e-12)


def test_what_a_result_has(runs):
    folder, _ = runs
    with fsipetsc.open_run(folder / "3d_2.h5") as run:
        assert run.dimension == 3 and list(run.blocks) == ["gas", "plate", "more gas"]
        plate = run.blocks["plate"]
        assert plate.fields == (
            *("u", "v", "w", "T", "s_xx", "s_xy", "s_xz", "s_yy", "s_yz", "s_zz", "x", "y", "z"),
        )
        assert run.layers[0].fields == ("rho", "u", "v", "w", "T", "p", "J", "x", "y", "z")
        assert plate.shape == (7, 8, 9) and plate["T"].shape == (run.nframes, 7, 8, 9)
        assert np.allclose(plate.X, np.linspace(0, 1, 9)) and np.allclose(
            plate.Z, np.linspace(1, 1.5, 7)
        )
        assert np.allclose(plate.y[0], 1.01 * plate.Y[:, None], atol=2e-3)
        assert np.array_equal(plate.frame(1)["T"], plate["T"][1])
        assert run.series["least_J"].shape[1] == run.series["J_error"].shape[1] == 3
        assert {"momentum_z", "impulse_z", "entropy"} <= set(run.series)
        assert run.interfaces == ("gas | plate",)
        assert list(run.errors) == ["fluid", "solid"] and "w" in run.errors["fluid"]
    with fsipetsc.open_run(folder / "1d_1.h5") as run:
        assert run.blocks["gas"]["rho"].shape == (run.nframes, 13)
        assert run.blocks["plate"].fields == ("u", "T", "sigma", "x", "p")
        assert run.blocks["plate"].h == pytest.approx(0.5 / 12)
        assert run.series["x_interface"][-1] == run.blocks["plate"].x[-1, 0]
        assert run.series["u_interface"][-1] == run.blocks["plate"]["u"][-1, 0]
    text = info(folder / "3d_2.h5")
    assert "plate" in text and "9 by 8 by 7 points" in text and "z = " in text
    assert (folder / "3d_2.xdmf").read_text().count('"XYZ"') == 3 * 6
    assert not (folder / "1d_1.xdmf").exists()


def test_an_interface_is_a_line(runs):
    with fsipetsc.open_run(runs[0] / "2d_2.h5") as run:
        line, plate = run.interface("gas | plate"), run.blocks["plate"]
        assert np.array_equal(line.x, plate.x[:, 0]) and np.array_equal(line.T, plate["T"][:, 0])
        assert np.allclose(line.n_y, -1.0, atol=0.05), "out of the plate, downwards"
        assert np.allclose(line.displacement, plate.y[:, 0] - 1.0)


def test_xarray_has_dimensions_of_blocks(runs):
    pytest.importorskip("xarray")
    with fsipetsc.open_run(runs[0] / "3d_2.h5") as run:
        found = run.to_xarray()
        assert found["plate.T"].dims == ("time", "Z_plate", "Y_plate", "X_plate")
        assert np.array_equal(found["plate.T"], run.blocks["plate"]["T"])


def test_a_failure_names_field_block_and_place(runs):
    folder, said = runs
    status, message = said["fails"]
    assert status == 3 and message.startswith("T = -"), message
    for words in ("in layer 'gas' at x = 0.66", "m, y = 0.44", "(X = 0.66", "step 4", "fails.h5"):
        assert words in message, message
    with fsipetsc.open_run(folder / "fails.h5") as run:
        assert run.summary["status"] == "failed" and run.nframes >= 1


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("fault", "initial of block 'gas': returns 1 value: expected 4 values (rho, u, v, T)"),
        ("grids", "case_dimension"),
        ("many", "ranks are more than these blocks can feed"),
    ],
)
def test_bad_input_ends_with_one_message(runs, name, words):
    status, message = runs[1][name]
    assert status == 2 and words in message, message
