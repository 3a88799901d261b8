"""Linear elastic solid: Hooke's law for the small strain, for solutions that assume it.

    E = (F + F^T)/2 - 1,    W = lambda_e/2 tr(E)^2 + mu_e |E|^2 - p_ref (J - 1)
    P = dW/dF = lambda_e tr(E) + 2 mu_e E - p_ref cof F

A rotation is a strain for it, so that angular momentum is not conserved.
"""

from typing import NamedTuple

from fsipetsc.equations.tensors import (
    add_unit,
    cofactor,
    determinant_excess,
    outer,
    trace,
    transpose,
)
from fsipetsc.equations.vectors import add, along, dot, scale


class LinearElastic(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def small_strain(self, F):
        """E."""
        return add_unit(-1.0, scale(0.5, add(F, transpose(F))))

    def stress(self, F):
        """P [Pa]."""
        E = self.small_strain(F)
        hooke = add_unit(self.lambda_e * trace(E), scale(2.0 * self.mu_e, E))
        return along(hooke, -self.p_ref, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        E = self.small_strain(F)
        of_trace = 0.5 * self.lambda_e * trace(E) * trace(E)
        return of_trace + self.mu_e * dot(E, E) - self.p_ref * determinant_excess(F)

    def acoustic_tensor(self, F, N):
        """Q = mu_e + (lambda_e + mu_e) N N^T [Pa]."""
        return add_unit(self.mu_e, outer(scale(self.lambda_e + self.mu_e, N), N))

    def wave_modulus(self, F):
        """m0 c^2 = 2 mu_e + lambda_e [Pa]."""
        return 2.0 * self.mu_e + self.lambda_e
