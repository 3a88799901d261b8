"""Exact data (rho, u, T) at an embedded boundary, imposed without overspecifying it.

The formulas (4.26) of degree q give (rho, u, T)_D at the ghost point; of these only the incoming characteristic
p - n Z u is imposed, and the entropy on inflow. The outgoing characteristic p + n Z u and on outflow the entropy
rho - p/c^2 keep their values. Z = rho c and c are taken one point inside, as at an interface: then a ghost point that is
filled already does not change.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, dirichlet_ghost

NEW_POINT = 3


@njit(**OPTIONS)
def note_gradient(layer, side, nodes, weights):
    """Put u and T of the formulas where the gradients find them; from the points inside alone."""
    q, data = layer.end_degree[side], layer.end_data[side]
    layer.end_gradient[side, 0] = dirichlet_ghost(data[1], nodes[1], weights, q)
    layer.end_gradient[side, 1] = dirichlet_ghost(data[2], nodes[2], weights, q)


@njit(**OPTIONS)
def dirichlet(layer, side, normal, nodes, weights, slopes):
    """Fill the ghost values nodes[:, 0] of (rho, u, T); end_data = (rho, u, T) at the boundary."""
    q, data = layer.end_degree[side], layer.end_data[side]
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    note_gradient(layer, side, nodes, weights)
    rho_d = dirichlet_ghost(data[0], nodes[0], weights, q)
    u_d, T_d = layer.end_gradient[side]
    c2 = layer.gamma * layer.R * nodes[2, 1]
    c = np.sqrt(c2)
    if normal * data[1] <= -np.sqrt(layer.gamma * layer.R * data[2]):
        nodes[0, 0], nodes[1, 0], nodes[2, 0] = rho_d, u_d, T_d
        return
    if normal * data[1] >= 0.0 and normal * nodes[1, 1] >= c:
        return
    impedance = nodes[0, 1] * c
    p, p_d = layer.R * rho * T, layer.R * rho_d * T_d
    outgoing = p + normal * impedance * u
    incoming = p_d - normal * impedance * u_d
    entropy = rho - p / c2 if normal * data[1] >= 0.0 else rho_d - p_d / c2
    p = 0.5 * (incoming + outgoing)
    rho = entropy + p / c2
    nodes[0, 0] = rho
    nodes[1, 0] = normal * (outgoing - incoming) / (2.0 * impedance)
    nodes[2, 0] = p / (layer.R * rho)
