"""Adiabatic no-slip wall as an embedded boundary: u = 0 and T_X = 0 at x_w.

Only what the condition gives is overwritten at the ghost point: u by the Dirichlet formula (4.26), T by a
Neumann formula. The outgoing characteristic p + n Z u, Z = rho c, keeps its value and gives the pressure.
(A ghost point with extrapolated density, or with all variables prescribed, makes the scheme unstable.)

Temperature. The heat flux is D T, D acts on it once more, and D is exact to degree s only in its closure, s = 1, 2, 3, 4:
its error e_j on x^(s+1)/(s+1)! is as good as a heat flux through the wall of order s, whatever the degree of the
formula for T at the ghost point. But the semi-discrete solution near the wall is T + E h^(s+1) T^(s+1) with D E = -e, E
constant but for the shortest wave far inside; for it the flux is right. So the formula is made to fit this, not T:

    sum_k (s_k + sum_q eta_q b_qk) T_k = 0,      s_k slopes at the wall of degree s, b_qk = (-1)^k binomial(q, k)

with one eta, of q = s + 1, such that 1, (x - x_w)^2, ..., (x - x_w)^s, (x - x_w)^(s+1)/(s+1)! + E obey it; as e is a number
per operator, eta is a polynomial in delta, in ETA. It is a damped formula as (4.26) is: where the grid runs away from the
wall, and the ghost point's T comes in with the gas, the shortest wave grows by 0.00 to 0.13 in its logarithm with each
point that the wall passes, with the undamped formula of degree s + 1 by 0.2 to 1.1. For 8/4 E is so large that it alone
decides the formula with q = 5, and the growth is 0.2; with three differences, whose eta are fits of degree 2 to the
formula of degree 4 with the least sum of squares, it is 0.02. The order in T is 2, 3, 4 and, for 8/4, 3.6 to 5.6.

With narrow second derivatives (fsipetsc.operators.narrow) E is another one, D2 E = -(D2 x^(s+1)/(s+1)! - x^(s-1)/(s-1)!),
falling off inside, where no wave is left that nothing damps. For 2/1 it gives the same formula, and for even s E cancels; 8/4
reaches the order 5. For 6/3 eta is the polynomial in ETA_NARROW; with that for D twice the order would be 3.

Velocity. Degree 2: higher ones let sound grow where the viscosity is not resolved, 3 twice to four times as fast.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, dirichlet_ghost, lagrange, neumann_ghost

#: degree of the extrapolation that fills a new point, and of the formula for u
NEW_POINT, DEGREE = 2, 2
#: by s, and for q = s + 1, s + 2, s + 3: coefficients of eta_q in powers of delta
ETA = np.zeros((4, 3, 4))
ETA[0, 0, :2] = 0.0, 0.5
ETA[1, 0, :3] = 0.0882352941176471, 0.0883801777493091, -0.1766154718669562
ETA[2, 0] = 0.2222164620745679, -0.4850917636042938, 0.1267629370385567, 0.0198481621891904
ETA[3, :, :3] = (1.267, -2.9, 1.178), (-0.888, 1.872, -0.677), (0.193, -0.389, 0.131)
#: with narrow second derivatives
ETA_NARROW = ETA.copy()
ETA_NARROW[2, 0] = 0.2289158450015872, -0.4914033185443774, 0.1207498614024324, 0.0225285974796345


@njit(**OPTIONS)
def insulated_slopes(delta, s, narrow, slopes):
    """Turn slopes of degree s at delta into the weights of the formula for T; returns how many nodes inside it has.

    narrow: 1 where second derivatives are, 0 for D twice.
    """
    last = s + 3 if s == 4 else s + 1
    for k in range(s + 1, last + 1):
        slopes[k] = 0.0
    for q in range(s + 1, last + 1):
        eta, binomial = 0.0, 1.0
        for power in range(3, -1, -1):
            eta = eta * delta + (ETA_NARROW if narrow else ETA)[s - 1, q - s - 1, power]
        for k in range(q + 1):
            slopes[k] += eta * binomial
            binomial *= -(q - k) / (k + 1.0)
    return last


@njit(**OPTIONS)
def wall(law, layer, op, side, normal, delta, nodes, weights, slopes):
    """Fill the ghost values nodes[:, 0] of (rho, u, T) from nodes[:, 1:]; normal is -1 left, +1 right."""
    gas, c = law.gas, law.gas.constants(layer)
    rho, u, T = nodes[0, 0], nodes[1, 0], nodes[2, 0]
    impedance = rho * np.sqrt(gas.sound_speed_squared(c, rho, T))
    u_g = dirichlet_ghost(0.0, nodes[1], weights, layer.end_degree[side])
    p_g = gas.pressure(c, rho, T) - normal * impedance * (u_g - u)
    lagrange(delta, op.p, weights, slopes)
    T_g = neumann_ghost(nodes[2], slopes, insulated_slopes(delta, op.p, op.narrow, slopes))
    nodes[0, 0] = gas.density(c, p_g, T_g)
    nodes[1, 0] = u_g
    nodes[2, 0] = T_g
