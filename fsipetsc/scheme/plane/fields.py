"""What is saved of a point in two dimensions: gas (rho, u, v, T, p, J, x, y), solid (u, v, T, s_xx, s_xy, s_yy, x, y).
Compiled.

s is Cauchy's stress, P F^T / J.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.kernels import OPTIONS, U64
from fsipetsc.operators.rows import across, along, at
from fsipetsc.physics.plane.gas import LINE_ROWS
from fsipetsc.physics.plane.layer import DOF
from fsipetsc.scheme.plane.look import blended
from fsipetsc.scheme.plane.sweep import last_needed, prepare_row

#: columns of a point
SAVED = 8


@njit(**OPTIONS)
def gas_fields(law, layer, op, s, place, y, X, out):
    """To out[row, column], of the points that are owned; X: of the columns held. The lines must stand in scratch."""
    gas, stride, low = law.gas.constants(layer), place.stride, place.lines
    high = low + LINE_ROWS * stride
    for j in range(layer.own_y[0], layer.own_y[1]):
        zeta = (layer.first_y + j) / (layer.ny - 1)
        for i in range(layer.own_x[0], layer.own_x[1]):
            n = (j * layer.width + i) * DOF
            J, r, m, k, e = y[U64(n)], y[U64(n + 1)], y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            u, v, rho = m / r, k / r, r / J
            T = law.gas.temperature(gas, rho, e / r - 0.5 * (u * u + v * v))
            point = out[j - layer.own_y[0], i - layer.own_x[0]]
            point[0], point[1], point[2], point[3], point[4], point[5] = rho, u, v, T, law.gas.pressure(gas, rho, T), J
            point[6], point[7] = X[i] + blended(s, low, high, i, zeta), blended(s, low, high, stride + i, zeta)


@njit(**OPTIONS)
def solid_fields(law, layer, op, s, place, y, X, out):
    """The same of a solid; X: of the columns held, and behind them Y of the rows held."""
    c, lo, hi = law.elastic.constants(layer), layer.end_y[0], layer.end_y[1]
    a, b, prepared, stride = layer.own_x[0], layer.own_x[1], 0, place.stride
    for j in range(layer.own_y[0], layer.own_y[1]):
        while prepared <= min(last_needed(op, j, lo, hi), layer.height - 1):
            prepare_row(law, layer, s, place, y, prepared)
            prepared += 1
        for k in range(2):
            to = place.slopes + 2 * k * stride
            along(op, s, at(place.v, k, j), to, a, b, layer.end_x[0], layer.end_x[1], 1.0 / layer.h_x)
            across(op, s, place.v, k, j, to + stride, a, b, lo, hi, 1.0 / layer.h_y)
        for i in range(a, b):
            n, d = (j * layer.width + i) * DOF, place.slopes + i
            f11, f12 = 1.0 + s[U64(d)], s[U64(d + stride)]
            f21, f22 = s[U64(d + 2 * stride)], 1.0 + s[U64(d + 3 * stride)]
            p11, p12, p21, p22 = law.elastic.stress(c, (f11, f12, f21, f22))
            J = f11 * f22 - f12 * f21
            point = out[j - layer.own_y[0], i - a]
            point[0], point[1], point[2] = y[U64(n + 2)], y[U64(n + 3)], y[U64(n + 4)]
            point[3], point[5] = (p11 * f11 + p12 * f12) / J, (p21 * f21 + p22 * f22) / J
            point[4] = (p11 * f21 + p12 * f22) / J
            point[6], point[7] = X[i] + y[U64(n)], X[layer.width + j] + y[U64(n + 1)]
