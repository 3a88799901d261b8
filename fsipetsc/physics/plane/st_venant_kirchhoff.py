"""The St. Venant–Kirchhoff solid: P = F S, S = lambda_e tr(E) I + 2 mu_e E, E = (F^T F - I)/2, less p_ref cof F.

Linear in Green's strain: for large rotations and small strains; under strong compression it gives way. The formulas are those
that ``log_solid`` lists.
"""

from __future__ import annotations

from numba import njit

from fsipetsc.operators.formulas import Formulas
from fsipetsc.operators.kernels import FORMULA


@njit(**FORMULA)
def constants(layer):
    """(mu_e, lambda_e, p_ref)."""
    return layer.mu_e, layer.lambda_e, layer.p_ref


@njit(**FORMULA)
def strain(F):
    """(E_11, E_12, E_22)."""
    f11, f12, f21, f22 = F
    return (
        0.5 * (f11 * f11 + f21 * f21 - 1.0),
        0.5 * (f11 * f12 + f21 * f22),
        0.5 * (f12 * f12 + f22 * f22 - 1.0),
    )


@njit(**FORMULA)
def second(c, F):
    """(S_11, S_12, S_22)."""
    e11, e12, e22 = strain(F)
    volumetric = c[1] * (e11 + e22)
    return 2.0 * c[0] * e11 + volumetric, 2.0 * c[0] * e12, 2.0 * c[0] * e22 + volumetric


@njit(**FORMULA)
def stress(c, F):
    """P."""
    f11, f12, f21, f22 = F
    s11, s12, s22 = second(c, F)
    p = c[2]
    return (
        f11 * s11 + f12 * s12 - p * f22,
        f11 * s12 + f12 * s22 + p * f21,
        f21 * s11 + f22 * s12 + p * f12,
        f21 * s12 + f22 * s22 - p * f11,
    )


@njit(**FORMULA)
def energy(c, F):
    """W."""
    f11, f12, f21, f22 = F
    e11, e12, e22 = strain(F)
    trace = e11 + e22
    return 0.5 * c[1] * trace * trace + c[0] * (e11 * e11 + 2.0 * e12 * e12 + e22 * e22) - c[2] * (f11 * f22 - f12 * f21 - 1.0)


@njit(**FORMULA)
def modulus(c, F, squared_x, squared_y):
    """No less than m0 c^2 of waves along X and along Y: N.S N + (lambda_e + mu_e) |F N|^2 + mu_e |F|^2."""
    f11, f12, f21, f22 = F
    s11, _, s22 = second(c, F)
    x, y = f11 * f11 + f21 * f21, f12 * f12 + f22 * f22
    shear = c[0] * (x + y)
    return s11 + (c[1] + c[0]) * x + shear, s22 + (c[1] + c[0]) * y + shear


st_venant_kirchhoff = Formulas(constants=constants, stress=stress, energy=energy, modulus=modulus)
