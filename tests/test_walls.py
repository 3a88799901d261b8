"""Walls that move and give off heat, and ends of solids that are driven: errors of walls.py."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")

#: state -> grids, orders
STATES = {"left": ((0.05, 0.025, 0.0125), ORDERS), "right": ((0.05, 0.025), (4, 8))}
#: of 2/1 to 8/4: the rate, the combined error on the second grid, and the Courant number, which is
#: smaller at 8/4 as 6/3 and 8/4 end at order 4, that of time. 2/1 is at 1.82 between h = 0.025 and
#: 0.0125, at 1.96 from there to 0.00625
REACHED = {2: (1.8, 4.5e-3, 1.0), 4: (2.9, 6e-4, 1.0), 6: (3.9, 4e-5, 1.0), 8: (4.5, 2e-5, 0.4)}


@pytest.mark.parametrize(
    ("state", "order"),
    [(state, order) for state, (_, orders) in STATES.items() for order in orders],
)
def test_the_order_is_that_of_table_1_or_better(state, order, tmp_path):
    least, largest, courant = REACHED[order]
    words = f"-walls_state {state} -fsi_order {order} -fsi_cfl {courant} -fsi_h"
    case = str(REPOSITORY / "tests" / "walls.py")
    made = compute(1, tmp_path, {f"h{h}": (case, f"{words} {h}") for h in STATES[state][0]})
    assert len(made) == len(STATES[state][0]), [f.read_text() for f in tmp_path.glob("*.txt")]
    every = [fsipetsc.open_run(path).errors for path in made.values()]
    found = np.array([[listed["combined"] for listed in one.values()] for one in every])
    assert np.all(np.log2(found[:-1] / found[1:]) >= least), found
    assert np.all(found[1] < largest)
