"""Open ends with data: the right number of conditions for every viscosity, conduction and Mach number."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import BECKER_SPACINGS, ORDERS, VISCOUS

EVERY_ORDER = pytest.mark.parametrize("order", ORDERS)


def rate(coarse, fine) -> float:
    return float(np.log2(coarse.errors["fluid"]["combined"] / fine.errors["fluid"]["combined"]))


@EVERY_ORDER
@pytest.mark.parametrize("mach", [1.5, 2.0])
def test_becker(computed, order, mach):
    """A viscous shock with supersonic inflow: imposing only what comes in below the speed of sound, T < 0 ends it."""
    coarse, fine = (computed("becker", f"order{order}_h{h}_M{mach}") for h in BECKER_SPACINGS)
    # at M = 2 the shock is half as thick
    least = {1.5: {2: 1.9, 4: 3.8, 6: 5.5, 8: 6.9}, 2.0: {2: 1.9, 4: 3.8, 6: 5.0, 8: 5.5}}
    assert rate(coarse, fine) >= least[mach][order]


@EVERY_ORDER
@pytest.mark.parametrize("gas", VISCOUS)
def test_orders_with_resolved_viscosity(computed, order, gas):
    coarse, fine = (computed("viscous", f"order{order}_h{h}_{gas}") for h in (0.05, 0.025))
    assert rate(coarse, fine) >= {2: 1.7, 4: 2.7, 6: 4.0, 8: 3.8}[order]
