"""The neo-Hookean solid: W = mu_e/2 (|F|^2 - 2 - 2 ln J) + lambda_e/2 (ln J)^2 - p_ref (J - 1).

The formulas are those that ``log_solid`` lists.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA
from fsipetsc.operators.logarithms import log_near_one


@njit(**FORMULA)
def constants(layer):
    """(mu_e, lambda_e, p_ref)."""
    return layer.mu_e, layer.lambda_e, layer.p_ref


@njit(**FORMULA)
def stress(c, F):
    """P = mu_e F + ((lambda_e ln J - mu_e)/J - p_ref) cof F."""
    f11, f12, f21, f22 = F
    mu, lam, p = c
    J = f11 * f22 - f12 * f21
    volumetric = (lam * log_near_one(J) - mu) / J - p
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
    mu, lam, p = c
    J = f11 * f22 - f12 * f21
    ln = log_near_one(J)
    shear = mu * (0.5 * (f11 * f11 + f12 * f12 + f21 * f21 + f22 * f22) - 1.0 - ln)
    return shear + 0.5 * lam * ln * ln - p * (J - 1.0)


@njit(**FORMULA)
def modulus(c, F, squared_x, squared_y):
    """Largest m0 c^2 of waves along X and along Y: mu_e + max(0, (lambda_e (1 - ln J) + mu_e)/J^2) |cof F N|^2."""
    f11, f12, f21, f22 = F
    mu, lam, _ = c
    J = f11 * f22 - f12 * f21
    curvature = max((lam * (1.0 - log_near_one(J)) + mu) / (J * J), 0.0)
    return mu + curvature * squared_x, mu + curvature * squared_y


neo_hookean = Formulas(constants=constants, stress=stress, energy=energy, modulus=modulus)
