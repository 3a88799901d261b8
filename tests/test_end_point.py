"""The gas's point at an interface without conduction is a particle that keeps its entropy."""

from __future__ import annotations

import numpy as np
import pytest
from receding import gas

pytest.importorskip("numba")
pytest.importorskip("petsc4py")



#: order -> (largest errors of rho and T on h = 0.00625, least order from 0.0125 on)
EXPECTED = {2: (4.6e-6, 3.7e-5, 1.85), 4: (3.3e-6, 3.9e-5, 1.8), 6: (3.3e-7, 3.7e-6, 2.5), 8: (7.1e-8, 7.9e-7, 3.1)}


def errors(run):
    """Largest errors of rho and T, away from the open end."""
    layer, t = run.layers[1], float(run.time[-1])
    inside = np.isfinite(layer["rho"][-1]) & (layer.X < 1.2)
    rho, _, T = gas(np.asarray(layer.X)[inside], t)
    return np.array([np.abs(layer["rho"][-1][inside] - rho).max(), np.abs(layer["T"][-1][inside] - T).max()])


@pytest.mark.parametrize("order", (2, 6))
def test_receding_piston(computed, order):
    coarse, fine = (errors(computed("receding", f"order{order}_h{h}")) for h in (0.0125, 0.00625))
    *largest, least_order = EXPECTED[order]
    assert np.all(fine < largest), fine
    assert np.all(np.log2(coarse / fine) > least_order), (coarse, fine)


