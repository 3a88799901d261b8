"""What passes a face of a gas: F(U) = n . (f(U) - v U), v the velocity of the grid."""

import numpy as np

from fsipetsc.equations.vectors import along, mean, sub


def surface_flux(gas, w, n, g):
    """F(U) of the state w; g: n . v."""
    return along(gas.flux(w, n), -g, gas.densities(w))


def mixed_flux(gas, w, beyond, n, g):
    """1/2 (F(U_in) + F(U_out)) - 1/2 lambda (U_out - U_in), lambda = max over both of
    |n . (u - v)| + c |n| (local Lax-Friedrichs).
    """
    fastest = gas.fastest(w, n, g), gas.fastest(beyond, n, g)
    jump = sub(gas.densities(beyond), gas.densities(w))
    both = mean(surface_flux(gas, w, n, g), surface_flux(gas, beyond, n, g))
    return along(both, -0.5 * np.maximum(*fastest), jump)
