"""Frequencies of beams and plates, and the pressure at which a panel flutters.

Flutter, quasi-steady pressure without damping, lengths over the panel's: w'''' + l w' = q w. The w
are sums of exp(m x), m^4 + l m - q = 0. Flutter begins at the l at which two real q merge: 636.57
of a clamped panel, 343.36 of a simply supported one (E. H. Dowell, Aeroelasticity of Plates and
Shells, 1975; J. M. Hedgepeth, J. Aeronaut. Sci. 24 (1957) 381 has 343). Panels with a thickness, in
plane strain, under the pressure of linear flow: Galerkin's method.

Vibration, Timoshenko: D t'' + S (w' - t) = -r I t.., S (w'' - t') = m w.., plane strain, with
S = 5/6 mu h, I = density h^3/12. Euler and Bernoulli: cos b cosh b = 1, w = b^2 sqrt(D/m).
"""

import numpy as np
from numpy.polynomial import Chebyshev, Legendre
from numpy.polynomial.legendre import legder, leggauss, legint, legval, legvander
from scipy.linalg import cholesky, eigh
from scipy.linalg import solve_triangular as solve
from scipy.optimize import brentq, newton
from scipy.special import eval_jacobi, iv

#: derivatives that vanish at both ends
ENDS = {"clamped": (0, 1), "hinged": (0, 2)}


def misfit(l, q, ends):
    """Zero at an eigenvalue q; real, smooth in q."""
    m = np.roots([1, 0, 0, l, -q]).astype(complex)
    for _ in range(3):
        m -= (m**4 + l * m - q) / (4 * m**3 + l)
    rows = [m**d for d in ENDS[ends]] + [m**d * np.exp(m) for d in ENDS[ends]]
    differences = np.prod([m[j] - m[i] for i in range(4) for j in range(i + 1, 4)])
    return (np.linalg.det(np.array(rows)) / differences).real


def flutter(ends):
    """The l at which the first two q merge."""
    low, high = {"clamped": (500.5639, 3803.537), "hinged": (np.pi**4, 16 * np.pi**4)}[ends]
    sign = np.sign(misfit(0.0, 0.5 * (low + high), ends))

    def gap(l):
        """Largest misfit between the two eigenvalues, with its sign at l = 0."""
        between = np.vectorize(lambda q: sign * misfit(l, q, ends))
        of = Chebyshev.interpolate(between, 30, domain=(low, high))
        tops = [q.real for q in of.deriv().roots() if q.imag == 0.0 and low < q.real < high]
        return max(of(q) for q in tops)

    near = {"clamped": 600.0, "hinged": 320.0}[ends], {"clamped": 680.0, "hinged": 360.0}[ends]
    scale = abs(gap(near[0]))
    return brentq(lambda l: gap(l) / scale, *near, xtol=1e-10, rtol=1e-14)


def euler_bernoulli(number=1, ends="clamped"):
    """w sqrt(m/D) L^2."""
    if ends == "hinged":
        return (number * np.pi) ** 2
    b = (number + 0.5) * np.pi
    return (
        brentq(lambda b: np.cos(b) - 1 / np.cosh(b), b - 0.3, b + 0.3, xtol=1e-15, rtol=1e-15) ** 2
    )


def timoshenko(thickness, number=1, poisson_lambda=2.0):
    """w sqrt(m/D) of a clamped beam, L = 1, h = thickness, lambda_e = poisson_lambda mu_e."""
    ratio = 4 * (poisson_lambda + 1) / (poisson_lambda + 2) / 12  # D/(mu h^3)
    S, inertia = 5 / 6 / (ratio * thickness**2), thickness**2 / 12  # D = m = 1

    def misfit(w):
        # w, t ~ exp(m x): (S m^2 + w^2) W = S m t,  (m^2 - S + inertia w^2) t = -S m W
        a, b, c = S, S * inertia * w**2 + w**2, (inertia * w**2 - S) * w**2
        squares = np.roots([a, b, c]).astype(complex)
        m = np.concatenate([np.sqrt(squares), -np.sqrt(squares)])
        t = (S * m * m + w * w) / (S * m)
        top = np.exp(m - np.abs(m.real).max())
        d = np.linalg.det(np.array([np.ones(4), t, top, t * top])) / (m[0] * m[1])
        return d.real if abs(d.real) > abs(d.imag) else d.imag

    top = euler_bernoulli(number)
    grid = np.linspace(0.5, 1.0, 201) * top
    values = [misfit(w) for w in grid]
    found = [i for i in range(200) if values[i] * values[i + 1] < 0]
    return brentq(misfit, grid[found[-1]], grid[found[-1] + 1], xtol=1e-12, rtol=1e-15)


