"""St. Venant–Kirchhoff solid: Hooke's law for the strain of Green.

E = (F^T F - 1)/2,    S = lambda_e tr(E) + 2 mu_e E
W = lambda_e/2 tr(E)^2 + mu_e |E|^2 - p_ref (J - 1)
P = dW/dF = F S - p_ref cof F
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
    twice_strain,
)
from fsipetsc.equations.vectors import add, along, dot, scale


class StVenantKirchhoff(NamedTuple):
    """mu_e, lambda_e: Lamé's constants [Pa], p_ref: pressure under which F = 1 [Pa]."""

    mu_e: float
    lambda_e: float
    p_ref: float

    def strain(self, F):
        """E."""
        return scale(0.5, twice_strain(F))

    def second_stress(self, F):
        """S [Pa], the second Piola–Kirchhoff stress."""
        E = self.strain(F)
        return add_unit(self.lambda_e * trace(E), scale(2.0 * self.mu_e, E))

    def stress(self, F):
        """P [Pa]."""
        return along(product(F, self.second_stress(F)), -self.p_ref, cofactor(F))

    def energy(self, F):
        """W [J/m3]."""
        E = self.strain(F)
        of_trace = 0.5 * self.lambda_e * trace(E) * trace(E)
        return of_trace + self.mu_e * dot(E, E) - self.p_ref * determinant_excess(F)

    def acoustic_tensor(self, F, N):
        """Q = N . S N + (lambda_e + mu_e) (F N) (F N)^T + mu_e F F^T [Pa]."""
        stretched, pull = apply(F, N), dot(N, apply(self.second_stress(F), N))
        along_it = outer(scale(self.lambda_e + self.mu_e, stretched), stretched)
        across = scale(self.mu_e, product_transposed(F, F))
        return add_unit(pull, add(along_it, across))

    def wave_modulus(self, F):
        """Upper bound of m0 c^2 [Pa]: K |F N|^2 + N . S N."""
        pull = largest_eigenvalue(self.second_stress(F))
        return (2.0 * self.mu_e + self.lambda_e) * largest_stretch(F) + pull
