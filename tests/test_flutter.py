"""Panel flutter: modes of a motion, short runs."""

import numpy as np
import pytest
from helpers import message, program, rows_of, solve

from fsipetsc.errors import ComputationError
from fsipetsc.studies.panel_modes import crossing, fit_modes, unit_of
from fsipetsc.studies.verify.data import reference

#: a thick and light panel on a coarse grid: a second or two each
COARSE = "-fsi_h 0.0625 -panel_thickness 0.1 -panel_height 0.5 -flutter_machs 2"


def test_two_modes_of_nearly_one_frequency_are_told_apart():
    """In a period and a quarter, with some noise; what does not oscillate has none."""
    s, t, x = np.array([-0.04 + 1.0j, 0.02 + 1.05j]), np.arange(0, 8, 0.1), np.linspace(0, 1, 17)
    first, second = np.sin(np.pi * x), np.sin(2 * np.pi * x)
    shapes, e = np.array([first + 0.2j * second, 0.5 * second]), np.exp(np.outer(t, s))
    place, speed = (e @ shapes).real + 1e-3, ((e * s) @ shapes).real
    for size, most in ((0.0, 1e-9), (1e-4, 2e-3)):
        noise = size * np.random.default_rng(1).standard_normal((2, *place.shape))
        found, misfit = fit_modes(t, place + noise[0], speed + noise[1])
        assert np.abs(found[:2] - s).max() < most and misfit < 1e-9 + 10 * size
    still = np.outer(np.exp(-0.1 * t), np.ones(9))
    with pytest.raises(ComputationError, match="0 modes oscillate"):
        fit_modes(t, still, -0.1 * still)


def test_the_crossing_from_a_few_dynamic_pressures():
    """Two frequencies that meet, s^2 + d s + m +- sqrt(a^2 - (f lambda)^2) = 0: their growth has a
    kink there, and is positive from (f lambda)^2 = a^2 + d^2 m on."""
    m, a, f, d = 2152.0, 1651.0, 2.6, 2.0
    dynamic = (500.0, 600.0, 700.0, 800.0)
    units = [unit_of(2.0, 10.0, at) for at in dynamic]
    roots = [np.sqrt(a**2 - (f * at) ** 2 + 0j) * np.array([1, -1]) for at in dynamic]
    pairs = [u * (np.sqrt(0.25 * d**2 - m - r) - 0.5 * d) for u, r in zip(units, roots)]
    pairs = [np.where(pair.imag < 0, -d * u - pair, pair) for u, pair in zip(units, pairs)]
    found, s = crossing(2.0, 10.0, dynamic, pairs)
    assert found == pytest.approx(np.sqrt(a**2 + d**2 * m) / f, rel=1e-6)
    assert s == pytest.approx(1j * np.sqrt(m) * unit_of(2.0, 10.0, found), rel=1e-6)
    at, s = crossing(2.0, 10.0, dynamic[:2], pairs[:2])
    assert np.isnan([at, s.real, s.imag]).all()


def test_runs_decay_below_and_grow_above(tmp_path):
    """On two ranks, which share the runs; a thick panel, with the two slowest modes of theory."""
    beams, dynamic = program("beams"), (350, 430, 650)
    panel = beams.plane(0.1, "clamped")
    known = {at: np.array(beams.modes(panel, at)) for at in dynamic}
    words = f"flutter {COARSE} -flutter_lambdas 350,430,650 -fsi_output some.csv".split()
    done = solve(*words, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "") and "onset of flutter" in done.stdout
    rows = rows_of(tmp_path / "some.csv")
    runs = [{name: float(value) for name, value in row.items() if value} for row in rows]
    assert [row["lambda"] for row in runs] == [*dynamic]
    assert runs[0]["growth"] < 0 < runs[2]["growth"]
    for row in runs[:2]:  # before they meet
        found = [complex(row[f"growth_{n}"], row[f"frequency_{n}"]) for n in (1, 2)]
        np.testing.assert_allclose(found, known[row["lambda"]], rtol=0.05)
    assert abs(complex(runs[2]["growth"], runs[2]["frequency"]) - known[650][1]) < 0.05


def test_hinged_ends(tmp_path):
    words = f"flutter {COARSE} -panel_ends hinged -flutter_lambdas 260,360".split()
    done = solve(*words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    onset = float(done.stdout.split("of 343.36")[1].split()[1])
    table = reference("panel_flutter")
    theory = dict(zip(table["d"], table["hinged theory"], strict=True))
    assert onset == pytest.approx(theory[0.1], rel=0.05)


def test_messages(tmp_path):
    for words, said in {
        "-panel_lambda 700": "takes -flutter_lambdas",
        "-flutter_machs 0.9": "Mach numbers above 1",
        "-panel_ends hinged -fluid_mu 1e-3": "expected -fluid_mu 0",
        "-flutter_machs 2 -ts_max_time 2": "-ts_max_time is 2: expected at least",
    }.items():
        message(solve("flutter", *words.split(), cwd=tmp_path), 2, said)
