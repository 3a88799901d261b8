"""The pressure of a solid p = G rho epsilon with epsilon = alpha T, rho = m0 / x_X; G = 0 is the purely elastic solid.

A law of pressure is formulas of numbers or of vectors of points; c is what ``constants`` has read of a layer or an
interface. T: temperature [K], stretch: 1/x_X.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA


@njit(**FORMULA)
def constants(record):
    """G m0 alpha of a layer or an interface."""
    return record.gruneisen * record.m0 * record.alpha


@njit(**FORMULA)
def pressure(c, T, stretch):
    """p [Pa]."""
    return c * T * stretch


gruneisen = Formulas(constants=constants, pressure=pressure)
