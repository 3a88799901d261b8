"""Frequencies of small motions of gas and elastic solid about rest, by determinants.

Layers: disturbances go as exp(i k x + s t). A gas with viscosity and conduction has potentials
phi exp(m y), m^2 = k^2 + L, with (rho s - (p/s + 4 mu/3) L)(rho c_v s - kappa L) = R rho p L, and a
vortical one with L = rho s/mu; a solid has L = s^2/c_p^2 and L = s^2/c_s^2; a liquid without both
has L = s^2/c^2. Ring: displacements by Bessel functions of order n times exp(i n theta - i w t).
Shells: grad phi with phi'' + kappa/r phi' + w^2/c^2 phi = 0, around an axis (kappa = 1) or a
centre (2). Half spaces: the equations of Scholte (A. Ben-Menahem, S. J. Singh, Seismic Waves and
Sources, 1981) and of Rayleigh; Stoneley's wave by the determinant of what decays on both sides.
"""

import numpy as np
from scipy.optimize import brentq, newton
from scipy.special import jvp, yvp

I = 1j
sqrt = np.emath.sqrt


def solid(k, s, mu, lam, density):
    """[(u, v, s_xy, s_yy)] velocities and stresses, as functions of y, of the four potentials."""
    found = []
    for squared, shear in (((lam + 2 * mu) / density, False), (mu / density, True)):
        for sign in (1, -1):
            m = sign * sqrt(k * k + s * s / squared)
            x, y = (m, -I * k) if shear else (I * k, m)
            xy, yy = mu * (m * x + I * k * y), lam * (I * k * x + m * y) + 2 * mu * m * y
            found.append((m, (s * x, s * y, xy, yy)))
    return found


def gas(k, s, mu, kappa, rho=1, p=1, gamma=1.4):
    """[(m, (u, v, s_xy, s_yy, T_y))] of the six potentials; R = p/rho, T = 1."""
    R, cv = p / rho, p / rho / (gamma - 1)
    a, b = p / s + 4 * mu / 3, rho * cv * s
    A, B, C = a * kappa, a * b + rho * s * kappa + R * rho * p, rho * s * b
    large = (
        B + (1 if (B * np.conj(sqrt(B * B - 4 * A * C))).real > 0 else -1) * sqrt(B * B - 4 * A * C)
    ) / 2
    roots = C / large, large / A
    found = []
    for L in (*roots, rho * s / mu):
        for sign in (1, -1):
            m, shear = sign * sqrt(k * k + L), L is not roots[0] and L is not roots[1]
            u, v = (m, -I * k) if shear else (I * k, m)
            xy = mu * (m * u + I * k * v)
            div = 0 if shear else L
            pressure = 0 if shear else -rho * s + 4 * mu / 3 * L
            T = 0 if shear else -p * L / (b - kappa * L)
            found.append((m, (u, v, xy, -pressure + 2 * mu * (m * v - div / 3), m * T)))
    return found


def liquid(k, s, rho, c):
    """[(m, (v, s_yy))]; without viscosity."""
    return [(m, (m, rho * s)) for m in (sqrt(k * k + s * s / c**2), -sqrt(k * k + s * s / c**2))]


def determinant(*blocks):
    """Of rows [(potentials, which field, y, sign, part)], each potential scaled by its largest."""
    rows = []
    for row in blocks:
        line = []
        for fields, which, y, y0 in row:
            line += (
                [0] * len(fields)
                if which is None
                else [f[which] * np.exp(m * (y - y0(m))) for m, f in fields]
            )
        rows.append(line)
    matrix = np.array(rows, complex)
    return np.linalg.det(matrix / np.abs(matrix).max(axis=1)[:, None])


def over_layer(s, k, height, depth, fluid, of_solid):
    """Zero for a mode of a fluid, or a solid, in 0 < y < height over a solid clamped at -depth."""
    f, w = fluid(k, s), solid(k, s, *of_solid)
    top, low = lambda m: height if np.real(m) > 0 else 0, lambda m: 0 if np.real(m) > 0 else -depth
    held = {6: (0, 1, 4), 4: (0, 1), 2: (0,)}[len(f)]  # viscous gas, solid, liquid
    rows = [[(f, i, height, top), (w, None, 0, low)] for i in held]
    both = ((0, 1), (1, 3)) if len(f) == 2 else ((0, 0), (1, 1), (2, 2), (3, 3))
    for i, j in both:
        minus = [(m, tuple(-v for v in values)) for m, values in w]
        rows.append([(f, i, 0, top), (minus, j, 0, low)])
    if len(f) == 6:
        rows.append([(f, 4, 0, top), (w, None, 0, low)])
    elif len(f) == 2:
        rows.append([(f, None, 0, top), (w, 2, 0, low)])
    rows += [[(f, None, 0, top), (w, i, -depth, low)] for i in (0, 1)]
    return determinant(*rows)


