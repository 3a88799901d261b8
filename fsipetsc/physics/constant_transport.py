"""Viscosity and heat conductivity that do not depend on the state.

A transport law says mu and kappa at a temperature T [K], of a number or a vector of points, over the mu and kappa that the
material names (those at a reference temperature, say). c is what ``constants`` has read of a layer or an interface.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA


@njit(**FORMULA)
def constants(record):
    """None."""
    return ()


@njit(**FORMULA)
def relative(c, T):
    """(mu(T)/mu, kappa(T)/kappa)."""
    return 1.0, 1.0


constant_transport = Formulas(constants=constants, relative=relative)
