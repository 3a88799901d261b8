"""Hooke's law for the strain of Green (St. Venant–Kirchhoff), and for the small strain.

    W = lambda_e/2 tr(E)^2 + mu_e |E|^2 - p_ref (J - 1),    S = lambda_e tr(E) + 2 mu_e E
    Green    E = (F^T F - 1)/2,      P = dW/dF = F S - p_ref cof F
    small    E = (F + F^T)/2 - 1,    P = dW/dF = S - p_ref cof F

A rotation is a small strain, so that angular momentum is not conserved: that law is for solutions
that assume it.
"""

from typing import NamedTuple

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    cofactor,
    determinant_excess,
    largest_eigenvalue,
    largest_stretch,
    outer,
    product,
    product_transposed,
    trace,
    transpose,
    twice_strain,
)
from fsipetsc.equations.vectors import add, along, dot, scale


class StVenantKirchhoff(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def _strain(self, F):
        """E."""
        return scale(0.5, twice_strain(F))

    def _hooke(self, F):
        """S [Pa]; of the strain of Green it is the second Piola–Kirchhoff stress."""
        E = self._strain(F)
        return add_unit(self.lambda_e * trace(E), scale(2.0 * self.mu_e, E))

    def stress(self, F):
        """P [Pa]."""
        return along(product(F, self._hooke(F)), -self.p_ref, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        E = self._strain(F)
        of_trace = 0.5 * self.lambda_e * trace(E) * trace(E)
        return of_trace + self.mu_e * dot(E, E) - self.p_ref * determinant_excess(F)

    def acoustic_tensor(self, F, N):
        """Q = N . S N + (lambda_e + mu_e) (F N) (F N)^T + mu_e F F^T [Pa]."""
        stretched = apply(F, N)
        along_it = outer(scale(self.lambda_e + self.mu_e, stretched), stretched)
        across = scale(self.mu_e, product_transposed(F, F))
        return add_unit(dot(N, apply(self._hooke(F), N)), add(along_it, across))

    def wave_modulus(self, F):
        """Upper bound of m0 c^2 [Pa]: K |F N|^2 + N . S N."""
        pull = largest_eigenvalue(self._hooke(F))
        return (2.0 * self.mu_e + self.lambda_e) * largest_stretch(F) + pull


class LinearElastic(StVenantKirchhoff):
    """Its numbers and energy are those of StVenantKirchhoff, of the small strain."""

    def _strain(self, F):
        return add_unit(-1.0, scale(0.5, add(F, transpose(F))))

    def stress(self, F):
        return along(self._hooke(F), -self.p_ref, cofactor(F))

    def acoustic_tensor(self, F, N):
        """Q = mu_e + (lambda_e + mu_e) N N^T [Pa]."""
        return add_unit(self.mu_e, outer(scale(self.lambda_e + self.mu_e, N), N))

    def wave_modulus(self, F):
        """m0 c^2 = 2 mu_e + lambda_e [Pa]."""
        return 2.0 * self.mu_e + self.lambda_e