def root(function, near):
    """By secants; the scale of a determinant is that at the start."""
    scale = abs(function(near * (1 + 1e-3)))
    return newton(
        lambda s: function(s) / scale, near * (1 + 0j), tol=1e-15, maxiter=100, rtol=1e-14
    )


def layer_mode(
    near, mu=0.01, kappa=0.035 / 0.72, k=2 * np.pi, height=1.0, depth=0.5, of_solid=(1.0, 1.0, 1.0)
):
    """s of a mode of a viscous gas over an elastic layer."""
    return root(
        lambda s: over_layer(s, k, height, depth, lambda k, s: gas(k, s, mu, kappa), of_solid), near
    )


def ring_mode(
    near, n=2, core=0.4, inner=1.0, outer=1.3, vessel=2.0, density=2.0, lam=1.5, mu=1.0, gas=True
):
    """w of an elastic ring between gases of rho = p = 1 without viscosity, or in vacuum."""
    gamma = 1.4
    cp, cs, c = sqrt((lam + 2 * mu) / density), sqrt(mu / density), sqrt(gamma)

    def columns(w, r):
        """(u_r, s_rr, s_rt) of J and Y, of the P and of the S potential."""
        found = []
        for f in (jvp, yvp):
            k = w / cp
            v, d, dd = f(n, k * r, 0), k * f(n, k * r, 1), k * k * f(n, k * r, 2)
            found.append((d, 2 * mu * dd - lam * k * k * v, 2 * n * mu * (v / r**2 - d / r)))
        for f in (jvp, yvp):
            k = w / cs
            v, d, dd = f(n, k * r, 0), k * f(n, k * r, 1), k * k * f(n, k * r, 2)
            # u_r = (n/r) psi cos, u_theta = -psi' sin
            turning = mu * (-dd + d / r - n * n * v / r**2)
            found.append((n * v / r, 2 * n * mu * (d / r - v / r**2), turning))
        return found

    def fluid(w, r, wall):
        """(u_r, -p) of what meets the wall."""
        k = w / c
        j, y = (k * f(n, k * wall, 1) for f in (jvp, yvp))
        value = y * jvp(n, k * r, 0) - j * yvp(n, k * r, 0)
        slope = k * (y * jvp(n, k * r, 1) - j * yvp(n, k * r, 1))
        return slope, -gamma * k * k * value

    def misfit(w):
        rows = []
        for r, wall in ((inner, core), (outer, vessel)):
            at = columns(w, r)
            if gas:
                u, s = fluid(w, r, wall)
                rows.append([a[1] * u - a[0] * s for a in at])
            else:
                rows.append([a[1] for a in at])
            rows.append([a[2] for a in at])
        return np.linalg.det(np.array(rows))

    return root(misfit, near).real


def shell_mode(near, kappa, core=0.0, vessel=2.0, density=2.0, lam=1.5, mu=1.0):
    """w of an elastic shell, 1 < r < 1.3, between gases of rho = p = 1 that reach to a core, or to
    r = 0, and to a vessel; core, vessel None: in a vacuum."""
    gamma = 1.4

    def waves(k, r):
        """[(phi, phi')] of the function that is regular at r = 0, and of the other one."""
        if kappa == 1:
            return [(f(0, k * r, 0), k * f(0, k * r, 1)) for f in (jvp, yvp)]
        pairs = (np.sin(k * r), np.cos(k * r)), (np.cos(k * r), -np.sin(k * r))
        return [(a / (k * r), (b - a / (k * r)) / r) for a, b in pairs]

    def misfit(w):
        k, g = w / sqrt((lam + 2 * mu) / density), w / sqrt(gamma)
        rows = []
        for r, wall in ((1.0, core), (1.3, vessel)):
            da, db = (slope for _, slope in waves(g, wall)) if wall else (0, 1)
            phi, u = (sum(c * v for c, v in zip((db, -da), of)) for of in zip(*waves(g, r)))
            p = gamma * g * g * phi  # of the gas, whose displacement is u
            if wall is None:
                p, u = 0.0, 1.0
            row = []
            for f, df in waves(k, r):
                stress = -lam * k * k * f - 2 * mu * (k * k * f + kappa / r * df)
                row.append(u * stress + df * p)
            rows.append(row)
        return np.linalg.det(np.array(rows))

    return root(misfit, near).real


