"""Runs with dissipation of half the order: the orders of their errors."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute

pytest.importorskip("petsc4py")
pytestmark = pytest.mark.mpi

#: order -> least order of the errors of the manufactured solution with dissipation of half the
#: order, in fluid and solid, between the grids below: 2 q - 1 inside, q at the ends
LEAST = {2: (0.9, 0.65), 4: (2.2, 2.6), 6: (4.0, 3.9), 8: (4.9, 4.4)}
SPACINGS = (0.025, 0.0125)
#: numba compiles dissipation anew for each order
ORDERS = [q if q == 4 else pytest.param(q, marks=pytest.mark.long) for q in LEAST]


@pytest.mark.parametrize("order", ORDERS)
def test_orders(order, tmp_path):
    """Where the strength at shocks is as good as none, what is left is the other term."""
    words = f"-box_dimension 1 -fsi_dissipation 1 -fsi_shock 1e-300 -fsi_order {order}"
    runs = {f"{h}": ("box_mms", f"{words} -fsi_h {h}") for h in SPACINGS}
    results = compute(1, tmp_path, runs)
    coarse, fine = (results[f"{h}"].errors for h in SPACINGS)
    for kind, least in zip(("fluid", "solid"), LEAST[order], strict=True):
        assert np.log2(coarse[kind]["combined"] / fine[kind]["combined"]) > least
