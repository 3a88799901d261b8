"""Open end: sound leaves, nothing comes in but the state at rest (p0, T0).

At the ghost point the outgoing characteristic wo = p' + n Z0 u, Z0 = rho0 c0, and on outflow the entropy, keep
their values; the incoming characteristic and on inflow the entropy are those of the state at rest.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS

NEW_POINT = 1


@njit(**OPTIONS)
def open_end(law, layer, side, normal, nodes, weights, slopes):
    """Fill the ghost values nodes[:, 0] of (rho, u, T); end_data = (p0, T0)."""
    gas, c = law.gas, law.gas.constants(layer)
    p0, T0 = layer.end_data[side, 0], layer.end_data[side, 1]
    rho0 = gas.density(c, p0, T0)
    c2 = gas.sound_speed_squared(c, rho0, T0)
    impedance = rho0 * np.sqrt(c2)
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    p = gas.pressure(c, rho, T) - p0
    outgoing = p + normal * impedance * u
    entropy = rho - rho0 - p / c2 if normal * u >= 0.0 else 0.0
    p = 0.5 * outgoing
    rho = rho0 + entropy + p / c2
    nodes[0, 0] = rho
    nodes[1, 0] = normal * p / impedance
    nodes[2, 0] = gas.temperature_of_pressure(c, rho, p0 + p)
