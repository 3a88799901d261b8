"""The cases with more layers and a wall that moves."""

import numpy as np
import pytest
from helpers import computed

from fsipetsc.output.info import info


@pytest.mark.parametrize("order", [4, 8])
def test_the_column_keeps_what_it_has(order, tmp_path):
    """Mass, momentum less the impulse of the ends, energy: the run is held to them."""
    words = f"column -fsi_order {order} -ts_max_time 2 -fsi_cfl 0.4 -fsi_check 1e-10"
    run = computed(tmp_path, "column.h5", *words.split())
    assert len(run.layers) == 5
    assert np.ptp(run.series["x_interface"], axis=0).min() > 1e-4, "the pulse has come through"


def test_the_piston_compresses_the_gas_adiabatically(tmp_path):
    """So slowly, before so heavy a layer, that p V^gamma stays; the energy grows by the work."""
    words = "piston -fsi_h 0.025 -fluid_mu 0 -fluid_kappa 0 -piston_time 0.1 -ts_max_time 0.1"
    run = computed(tmp_path, "piston.h5", *words.split(), "-solid_density", 1e8)
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
