"""Compressible neo-Hookean solid.

    W = mu_e/2 (|F|^2 - d - 2 ln J) + lambda_e/2 ln(J)^2 - p_ref (J - 1)
    P = dW/dF = mu_e F + ((lambda_e ln J - mu_e)/J - p_ref) cof F,    J = det F

With j = J - 1, |F|^2 - d - 2 ln J is computed as |F|^2 - d - (J^2 - 1) + j^2 + 2 (j - ln J), whose
parts are of second order near F = 1 and no differences of larger numbers.

P. Wriggers, Nonlinear Finite Element Methods (2008), section 3.3.
"""

from typing import NamedTuple

import numpy as np

from fsipetsc.equations.logarithm import logarithm_rest
from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    cofactor,
    determinant,
    determinant_excess,
    largest_stretch,
    outer,
    shear_excess,
)
from fsipetsc.equations.vectors import along, scale


class NeoHookean(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def stress(self, F):
        """P [Pa]."""
        J, j = determinant(F), determinant_excess(F)
        pull = (self.lambda_e * np.log1p(j) - self.mu_e) / J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        j = determinant_excess(F)
        rest = logarithm_rest(j, determinant(F))
        shear = 0.5 * self.mu_e * (shear_excess(F) + j * j + 2.0 * rest)
        return shear + 0.5 * self.lambda_e * (j - rest) * (j - rest) - self.p_ref * j

    def acoustic_tensor(self, F, N):
        """Q = mu_e + (lambda_e (1 - ln J) + mu_e)/J^2 a a^T [Pa], a = cof F N."""
        J, a = determinant(F), apply(cofactor(F), N)
        stiffening = (self.lambda_e * (1.0 - np.log(J)) + self.mu_e) / (J * J)
        return add_unit(self.mu_e, outer(scale(stiffening, a), a))

    def wave_modulus(self, F):
        """Largest m0 c^2 [Pa]: mu_e + (lambda_e (1 - ln J) + mu_e)/J^2 |cof F N|^2."""
        J = determinant(F)
        stiffening = (self.lambda_e * (1.0 - np.log(J)) + self.mu_e) / (J * J)
        return self.mu_e + np.maximum(stiffening, 0.0) * largest_stretch(cofactor(F))
