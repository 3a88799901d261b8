"""Hyperelastic solid in Lagrangian coordinates X, for d = 1, 2, 3.

    D_t    = v,                              F = 1 + grad D,  J = det F
    m0 v_t = Div P + m0 b                    P = dW/dF - p(J, T) cof F
    m0 e_t = Div (P^T v + h) + m0 b . v,     h = kappa J F^-1 F^-T grad T

D = x - X: displacement, v: velocity, e: total energy per mass, b: body force per mass. With heat
'coupled', e = |v|^2/2 + alpha T: the work of the stresses becomes heat (Sjögreen and Banks 2012,
(3.1c)). With heat 'elastic', e = |v|^2/2 + W/m0 + alpha T: W is an energy of its own.

On a curved reference map X(xi) with A^k = J0 (dX/dxi)^-T e_k, J0 = det dX/dxi,

    F = 1 + 1/J0 sum_k D_k D A^k,   J0 m0 v_t = sum_k D_k (P A^k),   grad T = 1/J0 sum_k A^k D_k T

and the power of two nodes i, l in the direction k is (P_i A^k_i . v_l + P_l A^k_l . v_i)/2, which
together is v . D_k (P A^k) + P A^k . D_k v. Unknowns of a node: q = (D_1 … D_d, v_1 … v_d, e).

Around an axis (m = 1) or a centre (2) the last coordinate is a radius, r at R:

    F = (F of d dimensions, lambda),    lambda = r/R: the stretch of each of the m hoops
    m0 J0 v_t = sum_k D_k (P A^k) - J0 m/R P_o e_r,    A^k and J0 with the weight R^m

P_o is the last entry of the stress of an ordinary law, in m + d dimensions, at F and lambda[,
lambda] on the diagonal: in one dimension around an axis strain is plane. What the hoop stress takes
from the motion is stored or becomes heat at the node itself. Source: docs/derivation.md, Solid.
"""

from math import isqrt
from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations import tensors
from fsipetsc.equations.tensors import add_unit, apply, cofactor, determinant, outer, transpose
from fsipetsc.equations.vectors import add, along, dot, last_times, mean, scale
from fsipetsc.kernels.symbols import derivative


def pressure_slopes(law, *at):
    """dp/dJ [Pa] and dp/dT [Pa/K] of a law of pressure at (J, T, m0, alpha)."""
    return [derivative(law.pressure, at, way) for way in np.eye(4)[:2].tolist()]


