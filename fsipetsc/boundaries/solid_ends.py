"""What can stand at an outer end of a solid layer: clamped, free, absorbing; insulated, or with given temperature or heat.

Each changes the end point only, like an interface treatment with nothing on the other side. With the impedance
Z = m0 c, c the speed of elastic waves, the characteristic that leaves through the end is (sigma - p) - n Z u. For Z the
stress sigma is that of the solid at rest beyond the end, given + p, so that a second application changes nothing.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.operators.kernels import OPTIONS, row_length
from fsipetsc.physics.layer import GIVEN_FLUX, GIVEN_T


@njit(**OPTIONS)
def wave_impedance(law, layer, T, p, sigma, x_X):
    """m0 times the speed of elastic waves in a solid of this temperature, pressure, stress and strain."""
    heat = layer.alpha * layer.m0
    return np.sqrt(law.pressing.wave_modulus(law.pressing.constants(layer), layer.K, heat, T, p, sigma, x_X) * layer.m0)


@njit(**OPTIONS)
def solid_end(law, layer, op, side, normal, kind, trace_s):
    """Apply the end condition to trace_s[0]; trace_s[j] = (u, sigma, T, x) counted inwards.

    end_data = (u) clamped, (sigma - p) free or absorbing. kind: 0 clamped, 1 free, 2 absorbing.
    """
    n = row_length(op)
    d = -normal / layer.h
    x_X, rest = 0.0, 0.0
    for j in range(n):
        x_X += d * op.closure[0, j] * trace_s[j, 3]
        if j > 0:
            rest += op.closure[0, j] * trace_s[j, 2]
    if layer.kappa_e > 0.0:
        thermal, heat = layer.end_thermal[side], layer.end_heat[side]
        if thermal == GIVEN_T:
            trace_s[0, 2] = heat
        else:
            slope = normal * heat * x_X / (layer.kappa_e * d) if thermal == GIVEN_FLUX else 0.0
            trace_s[0, 2] = (slope - rest) / op.closure[0, 0]
    T, c = trace_s[0, 2], law.pressing.constants(layer)
    p = law.pressing.pressure(c, T, x_X)
    given = layer.end_data[side, 0]
    if kind == 0:
        trace_s[0, 0] = given
    elif kind == 1:
        trace_s[0, 1] = given + p
    else:
        impedance = wave_impedance(law, layer, T, p, given + p, x_X)
        outgoing = trace_s[0, 1] - p - given - normal * impedance * trace_s[0, 0]
        trace_s[0, 0] = -normal * 0.5 * outgoing / impedance
        trace_s[0, 1] = given + p + 0.5 * outgoing