def stoneley(density, cp, cs, density2, cp2, cs2):
    """Speed of the wave along the plane between two elastic half spaces."""

    def misfit(v):
        """Velocities and stresses of what decays on either side do not match."""
        k, s = 1.0, -1j * v
        f = solid(k, s, density2 * cs2**2, density2 * (cp2**2 - 2 * cs2**2), density2)
        g = solid(k, s, density * cs**2, density * (cp**2 - 2 * cs**2), density)
        rows = [fields for m, fields in f if m.real < 0] + [fields for m, fields in g if m.real > 0]
        return (np.linalg.det(np.array(rows))).real

    least = min(cs, cs2)
    return brentq(misfit, 0.9 * least, least * (1 - 1e-9), xtol=1e-13)


def scholte(rho, c, density, cp, cs):
    """Speed of the wave along a liquid half space over an elastic one; rho = 0: Rayleigh's."""

    def misfit(v):
        p, s, g = (np.sqrt(1 - (v / a) ** 2) for a in (cp, cs, c))
        return g * (4 * p * s - (2 - (v / cs) ** 2) ** 2) - rho / density * p * (v / cs) ** 4

    return brentq(misfit, 0.5 * min(c, cs), min(c, cs) * (1 - 1e-12), xtol=1e-12, rtol=1e-15)


def two_layers_mode(near, lower, upper, k=2 * np.pi):
    """s of a mode of two elastic layers, 1 m each, on and under a clamp."""
    one, other = ((n * s**2, n * (p**2 - 2 * s**2), n) for n, p, s in (lower, upper))
    return root(lambda s: over_layer(s, k, 1.0, 1.0, lambda k, s: solid(k, s, *other), one), near)


def liquid_layer_mode(near, k, height, depth, rho, c, density, cp, cs):
    """s of a mode of a liquid layer under a rigid lid over an elastic one that is clamped below."""
    mu = density * cs**2
    of_solid = mu, density * cp**2 - 2 * mu, density
    return root(
        lambda s: over_layer(s, k, height, depth, lambda k, s: liquid(k, s, rho, c), of_solid), near
    )


#: density, speeds of P and S waves [SI]
METALS = {"steel": (7850.0, 5900.0, 3200.0), "aluminium": (2700.0, 6320.0, 3130.0)}
TUNGSTEN = 19250.0, 5220.0, 2890.0


def columns():
    """Of normal_modes.csv: real and imaginary parts of s = i w [1/s]."""
    made = {"ring": [1j * ring_mode(w) for w in (0.1175, 1.720, 2.0886)]}
    made["ring in vacuum"] = [1j * ring_mode(w, gas=False) for w in (0.2033, 2.2788, 7.86)]
    near = -0.368 + 4.727j, -0.661 + 7.444j, -1.024 + 8.358j
    made["viscous gas"] = [layer_mode(s) for s in near]
    for name, metal in METALS.items():
        s = 2j * np.pi * scholte(1000.0, 1480.0, *metal)
        layers = liquid_layer_mode(s, 2 * np.pi, 1.0, 1.0, 1000.0, 1480.0, *metal)
        made[f"water over {name}"] = [layers, s, np.nan]
    heavy, light = TUNGSTEN, METALS["aluminium"]
    s = 2j * np.pi * stoneley(*heavy, *light)
    made["tungsten under aluminium"] = [two_layers_mode(s, heavy, light), s, np.nan]
    made["cylinder"] = [1j * shell_mode(w, 1) for w in (2.081, 4.469, 5.812)]
    made["sphere"] = [1j * shell_mode(w, 2) for w in (2.490, 4.989, 6.127)]
    parts = [(name, part) for name in made for part in ("real", "imag")]
    return {f"{name} {part}": list(getattr(np.array(made[name]), part)) for name, part in parts}


if __name__ == "__main__":
    from csv_file import save

    save(
        "normal_modes",
        columns(),
        "made by verify/modes.py: small motions as exp(s t), s [1/s], real and imaginary parts",
        "ring: angular number 2, first three; "
        "viscous gas over an elastic layer, k = 2 pi: first three",
        "water over a metal, k = 2 pi/m: first row layers of 1 m under a lid and on a clamp; "
        "second row half",
        "spaces (Scholte), whose speed is s/k: 1479.601 (steel), 1476.765 m/s (aluminium)",
        "tungsten under aluminium, the same without a liquid (Stoneley)",
        "cylinder, sphere: shells of the ring's solid and gases, gas to r = 0; first three",
    )
