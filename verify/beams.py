"""Frequencies of beams, and the pressure at which a panel flutters. Lengths are over the panel's.

Panels, l = 2 q L^3/(D sqrt(M^2 - 1)). A thin one under steady pressure: w'''' + l w' = k w, where w
is a sum of exp(m x) with m^4 + l m = k. Flutter begins at the l at which two real k merge: 636.57
if the ends are clamped, 343.36 if they are hinged (E. H. Dowell, Aeroelasticity of Plates and
Shells, 1975; J. M. Hedgepeth, J. Aeronaut. Sci. 24 (1957) 381 has 343). Panels with a thickness, in
plane strain, under the pressure of linear flow: Galerkin's method.

Beams with a thickness d, by Timoshenko: w is the deflection, t the turn of a cross-section,

    S (w'' - t') = m w_tt,   D t'' + S (w' - t) = m d^2/12 t_tt.

In plane strain with lambda_e = 0, S = shear mu d and D = mu d^3/6. The coefficient shear is 5/6
(Timoshenko, Reissner), or pi^2/12 (R. D. Mindlin, J. Appl. Mech. 18 (1951) 31). Frequencies are
over sqrt(D/m).
"""

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import legder, leggauss, legint, legval, legvander
from scipy.linalg import cholesky, eigh
from scipy.linalg import solve_triangular as solve
from scipy.optimize import brentq, minimize_scalar, newton
from scipy.special import eval_jacobi, iv

#: derivatives of w that vanish at both ends
ENDS = {"clamped": (0, 1), "hinged": (0, 2)}
#: the two least k at l = 0, and numbers below and above the l at which they merge
THIN = {
    "clamped": ((500.5639, 3803.537), (600.0, 680.0)),
    "hinged": ((np.pi**4, 16 * np.pi**4), (320.0, 360.0)),
}
#: of the flow; of the panel, over the density of the gas and the length
MACH, MASS = 2.0, 10.0


def misfit(l, k, ends):
    """Zero at an eigenvalue k; real, smooth in k."""
    m = np.roots([1, 0, 0, l, -k]).astype(complex)
    rows = [m**d for d in ENDS[ends]] + [m**d * np.exp(m) for d in ENDS[ends]]
    differences = np.prod([m[j] - m[i] for i in range(4) for j in range(i + 1, 4)])
    return (np.linalg.det(np.array(rows)) / differences).real


def thin_limit(ends):
    """The l at which the two least k merge: no misfit is left between them."""
    between, bounds = THIN[ends]
    scale = misfit(0.0, 0.5 * sum(between), ends)

    def largest(l):
        """Misfit between the two k, over its size at l = 0."""
        return -minimize_scalar(lambda k: -misfit(l, k, ends) / scale, bounds=between).fun

    return brentq(largest, *bounds, xtol=1e-10, rtol=1e-14)


def thin_beam():
    """First frequency of a clamped beam of Euler and Bernoulli."""
    return brentq(lambda b: np.cos(b) - 1 / np.cosh(b), 4.0, 5.0, xtol=1e-15, rtol=1e-15) ** 2


def clamped_beam(d, shear=5 / 6):
    """First frequency of Timoshenko's beam."""
    S, inertia = 6.0 * shear / d**2, d**2 / 12.0

    def misfit(w):
        # w, t ~ exp(m x): (S m^2 + w^2) W = S m t,  (m^2 - S + inertia w^2) t = -S m W
        squares = np.roots([S, (S * inertia + 1.0) * w**2, (inertia * w**2 - S) * w**2])
        m = np.sqrt(squares.astype(complex))
        m = np.concatenate([m, -m])
        t = (S * m * m + w * w) / (S * m)
        top = np.exp(m - np.abs(m.real).max())
        d = np.linalg.det(np.array([np.ones(4), t, top, t * top])) / (m[0] * m[1])
        return d.real if abs(d.real) > abs(d.imag) else d.imag

    grid = np.linspace(0.5, 1.0, 201) * thin_beam()
    values = [misfit(w) for w in grid]
    found = [i for i in range(200) if values[i] * values[i + 1] < 0]
    return brentq(misfit, grid[found[-1]], grid[found[-1] + 1], xtol=1e-12, rtol=1e-15)


def hinged_beam(d, shear=5 / 6):
    """First frequency of Timoshenko's beam, which bends as sin(pi x)."""
    S, inertia, square = 6.0 * shear / d**2, d**2 / 12.0, np.pi**2
    # (S k^2 - w^2)(k^2 + S - inertia w^2) = S^2 k^2 with k = pi
    a, b, c = inertia, -(square + S + inertia * S * square), S * square**2
    return np.sqrt(2 * c / (-b + np.sqrt(b * b - 4 * a * c)))


def gauss(n):
    """Nodes and weights for 0 < x < 1."""
    t, weights = leggauss(n)
    return 0.5 * (t + 1.0), 0.5 * weights


