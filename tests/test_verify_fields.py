"""Entries of the command `verify` in two dimensions: references, derivations, one entry as it runs."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import solve
from test_verify import program

from fsipetsc.cases import superseismic as case
from fsipetsc.verify.entry import reference


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("superseismic", lambda: program("superseismic").columns()),
        ("beam", lambda: program("beams").columns()),
        ("panel_flutter", lambda: program("beams").flutter_columns()),
        ("normal_modes", lambda: program("modes").columns()),
    ],
)
def test_references_are_what_their_programs_make(name, made):
    kept, made = reference(name), made()
    assert list(kept) == list(made)
    for column, values in made.items():
        np.testing.assert_allclose(kept[column], values, rtol=1e-8, atol=1e-12, err_msg=column)


def test_the_disk_in_the_radius_keeps_its_energy_and_converges():
    disk = program("disk")
    made, kept = disk.columns(20, 20, 5, (2.0,)), reference("spinning_disk")
    for column, largest in (("real 2", 2e-5), ("imag 2", 2e-5), ("x 2", 1e-6)):
        assert np.abs(made[column] - kept[column][::25]).max() < largest, column
    assert abs(disk.solve(2.0, 2.0, 4, 0.1, 16, 16)[2]) < 1e-12


def test_superseismic_states_of_the_case_and_of_the_literature():
    ours, literature = (
        {name: values[row] for name, values in reference("superseismic").items()} for row in (0, 1)
    )
    assert (case.PHI, case.P_WAVE, case.S_WAVE) == (ours["phi"], ours["a"], ours["b"])
    assert case.BEHIND == tuple(ours[name] for name in ("rho", "u", "v", "T"))
    published = {"rho": 0.4032762, "u": 0.7209148, "v": -0.04364727, "T": 0.2252081}
    published |= {"phi": -0.06047047, "a": -0.3079172, "b": 0.1229946}
    for name, value in published.items():
        assert literature[name] == pytest.approx(value, rel=1e-6), name
    # the exact data fulfil the wave equations of the solid: behind both waves v is constant
    X = np.array([-0.4])
    velocity = case.displacement(X, 0.0 * X, 0.5)[1]
    assert [v[0] for v in velocity] == pytest.approx([ours["solid u"], ours["solid v"]], rel=1e-9)


def test_waves_along_half_spaces_have_the_speeds_of_the_literature():
    table = reference("normal_modes")
    speeds = [table[f"water over {metal} imag"][1] / (2 * np.pi) for metal in ("steel", "aluminium")]
    assert np.round(speeds, 2) == pytest.approx([1479.60, 1476.76])
    assert reference("panel_flutter")["clamped lambda"][0] == pytest.approx(636.57, abs=0.005)


def test_the_entry_of_beams(tmp_path):
    done = solve("verify", "beam", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    with (tmp_path / "verify.csv").open() as file:
        errors = {row["quantity"]: float(row["error"]) for row in csv.DictReader(file)}
    assert 0.0 < errors["clamped, d = 0.05"] < 3e-4 and 0.0 < errors["hinged, d = 0.02"] < 1e-4
