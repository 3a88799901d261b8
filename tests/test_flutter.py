"""Panel flutter: modes on coarse grids, and where one begins to grow."""

import numpy as np
import pytest
from helpers import program, rows_of, solve

from fsipetsc.studies.flutter import crossing, unit_of

#: a thick and light panel on a coarse grid: a second or two for each lambda
COARSE = "-fsi_h 0.0625 -panel_thickness 0.1 -panel_height 0.5 -flutter_machs 2"


def test_the_crossing_from_a_few_dynamic_pressures():
    """Two frequencies that meet: their growth is positive from (f lambda)^2 = a^2 + d^2 m on."""
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


def test_modes_decay_below_and_grow_above(tmp_path):
    """On two ranks, which share the work; a thick panel, with the two slowest modes of theory."""
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
