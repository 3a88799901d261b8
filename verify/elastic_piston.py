"""An elastic piston that recedes from a gas or advances into it: exact (Banks, Henshaw, Schwendeman
2012).

The interface moves as F(t) = -t^4/4 or t^4/4. Gas: gamma = 1.4, at rest rho = 0.1, speed of sound
1; a simple wave, u = F'(s) along x = F(s) + (1 + 1.2 F'(s)) (t - s). Solid: density 1, speed of
waves c = 2, displacement f(t - X/c) + g(t + X/c), f' = (F' + q/c)/2, g' = (F' - q/c)/2, q = p - p0.
"""

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

GAMMA, RHO, LENGTH, WIDTH, END, POINTS = 1.4, 0.1, 0.5, 1.5, 0.7, 401
P, C = RHO / GAMMA, 2.0


def speed(t, sign):
    """F'."""
    return sign * t**3


def overpressure(t, sign):
    """q."""
    return P * ((1 + (GAMMA - 1) / 2 * speed(t, sign)) ** (2 * GAMMA / (GAMMA - 1)) - 1)


def gas(x, sign):
    """(rho, u, T)."""
    if x >= END:
        return RHO, 0.0, P / RHO

    def foot(s):
        return sign * s**4 / 4 + (1 + (GAMMA + 1) / 2 * speed(s, sign)) * (END - s) - x

    u = speed(brentq(foot, 0.0, END, xtol=1e-15, rtol=1e-14), sign)
    c = 1 + (GAMMA - 1) / 2 * u
    return RHO * c ** (2 / (GAMMA - 1)), u, P / RHO * c * c


def solid(X, sign):
    """(displacement, velocity, stress beside -p0)."""
    right, left = END - X / C, END + X / C
    q_right, q_left = overpressure(right, sign), overpressure(left, sign)
    f = (sign * right**4 / 4 + quad(overpressure, 0, right, (sign,), epsabs=1e-14)[0] / C) / 2
    g = (sign * left**4 / 4 - quad(overpressure, 0, left, (sign,), epsabs=1e-14)[0] / C) / 2
    f_t, g_t = (speed(right, sign) + q_right / C) / 2, (speed(left, sign) - q_left / C) / 2
    return f + g, f_t + g_t, C * (g_t - f_t)


def columns(points=POINTS):
    """Head -> numbers. X: of the solid; s: from the interface (0) to the wall at x = 1.5 (1)."""
    s = [k / (points - 1) for k in range(points)]
    table = {"s": s, "X": [LENGTH * (k - 1) for k in s]}
    for way, sign in (("receding", -1), ("advancing", 1)):
        place = sign * END**4 / 4
        of_gas = [gas(place + k * (WIDTH - place), sign) for k in s]
        of_solid = [solid(X, sign) for X in table["X"]]
        for name, values in zip(("rho", "u", "T"), zip(*of_gas)):
            table[f"{way}_{name}"] = values
        for name, values in zip(("displacement", "velocity", "stress"), zip(*of_solid)):
            table[f"{way}_{name}"] = values
    return {name: np.array(values) for name, values in table.items()}


if __name__ == "__main__":
    from csv_file import save

    save(
        "elastic_piston",
        columns(),
        "t = 0.7; lengths over the unit of length, speeds over that of sound, R = 1",
        "gas at x = F + s (1.5 - F), F = -+0.7^4/4; solid at its label X; stress beside -p0",
        "after Banks, Henshaw, Schwendeman, J. Comput. Phys. 231 (2012) 3518",
    )
