"""The case ring and the command modes: frequencies against those by Bessel functions, on any ranks the same bits."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import computed, message, solve

pytest.importorskip("petsc4py")

from fsipetsc.analysis.ring_theory import Medium, conditions, mode_near

#: of angular number 2, by another program: with gas, and in a vacuum
IN_GAS = 0.117577100308, 1.720096919386, 2.088655435371
IN_VACUUM = 0.203342164541, 2.278832154933, 7.861577812638
RING = Medium(1.0, 1.3, 2.0, 1.5, 1.0)
COARSE = "-fsi_h 0.05 -ring_around 32"


def media(viscosity=0.0):
    """Those of the case."""
    gas = 1.0, 1.4, 0.0, viscosity
    return Medium(0.4, 1.0, *gas), RING, Medium(1.3, 2.0, *gas)


def modes_of(folder, words=""):
    """(omega of the scheme, exact or nan) from the file of the command."""
    done = solve("modes", "ring", *words.split(), cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert "saved modes.csv" in done.stdout
    with (folder / "modes.csv").open() as file:
        rows = [{name: float(text or "nan") for name, text in row.items()} for row in csv.DictReader(file)]
    assert [row["index"] for row in rows] == list(range(1, len(rows) + 1))
    return np.array([(complex(r["omega_re"], r["omega_im"]), complex(r["exact"], r["exact_im"])) for r in rows]).T


def errors(found, exact):
    return np.abs(found / exact - 1.0)


@pytest.mark.parametrize(("rings", "known"), [(media(), IN_GAS), ((RING,), IN_VACUUM)])
def test_theory_has_the_known_modes(rings, known):
    for omega in known:
        assert abs(mode_near(rings, 2, 1.02 * omega) - omega) < 1e-11


def test_theory_finds_no_mode_where_none_is():
    """Modes of gas alternating from node to node were at 1.49 and 7.75."""
    assert mode_near(media(), 2, 1.49) is None and mode_near(media(), 2, 7.7548) is None


def test_little_viscosity_changes_modes_by_its_root():
    """Boundary layers do it; and then displacements along the interface are continuous, too."""
    shifts = [abs(mode_near(media(mu), 2, IN_GAS[1]) - IN_GAS[1]) for mu in (4e-4, 1e-4)]
    assert shifts[0] / shifts[1] == pytest.approx(2.0, rel=0.05)
    assert conditions(media(1e-3), 2, 1.7 - 0.1j).shape == (12, 12)
    assert mode_near(media(1e-9), 2, IN_GAS[1]) is None  # numbers are too large


@pytest.mark.parametrize(("words", "known"), [("", IN_GAS), ("-ring_gas false", IN_VACUUM)])
def test_the_first_three_modes_of_the_default_grid(words, known, tmp_path):
    """Measured: 5.1e-6, 9.0e-7, 3.3e-6 with gas; 3.6e-6, 3.9e-6, 1.4e-5 without. Nothing is damped."""
    found, exact = modes_of(tmp_path, f"{words} -modes_count 3")
    assert np.abs(exact - known).max() < 1e-11
    assert errors(found, known).max() < 2e-5
    assert np.abs(found.imag).max() < 1e-10


def test_errors_of_a_coarse_grid_and_of_another_order(tmp_path):
    """No more than 1.5 times those of another program."""
    found, _ = modes_of(tmp_path, f"{COARSE} -modes_count 3")
    assert (errors(found, IN_GAS) < 1.5 * np.array([3.1e-4, 5.5e-5, 2.0e-4])).all()
    found, _ = modes_of(tmp_path, "-fsi_order 4 -fsi_h 0.075 -ring_around 24 -modes_count 3")
    assert (errors(found, IN_GAS) < 1.5 * np.array([1.3e-2, 2.7e-3, 8.5e-3])).all()


def test_modes_are_complete_and_smooth(tmp_path):
    """What alternates from node to node is left out, and of the rest each has one of its own of the equations."""
    found, exact = modes_of(tmp_path, f"{COARSE} -modes_count 7")
    assert errors(found, exact).max() < 1e-3
    assert np.diff(exact.real).min() > 0.1


def test_modes_of_a_viscous_gas_are_damped(tmp_path):
    """Boundary layers are as thick as two cells and more."""
    found, exact = modes_of(tmp_path, f"{COARSE} -fluid_mu 0.01 -modes_count 3")
    assert errors(found, exact).max() < 2e-3
    assert (exact.imag < -0.05).all()
    found, exact = modes_of(tmp_path, f"{COARSE} -fluid_kappa 0.01 -modes_count 3")
    assert np.isnan(exact).all() and np.isfinite(found).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "the command modes knows the case ring, none was given"),
        ("blast", "the command modes knows the case ring, not blast"),
        ("ring -ring_pulse 1", "-ring_pulse: modes are of small motions"),
        ("ring -ring_angular 12 -ring_around 24 -fsi_order 2", "knows angular numbers from 0 to 11"),
        ("ring -ring_angular -1", "bad value '-1' for -ring_angular"),
        ("ring -ring_around 4", "axis 1"),
    ],
)
def test_one_message_each(words, said, tmp_path):
    message(solve("modes", *words.split(), cwd=tmp_path), 2, said)
    assert not (tmp_path / "modes.csv").exists()


def test_a_file_that_cannot_be_written(tmp_path):
    words = f"{COARSE} -ring_gas false -fsi_output nowhere/modes.csv"
    message(solve("modes", "ring", *words.split(), cwd=tmp_path), 4, "nowhere/modes.csv")


@pytest.mark.mpi
def test_a_pulse_on_one_rank_and_on_two(tmp_path):
    """The same bits; mass and energy stay; the ring is pushed."""
    words = f"ring -fsi_order 4 -fsi_h 0.1 {COARSE.split(' ', 2)[2]} -ts_max_time 0.3 -fsi_output_dt 0.3"
    one, two = (computed(tmp_path, f"{n}.h5", *words.split(), ranks=n) for n in (1, 2))
    for a, b in zip(one.layers, two.layers, strict=True):
        for name in a.fields:
            assert np.array_equal(a[name], b[name]), (a.name, name)
    for name in ("mass", "energy"):
        assert np.abs(one.series[name] / one.series[name][0] - 1.0).max() < 1e-14, name
    ring = one.layers[1]
    assert 1e-3 < np.abs(ring["x"][-1] - ring["x"][0]).max() < 0.1


def test_a_ring_without_a_pulse_rests(tmp_path):
    words = "ring -fsi_order 4 -fsi_h 0.1 -ring_around 32 -ring_pulse 0 -ts_max_time 0.3"
    for layer in computed(tmp_path, "rest.h5", *words.split()).layers:
        assert np.abs(layer["u" if layer.kind == "fluid" else "v"][-1]).max() < 1e-13, layer.name
