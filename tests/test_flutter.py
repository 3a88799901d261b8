"""Panel flutter: theory without a grid, modes of a motion, short runs."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from helpers import message, solve

pytest.importorskip("scipy")

from fsipetsc.analysis.panel_modes import Flow, Motion, crossing, fit_modes, panel
from fsipetsc.errors import ComputationError

#: a thick and light panel on a coarse grid: a second or two each
COARSE = "-fsi_h 0.0625 -panel_thickness 0.1 -panel_height 0.5 -flutter_machs 2"


def test_modes_of_a_clamped_panel():
    """cos b cosh b = 1 for b^2 the frequency; Timoshenko's go there as the panel gets thin."""
    thin, slender, thick = (panel(thickness)[0][:4] ** 0.25 for thickness in (0.0, 1e-3, 0.04))
    assert np.abs(np.cos(thin) - 1 / np.cosh(thin)).max() < 1e-9
    assert np.abs(slender[:3] / thin[:3] - 1).max() < 1e-4
    assert np.all(thick < 0.995 * thin)


def test_the_known_onset_of_flutter():
    """636.57, with frequency 52.4 (Dowell 1975), whatever the mass; damping delays it."""
    for mass in (1.0, 1e3):
        found, s = Flow(2.0, mass).onset(damped=False)
        assert abs(found - 636.57) < 0.01
        assert abs(s.imag / Flow(2.0, mass).unit(found) - 52.36) < 0.05
    assert abs(Flow(2.0, 1e4).onset()[0] - 636.57) < 0.1
    assert Flow(2.0, 10.0).onset()[0] == pytest.approx(641.6, abs=0.05)


def motion(s, a, t, noise=0.0):
    """Of two modes with the shapes sin(pi x), sin(2 pi x), and a mean that stays."""
    x = np.linspace(0, 1, 17)
    waves = np.sin(np.pi * x), np.sin(2 * np.pi * x)
    shapes = np.array([waves[0] + 0.2j * waves[1], waves[1]]) * np.array(a)[:, None]
    e = np.exp(np.outer(t, s))
    random = noise * np.random.default_rng(1).standard_normal((2, len(t), len(x)))
    return Motion(t, (e @ shapes).real + 1e-3 + random[0], ((e * s) @ shapes).real + random[1])


def test_two_modes_of_nearly_one_frequency_are_told_apart():
    """In a period and a quarter, without noise and with some; what does not oscillate has none."""
    s, t = np.array([-0.04 + 1.0j, 0.02 + 1.05j]), np.arange(0, 8, 0.1)
    for noise, most in ((0.0, 1e-9), (1e-4, 2e-3)):
        found, misfit = fit_modes(motion(s, (1.0, 0.5), t, noise))
        assert np.abs(found[:2] - s).max() < most
        assert misfit < 1e-9 + 10 * noise
    still = np.outer(np.exp(-0.1 * t), np.ones(9))
    with pytest.raises(ComputationError, match="0 modes oscillate"):
        fit_modes(Motion(t, still, -0.1 * still))


def test_the_crossing_from_a_few_dynamic_pressures():
    """Of theory's modes: their growth has a kink near 636, what is interpolated is smooth."""
    flow, dynamic = Flow(2.0, 10.0), (500.0, 600.0, 700.0, 800.0)
    units, pairs = [flow.unit(d) for d in dynamic], [flow.modes(d)[:2] for d in dynamic]
    found, s = crossing(dynamic, units, pairs)
    exact, expected = flow.onset()
    assert abs(found - exact) < 3.0 and abs(s.imag * flow.unit(found) - expected.imag) < 0.01
    assert np.isnan(crossing(dynamic[:2], units[:2], pairs[:2])[0])


@pytest.mark.mpi
def test_runs_decay_below_and_grow_above(tmp_path):
    """On two ranks, which share the runs; a thick panel, with the modes of theory."""
    words = f"flutter {COARSE} -flutter_lambdas 350,430,650 -fsi_output some.csv".split()
    done = solve(*words, cwd=tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    assert "onset of flutter" in done.stdout and (tmp_path / "some.png").stat().st_size > 10_000
    with (tmp_path / "some.csv").open() as file:
        runs = [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(file)]
    flow = Flow(2.0, 10.0, 0.1)
    assert [row["lambda"] for row in runs] == [350, 430, 650]
    assert runs[0]["growth"] < 0 < runs[2]["growth"]
    for row in runs[:2]:  # before they meet
        found = [complex(row[f"growth_{n}"], row[f"frequency_{n}"]) for n in (1, 2)]
        expected = flow.modes(row["lambda"])[:2]
        assert np.all(np.abs(found - expected) < 0.05 * np.abs(expected)), (found, expected)
    fastest = max(flow.modes(650.0)[:2], key=lambda s: s.real)
    assert abs(complex(runs[2]["growth"], runs[2]["frequency"]) - fastest) < 0.05


def test_messages(tmp_path):
    for words, said in {
        "-panel_lambda 700": "takes -flutter_lambdas",
        "-flutter_machs 0.9": "Mach numbers above 1",
    }.items():
        done = solve("flutter", *words.split(), cwd=tmp_path)
        message(done, 2, said)
