"""Pressures of solids p(J, T) [Pa], J = det F, which add -p cof F to the stress. m0: density at
rest [kg/m3], alpha: specific heat [J/(kg K)]. Their derivatives follow from them.
"""

from typing import NamedTuple

from fsipetsc.checks import NONNEGATIVE, POSITIVE, number


class NoPressure(NamedTuple):
    """The stress is that of the solid's law alone."""

    def pressure(self, J, T, m0, alpha):
        return 0.0


class gruneisen(NamedTuple):
    """Grüneisen's pressure, for `ElasticSolid(pressing=…)`: p = G rho alpha T, rho = m0/J.

    Args:
        G: Grüneisen's number.
    """

    G: float

    def ranges(self):
        return (NONNEGATIVE,)

    def pressure(self, J, T, m0, alpha):
        return self.G * m0 * alpha * T / J


class mie_gruneisen(NamedTuple):
    """Mie and Grüneisen's pressure, for `pressing=…`. Alone it has shocks of the speed
    u_s = c_0 + s u_p, and the bulk modulus: let K be 4/3 mu_e, or lambda_e = -2/3 mu_e.

    With eta = 1 - J, for -1/s < eta < 1/s, and p_H = m0 c_0^2 eta/(1 - s eta)^2:
    p = p_H (1 - G_0 eta/2) + G_0 m0 alpha (T - T_0).

    Source: M. A. Meyers, Dynamic Behavior of Materials (1994), chapters 4 and 5.

    Args:
        c_0: speed of weak shocks [m/s].
        s: slope of the Hugoniot, not below G_0/4, so that compression stiffens.
        G_0: Grüneisen's number at rest.
        T_0: temperature ahead of the shocks [K].
    """

    c_0: float
    s: float
    G_0: float
    T_0: float

    def ranges(self):
        G_0 = number(self.G_0, "mie_gruneisen: G_0", NONNEGATIVE)
        return POSITIVE, f"not below {G_0 / 4.0:.17g}", NONNEGATIVE, POSITIVE

    def pressure(self, J, T, m0, alpha):
        eta = 1.0 - J
        room = 1.0 - self.s * eta
        hugoniot = m0 * self.c_0 * self.c_0 * eta / (room * room)
        heated = self.G_0 * m0 * alpha * (T - self.T_0)
        return hugoniot * (1.0 - 0.5 * self.G_0 * eta) + heated
