"""Walls that move and give off heat, and ends of solids that are driven: the manufactured solutions of walls.py."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import REPOSITORY, compute

import fsipetsc

pytest.importorskip("petsc4py")

#: state -> grids
SPACINGS = {"left": (0.05, 0.025, 0.0125), "gas": (0.025, 0.0125), **dict.fromkeys(("right", "solid"), (0.05, 0.025))}
#: state -> orders; the others are long
SOME = {"left": ORDERS, "right": (4, 8), "gas": (2, 6), "solid": (4, 8)}
OTHERS = {state: tuple(q for q in ORDERS if q not in orders) for state, orders in SOME.items()}
#: those of the other side, at the grids of docs/conservative.md
FINE = {"right": (0.025, 0.0125)}
#: 2/1 is at 1.82 between h = 0.025 and 0.0125, at 1.96 from there to 0.00625. Those of 6/3 and 8/4 end at order 4, that of
#: time: so 8/4 has shorter steps
COURANT = {2: 1.0, 4: 1.0, 6: 1.0, 8: 0.4}
LEAST_RATE = {2: 1.8, 4: 2.9, 6: 3.9, 8: 4.5}
#: combined errors on the second grid
LARGEST = {2: 4.5e-3, 4: 6e-4, 6: 4e-5, 8: 2e-5}


def computed_errors(folder, spacings, orders):
    """errors(state, order): combined errors, shape (grids, kinds of layer)."""
    names = {(s, q, h): f"{s}_{q}_{h}" for s, hs in spacings.items() for q in orders[s] for h in hs}
    case = str(REPOSITORY / "tests" / "walls.py")
    words = "-walls_state {} -fsi_order {} -fsi_h {} -fsi_cfl {}"
    runs = {name: (case, words.format(s, q, h, COURANT[q])) for (s, q, h), name in names.items()}
    files = compute(1, folder, runs)

    def found(state, order):
        every = [fsipetsc.open_run(files[names[state, order, h]]).errors for h in spacings[state]]
        return np.array([[listed["combined"] for listed in one.values()] for one in every])

    return found


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    return computed_errors(tmp_path_factory.mktemp("walls"), SPACINGS, SOME)


def assert_of_its_order(found, order):
    assert np.all(np.log2(found[:-1] / found[1:]) >= LEAST_RATE[order]), found
    assert np.all(found[1] < LARGEST[order])


@pytest.mark.parametrize(("state", "order"), [(state, order) for state, orders in SOME.items() for order in orders])
def test_the_order_is_that_of_table_1_or_better(errors, state, order):
    assert_of_its_order(errors(state, order), order)


@pytest.mark.long
def test_so_it_is_with_all_others(tmp_path):
    errors = computed_errors(tmp_path, SPACINGS, OTHERS)
    for state, orders in OTHERS.items():
        for order in orders:
            assert_of_its_order(errors(state, order), order)


@pytest.mark.long
def test_the_order_on_the_finest_grid(tmp_path):
    errors = computed_errors(tmp_path, FINE, {"right": ORDERS})
    for order in ORDERS:
        coarse, fine = errors("right", order)
        assert np.all(np.log2(coarse / fine) >= LEAST_RATE[order]), (order, coarse, fine)
