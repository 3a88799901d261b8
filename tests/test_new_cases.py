"""The cases with more layers, a wall that moves and an exact solution of conjugate heat transfer."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS
from helpers import compute

import fsipetsc

pytest.importorskip("petsc4py")

from fsipetsc.cases import heat
from fsipetsc.materials.fluid import Fluid
from fsipetsc.materials.line_solid import Solid

SPACINGS = (0.05, 0.025)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """results(name): the result of a run."""
    folder = tmp_path_factory.mktemp("cases")
    runs = {f"heat_{q}_{h}": ("heat", f"-fsi_order {q} -fsi_h {h} -fsi_output_dt 1") for q in ORDERS for h in SPACINGS}
    runs |= {f"column_{q}": ("column", f"-fsi_order {q} -ts_max_time 2 -fsi_cfl 0.4") for q in ORDERS}
    runs["piston"] = ("piston", "-fsi_h 0.025 -fluid_mu 0 -fluid_kappa 0 -piston_time 0.1 -ts_max_time 0.1 -solid_density 1e8")
    compute(1, folder, runs)
    return lambda name: fsipetsc.open_run(folder / f"{name}.h5")


@pytest.mark.parametrize("order", ORDERS)
def test_heat_has_the_order_of_the_scheme(results, order):
    """Relative to the amplitude; measured orders in the gas 2.0, 3.0, 4.4, 5.0."""
    for kind in ("fluid", "solid"):
        coarse, fine = (results(f"heat_{order}_{h}").errors[kind]["T"] / 1e-7 for h in SPACINGS)
        assert fine < {2: 2e-3, 4: 1e-4, 6: 1e-5, 8: 1e-5}[order], (kind, fine)
        assert np.log2(coarse / fine) > {2: 1.7, 4: 2.7, 6: 2.7, 8: 2.7}[order], (kind, coarse, fine)


def test_the_thermal_mode_is_one():
    """Of gases and solids that differ: the conditions hold, and the temperature has one sign."""
    for kappa, kappa_e, alpha in ((0.1, 0.3, 1.0), (0.02, 0.3, 4.0), (1.0, 0.05, 0.5)):
        mode = heat.Mode(Fluid(0.02, kappa, heat.GAMMA, heat.R), Solid(20.0, kappa_e, 2.0, alpha))
        assert mode.rate < 0
        gas, solid = mode.fields("gas", np.linspace(0, 1, 50), 0.0), mode.fields("solid", np.linspace(-1, 0, 50), 0.0)
        assert gas[2].min() > -1e-9 and solid[2].min() > -1e-9
        assert np.abs([gas[1, -1], gas[2, -1], solid[0, 0], solid[2, 0]]).max() < 1e-9
        assert gas[1, 0] == pytest.approx(solid[0, -1], rel=1e-6) and gas[2, 0] == pytest.approx(solid[2, -1], rel=1e-9)


@pytest.mark.parametrize("order", ORDERS)
def test_the_column_keeps_what_it_has(results, order):
    run = results(f"column_{order}")
    series, start = run.series, run.summary
    assert len(run.layers) == 5
    assert np.abs(series["mass"] / np.array(start["initial_mass"]) - 1).max() < 1e-14
    assert np.abs(series["energy"] / start["initial_energy"] - 1).max() < 1e-10
    change = series["momentum_x"] - start["initial_momentum_x"] - np.cumsum(series["impulse_x"])
    assert np.abs(change).max() < 1e-13 * np.abs(series["impulse_x"]).sum()
    assert np.ptp(series["x_interface"], axis=0).min() > 1e-4, "the pulse has come through"


def test_the_piston_compresses_the_gas_adiabatically(results):
    """So slowly, and before so heavy a layer, that p V^gamma stays; the energy grows by the work."""
    run = results("piston")
    p, mass = run.layers[0]["p"][-1], run.series["mass"] / np.array(run.summary["initial_mass"])
    length = run.series["x_interface"][-1, 0] - 0.3
    assert np.abs(mass - 1).max() < 1e-14
    assert p.mean() == pytest.approx(1e5 * length**-1.4, rel=2e-3)
    work = 1e5 / 0.4 * (length**-0.4 - 1)
    assert run.series["energy"][-1] - run.summary["initial_energy"] == pytest.approx(work, rel=1e-2)
