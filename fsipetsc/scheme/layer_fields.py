"""What is saved of the points of a layer. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from fsipetsc.boundaries import INTERFACE_END
from fsipetsc.operators.kernels import BLOCK, OPTIONS, U64, derivative, row

#: numbers that are saved of a point, in either kind of layer
SAVED = 5


@njit(**OPTIONS)
def fluid_fields(law, layer, op, s, w, scratch, out, at, stride):
    """rho, u, T, p and the Eulerian position x of the owned points; NaN where inactive.

    s, w, scratch: as in ``sweep``. What belongs to the first owned point goes to out[at:], to the next one to
    out[at + stride:], ...
    """
    gas, last = law.gas.constants(layer), layer.n - 1
    for i in range(layer.own_lo, layer.own_hi):
        inside = layer.lo <= i <= layer.hi
        mass = s[U64(w + i)] if inside else np.nan
        rho, u = mass / layer.J, s[U64(w + layer.stride + i)] / mass
        T = law.gas.temperature(gas, rho, s[U64(w + 2 * layer.stride + i)] / mass - 0.5 * u * u)
        if layer.stretched != 0:
            x = ((last - i) * layer.end_x[0] + i * layer.end_x[1]) / last
        else:
            interface = layer.lo if layer.end_kind[0] == INTERFACE_END else layer.hi
            x = (i - interface) * layer.h + layer.x_interface if inside else np.nan
        o = U64(at + (i - layer.own_lo) * stride)
        out[o], out[o + U64(1)], out[o + U64(2)], out[o + U64(3)], out[o + U64(4)] = rho, u, T, law.gas.pressure(gas, rho, T), x


@njit(**OPTIONS)
def solid_fields(law, layer, op, s, w, scratch, out, at, stride):
    """u, sigma, T, x and p of the owned points; see ``fluid_fields``."""
    pressing, heated, strain = law.pressing, law.pressing.constants(layer), scratch + row(0)
    for i0 in range(layer.own_lo, layer.own_hi, BLOCK):
        i1 = min(i0 + BLOCK, layer.own_hi)
        derivative(op, s, w + 3 * layer.stride + i0, i0, strain, i0, i0, i1, layer.lo, layer.hi, 1.0 / layer.h)
        for i in range(i0, i1):
            o = U64(at + (i - layer.own_lo) * stride)
            for c in range(4):
                out[o + U64(c)] = s[U64(w + c * layer.stride + i)]
            out[o + U64(4)] = pressing.pressure(heated, out[o + U64(2)], s[U64(strain + i - i0)])
