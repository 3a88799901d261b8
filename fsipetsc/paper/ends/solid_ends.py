"""Ends of a solid: clamped, free, or such that waves leave."""

from typing import NamedTuple

import numpy as np


class AtEnd(NamedTuple):
    """What is known of the end of a solid: velocity, sigma, p, temperature, x_X; what is given."""

    u: float
    sigma: float
    p: float
    T: float
    x_X: float
    given: float


def clamped_end(solid, end, n):
    """(u, sigma) where u is given."""
    return end.given, end.sigma


def free_end(solid, end, n):
    """(u, sigma) where sigma - p is given."""
    return end.u, end.given + end.p


def absorbing_end(solid, end, n):
    """(u, sigma) where sigma - p is given of the solid at rest beyond the end: the characteristic
    that leaves, sigma - p - n Z u, Z = m0 c, keeps its value.
    """
    u, sigma, p, T, x_X, given = end
    Z = np.sqrt(solid.wave_modulus(T, p, given + p, x_X) * solid.m0)
    w_o = sigma - p - given - n * Z * u
    return -n * 0.5 * w_o / Z, given + p + 0.5 * w_o