def hinged_timoshenko(thickness, number=1, poisson_lambda=2.0):
    """w sqrt(m/D) of a simply supported beam: the deflection is sin(k x)."""
    ratio = 4 * (poisson_lambda + 1) / (poisson_lambda + 2) / 12
    S, inertia, k = 5 / 6 / (ratio * thickness**2), thickness**2 / 12, number * np.pi
    # (S k^2 - w^2)(k^2 + S - inertia w^2) = S^2 k^2
    a, b, c = inertia, -(k**2 + S + inertia * S * k**2), S * k**4
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
    """Series in s, 0 < s < 1, of x and n - 1 more integrals f of Jacobi's polynomials over x, where
    dx/ds ~ s^left (1 - s)^right, x(1) = 1; weights of integrals over x, and f, df/dx there. Roots
    of x and 1 - x are smooth in s. All f but x itself vanish at s = 1, too, not only at 0.
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
    on its end faces; hinged: v = 0 there. u is odd in y, the distance from the middle. Corners of
    clamped panels have singular stress: 7 digits are right.
    """
    mu = 4.0 / thickness**3
    series, X, all_x, slopes = stretched(along + 1, 5, 5)
    v, v_x = all_x[1:], slopes[1:]  # all but x vanish at both ends
    u, u_x = (v, v_x) if ends == "clamped" else with_one(all_x, slopes)
    upper, Y, g, g_y = stretched(across, 0, 5)  # over the upper half, of which Y is twice
    Y, g_y = thickness * Y, g_y / (0.5 * thickness)
    f, f_y = with_one(g, g_y)

    def both(a, b, c, d):
        return np.kron(a * X @ b.T, c * Y @ d.T)

    uv = mu * (2.0 * both(u_x, v, g, f_y) + both(u, v_x, g_y, f))
    uu = mu * (4.0 * both(u_x, u_x, g, g) + both(u, u, g_y, g_y))
    vv = mu * (4.0 * both(v, v, f_y, f_y) + both(v_x, v_x, f, f))
    K = np.block([[uu, uv], [uv.T, vv]])
    M = np.block([[both(u, u, g, g), 0.0 * uv], [0.0 * uv.T, both(v, v, f, f)]]) / thickness
    at_top = np.concatenate([[1.0], values(upper, 1.0)])
    s = gauss(len(X))[0]
    pushes = values(np.eye(terms), values(series[:, 0], s))
    push = np.kron(v * X @ pushes.T, at_top[:, None])
    loads = np.vstack([np.zeros((len(uu), terms)), push])
    squares, a = reduced(K, M, loads)
    of_v = np.einsum("xyk,y->xk", a[len(uu) :].reshape(len(v), len(f), -1), at_top)
    return squares, series[:, 0], series[:, 1:] @ of_v


