"""Laws of hyperelastic solids with Lamé's constants: the stress P = dW/dF [Pa], the energy W
[J/m3], the acoustic tensor Q [Pa] of waves along N, and a bound of its eigenvalues, the m0 c^2 of
waves in any direction; J = det F. Under the pressure p_ref F = 1.

Near F = 1 energies are of second order. They are computed of such parts, without differences of
larger numbers: j = J - 1, j - ln J, and |F|^2 - d - (J^2 - 1).
"""

from typing import NamedTuple

import numpy as np

from fsipetsc.equations import tensors
from fsipetsc.equations.elementary import logarithm_rest
from fsipetsc.equations.tensors import add_unit, apply, cofactor, determinant, outer, product
from fsipetsc.equations.vectors import add, along, dot, scale


class NeoHookean(NamedTuple):
    """The compressible neo-Hookean solid.

        W = mu_e/2 (|F|^2 - d - 2 ln J) + lambda_e/2 ln(J)^2 - p_ref (J - 1)
        P = mu_e F + ((lambda_e ln J - mu_e)/J - p_ref) cof F

    Waves along N have the acoustic tensor mu_e + s a a^T, a = cof F N, with

        s = (lambda_e (1 - ln J) + mu_e)/J^2

    P. Wriggers, Nonlinear Finite Element Methods (2008), section 3.3.
    """

    mu_e: float
    lambda_e: float
    p_ref: float

    def stress(self, F):
        J, j = determinant(F), tensors.determinant_excess(F)
        pull = (self.lambda_e * np.log1p(j) - self.mu_e) / J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        j = tensors.determinant_excess(F)
        rest = logarithm_rest(j, determinant(F))
        shear = 0.5 * self.mu_e * (tensors.shear_excess(F) + j * j + 2.0 * rest)
        return shear + 0.5 * self.lambda_e * (j - rest) * (j - rest) - self.p_ref * j

    def acoustic_tensor(self, F, N):
        a = apply(cofactor(F), N)
        return add_unit(self.mu_e, outer(scale(self._s(F), a), a))

    def wave_modulus(self, F):
        return self.mu_e + np.maximum(self._s(F), 0.0) * tensors.largest_stretch(cofactor(F))

    def _s(self, F):
        J, j = determinant(F), tensors.determinant_excess(F)
        return (self.lambda_e * (1.0 - np.log1p(j)) + self.mu_e) / (J * J)


class Log(NeoHookean):
    """A logarithmic law, with the uniaxial stress P = K ln F - p_ref, K = 2 mu_e + lambda_e.

        W = mu_e/2 (|F|^2 - d - 2 ln J) + K (J ln J - J + 1) - mu_e ((J^2 - 1)/2 - ln J)
            - p_ref (J - 1)
        P = mu_e F + (K ln J - mu_e J - p_ref) cof F,    s = K/J - mu_e

    In one dimension: B. Sjögreen and J. W. Banks (2012), (4.19).
    """

    def stress(self, F):
        J, j, K = determinant(F), tensors.determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        pull = K * np.log1p(j) - self.mu_e * J - self.p_ref
        return along(scale(self.mu_e, F), pull, cofactor(F))

    def energy(self, F):
        j, K = tensors.determinant_excess(F), 2.0 * self.mu_e + self.lambda_e
        rest = logarithm_rest(j, determinant(F))
        shear = 0.5 * self.mu_e * tensors.shear_excess(F)
        return shear + K * (j * (j - rest) - rest) - self.p_ref * j

    def _s(self, F):
        return (2.0 * self.mu_e + self.lambda_e) / determinant(F) - self.mu_e


class StVenantKirchhoff(NamedTuple):
    """Hooke's law for the strain of Green.

    W = lambda_e/2 tr(E)^2 + mu_e |E|^2 - p_ref (J - 1),    S = lambda_e tr(E) + 2 mu_e E
    E = (F^T F - 1)/2,    P = F S - p_ref cof F
    """

    mu_e: float
    lambda_e: float
    p_ref: float

    def _strain(self, F):
        return scale(0.5, tensors.twice_strain(F))

    def _hooke(self, F):
        """S [Pa]; of the strain of Green it is the second Piola–Kirchhoff stress."""
        E = self._strain(F)
        return add_unit(self.lambda_e * tensors.trace(E), scale(2.0 * self.mu_e, E))

    def stress(self, F):
        return along(product(F, self._hooke(F)), -self.p_ref, cofactor(F))

    def energy(self, F):
        E = self._strain(F)
        of_trace = 0.5 * self.lambda_e * tensors.trace(E) * tensors.trace(E)
        return of_trace + self.mu_e * dot(E, E) - self.p_ref * tensors.determinant_excess(F)

    def acoustic_tensor(self, F, N):
        """Q = N . S N + (lambda_e + mu_e) (F N) (F N)^T + mu_e F F^T [Pa]."""
        stretched = apply(F, N)
        along_it = outer(scale(self.lambda_e + self.mu_e, stretched), stretched)
        across = scale(self.mu_e, product(F, tensors.transpose(F)))
        return add_unit(dot(N, apply(self._hooke(F), N)), add(along_it, across))

    def wave_modulus(self, F):
        """K |F N|^2 + N . S N."""
        pull = tensors.largest_eigenvalue(self._hooke(F))
        return (2.0 * self.mu_e + self.lambda_e) * tensors.largest_stretch(F) + pull


class LinearElastic(StVenantKirchhoff):
    """Hooke's law for the small strain, E = (F + F^T)/2 - 1, P = S - p_ref cof F.

    A rotation is a small strain, so that angular momentum is not conserved: this law is for
    solutions that assume it.
    """

    def _strain(self, F):
        return add_unit(-1.0, scale(0.5, add(F, tensors.transpose(F))))

    def stress(self, F):
        return along(self._hooke(F), -self.p_ref, cofactor(F))

    def acoustic_tensor(self, F, N):
        return add_unit(self.mu_e, outer(scale(self.lambda_e + self.mu_e, N), N))

    def wave_modulus(self, F):
        return 2.0 * self.mu_e + self.lambda_e
