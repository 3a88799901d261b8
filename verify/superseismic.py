"""A shock that runs along an elastic half space faster than all of its waves: exact states.

Gas above Y = 0, a linear elastic solid below, speed of the shock's foot U = 1 along x. All is
constant between fronts through the foot. With the shock's normal n = (cos phi, sin phi), the
gas behind it follows from Rankine and Hugoniot. In the solid the displacement gradient is

    G = a n_P (x) n_P + b t_S (x) n_S,    n_P = (c_p, -sqrt(1 - c_p^2)),  n_S = (c_s, -sqrt(1 -
    c_s^2)),

t_S across n_S, c_p and c_s over U, so that v = -U G e_x. Three conditions at Y = 0 give phi, a, b:

    v_solid . N = u_gas . N,    sigma e_y = -(p - p_1) A,    N along A = cof(F) e_y, F = 1 + G.

`literature=True`: A is divided by its length. Only then the states are those of Banks, Henshaw,
Schwendeman, Kapila (J. Comput. Phys. 231 (2012) 3518): the traction is per undeformed area, sigma
acts on the undeformed normal, and the pressure acts along the deformed one. The states for A itself
are those of a pressure force on the deformed face, which a conservative interface has; they differ
by 5 %.
"""

import numpy as np
from scipy.optimize import fsolve

GAMMA, RHO, T, LAMBDA, MU = 1.4, 0.1114827, 0.09375, 0.1398307, 0.07203351


def states(literature: bool = False) -> dict[str, float]:
    c_p, c_s, p_1 = np.sqrt(LAMBDA + 2.0 * MU), np.sqrt(MU), RHO * T
    n_p, n_s = np.array([c_p, -np.sqrt(1 - c_p**2)]), np.array([c_s, -np.sqrt(1 - c_s**2)])
    t_s = np.array([-n_s[1], n_s[0]])

    def gas(phi):
        n = np.array([np.cos(phi), np.sin(phi)])
        square = n[0] ** 2 / (GAMMA * T)
        rho = RHO * (GAMMA + 1) * square / ((GAMMA - 1) * square + 2)
        return rho, n[0] * (1 - RHO / rho) * n, p_1 * (1 + 2 * GAMMA / (GAMMA + 1) * (square - 1))

    def solid(a, b):
        G = a * np.outer(n_p, n_p) + b * np.outer(t_s, n_s)
        sigma = LAMBDA * np.trace(G) * np.eye(2) + MU * (G + G.T)
        area = np.array([-G[1, 0], 1 + G[0, 0]])
        return G, sigma, area / np.linalg.norm(area) if literature else area

    def misfit(x):
        (_, u, p), (G, sigma, area) = gas(x[0]), solid(*x[1:])
        return [*(sigma[:, 1] + (p - p_1) * area), (-G[:, 0] - u) @ area]

    phi, a, b = fsolve(misfit, [-0.06, -0.3, 0.1], xtol=1e-12)
    assert np.abs(misfit([phi, a, b])).max() < 1e-14
    (rho, u, p), G = gas(phi), solid(a, b)[0]
    return {
        "phi": phi,
        "a": a,
        "b": b,
        "rho": rho,
        "u": u[0],
        "v": u[1],
        "T": p / rho,
        "p": p,
        "solid u": -G[0, 0],
        "solid v": -G[1, 0],
        "solid u behind P": -a * n_p[0] ** 2,
        "solid v behind P": -a * n_p[0] * n_p[1],
        "deflection": float(np.arctan2(G[1, 0], 1 + G[0, 0])),
    }


def columns() -> dict[str, list[float]]:
    """Of the CSV file: first the states for A itself, then those of the literature."""
    both = states(), states(literature=True)
    return {name: [found[name] for found in both] for name in both[0]}


if __name__ == "__main__":
    from csv_file import save

    save(
        "superseismic",
        columns(),
        "Superseismic shock, made by verify/superseismic.py; "
        "U = 1, rho = 1 in the solid, p = rho T",
        "first row: pressure on the deformed face; "
        "second row: divided by its stretch, as in the literature",
        "phi, deflection [rad]; a, b strengths of P and S wave; behind the shock and the waves",
    )
