"""The law whose uniaxial stress is the paper's: P = K ln F - p_ref, K = 2 mu_e + lambda_e, that of (4.19).

    W = mu_e/2 (|F|^2 - 2 - 2 ln J) + U(J),    U'(J) = K ln J - mu_e (J - 1/J) - p_ref

A law is formulas of numbers or vectors of points; F = (F_11, F_12, F_21, F_22), P likewise; c: what ``constants`` has read.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.logarithms import log_near_one


@njit(**FORMULA)
def constants(layer):
    """(mu_e, K, p_ref)."""
    return layer.mu_e, 2.0 * layer.mu_e + layer.lambda_e, layer.p_ref


@njit(**FORMULA)
def stress(c, F):
    """P = mu_e F + (U'(J) - mu_e/J) cof F."""
    f11, f12, f21, f22 = F
    mu, K, p = c
    J = f11 * f22 - f12 * f21
    volumetric = K * log_near_one(J) - mu * J - p  # + mu/J - mu/J
    return (
        mu * f11 + volumetric * f22,
        mu * f12 - volumetric * f21,
        mu * f21 - volumetric * f12,
        mu * f22 + volumetric * f11,
    )


@njit(**FORMULA)
def energy(c, F):
    """W."""
    f11, f12, f21, f22 = F
    mu, K, p = c
    J = f11 * f22 - f12 * f21
    ln = log_near_one(J)
    of_J = K * (J * ln - J + 1.0) - mu * (0.5 * (J * J - 1.0) - ln) - p * (J - 1.0)
    return mu * (0.5 * (f11 * f11 + f12 * f12 + f21 * f21 + f22 * f22) - 1.0 - ln) + of_J


@njit(**FORMULA)
def modulus(c, F, squared_x, squared_y):
    """Largest m0 c^2 of waves along X and along Y: mu_e + max(0, g''(J)) |cof F N|^2, g = U - mu_e ln J; |cof F N|^2 are
    given.
    """
    f11, f12, f21, f22 = F
    mu, K, _ = c
    curvature = max(K / (f11 * f22 - f12 * f21) - mu, 0.0)
    return mu + curvature * squared_x, mu + curvature * squared_y


log_solid = Formulas(constants=constants, stress=stress, energy=energy, modulus=modulus)
