"""A wall that a gas sticks to."""

import numpy as np

from fsipetsc.paper.embedded import (
    LEAST,
    beyond_boundary,
    dirichlet_ghost,
    insulated_ghost,
    lagrange,
)
from fsipetsc.paper.ends.end import GasEnd


class WallEnd(GasEnd):
    """Adiabatic, at rest."""

    new = 2

    @staticmethod
    def ghost(part, layer, side, n, nodes):
        """Adiabatic no-slip wall: u = 0, T_X = 0, and p + n Z u keeps its value."""
        gas, (rho, u, T) = part.law, (values[0] for values in nodes)
        Z, delta = rho * np.sqrt(gas.law.sound_speed_squared(rho, T)), beyond_boundary(layer, side)
        degree = part.ends.degree[side]
        u_G = dirichlet_ghost(0.0, nodes[1], lagrange(delta, degree)[0], degree, LEAST)
        p_G = gas.law.pressure(rho, T) - n * Z * (u_G - u)
        T_G = insulated_ghost(part.op, nodes[2], delta)
        return gas.law.density(p_G, T_G), u_G, T_G
