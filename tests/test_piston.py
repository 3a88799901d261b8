"""The example of a user's own case, runs/piston.py: the gas works like the spring that it is."""

import numpy as np
import pytest
from helpers import REPOSITORY, computed

P0, GAMMA, MASS, SPEED = 1e5, 1.4, 250.0 * 0.2, 25.0


def test_it_turns_where_the_energy_balance_says_and_comes_back_as_fast(tmp_path):
    from scipy.optimize import brentq

    run = computed(tmp_path, "piston.h5", REPOSITORY / "runs" / "piston.py", ranks=2)
    x, u = run.series["x_interface"][:, 0], run.series["u_interface"][:, 0]
    kinetic = 0.5 * MASS * SPEED**2
    energy = kinetic + 0.5 * 1.1614 * SPEED**2 / 3  # and of the gas, at the start

    def left(place):
        """Energy less the work on the gas, and that of the outer pressure, from 1 to a place."""
        return energy - P0 / (GAMMA - 1) * (place ** (1 - GAMMA) - 1) + P0 * (1 - place)

    assert x.min() == pytest.approx(brentq(left, 0.1, 1.0), abs=1e-4)
    back = np.flatnonzero((u > 0) & (x > 1))[0]
    assert u[back] == pytest.approx(SPEED, rel=2e-3)
    assert np.ptp(run.series["energy"] + P0 * x) < 2e-3 * kinetic
    mass = run.series["mass"][:, 0]
    assert np.ptp(mass) < 3e-6 * mass[0]
