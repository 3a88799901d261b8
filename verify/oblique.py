"""Regular reflection of an oblique shock from a rigid wall (J. D. Anderson, Modern Compressible
Flow, 3rd ed., Sec. 4.3, 4.6): conservation of mass, momentum and energy across both shocks."""

import numpy as np
from scipy.optimize import brentq, fsolve

G = 1.4


def shock(state, angle):
    """(rho, u, v, p) behind a shock whose front has this angle to the x axis."""
    rho, u, v, p = state
    n, along = np.array([np.sin(angle), -np.cos(angle)]), np.array([np.cos(angle), np.sin(angle)])
    w, t = np.dot(n, (u, v)), np.dot(along, (u, v))
    enthalpy = G / (G - 1) * p / rho + w * w / 2

    def jumps(x):
        dense, push, w2 = x
        return (
            dense * w2 - rho * w,
            dense * w2 * w2 + push - rho * w * w - p,
            G / (G - 1) * push / dense + w2 * w2 / 2 - enthalpy,
        )

    strong = G * p / rho / w**2  # 1/M^2
    guess = (rho * (1.2 + 0.8 * (1 - strong)), p * (1.5 / strong), w * 0.7)
    dense, push, w2 = fsolve(jumps, guess, xtol=1e-13)
    return (dense, *(w2 * n + t * along), push)


def reflection(mach, degrees):
    """States and angles: incoming shock falls from (0, 1), the other rises from the wall."""
    theta, first = np.radians(degrees), (1.0, mach, 0.0, 1 / G)

    def turned(state, angle):
        _, u, v, _ = shock(state, angle)
        return np.arctan2(v, u)

    least = np.arcsin(1 / mach)
    incoming = brentq(lambda b: turned(first, -b) + theta, least + 0.05, least + 0.35, xtol=1e-13)
    second = shock(first, -incoming)
    leaving = brentq(lambda b: turned(second, b), 0.3, 0.65, xtol=1e-13)
    return first, second, shock(second, leaving), incoming, leaving


def columns():
    """Head -> numbers: Mach 2.9, 10 degrees."""
    *states, incoming, leaving = reflection(2.9, 10.0)
    found = {name: [state[k] for state in states] for k, name in enumerate(("rho", "u", "v", "p"))}
    return {**found, "angle": [0.0, incoming, leaving]}


if __name__ == "__main__":
    from csv_file import save

    save(
        "oblique",
        columns(),
        "made by verify/oblique.py: Mach 2.9, wedge of 10 degrees; rho = c = 1 of what comes in",
        "rows: before, between, behind the shocks; angle [rad] of the incoming and the reflected "
        "shock to the wall",
    )
