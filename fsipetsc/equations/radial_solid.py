"""Solid around an axis (kappa = 1) or a centre (2): x(X) is a radius, R = X.

    F = (dx/dR, lambda),    lambda = x/R: the stretch of each of the kappa hoops
    m0 A v_t = D(A P_r) - kappa A/R P_o,    A = R^kappa

P_r and P_o are the first and the last entry on the diagonal of the stress of an ordinary law, in
kappa + 1 dimensions, at diag(dx/dR, lambda[, lambda]): around an axis strain is plane. What the
hoop stress takes from the motion is stored or becomes heat at the node itself, so that it does not
change e. Rest is F = 1 to the last bit. Source: SCHEME-BLOCKS.md, section 6.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fsipetsc.equations.solid import Solid
from fsipetsc.equations.tensors import determinant
from fsipetsc.operators.loops import _by_length as by_length


def _diagonal(hoops: int) -> str:
    """Source of diag(first, other, …) with so many others."""
    d = hoops + 1
    entries = [
        "first" if i == j == 0 else "other" if i == j else "0.0 * first"
        for i in range(d)
        for j in range(d)
    ]
    return f" return ({', '.join(entries)})"


#: the tensor diag(first, other) or diag(first, other, other), by the length of around
diagonal = by_length("diagonal", "around, first, other", _diagonal)


class RadialSolid(NamedTuple):
    """solid: the equations in kappa + 1 dimensions, without p_ref, which is a pressure on faces.
    around: kappa zeros. m0 … force: as of a Solid in one dimension.
    """

    solid: Solid
    around: Any
    p_ref: float
    m0: float
    alpha: float
    kappa: float
    coupled: float
    force: tuple[float, ...]

    def unstrained(self, like):
        """F at rest."""
        return (1.0, 1.0)

    def in_space(self):
        """The equations of full tensors."""
        return self.solid

    def hoops(self):
        """How many hoop stretches there are beside dx/dR; F has one, for all are equal."""
        return len(self.around)

    def tensor(self, F):
        """diag(dx/dR, lambda) or diag(dx/dR, lambda, lambda)."""
        return diagonal(self.around, F[0], F[1])

    def hoop_stretch(self, D, A):
        """lambda from the displacement D and A = R^kappa."""
        return 1.0 + D / (A if len(self.around) == 1 else np.sqrt(A))

    def hoop_acceleration(self, F, T, A):
        """-kappa P_o/(R m0)."""
        kappa = len(self.around)
        P = self.solid.stress_at(self.tensor(F), T)[-1]
        return -kappa * P / (self.m0 * (A if kappa == 1 else np.sqrt(A)))

    def hoop_stress(self, F, T):
        """Cauchy stress of the hoops [Pa]."""
        return self.solid.stress_at(self.tensor(F), T)[-1] * F[1] / self.volume(F) - self.p_ref

    def energy(self, F):
        """W [J/m3]."""
        return self.solid.law.energy(self.tensor(F))

    def volume(self, F):
        """J."""
        return determinant(self.tensor(F))

    def line_stress(self, F):
        """Cauchy stress of the law along the radius [Pa]."""
        P = self.solid.law.stress(self.tensor(F))[0]
        return P * F[0] / self.volume(F) - self.p_ref

    def temperature(self, v, e, F):
        """T [K]."""
        return self.solid.temperature(v, e, self.tensor(F))

    def total_energy(self, v, T, F):
        """e [J/kg]."""
        return self.solid.total_energy(v, T, self.tensor(F))

    def pressure_at(self, J, T):
        """p [Pa]."""
        return self.solid.pressure_at(J, T)

    def stress_at(self, F, T):
        """P_r [Pa]."""
        return (self.solid.stress_at(self.tensor(F), T)[0],)

    def heat_flux(self, F, gradient):
        """kappa J/F_r^2 dT/dR."""
        return (self.solid.heat_flux(self.tensor(F), (gradient[0], *self.around))[0],)

    def wave_modulus_at(self, F, T):
        """Upper bound of m0 c^2 [Pa]."""
        return self.solid.wave_modulus_at(self.tensor(F), T)
