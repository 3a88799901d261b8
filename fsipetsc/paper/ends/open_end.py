"""An open end: sound leaves it, and none comes in. docs/open-end.md says why each formula is as it
is, with measurements.
"""

import numpy as np

from fsipetsc.equations.vectors import choose
from fsipetsc.kernels.loops import number
from fsipetsc.paper.ends.end import GasEnd

#: order 1 of an open end fades out where viscosity is this fraction of c0 L; q_nn = 0 where alpha
#: is this fraction of a L
LONGEST = 0.25


class OpenEnd(GasEnd):
    """Towards gas of p0, T0 and velocity u0; end_data = (p0, T0, u0, order)."""

    new = 1

    @staticmethod
    def ghost(part, layer, side, n, nodes):
        """Towards gas of p0, T0 and velocity u0: no sound comes in, up to order 0 or 1 in the
        viscosity; on outflow the entropy keeps its value, on inflow it is that of the gas beyond.
        """
        gas, (p0, T0, u0) = part.law, (layer.end_data[side, c] for c in range(3))
        rho0, c0, tau, alpha, by_heat, b, kappa, of_1 = gas_beyond(gas, layer, side)
        (rho, u, T), (rho1, u1, T1), (rho2, _, T2) = ([of[k] for of in nodes] for k in range(3))
        v1, c2 = n * (u1 - u0), gas.law.sound_speed_squared(rho1, T1)
        p, p1 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1)
        Z, scale, m = rho1 * np.sqrt(c2), rho0 * c0 * c0 / gas.gamma, 0.5 - 0.5 / gas.gamma
        # Z v (1 + by_v) = simple wave + by_p (p - p0) + known
        by = of_1 / (rho0 * c0 * layer.h)
        by_v, by_p = by * np.maximum(b, 0.0), by * np.maximum(-b, 0.0)
        q_n = (T1 - T2 - tau * (p1 - gas.law.pressure(rho2, T2))) / layer.h
        heat = carried(layer, n * u1, alpha, of_1) * by_heat * kappa / (rho0 * c0) * q_n
        known = by_v * rho0 * c0 * v1 - by_p * (p1 - p0) + np.where(kappa > 0.0, heat, 0.0)
        # with p + n Z u, a quadratic equation for y, the pressure of the wave in units of scale
        share, rise, fall = Z / (rho0 * c0 * (1.0 + by_v)), (1.0 + m) / 6.0, (2.0 - m) / 3.0
        w_o = p - p0 + Z * n * (u - u0)
        free, wave = 1.0 + share * by_p, (w_o - share * known) / scale
        half = 0.5 * (free + share - fall * wave)
        y = wave / (half + np.sqrt(half * half + (free * fall + share * rise) * wave))
        sound = scale * y
        u_G = u0 + n * (w_o - sound) / Z
        in_, out = rho0 * (1.0 + y) ** (1.0 / gas.gamma), rho + (p0 + sound - p) / c2
        rho_G = np.where(n * u_G >= 0.0, out, in_)
        slow = rho_G, u_G, gas.law.temperature_of(rho_G, p0 + sound)
        slow = choose(n * u0 <= -c0, (rho0, u0, T0), slow)
        return choose(n * u1 >= np.sqrt(c2), (rho, u, T), slow)

    @staticmethod
    def seen(part, layer, side, n, nodes):
        """(u, T) for the gradients at an open end: heat and viscous stress are imposed there."""
        gas = part.law
        (rho, u, T), (rho1, u1, T1), (rho2, u2, T2) = ([of[k] for of in nodes] for k in range(3))
        a, p0, T0 = n * u, layer.end_data[side, 0], layer.end_data[side, 1]
        imposed = (a < 0.0) | (a * a >= gas.law.sound_speed_squared(rho1, T1))
        seen_u = np.where((gas.mu > 0.0) & imposed, 2.0 * u1 - u2, u)
        _, c0, tau, alpha, _, _, _, of_1 = gas_beyond(gas, layer, side)
        p, p1, p2 = gas.law.pressure(rho, T), gas.law.pressure(rho1, T1), gas.law.pressure(rho2, T2)
        q_n = T1 - T2 - tau * (p1 - p2)
        slow, conducted = np.maximum(1.0 + np.minimum(a, 0.0) / c0, 0.0), alpha / layer.h
        step = of_1 * slow * slow * tau * (p - p1) + carried(layer, a, alpha, of_1) * q_n
        width = layer.h * number(layer.hi - layer.lo)
        lost = 0.5 * (np.sqrt(a * a + 4.0 * (alpha / width) ** 2) - a)
        at_rest = T0 + tau * (p - p0)
        seen_T = (conducted * (T1 + step) + lost * at_rest) / (conducted + lost)
        return seen_u, np.where(gas.kappa > 0.0, seen_T, T)


def gas_beyond(gas, layer, side):
    """(rho0, c0, tau, alpha, p_T/cv, b, kappa) of the gas beyond an open end, and how much of order
    1 there is, 0 to 1."""
    p0, T0 = layer.end_data[side, 0], layer.end_data[side, 1]
    rho = gas.law.density(p0, T0)
    c2, cv = gas.law.sound_speed_squared(rho, T0), gas.law.heat_capacity(rho, T0)
    c, by_heat = np.sqrt(c2), gas.law.pressure_by_temperature(rho, T0) / cv
    mu, kappa, tau = gas.viscosity(T0), gas.conductivity(T0), T0 * by_heat / (rho * rho * c2)
    alpha = kappa * gas.law.bulk_modulus(rho, T0) / (cv * rho * rho * c2)
    longest = LONGEST * c * layer.h * number(layer.hi - layer.lo)
    faded = 1.0 - np.maximum(mu, kappa / cv) / (rho * longest)
    part = layer.end_data[side, 3] * np.maximum(0.0, faded)
    return rho, c, tau, alpha, by_heat, 0.5 * (mu - tau * by_heat * kappa), kappa, part


def carried(layer, a, alpha, part):
    """How much of q_nn = 0 there is where gas flows out with a, 0 to 1."""
    carrying = np.maximum(a, 0.0) * LONGEST * layer.h * number(layer.hi - layer.lo)
    return part * carrying / (carrying + alpha)