def values(series, x, derivative=0):
    """(n, nx) of n series of Legendre's polynomials on 0 < x < 1."""
    return legval(2.0 * x - 1.0, legder(series, derivative, 2.0))


def thin(ends, terms=16):
    """Squares of the frequencies of a thin panel, D = m = L = 1, and series of x and the w."""
    x, weights = gauss(2 * terms)
    bubble = Legendre.fit([0.0, 0.5, 1.0], [0.0, 0.25, 0.0], 2, domain=[0, 1])
    held = bubble**2 if ends == "clamped" else bubble
    all_w = (held * Legendre.basis(k, domain=[0, 1]) for k in range(terms))
    series = np.array([np.pad(w.coef, (0, terms + 4 - len(w.coef))) for w in all_w]).T
    M, K = (v * weights @ v.T for v in (values(series, x, n) for n in (0, 2)))
    squares, a = eigh(K, M)
    return squares, np.array([0.5, 0.5]), series @ a


def stretched(n, left, right):
    """Functions f on 0 < x < 1 for Galerkin's method: x itself and n - 1 that vanish at both ends.

    They are smooth functions of s, 0 < s < 1, with dx/ds ~ s^left (1 - s)^right, so that roots of x
    and 1 - x, as in corners, are well approximated. Their df/dx are Jacobi's polynomials of s.
    Returns Legendre series in s of all f; at nodes, weights of integrals over x, f, df/dx.
    """
    s, weights = gauss(n + left + right + 8)
    slope = s**left * (1.0 - s) ** right
    slope /= weights @ slope
    f_x = np.array([eval_jacobi(k, right, left, 2.0 * s - 1.0) for k in range(n)])
    degrees = np.arange(len(s))
    projected = (legvander(2.0 * s - 1.0, degrees[-1]) * weights[:, None]).T @ (f_x * slope).T
    series = legint((2 * degrees + 1)[:, None] * projected, lbnd=-1, scl=0.5)
    return series, weights * slope, values(series, s), f_x


def with_one(f, f_x):
    """f and df/dx with the function 1 before them."""
    one = np.ones((1, f.shape[1]))
    return np.vstack([one, f]), np.vstack([0.0 * one, f_x])


def reduced(K, M, loads):
    """Squares and amplitudes of motions of K^-1 loads and K^-1 M K^-1 loads alone: what smooth
    pressures make. Many more modes were needed for the same.
    """
    scale = 1.0 / np.sqrt(np.diag(K))
    K, M = (A * scale * scale[:, None] for A in (K, M))
    root = cholesky(K, lower=True)

    def softness(b):
        return solve(root, M @ solve(root, b, trans="T", lower=True), lower=True)

    b = solve(root, scale[:, None] * loads, lower=True)
    b = np.linalg.qr(np.hstack([b, softness(b)]))[0]
    inverse, a = eigh(b.T @ softness(b))
    a = solve(root, b @ a[:, ::-1], trans="T", lower=True) * scale[:, None]
    return 1.0 / inverse[::-1], a / np.sqrt(inverse[::-1])


def plane(thickness, ends, along=64, across=20, terms=16):
    """As thin: a panel in plane strain, lambda_e = 2 mu_e, w at its upper face. Clamped: u = v = 0
    on its end faces; hinged: v = 0 there. u is odd in y, the distance from the middle, v is even.
    Corners of clamped panels have singular stress: 7 digits are right.
    """
    mu = 4.0 / thickness**3
    series, dx, all_x, slopes = stretched(along + 1, 5, 5)
    v, v_x = all_x[1:], slopes[1:]  # all but x vanish at both ends
    u, u_x = (v, v_x) if ends == "clamped" else with_one(all_x, slopes)
    upper, dy, g, g_y = stretched(across, 0, 5)  # over the upper half, counted twice
    dy, g_y = thickness * dy, g_y / (0.5 * thickness)
    f, f_y = with_one(g, g_y)

    def integral(a, b, c, d):
        """Of a(x) b(x) c(y) d(y), for all pairs of products a c and b d."""
        return np.kron(a * dx @ b.T, c * dy @ d.T)

    uv = mu * (2.0 * integral(u_x, v, g, f_y) + integral(u, v_x, g_y, f))
    uu = mu * (4.0 * integral(u_x, u_x, g, g) + integral(u, u, g_y, g_y))
    vv = mu * (4.0 * integral(v, v, f_y, f_y) + integral(v_x, v_x, f, f))
    K = np.block([[uu, uv], [uv.T, vv]])
    M = np.block([[integral(u, u, g, g), 0.0 * uv], [0.0 * uv.T, integral(v, v, f, f)]]) / thickness
    at_top = np.concatenate([[1.0], values(upper, 1.0)])
    s = gauss(len(dx))[0]
    pushes = values(np.eye(terms), values(series[:, 0], s))
    push = np.kron(v * dx @ pushes.T, at_top[:, None])
    loads = np.vstack([np.zeros((len(uu), terms)), push])
    squares, a = reduced(K, M, loads)
    of_v = np.einsum("xyk,y->xk", a[len(uu) :].reshape(len(v), len(f), -1), at_top)
    return squares, series[:, 0], series[:, 1:] @ of_v


