"""Cauchy stress of solids in simple shear and in extension: derivatives of their energy W(F).

Neo-Hookean: W = mu/2 (|F|^2 - 2 - 2 ln J) + lambda/2 ln(J)^2. St. Venant and Kirchhoff:
W = lambda/2 tr(E)^2 + mu |E|^2, E = (F^T F - 1)/2. s = dW/dF F^T/J, plane strain; derivatives
by complex steps, exact to round-off (W. Squire, G. Trapp, SIAM Review 40 (1998) 110).
"""

import numpy as np

MU, LAMBDA, STEP = 1.0, 1.5, 1e-40


def det(F):
    """Of a 2 x 2 matrix as a list (xx, xy, yx, yy)."""
    return F[0] * F[3] - F[1] * F[2]


def neo_hookean(*F):
    """W."""
    log = np.log(det(F))
    return MU / 2 * (sum(f * f for f in F) - 2 - 2 * log) + LAMBDA / 2 * log**2


def svk(*F):
    """W."""
    xx, yy = (F[0] ** 2 + F[2] ** 2 - 1) / 2, (F[1] ** 2 + F[3] ** 2 - 1) / 2
    xy = (F[0] * F[1] + F[2] * F[3]) / 2
    return LAMBDA / 2 * (xx + yy) ** 2 + MU * (xx**2 + yy**2 + 2 * xy**2)


def cauchy(energy, F):
    """(s_xx, s_xy, s_yy)."""
    P = [energy(*(f + 1j * STEP * (i == k) for i, f in enumerate(F))).imag / STEP for k in range(4)]
    J = det(F)
    xx, xy = P[0] * F[0] + P[1] * F[1], P[0] * F[2] + P[1] * F[3]
    return xx / J, xy / J, (P[2] * F[2] + P[3] * F[3]) / J


def columns():
    """Head -> numbers: rows neo-Hookean, St. Venant and Kirchhoff."""
    found = {}
    for name, F in (("shear", (1, 1, 0, 1)), ("extension", (2, 0, 0, 1))):
        rows = [cauchy(energy, F) for energy in (neo_hookean, svk)]
        for part, values in zip(("xx", "xy", "yy"), zip(*rows)):
            found[f"{name} s_{part}"] = [round(value, 14) for value in values]
    return found


if __name__ == "__main__":
    from csv_file import save

    save(
        "large_deformation",
        columns(),
        "made by verify/large_deformation.py: Cauchy stress over mu, lambda = 1.5 mu, plane strain",
        "first row neo-Hookean, second St. Venant and Kirchhoff",
        "shear: x = X + Y; extension: x = 2 X",
    )
