"""Riemann problems of a perfect gas (left) and an elastic rod (right): the state between the waves.

Gas (gamma = 1.4): E. F. Toro, Riemann Solvers, 3rd ed., Sec. 4.2. Rod: stress sigma = K ln F - p_r,
at rest under the pressure p_r with F = 1; a compression is a shock, u = sqrt((F - 1) sigma_jump /
m0). Behind the shock of Mach number M that hits the rod at t = 0: Rankine and Hugoniot.
"""

import numpy as np
from scipy.optimize import brentq

#: of the gas, density of the rod, (rho, p) of the gas on it
GAMMA, DENSITY, LOW = 1.4, 0.5, (0.125, 0.1)


def behind(mach):
    """(rho, u, p) behind a shock into LOW at rest."""
    rho, p = LOW
    speed = mach * np.sqrt(GAMMA * p / rho)
    dense = rho * (GAMMA + 1) * mach**2 / ((GAMMA - 1) * mach**2 + 2)
    return dense, speed * (1 - rho / dense), p * (1 + 2 * GAMMA / (GAMMA + 1) * (mach**2 - 1))


def gas_velocity(p, state):
    """u of the gas where its pressure has become p."""
    rho, u, p0 = state
    if p > p0:
        a, b = 2 / ((GAMMA + 1) * rho), (GAMMA - 1) / (GAMMA + 1) * p0
        return u - (p - p0) * np.sqrt(a / (p + b))
    c = np.sqrt(GAMMA * p0 / rho)
    return u - 2 * c / (GAMMA - 1) * ((p / p0) ** ((GAMMA - 1) / (2 * GAMMA)) - 1)


def rod_velocity(p, modulus):
    """u of the rod under the pressure p."""
    F = np.exp(-(p - LOW[1]) / modulus)
    return np.sqrt((1 - F) * (p - LOW[1]) / DENSITY)


def between(state, modulus):
    """(p, u, F)."""
    p = brentq(
        lambda p: gas_velocity(p, state) - rod_velocity(p, modulus),
        LOW[1],
        50 * max(state[2], 1.0),
        xtol=1e-15,
        rtol=1e-14,
    )
    return p, rod_velocity(p, modulus), np.exp(-(p - LOW[1]) / modulus)


def columns():
    """Head -> numbers: problem, ratio or Mach number, K, p, u, F."""
    rows = []
    for ratio, modulus in ((10.0, 4.0), (100.0, 40.0)):
        rows.append((0, ratio, modulus, *between((1.0, 0.0, ratio * LOW[1]), modulus)))
    for mach, modulus in ((3.0, 4.0), (10.0, 40.0)):
        rows.append((1, mach, modulus, *between(behind(mach), modulus)))
    return dict(zip(("strong", "number", "K", "p", "u", "F"), zip(*rows)))


if __name__ == "__main__":
    from csv_file import save

    save(
        "riemann_problems",
        columns(),
        "gas gamma = 1.4, R = 1; on the rod rho = 0.125, p = 0.1; rod m0 = 0.5, K ln F - 0.1",
        "strong = 0: gas at rest, rho = 1, p = number * 0.1; 1: a shock of Mach number number",
        "p, u, F of the rod at the interface; exact by iteration",
    )