class Solid(NamedTuple):
    """The equations for laws of stress and pressure and numbers.

    law, pressing: stress and pressure, as in fsipetsc.materials. m0: density at rest [kg/m3],
    alpha: specific heat [J/(kg K)], kappa: conductivity [W/(m K)], coupled: False with heat
    'elastic'. force: (d,) body force per mass [m/s2]. around: a zero for each hoop stretch, p_ref:
    pressure [Pa] on faces that is no part of the stress; both around an axis or a centre alone.

    Formulas take F with lambda as its last number, where there are hoops. N, v, gradients and what
    formulas return have d dimensions, unless they say otherwise: energy W [J/m3], volume J,
    temperature [K], pressures and stresses [Pa].
    """

    law: Any
    pressing: Any
    m0: float
    alpha: float
    kappa: float
    coupled: bool
    force: tuple[float, ...]
    around: Any = ()
    p_ref: float = 0.0

    def strains(self, d):
        """How many numbers F has in d dimensions."""
        return d * d + bool(self.around)

    def unstrained(self, d):
        """F at rest in d dimensions."""
        return (*add_unit(1.0, (0.0,) * d * d), *[1.0] * bool(self.around))

    def tensor(self, F):
        """F as a tensor of the dimensions that the law has, with hoops on the diagonal."""
        return tensors.bordered(F[:-1], F[-1], len(self.around)) if self.around else F

    def weight(self, x):
        """r^m of a place, of what weighs the last number of its area vectors."""
        m = len(self.around)
        return 1.0 if m == 0 else x[-1] if m == 1 else x[-1] * x[-1]

    def flat(self, x):
        """A place; around an axis or a centre (z, s), see fsipetsc.blocks.grid."""
        return last_times(self.weight(x) / (len(self.around) + 1), x)

    def with_hoops(self, F, D, R):
        """F with the hoop stretch, if any, from the displacement D and the radius R at rest."""
        return (*F, 1.0 + D[-1] / R) if self.around else F

    def with_hoop_force(self, acceleration, v, e, F, R):
        """An acceleration less m P_o/(R m0) along r."""
        P = self.full_stress(F, self.temperature(v, e, F))[-1]
        *others, along_r = acceleration
        return (*others, along_r - len(self.around) * P / (self.m0 * R))

    def curvature(self, R):
        """What hoop stress adds to the squared wave number that bounds a step [1/m2]: with it,
        omega dt of a node at R = h/2 is at most 2.7 for the longest step; RK4 allows 2.8.
        """
        return (0.5 * len(self.around) / R) ** 2

    def energy(self, F):
        return self.law.energy(self.tensor(F))

    def volume(self, F):
        return determinant(self.tensor(F))

    def temperature(self, v, e, F):
        stored = (1.0 - self.coupled) * self.energy(F) / self.m0
        return (e - 0.5 * dot(v, v) - stored) / self.alpha

    def pressure_at(self, J, T):
        return self.pressing.pressure(J, T, self.m0, self.alpha)

    def full_stress(self, strain, T):
        """P [Pa] in the dimensions of the law."""
        F = self.tensor(strain)
        return along(self.law.stress(F), -self.pressure_at(determinant(F), T), cofactor(F))

    def stress_at(self, F, T):
        d = isqrt(len(F))
        return tuple(entry for row in tensors.rows(self.full_stress(F, T))[:d] for entry in row[:d])

    def line_stress(self, F):
        """Stress of the law in one dimension [Pa]; around an axis or a centre Cauchy's."""
        stress = self.law.stress(self.tensor(F))[0]
        return stress * F[0] / self.volume(F) if self.around else stress

    def hoop_stress(self, F, T):
        """Cauchy stress of the hoops [Pa]."""
        return self.full_stress(F, T)[-1] * F[-1] / self.volume(F) - self.p_ref

    def heat_flux(self, F, gradient):
        """h = kappa/J (cof F)^T cof F grad T [W/m2]: minus the flux of heat, per area at rest."""
        C = cofactor(self.tensor(F))
        flux = apply(transpose(C), apply(C, (*gradient, *self.around)))
        return scale(self.kappa / self.volume(F), flux)[: len(gradient)]

    def wave_modulus_at(self, strain, T):
        """Upper bound of m0 c^2 [Pa], of waves along the stiffest direction at constant entropy."""
        F = self.tensor(strain)
        J, m0, alpha = determinant(F), self.m0, self.alpha
        area, P = tensors.largest_stretch(cofactor(F)), self.full_stress(strain, T)
        by_J, by_T = pressure_slopes(self.pressing, J, T, m0, alpha)
        pressed = (1.0 - self.coupled) * abs(self.pressure_at(J, T)) * area
        heats = self.coupled * np.sqrt(area * dot(P, P)) + pressed
        heating = abs(by_T) * heats / (m0 * alpha)
        return self.law.wave_modulus(F) + np.maximum(-by_J, 0.0) * area + heating

    def acoustic_tensor(self, strain, T, N):
        """Q [Pa] in the dimensions of the law, at constant entropy: waves along N move along its
        eigenvectors, and its eigenvalues are their m0 c^2.

            Q_ik = N_j N_l dP_ij/dF_kl - dp/dJ a_i a_k - dp/dT a_i t_k/(m0 alpha),    a = cof F N

        The work of t becomes heat: t = P N, with heat 'elastic' -p a alone. Returned is the
        symmetric part: Q has another one only where shear stress heats.
        """
        F, n = self.tensor(strain), (*N, *self.around)
        J, m0, alpha, a = determinant(F), self.m0, self.alpha, apply(cofactor(F), n)
        pressed = -(1.0 - self.coupled) * self.pressure_at(J, T)
        heats = along(scale(self.coupled, apply(self.full_stress(strain, T), n)), pressed, a)
        by_J, by_T = pressure_slopes(self.pressing, J, T, m0, alpha)
        b = along(scale(-by_J, a), -by_T / (m0 * alpha), heats)
        Q = add(self.law.acoustic_tensor(F, n), outer(a, b))
        return mean(Q, transpose(Q))

    def resistance(self, F, T, N, v):
        """Z v = sqrt(m0 Q) v [Pa]: the traction that waves along N have where they move with v."""
        root = tensors.square_root(scale(self.m0, self.acoustic_tensor(F, T, N)))
        return apply(root, (*v, *self.around))[: len(v)]
