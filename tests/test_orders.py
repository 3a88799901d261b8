"""Orders that are reached, in L2 between two grids, as docs/convergence.md states them; each may be
0.15 lower than it was."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import REPOSITORY, compute

pytest.importorskip("petsc4py")

#: problem of orders_reached.py -> kind of layer, unknown, orders of 2/1, 4/2, 6/3, 8/4
MEASURED = {
    "insulated": ("solid", "T", (2.00, 3.98, 3.96, 6.00)),
    "warm": ("solid", "T", (2.00, 2.93, 5.50, 4.77)),
    "heated": ("solid", "T", (2.01, 3.09, 4.10, 5.24)),
    "gas": ("fluid", "rho", (1.96, 2.92, 4.48, 4.59)),
    "shock": ("fluid", "T", (None, 3.12, 4.46)),
}
#: errors of T where the end is open, to order 0 and 1 in viscosity, on both grids: they do not fall
OPEN = {"shock_open": (4.7e-3, 4.7e-3), "shock_first": (1.6e-3, 1.9e-3)}


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """errors(name): those of both grids, as listed in the results."""
    runs, case = {}, str(REPOSITORY / "tests" / "orders_reached.py")
    several = [(p, q) for p in MEASURED for q, n in zip(ORDERS, MEASURED[p][2], strict=False) if n]
    for k, h in enumerate((1 / 20, 1 / 40)):
        for problem, order in (*several, *((name, 4) for name in OPEN)):
            words = f"-orders_problem {problem} -fsi_order {order} "
            words += f"-fsi_h {h / 2} -ts_max_time 0.16" if "shock" in problem else f"-fsi_h {h}"
            runs[f"{problem}_{order}_{k}"] = case, words
    results = compute(1, tmp_path_factory.mktemp("orders"), runs)
    return lambda name: [results[f"{name}_{k}"].errors for k in range(2)]


@pytest.mark.parametrize("problem", MEASURED)
def test_orders_beside_ends(errors, problem):
    """Heat beside ends of three kinds; a wave of density between ends where all is given; a viscous
    shock in the middle of such an end."""
    kind, unknown, orders = MEASURED[problem]
    for order, measured in zip(ORDERS, orders, strict=False):
        if measured:
            coarse, fine = (e[kind][unknown] for e in errors(f"{problem}_{order}"))
            assert np.log2(coarse / fine) > measured - 0.15, (order, coarse, fine)


@pytest.mark.parametrize("name", OPEN)
def test_errors_of_a_shock_that_goes_out_through_an_open_end(errors, name):
    found = [e["fluid"]["T"] for e in errors(f"{name}_4")]
    np.testing.assert_allclose(found, OPEN[name], rtol=0.1)
