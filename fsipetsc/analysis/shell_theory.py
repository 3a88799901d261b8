"""Small radial motions of shells of elastic solid and gas around each other, exactly.

The displacement of a medium between two radii is that of compression waves, with k = omega/c_p,

    u = a j_1(k r) + b y_1(k r),    s_rr = (lambda + 2 mu) k (a j_0 + b y_0) - 2 kappa mu u/r

j_n and y_n are Bessel functions around an axis (kappa = 1), spherical ones around a centre (2). A
gas is such a medium as in fsipetsc.analysis.ring_theory, which has the conditions between media.
In what goes to r = 0 b is 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import jv, spherical_jn, spherical_yn, yv

from fsipetsc.analysis.ring_theory import Complex, Medium


@dataclass(frozen=True)
class RadialMedium(Medium):
    """A medium between two radii, the inner one perhaps 0."""

    kappa: int = 2

    @property
    def sticks(self) -> bool:
        """There are no motions but those along the radius."""
        return False

    def fields(self, n: int, omega: complex, r: float) -> Complex:
        """(4, 2): u, 0, s_rr, 0 of both functions; n is 0."""
        if r == 0.0:
            return np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]], complex)
        lame, mu = self.stiffness(omega)
        k = omega / np.sqrt((lame + 2.0 * mu) / self.density)
        of = (jv, yv) if self.kappa == 1 else (spherical_jn, spherical_yn)
        found = np.zeros((4, 2), complex)
        for column, f in enumerate(of):
            u = f(1, k * r)
            squeezed = (lame + 2.0 * mu) * k * f(0, k * r)
            found[:, column] = u, 0.0, squeezed - 2.0 * self.kappa * mu * u / r, 0.0
        return found
