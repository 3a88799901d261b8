"""What is saved of a point in two dimensions: gas (rho, u, v, T, p, J, x, y), solid (u, v, T, s_xx, s_xy, s_yy, x, y).
Compiled.

s is Cauchy's stress, P F^T / J.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.rows import STRIDE
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.look import strain_row
from fsipetsc.scheme.plane.sweep import block_width, place_of

#: columns of a point
SAVED = 8


@njit(**OPTIONS)
def gas_fields(law, layer, y, lines, X, out):
    """To out[row, column], of the points that are owned; X: of the columns held."""
    gas = law.gas.constants(layer)
    for j in range(layer.own_y[0], layer.own_y[1]):
        zeta = (layer.first_y + j) / (layer.ny - 1)
        for i in range(layer.own_x[0], layer.own_x[1]):
            n = (j * layer.width + i) * DOF
            J, r, m, k, e = y[U64(n)], y[U64(n + 1)], y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            u, v, rho = m / r, k / r, r / J
            T = law.gas.temperature(gas, rho, e / r - 0.5 * (u * u + v * v))
            point = out[j - layer.own_y[0], i - layer.own_x[0]]
            point[0], point[1], point[2], point[3], point[4], point[5] = rho, u, v, T, law.gas.pressure(gas, rho, T), J
            point[6] = X[i] + (lines[0, 0, i] + zeta * (lines[1, 0, i] - lines[0, 0, i]))
            point[7] = lines[0, 1, i] + zeta * (lines[1, 1, i] - lines[0, 1, i])


@njit(**OPTIONS)
def solid_fields(law, layer, op, s, y, X, out):
    """The same of a solid; X: of the columns held, and behind them Y of the rows held."""
    for first in range(layer.own_x[0], layer.own_x[1], block_width(layer)):
        block_of_fields(law, layer, op, s, place_of(layer, first), y, X, out)


@njit(**OPTIONS)
def block_of_fields(law, layer, op, s, place, y, X, out):
    """Those of a block of a solid."""
    c, prepared = law.elastic.constants(layer), 0
    for j in range(layer.own_y[0], layer.own_y[1]):
        prepared = strain_row(law, layer, op, s, place, y, j, prepared)
        for i in range(place.first, place.end):
            n, d = (j * layer.width + i) * DOF, place.slopes + i
            f11, f12 = 1.0 + s[U64(d)], s[U64(d + STRIDE)]
            f21, f22 = s[U64(d + 2 * STRIDE)], 1.0 + s[U64(d + 3 * STRIDE)]
            p11, p12, p21, p22 = law.elastic.stress(c, (f11, f12, f21, f22))
            J = f11 * f22 - f12 * f21
            point = out[j - layer.own_y[0], i - layer.own_x[0]]
            point[0], point[1], point[2] = y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            point[3], point[5] = (p11 * f11 + p12 * f12) / J, (p21 * f21 + p22 * f22) / J
            point[4] = (p11 * f21 + p12 * f22) / J
            point[6], point[7] = X[i] + y[U64(n)], X[layer.width + j] + y[U64(n + 1)]
