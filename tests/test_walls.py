"""Walls that move and give off heat, and ends of solids that are driven: errors of walls.py."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import REPOSITORY, compute

pytest.importorskip("petsc4py")

#: state -> grids, orders
STATES = {"left": ((0.05, 0.025, 0.0125), ORDERS), "right": ((0.05, 0.025), (4, 8))}
CASES = [(state, order) for state, (_, orders) in STATES.items() for order in orders]
#: those of 6/3 and 8/4 end at order 4, that of time: so 8/4 has shorter steps
COURANT = {2: 1.0, 4: 1.0, 6: 1.0, 8: 0.4}
#: 2/1 is at 1.82 between h = 0.025 and 0.0125, at 1.96 from there to 0.00625
LEAST_RATE = {2: 1.8, 4: 2.9, 6: 3.9, 8: 4.5}
#: combined errors on the second grid
LARGEST = {2: 4.5e-3, 4: 6e-4, 6: 4e-5, 8: 2e-5}


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """errors(state, order): combined errors, shape (grids, kinds of layer)."""
    case, runs = str(REPOSITORY / "tests" / "walls.py"), {}
    for state, order in CASES:
        for h in STATES[state][0]:
            words = f"-walls_state {state} -fsi_order {order} -fsi_h {h} -fsi_cfl {COURANT[order]}"
            runs[f"{state}_{order}_{h}"] = case, words
    results = compute(1, tmp_path_factory.mktemp("walls"), runs)

    def found(state, order):
        every = [results[f"{state}_{order}_{h}"].errors for h in STATES[state][0]]
        return np.array([[listed["combined"] for listed in one.values()] for one in every])

    return found


@pytest.mark.parametrize(("state", "order"), CASES)
def test_the_order_is_that_of_table_1_or_better(errors, state, order):
    found = errors(state, order)
    assert np.all(np.log2(found[:-1] / found[1:]) >= LEAST_RATE[order]), found
    assert np.all(found[1] < LARGEST[order])
