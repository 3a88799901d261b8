"""Data that are given."""

import numpy as np

from fsipetsc.equations.vectors import choose
from fsipetsc.paper.embedded import LEAST, beyond_boundary, dirichlet_ghost, lagrange
from fsipetsc.paper.ends.end import GasEnd


class GivenEnd(GasEnd):
    """Density, velocity and temperature are given."""

    @staticmethod
    def ghost(part, layer, side, n, nodes):
        """Exact (rho, u, T): as many of them as come in along characteristics.

        Inflow faster than sound: all three; inflow: p - n Z u and the entropy rho - p/c^2; outflow:
        p - n Z u; faster than sound: nothing. What viscosity and conduction ask for besides is
        imposed in the gradients.
        """
        gas, degree, data = part.law, part.ends.degree[side], layer.end_data[side]
        weights, _ = lagrange(beyond_boundary(layer, side), degree)
        (rho, u, T), (rho1, u1, T1) = ([values[k] for values in nodes] for k in range(2))
        rho_D = dirichlet_ghost(data[0], nodes[0], weights, degree, LEAST)
        u_D = dirichlet_ghost(data[1], nodes[1], weights, degree, LEAST)
        T_D = dirichlet_ghost(data[2], nodes[2], weights, degree, LEAST)
        c2 = gas.law.sound_speed_squared(rho1, T1)
        c, outflow = np.sqrt(c2), n * data[1] >= 0.0
        all_in = n * data[1] <= -np.sqrt(gas.law.sound_speed_squared(data[0], data[2]))
        Z, p, p_D = rho1 * c, gas.law.pressure(rho, T), gas.law.pressure(rho_D, T_D)
        w_o, w_i = p + n * Z * u, p_D - n * Z * u_D
        entropy, p_G = np.where(outflow, rho - p / c2, rho_D - p_D / c2), 0.5 * (w_i + w_o)
        rho_G = entropy + p_G / c2
        slow = rho_G, n * (w_o - w_i) / (2.0 * Z), gas.law.temperature_of(rho_G, p_G)
        slow = choose(outflow & (n * u1 >= c), (rho, u, T), slow)
        return choose(all_in, (rho_D, u_D, T_D), slow)
