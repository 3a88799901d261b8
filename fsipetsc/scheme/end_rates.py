"""Rates of end points that are not what the closure of the operator makes of the fluxes. Compiled."""

from __future__ import annotations

from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.coupling.interface import row_length
from fsipetsc.operators.kernels import OPTIONS, ROW, U64


@njit(**OPTIONS)
def as_they_are(law, layer, op, s, w, v, f, target, side):
    """No rates are changed."""


@njit(**OPTIONS)
def keep_entropy(law, layer, op, s, w, v, f, target, side):
    """Without conduction the gas's end point at an interface is a particle that no heat reaches: it keeps its entropy.

    The rate of e is not the flux's but that of rho T S_t = tau u_X, tau = mu' u_X: with h = eps + p/rho,

        e_t = u (rho u)_t + (h - u^2/2) rho_t + tau u_X.

    Summation by parts no longer makes the change of energy there that of the flux: by the closure's error, which conservation
    does not notice in smooth flow. A shock that reflects at the point would leave it with the entropy before.
    The error that the closure of order s makes in the energy would stay: nothing carries it away from there.
    """
    if layer.end_kind[side] != INTERFACE_END or layer.kappa != 0.0:
        return
    end, stride = (layer.lo if side == 0 else layer.hi), layer.stride
    scale = -1.0 / layer.h
    rho_t, m_t = scale * end_slope(op, s, f + end, side), scale * end_slope(op, s, f + ROW + end, side)
    e_t, u_X = scale * end_slope(op, s, f + 2 * ROW + end, side), end_slope(op, s, v + end, side) / layer.h
    rho, gas = s[U64(w + end)], law.gas.constants(layer)
    u = s[U64(w + stride + end)] / rho
    internal = s[U64(w + 2 * stride + end)] / rho - 0.5 * u * u
    T = law.gas.temperature(gas, rho, internal)
    h = internal + law.gas.pressure(gas, rho, T) / rho
    heating = layer.mu * law.transport.relative(law.transport.constants(layer), T)[0] * u_X * u_X
    change = u * m_t + (h - 0.5 * u * u) * rho_t + heating - e_t
    at = 2 * target.stride + end
    s[U64(target.next + at)] += target.a * change
    if target.sum >= 0:
        s[U64(target.sum + at)] += target.b * change


@njit(**OPTIONS)
def end_slope(op, s, at, side):
    """h D at the end point s[at] of a row, of which no more is known, perhaps, than what this takes."""
    step, d = 1 - 2 * side, 0.0
    for c in range(row_length(op)):
        d += op.closure[0, c] * s[U64(at + step * c)]
    return step * d
