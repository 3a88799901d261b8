"""Runs with narrow second derivatives: orders, and what is conserved."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute

import fsipetsc

pytest.importorskip("petsc4py")
pytestmark = [pytest.mark.mpi, pytest.mark.long]  # kernels that no other test needs

#: order -> least order of the errors of the manufactured solution, in fluid and solid, between the grids below
LEAST = {2: (1.9, 1.9), 4: (3.0, 2.5), 6: (4.2, 3.9), 8: (5.0, 4.4)}
SPACINGS = (0.025, 0.0125)
ALONE = {f"mms {order} {h}": ("mms", f"-fsi_viscous narrow -fsi_order {order} -fsi_h {h}") for order in LEAST for h in SPACINGS}
ALONE["box"] = ("box", "-fsi_viscous narrow -fsi_coupling energy -fsi_h 0.025 -ts_max_time 0.5")


@pytest.fixture(scope="module")
def runs(more_kernels, tmp_path_factory):
    """name -> result."""
    files = compute(1, tmp_path_factory.mktemp("narrow"), ALONE)
    return {name: fsipetsc.open_run(path) for name, path in files.items()}


@pytest.mark.parametrize("order", LEAST)
def test_orders(runs, order):
    coarse, fine = (runs[f"mms {order} {h}"].errors for h in SPACINGS)
    for kind, least in zip(("fluid", "solid"), LEAST[order], strict=True):
        assert np.log2(coarse[kind]["combined"] / fine[kind]["combined"]) > least


def test_box(runs):
    """Mass and energy drift by what embedded walls let through: 2e-6 of the mass on this grid."""
    series = runs["box"].series
    assert np.abs(series["mass"] / series["mass"][0] - 1).max() < 1e-5
    assert np.abs(series["energy"] / series["energy"][0] - 1).max() < 1e-5
