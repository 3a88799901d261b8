"""The case ring and the command modes: frequencies against those by Bessel functions."""

import csv

import numpy as np
import pytest
from helpers import assert_same_fields, computed, solve
from mpi4py import MPI

from fsipetsc.analysis.ring_theory import Medium, mode_near
from fsipetsc.analysis.wave_modes import linear_modes, radial_modes
from fsipetsc.blockrun.block_state import BlockForm, BlockState
from fsipetsc.cases import ring

#: of angular number 2, by another program: with gas, and in a vacuum
IN_GAS = 0.117577100308, 1.720096919386, 2.088655435371
IN_VACUUM = 0.203342164541, 2.278832154933, 7.861577812638
RING = Medium(1.0, 1.3, 2.0, 1.5, 1.0)
COARSE = "-fsi_h 0.05 -ring_around 32"


def media(viscosity=0.0):
    """Those of the case."""
    gas = 1.0, 1.4, 0.0, viscosity
    return Medium(0.4, 1.0, *gas), RING, Medium(1.3, 2.0, *gas)


def modes_of(folder, words="", case="ring"):
    """(omega of the scheme, exact or nan) from the file of the command."""
    done = solve("modes", case, *words.split(), cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert "saved modes.csv" in done.stdout
    with (folder / "modes.csv").open() as file:
        rows = [{k: float(v or "nan") for k, v in row.items()} for row in csv.DictReader(file)]
    assert [row["index"] for row in rows] == list(range(1, len(rows) + 1))
    omega, exact = ("omega_re", "omega_im"), ("exact", "exact_im")
    return np.array([[complex(row[a], row[b]) for row in rows] for a, b in (omega, exact)])


def test_theory_with_viscosity_and_where_there_is_no_mode():
    """Boundary layers shift modes by the root of the viscosity. Gas alternating from node to node
    was at 1.49 and 7.75.
    """
    shifts = [abs(mode_near(media(mu), 2, IN_GAS[1]) - IN_GAS[1]) for mu in (4e-4, 1e-4)]
    assert shifts[0] / shifts[1] == pytest.approx(2.0, rel=0.05)
    assert mode_near(media(1e-9), 2, IN_GAS[1]) is None  # numbers are too large
    assert mode_near(media(), 2, 1.49) is None and mode_near(media(), 2, 7.7548) is None


@pytest.mark.parametrize(("words", "known"), [("", IN_GAS), ("-ring_gas false", IN_VACUUM)])
def test_the_first_three_modes_of_the_default_grid(words, known, tmp_path):
    """Measured: 5.1e-6, 9.0e-7, 3.3e-6 with gas; 3.6e-6, 3.9e-6, 1.4e-5 without."""
    found, exact = modes_of(tmp_path, f"{words} -modes_count 3")
    assert np.abs(exact - known).max() < 1e-11
    assert np.abs(found / known - 1.0).max() < 2e-5
    assert np.abs(found.imag).max() < 1e-10


def test_modes_of_a_coarse_grid_and_of_a_viscous_gas(tmp_path):
    """Each has one of its own of the equations; in a viscous gas they are damped. The first three
    are within 1.5 times the errors of another program.
    """
    found, exact = modes_of(tmp_path, f"{COARSE} -modes_count 7")
    assert np.abs(found / exact - 1.0).max() < 1e-3 and np.diff(exact.real).min() > 0.1
    known = 1.5 * np.array([3.1e-4, 5.5e-5, 2.0e-4])
    assert (np.abs(found[:3] / IN_GAS - 1.0) < known).all()
    found, exact = modes_of(tmp_path, f"{COARSE} -fluid_mu 0.01 -modes_count 3")
    assert np.abs(found / exact - 1.0).max() < 2e-3
    assert (exact.imag < -0.05).all()


def at_rest(**more):
    """The problem."""
    opt = {option.name: option.default for option in ring.OPTIONS} | {"ring_pulse": 0.0}
    return ring.build(opt | more)


#: order -> (h, cells around), errors of the first three modes by another program
TABLE = {
    2: [(0.075, 24, (5.4e-2, 2.7e-2, 6.8e-2)), (0.0375, 48, (1.3e-2, 7.0e-3, 1.7e-2))],
    4: [(0.075, 24, (1.3e-2, 2.7e-3, 8.5e-3)), (0.0375, 48, (8.9e-4, 1.8e-4, 5.6e-4))],
    6: [(0.05, 32, (3.1e-4, 5.5e-5, 2.0e-4)), (0.025, 64, (5.1e-6, 9.0e-7, 3.3e-6))],
    8: [(0.0375, 48, (9.8e-7, 1.5e-7, 6.2e-7))],
}


@pytest.mark.long
@pytest.mark.parametrize("order", TABLE)
def test_modes_at_all_orders(order):
    """The errors are at most 1.5 times those of another program, at as many nodes in the gas."""
    found = []
    for h, around, known in TABLE[order]:
        problem = at_rest(fsi_order=order, fsi_h=h, ring_around=around)
        found.append(np.abs(radial_modes(problem, order, 2)[:3] / IN_GAS - 1.0))
        assert (found[-1] < 1.5 * np.array(known)).all(), found[-1]
    for coarse, fine in zip(found, found[1:]):
        rates = np.log2(coarse / fine)
        assert rates.min() > order - 0.2, rates


@pytest.mark.long
@pytest.mark.parametrize("viscosity", [0.0, 0.01])
@pytest.mark.parametrize("density", [1e-3, 1.0, 1e3])
def test_nothing_grows_beside_light_and_heavy_rings(density, viscosity):
    """About rest; modes of frequency 0 are double, and differences split these."""
    words = {"fsi_order": 4, "fsi_h": 0.1, "ring_around": 24, "fluid_mu": viscosity}
    problem = at_rest(solid_density=density, **words)
    with BlockState(MPI.COMM_SELF, problem, 4, BlockForm()) as state:
        values = linear_modes(state, 1, 2)[0]
    assert values.real.max() < 1e-11 * np.abs(values).max()


def test_a_pulse_on_two_ranks_and_on_three(tmp_path):
    """The same bits; mass and energy stay; the ring is pushed, and rests without a pulse."""
    words = "ring -fsi_order 4 -fsi_h 0.1 -ring_around 32".split()
    words += "-ts_max_time 0.3 -fsi_output_dt 0.3".split()
    two, three = (computed(tmp_path, f"{n}.h5", *words, ranks=n) for n in (2, 3))
    assert_same_fields(two, three)
    for name in ("mass", "energy"):
        assert np.abs(two.series[name] / two.series[name][0] - 1.0).max() < 1e-14, name
    ring = two.layers[1]
    assert 1e-3 < np.abs(ring["x"][-1] - ring["x"][0]).max() < 0.1
    for layer in computed(tmp_path, "rest.h5", *words, "-ring_pulse", 0, ranks=2).layers:
        assert np.abs(layer["v"][-1]).max() < 1e-13, layer.name
