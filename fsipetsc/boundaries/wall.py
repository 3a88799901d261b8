"""Adiabatic no-slip wall as an embedded boundary: u = 0 and T_X = 0 at x_w.

Only what the condition gives is overwritten at the ghost point: u by the Dirichlet formula (4.26), T by the
Neumann formula. The outgoing characteristic p + n Z u, Z = rho c, keeps its value and gives the pressure.
(A ghost point with extrapolated density, or with all variables prescribed, makes the scheme unstable.)
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, dirichlet_ghost, neumann_ghost

#: degree of the extrapolation that fills a new point, and of the formulas
NEW_POINT, DEGREE = 2, 2


@njit(**OPTIONS)
def wall(layer, side, normal, nodes, weights, slopes):
    """Fill the ghost values nodes[:, 0] of (rho, u, T) from nodes[:, 1:]; normal is -1 left, +1 right."""
    q = layer.end_degree[side]
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    impedance = rho * np.sqrt(layer.gamma * layer.R * T)
    u_g = dirichlet_ghost(0.0, nodes[1], weights, q)
    p_g = layer.R * rho * T - normal * impedance * (u_g - u)
    T_g = neumann_ghost(nodes[2], slopes, q)
    nodes[0, 0] = p_g / (layer.R * T_g)
    nodes[1, 0] = u_g
    nodes[2, 0] = T_g
