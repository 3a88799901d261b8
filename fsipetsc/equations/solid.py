"""Hyperelastic solid in Lagrangian coordinates X, for d = 1, 2, 3.

    D_t    = v,                              F = 1 + grad D,  J = det F
    m0 v_t = Div P + m0 b                    P = dW/dF - p(J, T) cof F
    m0 e_t = Div (P^T v + h) + m0 b . v,     h = kappa J F^-1 F^-T grad T

D = x - X: displacement, v: velocity, e: total energy per mass, b: body force per mass. With heat
'coupled', e = |v|^2/2 + alpha T: the work of the stresses becomes heat (Sjögreen and Banks 2012,
(3.1c)). With heat 'elastic', e = |v|^2/2 + W/m0 + alpha T: W is an energy of its own. These are
different solids. e is linear in what is conserved, so that every Runge–Kutta method conserves it; T
follows from it.

On a curved reference map X(xi) with A^k = J0 (dX/dxi)^-T e_k, J0 = det dX/dxi,

    F = 1 + 1/J0 sum_k D_k D A^k,   J0 m0 v_t = sum_k D_k (P A^k),   grad T = 1/J0 sum_k A^k D_k T

and the power of two nodes i, l in the direction k is (P_i A^k_i . v_l + P_l A^k_l . v_i)/2, which
together is v . D_k (P A^k) + P A^k . D_k v. Unknowns of a node: q = (D_1 … D_d, v_1 … v_d, e).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.tensors import (
    add_unit,
    apply,
    apply_transposed,
    cofactor,
    determinant,
    largest_stretch,
    outer,
)
from fsipetsc.operators.loops import along, dot, scale

#: step of differences of a pressure, which only the wave modulus takes
STEP = 2.0**-17


class Solid(NamedTuple):
    """The equations for laws of stress and pressure and numbers.

    law, pressing: stress and pressure, as in fsipetsc.materials. m0: density at rest [kg/m3],
    alpha: specific heat [J/(kg K)], kappa: conductivity [W/(m K)], coupled: 1, or 0 with heat
    'elastic'. force: (d,) body force per mass [m/s2].
    """

    law: Any
    pressing: Any
    m0: float
    alpha: float
    kappa: float
    coupled: float
    force: tuple[float, ...]

    def unstrained(self, like):
        """F at rest, for as many numbers as `like` has dimensions."""
        return add_unit(1.0, outer(like, like))

    def in_space(self):
        """The equations of full tensors."""
        return self

    def hoops(self):
        """How many hoop stretches F has."""
        return 0

    def hoop_stretch(self, D, A):
        """None."""
        return 1.0

    def hoop_acceleration(self, F, T, A):
        """None."""
        return 0.0

    def energy(self, F):
        """W [J/m3]."""
        return self.law.energy(F)

    def volume(self, F):
        """J."""
        return determinant(F)

    def line_stress(self, F):
        """Stress of the law in one dimension [Pa]."""
        return self.law.stress(F)[0]

    def temperature(self, v, e, F):
        """T [K]."""
        stored = (1.0 - self.coupled) * self.law.energy(F) / self.m0
        return (e - 0.5 * dot(v, v) - stored) / self.alpha

    def total_energy(self, v, T, F):
        """e [J/kg]."""
        stored = (1.0 - self.coupled) * self.law.energy(F) / self.m0
        return 0.5 * dot(v, v) + stored + self.alpha * T

    def pressure_at(self, J, T):
        """p [Pa]."""
        return self.pressing.pressure(J, T, self.m0, self.alpha)

    def stress_at(self, F, T):
        """P [Pa]."""
        return along(self.law.stress(F), -self.pressure_at(determinant(F), T), cofactor(F))

    def heat_flux(self, F, gradient):
        """h = kappa/J (cof F)^T cof F grad T [W/m2]: minus the flux of heat, per area at rest."""
        C = cofactor(F)
        return scale(self.kappa / determinant(F), apply_transposed(C, apply(C, gradient)))

    def wave_modulus_at(self, F, T):
        """Upper bound of m0 c^2 [Pa], of waves along the stiffest direction at constant entropy."""
        J, m0, alpha = determinant(F), self.m0, self.alpha
        area = largest_stretch(cofactor(F))
        dJ, dT = STEP * J, STEP * (1.0 + abs(T))
        p = self.pressing.pressure(J, T, m0, alpha)
        by_J = (self.pressing.pressure(J + dJ, T, m0, alpha) - p) / dJ
        by_T = (self.pressing.pressure(J, T + dT, m0, alpha) - p) / dT
        P = self.stress_at(F, T)
        heating = abs(by_T) * np.sqrt(area * dot(P, P)) / (m0 * alpha)
        return self.law.wave_modulus(F) + max(-by_J, 0.0) * area + heating
