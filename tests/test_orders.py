"""Orders that are reached, as docs/convergence.md states them.

An order is measured between two grids, in L2. Each bound is a little below what was measured; an
error may be a tenth larger than it was.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")

SPACINGS = 1 / 20, 1 / 40
#: problem of orders_reached.py -> unknown, its size; orders of 2/1, 4/2, 6/3, 8/4
MEASURED = {
    "insulated": ("T", 1e-6, (2.00, 3.98, 3.96, 6.00)),
    "warm": ("T", 1e-6, (2.00, 2.93, 5.50, 4.77)),
    "heated": ("T", 1e-6, (2.01, 3.09, 4.10, 5.24)),
    "gas": ("rho", 1.0, (1.96, 2.92, 4.48, 4.59)),
}
#: the errors on the second grid
ERRORS = {
    "insulated": (2.6e-3, 5.2e-5, 5.4e-5, 6.7e-6),
    "warm": (2.2e-3, 2.3e-4, 1.1e-5, 1.6e-5),
    "heated": (2.3e-3, 1.5e-4, 4.2e-5, 1.2e-5),
    "gas": (6.9e-4, 1.3e-4, 1.7e-5, 9.2e-6),
}
#: of a viscous shock in the middle of an end where all is given: orders in T; errors of T where the
#: end is open, to order 0 and 1 in viscosity, on both grids: they do not fall
SHOCK = {4: 3.12, 6: 4.46}
OPEN = {"shock_open": (4.7e-3, 4.7e-3), "shock_first": (1.6e-3, 1.9e-3)}
#: of box_mms in one dimension: options, orders in the velocity of the solid and of the gas. Ripples
#: of the start cost half an order; at 8/4, data that change within a step cost more
SOLIDS = {
    "ripples": ("-fsi_order 4", 2.43, 3.2),
    "damped": ("-fsi_order 4 -fsi_dissipation 1", 3.1, 2.8),
    "short_steps": ("-fsi_order 8 -fsi_dissipation 1 -fsi_cfl 0.1", 5.4, 5.0),
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results[name]: the result of a run."""
    runs, case = {}, str(REPOSITORY / "tests" / "orders_reached.py")
    for h in SPACINGS:
        for problem in MEASURED:
            for order in ORDERS:
                words = f"-orders_problem {problem} -fsi_order {order} -fsi_h {h}"
                runs[f"{problem}_{order}_{h}"] = case, words
        for problem, order in (*(("shock", k) for k in SHOCK), *((name, 4) for name in OPEN)):
            words = f"-orders_problem {problem} -fsi_order {order} -ts_max_time 0.16"
            runs[f"{problem}_{order}_{h}"] = case, f"{words} -fsi_h {h / 2}"
        for name, (words, *_) in SOLIDS.items():
            more = f"-box_dimension 1 -solid_law log -fsi_output_dt 1 -fsi_h {h}"
            runs[f"{name}_{h}"] = "box_mms", f"{words} {more}"
    files = compute(1, tmp_path_factory.mktemp("orders"), runs)
    return {name: fsipetsc.open_run(file) for name, file in files.items()}


@pytest.fixture(scope="module")
def errors(results):
    """errors(name): those of both grids, as listed in the results."""
    return lambda name: [results[f"{name}_{h}"].errors for h in SPACINGS]


@pytest.mark.parametrize("problem", MEASURED)
def test_orders_beside_ends(errors, problem):
    """Heat beside ends of three kinds; a wave of density between ends where all is given."""
    unknown, size, orders = MEASURED[problem]
    kind = "fluid" if problem == "gas" else "solid"
    for order, measured, largest in zip(ORDERS, orders, ERRORS[problem], strict=True):
        coarse, fine = (e[kind][unknown] / size for e in errors(f"{problem}_{order}"))
        assert np.log2(coarse / fine) > measured - 0.15, (order, coarse, fine)
        assert fine < 1.1 * largest, order


def test_orders_of_a_shock_that_goes_out(errors):
    """What is wrong at an open end, whose conditions are for small waves, does not fall with h."""
    for order, measured in SHOCK.items():
        coarse, fine = (e["fluid"]["T"] for e in errors(f"shock_{order}"))
        assert np.log2(coarse / fine) > measured - 0.15, (order, coarse, fine)
    for name, largest in OPEN.items():
        for found, most in zip(errors(f"{name}_4"), largest, strict=True):
            assert 0.9 * most < found["fluid"]["T"] < 1.1 * most


@pytest.mark.parametrize("name", SOLIDS)
def test_orders_of_a_solid_that_is_strained_from_the_start(errors, name):
    _, of_solid, of_gas = SOLIDS[name]
    coarse, fine = errors(name)
    for kind, measured in (("solid", of_solid), ("fluid", of_gas)):
        order = np.log2(coarse[kind]["u"] / fine[kind]["u"])
        assert order > measured - 0.15, (kind, order, coarse, fine)
