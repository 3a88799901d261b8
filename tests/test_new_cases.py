"""The cases with more layers, a wall that moves, and conjugate heat transfer, solved exactly."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import compute

import fsipetsc
from fsipetsc.output.info import info

pytest.importorskip("petsc4py")

#: of two grids; at 8/4 the errors on finer ones are round-off
SPACINGS = {2: (0.05, 0.025), 4: (0.05, 0.025), 6: (0.05, 0.025), 8: (1 / 15, 0.05)}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results(name): the result of a run."""
    folder, runs = tmp_path_factory.mktemp("cases"), {}
    for q in ORDERS:
        for h in SPACINGS[q]:
            runs[f"heat_{q}_{h}"] = "heat", f"-fsi_order {q} -fsi_h {h} -fsi_output_dt 1"
        runs[f"column_{q}"] = "column", f"-fsi_order {q} -ts_max_time 2 -fsi_cfl 0.4"
    words = "-fsi_h 0.025 -fluid_mu 0 -fluid_kappa 0 -piston_time 0.1 -ts_max_time 0.1"
    runs["piston"] = "piston", f"{words} -solid_density 1e8"
    compute(1, folder, runs)
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


@pytest.mark.parametrize("order", ORDERS)
def test_heat_has_the_order_of_the_scheme(results, order):
    """Relative to the amplitude; measured orders in the gas 2.0, 3.0, 4.4, 4.3."""
    for kind in ("fluid", "solid"):
        runs = [results(f"heat_{order}_{h}") for h in SPACINGS[order]]
        coarse, fine = (run.errors[kind]["T"] / 1e-7 for run in runs)
        assert fine < {2: 2e-3, 4: 1e-4, 6: 1e-5, 8: 1e-5}[order], (kind, fine)
        found = np.log(coarse / fine) / np.log(SPACINGS[order][0] / SPACINGS[order][1])
        assert found > {2: 1.7, 4: 2.7, 6: 2.7, 8: 3.7}[order], (kind, coarse)


@pytest.mark.parametrize("order", ORDERS)
def test_the_column_keeps_what_it_has(results, order):
    run = results(f"column_{order}")
    series, start = run.series, run.summary
    assert len(run.layers) == 5
    assert np.abs(series["mass"] / np.array(start["initial_mass"]) - 1).max() < 1e-14
    assert np.abs(series["energy"] / start["initial_energy"] - 1).max() < 1e-10
    came = np.cumsum(series["impulse_x"])
    change = series["momentum_x"] - start["initial_momentum_x"] - came
    assert np.abs(change).max() < 1e-13 * np.abs(series["impulse_x"]).sum()
    assert np.ptp(series["x_interface"], axis=0).min() > 1e-4, "the pulse has come through"


def test_the_piston_compresses_the_gas_adiabatically(results):
    """So slowly, before so heavy a layer, that p V^gamma stays; the energy grows by the work."""
    run = results("piston")
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
