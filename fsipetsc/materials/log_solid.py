"""The hyperelastic solid whose uniaxial stress is P = K ln F - p_ref, with K = 2 mu_e + lambda_e.

    W = mu_e/2 (|F|^2 - d - 2 ln J) + U(J)
    U = K (J ln J - J + 1) - mu_e ((J^2 - 1)/2 - ln J) - p_ref (J - 1)
    P = dW/dF = mu_e F + (K ln J - mu_e J - p_ref) cof F,    J = det F

With j = J - 1, W is computed as mu_e/2 (|F|^2 - d - (J^2 - 1)) + K (j ln J - (j - ln J)) - p_ref j,
whose parts are of second order near F = 1 and no differences of larger numbers.

In one dimension: B. Sjögreen and J. W. Banks (2012), (4.19).
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


class Log(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def stress(self, F):
        """P [Pa]."""
        J, j, K = determinant(F), determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        pull = K * np.log1p(j) - self.mu_e * J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        j, K = determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        rest = logarithm_rest(j, determinant(F))
        shear = 0.5 * self.mu_e * shear_excess(F)
        return shear + K * (j * (j - rest) - rest) - self.p_ref * j

    def acoustic_tensor(self, F, N):
        """Q = mu_e + (K/J - mu_e) a a^T [Pa], a = cof F N."""
        K, a = 2.0 * self.mu_e + self.lambda_e, apply(cofactor(F), N)
        return add_unit(self.mu_e, outer(scale(K / determinant(F) - self.mu_e, a), a))

    def wave_modulus(self, F):
        """Largest m0 c^2 [Pa]: mu_e + (K/J - mu_e) |cof F N|^2 in the direction N."""
        K = 2.0 * self.mu_e + self.lambda_e
        stiffening = np.maximum(K / determinant(F) - self.mu_e, 0.0)
        return self.mu_e + stiffening * largest_stretch(cofactor(F))
