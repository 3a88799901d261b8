"""Runs with convection in two-point form: ledgers, and both paths; refusals."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")
pytestmark = [pytest.mark.mpi, pytest.mark.long]  # kernels that no other test needs

ORDERS = 2, 4, 6, 8
_FORM = "-fsi_convection entropy"
#: a gas that is neither viscous nor conducts
ALONE = {
    f"box {order}": ("box", f"{_FORM} -fsi_order {order} -fsi_h 0.025 -ts_max_time 1 -fluid_mu 0 -fluid_kappa 0")
    for order in ORDERS
}


@pytest.fixture(scope="module")
def runs(more_kernels, tmp_path_factory):
    """name -> result."""
    files = compute(1, tmp_path_factory.mktemp("twopoint"), ALONE)
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.mark.long
def test_the_two_paths(tmp_path):
    """The fused method and PETSc's own agree to what a moving wall makes of their stages. (So they do, always, in divergence
    form, tests/test_time.py, and with dissipation, tests/test_dissipation_runs.py: kernels of each form are compiled for it.)
    """
    case, options = "piston", f"{_FORM} -fsi_partition balanced -ts_max_time 0.01"
    files = compute(1, tmp_path, {kind: (case, f"{options} -ts_type {kind}") for kind in ("fused", "rk")})
    fused, plain = (fsipetsc.open_run(files[kind]) for kind in ("fused", "rk"))
    (tmp_path / "two").mkdir()
    other = fsipetsc.open_run(compute(2, tmp_path / "two", {"rk": (case, f"{options} -ts_type rk")})["rk"])
    for a, b in zip(plain.layers, other.layers, strict=True):
        for field in a.fields:
            np.testing.assert_array_equal(a[field], b[field])
    for a, b in zip(fused.layers, plain.layers, strict=True):
        for field in a.fields:
            np.testing.assert_allclose(a[field], b[field], rtol=1e-6, atol=1e-6 * np.nanmax(np.abs(a[field])))


@pytest.mark.parametrize("order", ORDERS)
def test_box(runs, order):
    """Mass and energy hold as in divergence form, whether friction and conduction help or not."""
    series = runs[f"box {order}"].series
    assert np.abs(series["mass"] / series["mass"][0] - 1).max() < 1e-13
    assert np.abs(series["energy"] / series["energy"][0] - 1).max() < 1e-10


def test_a_gas_law_of_its_own_keeps_what_the_built_in_one_keeps(tmp_path):
    """In one process with runs of the perfect gas; its functions are no others with gamma = 1.4."""
    own = (str(REPOSITORY / "tests" / "own_gas.py"), f"{_FORM} -fsi_h 0.05 -ts_max_time 0.2")
    perfect = ("box", own[1])
    found = compute(1, tmp_path, {"perfect": perfect, "own": own})
    found = {name: fsipetsc.open_run(path) for name, path in found.items()}
    for name in ("mass", "energy", "x_interface"):
        assert np.array_equal(found["own"].series[name], found["perfect"].series[name]), name
