"""The example of a user's own case: it runs as its file says, and the gas works like the spring that it is."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import REPOSITORY, solve

import fsipetsc

pytest.importorskip("petsc4py")

P0, GAMMA, MASS, SPEED = 1e5, 1.4, 250.0 * 0.2, 25.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("piston")
    done = solve(REPOSITORY / "runs" / "piston.py", cwd=folder, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    with fsipetsc.open_run(folder / "piston.h5") as result:
        yield result


def adiabatic_work(x: float) -> float:
    """Work per area done on the gas, less that of the outer pressure, when the piston has come from 1 to x."""
    return P0 / (GAMMA - 1) * (x ** (1 - GAMMA) - 1) - P0 * (1 - x)


def turning_point(energy: float) -> float:
    """x at which the work equals the energy, by bisection."""
    low, high = 0.1, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if adiabatic_work(middle) > energy else (low, middle)
    return low


def test_it_turns_where_the_energy_balance_says(run):
    gas_at_start = 0.5 * 1.1614 * SPEED**2 / 3
    expected = turning_point(0.5 * MASS * SPEED**2 + gas_at_start)
    assert run.series["x_interface"].min() == pytest.approx(expected, abs=1e-4)


def test_it_comes_back_as_fast(run):
    x, u = run.series["x_interface"][:, 0], run.series["u_interface"][:, 0]
    back = np.flatnonzero((u > 0) & (x > 1))[0]
    assert u[back] == pytest.approx(SPEED, rel=2e-3)


def test_energy_and_mass(run):
    """Total energy plus what the outer pressure still has to give is constant; so is the mass."""
    total = run.series["energy"] + P0 * run.series["x_interface"][:, 0]
    kinetic = 0.5 * MASS * SPEED**2
    assert np.ptp(total) < 2e-3 * kinetic
    mass = run.series["mass"][:, 0]
    assert np.ptp(mass) < 3e-6 * mass[0]
