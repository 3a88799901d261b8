"""Compressible neo-Hookean solid.

    W = mu_e/2 (|F|^2 - d - 2 ln J) + lambda_e/2 ln(J)^2 - p_ref (J - 1)
    P = dW/dF = mu_e F + ((lambda_e ln J - mu_e)/J - p_ref) cof F,    J = det F

P. Wriggers, Nonlinear Finite Element Methods (2008), section 3.3.
"""

from typing import NamedTuple

from fsipetsc.equations.logarithm import log
from fsipetsc.equations.tensors import cofactor, determinant, invariant_excess, largest_stretch
from fsipetsc.operators.loops import along, scale


class NeoHookean(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def stress(self, F):
        """P [Pa]."""
        J = determinant(F)
        pull = (self.lambda_e * log(J) - self.mu_e) / J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        J = determinant(F)
        ln = log(J)
        shear = self.mu_e * (0.5 * invariant_excess(F) - ln)
        return shear + 0.5 * self.lambda_e * ln * ln - self.p_ref * (J - 1.0)

    def wave_modulus(self, F):
        """Largest m0 c^2 [Pa]: mu_e + (lambda_e (1 - ln J) + mu_e)/J^2 |cof F N|^2."""
        J = determinant(F)
        stiffening = max((self.lambda_e * (1.0 - log(J)) + self.mu_e) / (J * J), 0.0)
        return self.mu_e + stiffening * largest_stretch(cofactor(F))
