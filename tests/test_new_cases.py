"""The cases with more layers, a wall that moves, and conjugate heat transfer, solved exactly."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import compute

from fsipetsc.output.info import info

pytest.importorskip("petsc4py")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name of a run -> its result."""
    words = "-fsi_h 0.025 -fluid_mu 0 -fluid_kappa 0 -piston_time 0.1 -ts_max_time 0.1"
    runs = {"piston": ("piston", f"{words} -solid_density 1e8")}
    for q in (4, 8):
        words = f"-fsi_order {q} -ts_max_time 2 -fsi_cfl 0.4 -fsi_check 1e-10"
        runs[f"column_{q}"] = "column", words
    for h in (0.05, 0.025):
        runs[f"heat_{h}"] = "heat", f"-fsi_order 4 -fsi_h {h} -fsi_output_dt 1"
    return compute(1, tmp_path_factory.mktemp("cases"), runs)


def test_heat_has_the_order_of_the_scheme(results):
    for kind in ("fluid", "solid"):
        coarse, fine = (results[f"heat_{h}"].errors[kind]["T"] / 1e-7 for h in (0.05, 0.025))
        assert fine < 1e-4 and np.log2(coarse / fine) > 2.7, (kind, coarse, fine)


@pytest.mark.parametrize("order", [4, 8])
def test_the_column_keeps_what_it_has(results, order):
    """Mass, momentum less the impulse of the ends, energy: the run is held to them."""
    run = results[f"column_{order}"]
    assert len(run.layers) == 5
    assert np.ptp(run.series["x_interface"], axis=0).min() > 1e-4, "the pulse has come through"


def test_the_piston_compresses_the_gas_adiabatically(results):
    """So slowly, before so heavy a layer, that p V^gamma stays; the energy grows by the work."""
    run = results["piston"]
    mass = run.series["mass"] / np.array(run.summary["initial_mass"])
    assert np.abs(mass - 1).max() < 1e-14
    length = run.series["x_interface"][-1, 0] - 0.3
    assert run.layers[0]["p"][-1].mean() == pytest.approx(1e5 * length**-1.4, rel=2e-3)
    gained = run.series["energy"][-1] - run.summary["initial_energy"]
    assert gained == pytest.approx(1e5 / 0.4 * (length**-0.4 - 1), rel=1e-2)
    came, wall = run.series["energy_face"].sum(axis=0), "driven, axis 0, side 0"
    round_off = 1e-13 * run.series["energy"].max()  # of 6e12 J, that of the heavy layer
    assert dict(zip(run.faces, came, strict=True))[wall] == pytest.approx(gained, abs=round_off)
    assert np.count_nonzero(came) == 1 and not run.series["heat_face"].any()
    (told,) = (line for line in info(run.path).splitlines() if line.startswith(f"  {wall}"))
    assert f"{came.sum():.6g}" in told
