"""Runs with narrow second derivatives: orders, what is conserved, and the same bits on any number of ranks."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

#: order -> least order of the errors of the manufactured solution, in fluid and solid, between the grids below
LEAST = {2: (1.9, 1.9), 4: (3.0, 2.5), 6: (4.2, 3.9), 8: (5.0, 4.4)}
SPACINGS = (0.025, 0.0125)
LAYERS = str(REPOSITORY / "tests" / "layers.py")
_LAYERS = "-fsi_viscous narrow -fsi_h 0.025 -fsi_mapping stretched -ts_max_time 0.1 -fsi_partition balanced"
SHARED = {
    "rod": ("rod", "-fsi_viscous narrow -fsi_h 0.025 -ts_max_time 0.02 -fsi_partition balanced"),
    # tile by tile on one rank, and not on more
    **{
        f"tiles {order}": ("rod", f"-fsi_viscous narrow -fsi_order {order} -fsi_h 5e-4 -ts_max_steps 8 -fsi_partition balanced")
        for order in LEAST
    },
}
SHARED |= {
    f"layers {coupling}": (LAYERS, f"{_LAYERS} -fsi_coupling {coupling} -fsi_order {order}")
    for coupling, order in (("projection", 8), ("energy", 6), ("traditional", 4), ("conservative", 2))
}
ALONE = {f"mms {order} {h}": ("mms", f"-fsi_viscous narrow -fsi_order {order} -fsi_h {h}") for order in LEAST for h in SPACINGS}
ALONE["box"] = ("box", "-fsi_viscous narrow -fsi_h 0.025 -ts_max_time 0.5")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """(ranks, name) -> result."""
    found = {}
    for ranks, wanted in ((1, SHARED | ALONE), (2, SHARED), (3, SHARED), (5, SHARED)):
        folder = tmp_path_factory.mktemp(f"narrow{ranks}")
        found |= {(ranks, name): fsipetsc.open_run(path) for name, path in compute(ranks, folder, wanted).items()}
    return found


@pytest.mark.parametrize("order", LEAST)
def test_orders(runs, order):
    coarse, fine = (runs[1, f"mms {order} {h}"].errors for h in SPACINGS)
    for kind, least in zip(("fluid", "solid"), LEAST[order], strict=True):
        assert np.log2(coarse[kind]["combined"] / fine[kind]["combined"]) > least


@pytest.mark.parametrize("name", SHARED)
@pytest.mark.parametrize("ranks", [2, 3, 5])
def test_ranks_change_no_bit(runs, ranks, name):
    one, more = runs[1, name], runs[ranks, name]
    for a, b in zip(one.layers, more.layers, strict=True):
        assert all(np.array_equal(a[field], b[field], equal_nan=True) for field in a.fields)
    assert np.array_equal(one.series["t"], more.series["t"])


def test_box(runs):
    """Mass and energy hold as they do with D twice."""
    series = runs[1, "box"].series
    assert np.abs(series["mass"] / series["mass"][0] - 1).max() < 1e-13
    assert np.abs(series["energy"] / series["energy"][0] - 1).max() < 1e-10
