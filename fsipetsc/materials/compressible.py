"""Hyperelastic solids of the invariants |F|^2 and J = det F: neo-Hookean, and with a logarithm.

Both have P = dW/dF = mu_e F + (…) cof F, and waves along N have the acoustic tensor mu_e + s a a^T,
a = cof F N. The compressible neo-Hookean solid is

    W = mu_e/2 (|F|^2 - d - 2 ln J) + lambda_e/2 ln(J)^2 - p_ref (J - 1)
    P = mu_e F + ((lambda_e ln J - mu_e)/J - p_ref) cof F,    s = (lambda_e (1 - ln J) + mu_e)/J^2

With j = J - 1, |F|^2 - d - 2 ln J is computed as |F|^2 - d - (J^2 - 1) + j^2 + 2 (j - ln J), whose
parts are of second order near F = 1 and no differences of larger numbers.
P. Wriggers, Nonlinear Finite Element Methods (2008), section 3.3.

That with a logarithm has the uniaxial stress P = K ln F - p_ref, K = 2 mu_e + lambda_e:

    W = mu_e/2 (|F|^2 - d - 2 ln J) + K (J ln J - J + 1) - mu_e ((J^2 - 1)/2 - ln J) - p_ref (J - 1)
    P = mu_e F + (K ln J - mu_e J - p_ref) cof F,    s = K/J - mu_e

W is computed as mu_e/2 (|F|^2 - d - (J^2 - 1)) + K (j ln J - (j - ln J)) - p_ref j.
In one dimension: B. Sjögreen and J. W. Banks (2012), (4.19).
"""

from typing import NamedTuple

import numpy as np

from fsipetsc.equations.elementary import logarithm_rest
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

    def _s(self, F):
        J = determinant(F)
        return (self.lambda_e * (1.0 - np.log(J)) + self.mu_e) / (J * J)

    def acoustic_tensor(self, F, N):
        """mu_e + s a a^T [Pa], a = cof F N."""
        a = apply(cofactor(F), N)
        return add_unit(self.mu_e, outer(scale(self._s(F), a), a))

    def wave_modulus(self, F):
        """The largest m0 c^2 [Pa] of waves in any direction."""
        return self.mu_e + np.maximum(self._s(F), 0.0) * largest_stretch(cofactor(F))


class Log(NeoHookean):
    """Its numbers and waves are those of NeoHookean, with another s."""

    def stress(self, F):
        J, j, K = determinant(F), determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        pull = K * np.log1p(j) - self.mu_e * J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        j, K = determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        rest = logarithm_rest(j, determinant(F))
        shear = 0.5 * self.mu_e * shear_excess(F)
        return shear + K * (j * (j - rest) - rest) - self.p_ref * j

    def _s(self, F):
        return (2.0 * self.mu_e + self.lambda_e) / determinant(F) - self.mu_e
