"""The manufactured solution of Sec. 5.1: errors as the reference's, and rates no lower."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ORDERS, VISCOUS_ORDERS

pytest.importorskip("petsc4py")

#: combined errors (fluid, solid) at t = 0.45 for h = 0.0125 and 0.00625
REFERENCE = {
    2: {0.0125: (5.0e-4, 3.9e-4), 0.00625: (1.15e-4, 9.3e-5)},
    4: {0.0125: (1.1e-5, 2.9e-5), 0.00625: (1.1e-6, 4.4e-6)},
    6: {0.0125: (3.7e-7, 5.6e-7), 0.00625: (1.8e-8, 2.8e-8)},
    8: {0.0125: (3.2e-7, 4.7e-7), 0.00625: (5.9e-9, 2.0e-8)},
}
LEAST_RATE = {2: 1.9, 4: 2.6, 6: 4.2, 8: 4.5}
#: with resolved viscosity, conduction or both, between h = 0.05 and 0.025, in the gas
LEAST_VISCOUS = {2: 1.7, 4: 2.7, 6: 4.0, 8: 3.8}


def combined(run):
    return np.array([run.errors["fluid"]["combined"], run.errors["solid"]["combined"]])


@pytest.mark.parametrize("order", ORDERS)
def test_errors_and_rates(computed, order):
    errors = []
    for h, largest in REFERENCE[order].items():
        run = computed("mms", f"order{order}_h{h}")
        assert run.time[-1] == 0.45
        for name in ("u", "stress", "T", "flux"):
            assert np.abs(run.series[f"residual_{name}"]).max() < 2e-13, "with their jumps"
        errors.append(combined(run))
        assert np.all(np.abs(np.log(errors[-1] / largest)) <= np.log(1.3))
    assert np.all(np.log2(errors[0] / errors[1]) >= LEAST_RATE[order])


@pytest.mark.parametrize(("gas", "orders"), VISCOUS_ORDERS.items())
def test_orders_with_resolved_viscosity(computed, gas, orders):
    for order in orders:
        runs = [computed("viscous", f"order{order}_h{h}_{gas}") for h in (0.05, 0.025)]
        coarse, fine = (combined(run)[0] for run in runs)
        assert np.log2(coarse / fine) >= LEAST_VISCOUS[order]