def slow_pressure(panel, points=48):
    """Integrals of w_i p_j over x, of the pressure p_j that w_j exp(s t) makes, at s = 0, and their
    derivative by s there. Density, velocity of sound and length are 1.
    """
    _, x_of, w_of = panel
    at, weights = gauss(points)
    w, w_s, x_s = values(w_of, at), values(w_of, at, 1), values(x_of, at, 1)
    square, root = MACH**2 - 1.0, np.sqrt(MACH**2 - 1.0)
    by_s = MACH * (MACH**2 - 2.0) / (square * root)
    return (w * weights) @ w_s.T * MACH**2 / root, (w * weights * x_s) @ w.T * by_s


def pressure(panel, points=48):
    """A function of s: the same integrals at any s.

    In Laplace transforms over x of linear potential flow, w = 0 at x = 0, b^2 = M^2 - 1:

        p = (s + M a)^2 K w,   K = 1/sqrt((s + M a)^2 - a^2),
        K(x) = exp(-M s x/b^2) I0(s x/b^2)/b
    """
    _, x_of, w_of = panel
    square, root = MACH**2 - 1.0, np.sqrt(MACH**2 - 1.0)
    at, weights = gauss(points)
    steady = slow_pressure(panel, points)[0]
    w = values(w_of, at) * weights * values(x_of, at, 1)
    before = np.outer(at, at)  # places between 0 and each of at
    r = (values(x_of, at)[:, None] - values(x_of, before)) / square
    step = at[:, None] * weights
    dx, w_before = step * values(x_of, before, 1), values(w_of, before)
    dw = step * values(w_of, before, 1)

    def at_any(s):
        decay, z = np.exp(-MACH * s * r) / root, s * r
        K, K_x = decay * iv(0, z), decay * (iv(1, z) - MACH * iv(0, z)) * s / square
        by_slope = 2.0 * s * MACH * K + MACH**2 * K_x
        return steady + w @ (w_before * (s * s * K * dx) + dw * by_slope).sum(axis=2).T

    return at_any


def modes(panel, l, flow="exact"):
    """s of the two slowest modes; velocity of sound and length are 1. flow: exact or steady."""
    squares, one = panel[0], np.eye(len(panel[0]))
    stiff = MACH**2 / (l * np.sqrt(MACH**2 - 1.0)) * np.diag(squares)
    P, P_s = slow_pressure(panel)
    if flow == "steady":
        P_s = 0.0 * P_s
    s = np.linalg.eigvals(np.block([[0.0 * one, one], [-(stiff + P) / MASS, -P_s / MASS]]))
    s = sorted(s[s.imag >= 0.0], key=lambda s: s.imag)[:2]
    if flow == "steady":
        return s
    exact, scale = pressure(panel), 1.0 / (np.diag(stiff) + MASS)

    def misfit(s):
        return np.linalg.det((MASS * s * s * one + stiff + exact(s)) * scale)

    return [newton(misfit, start, x1=start * (1.0 + 1e-4), tol=1e-13) for start in s]


def onset(panel, flow="exact"):
    """Least l at which one of the two slowest modes grows."""
    noise = 1e-6 if flow == "steady" else 0.0  # without damping, modes do not decay below the onset
    return brentq(lambda l: max(s.real for s in modes(panel, l, flow)) - noise, 250, 750, xtol=1e-8)


def columns():
    """Of beam.csv."""
    d = [0.1, 0.05, 0.02, 0.01]
    made = {"d": [*d, 0.0]}
    beams = {"clamped": (clamped_beam, thin_beam()), "hinged": (hinged_beam, np.pi**2)}
    for ends, (beam, limit) in beams.items():
        made[ends] = [*(beam(v) for v in d), limit]
        made[f"{ends} pi^2/12"] = [*(beam(v, np.pi**2 / 12) for v in d), limit]
    return made


def flutter_columns():
    """Of panel_flutter.csv: l at flutter of panels of thickness d, steady and exact pressure."""
    d = [0.0, 0.04, 0.1]
    made = {"d": d}
    for ends in ENDS:
        panels = [thin(ends), *(plane(v, ends) for v in d[1:])]
        steady = (onset(panel, "steady") for panel in panels[1:])
        made[f"{ends} lambda"] = [thin_limit(ends), *steady]
        made[f"{ends} theory"] = [onset(panel) for panel in panels]
    return made


if __name__ == "__main__":
    from csv_file import save

    about = "w sqrt(m/D) of beams of length 1 and thickness d, lambda_e = 0; d = 0: thin"
    save("beam", columns(), f"made by verify/beams.py: {about}")
    about = "lambda = 2 q L^3/(D beta) at flutter of panels of thickness d (rows)"
    more = "lambda: steady pressure; theory: exact pressure, Mach 2, mass 10"
    save("panel_flutter", flutter_columns(), f"made by verify/beams.py: {about}", more)