def pressures(panel, flow="exact", mach=2.0, points=48):
    """s -> integrals of w_i p_j over x, of the pressure p_j that w_j exp(s t) makes: steady, to
    first order in s (slow), or exact. Density, velocity of sound and length are 1.

    In Laplace transforms over x of linear potential flow, w = 0 at x = 0, b^2 = M^2 - 1:

        p = (s + M a)^2 K w,   K = 1/sqrt((s + M a)^2 - a^2),
        K(x) = exp(-M s x/b^2) I0(s x/b^2)/b
    """
    _, x_of, w_of = panel
    square, root = mach**2 - 1.0, np.sqrt(mach**2 - 1.0)
    at, weights = gauss(points)
    # p times dx, as functions of the places s of the series
    w, slope = values(w_of, at), values(x_of, at, 1)
    steady = (w * weights) @ values(w_of, at, 1).T * mach**2 / root
    slow = (w * weights * slope) @ w.T * mach * (mach**2 - 2.0) / root**3
    if flow != "exact":
        return lambda s: steady + (s * slow if flow == "slow" else 0.0)
    before = np.outer(at, at)  # places between 0 and each of at
    r = (values(x_of, at)[:, None] - values(x_of, before)) / square
    step = at[:, None] * weights
    dx, w_before = step * values(x_of, before, 1), values(w_of, before)
    dw = step * values(w_of, before, 1)

    def exact(s):
        decay, z = np.exp(-mach * s * r) / root, s * r
        K, K_x = decay * iv(0, z), decay * (iv(1, z) - mach * iv(0, z)) * s / square
        by_slope = 2.0 * s * mach * K + mach**2 * K_x
        p = (w_before * (s * s * K * dx) + dw * by_slope).sum(axis=2)
        return steady + (w * weights * slope) @ p.T

    return exact


def modes(panel, l, flow="exact", mach=2.0, mass=10.0):
    """s of the two slowest modes, velocity of sound and length 1; mass over density and length."""
    squares, one = panel[0], np.eye(len(panel[0]))
    stiff = mach**2 / (l * np.sqrt(mach**2 - 1.0)) * np.diag(squares)
    first = pressures(panel, "steady" if flow == "steady" else "slow", mach)
    P, P_s = first(0.0), first(1.0) - first(0.0)
    s = np.linalg.eigvals(np.block([[0.0 * one, one], [-(stiff + P) / mass, -P_s / mass]]))
    s = sorted(s[s.imag >= 0.0], key=lambda s: s.imag)[:2]
    if flow != "exact":
        return s
    exact, scale = pressures(panel, flow, mach), 1.0 / (np.diag(stiff) + mass)

    def misfit(s):
        return np.linalg.det((mass * s * s * one + stiff + exact(s)) * scale)

    return [newton(misfit, start, x1=start * (1.0 + 1e-4), tol=1e-13) for start in s]


def onset(panel, flow="exact"):
    """Least l at which one of the two slowest modes grows."""
    noise = 1e-6 if flow == "steady" else 0.0  # without damping, modes do not decay below the onset
    return brentq(lambda l: max(s.real for s in modes(panel, l, flow)) - noise, 250, 750, xtol=1e-8)


def columns():
    """Of beam.csv: lambda_e = 0, the first frequencies over sqrt(D/m)."""
    d = [0.1, 0.05, 0.02, 0.01, 0.0]
    made = {"d": d}
    made["clamped"] = [timoshenko(v, 1, 0.0) for v in d[:-1]] + [euler_bernoulli()]
    made["hinged"] = [hinged_timoshenko(v, 1, 0.0) for v in d[:-1]] + [np.pi**2]
    return made


def flutter_columns():
    """Of panel_flutter.csv: l at flutter of panels of thickness d, steady and exact pressure."""
    d = [0.0, 0.04, 0.1]
    made = {"d": d}
    for ends in ENDS:
        panels = [thin(ends), *(plane(v, ends) for v in d[1:])]
        steady = (onset(panel, "steady") for panel in panels[1:])
        made[f"{ends} lambda"] = [flutter(ends), *steady]
        made[f"{ends} theory"] = [onset(panel) for panel in panels]
    return made


if __name__ == "__main__":
    from csv_file import save

    about = "w sqrt(m/D) of beams of length 1 and thickness d, lambda_e = 0; d = 0: thin"
    save("beam", columns(), f"made by verify/beams.py: {about}")
    about = "lambda = 2 q L^3/(D beta) at flutter of panels of thickness d (rows)"
    more = "lambda: steady pressure; theory: exact pressure, Mach 2, mass 10"
    save("panel_flutter", flutter_columns(), f"made by verify/beams.py: {about}", more)
