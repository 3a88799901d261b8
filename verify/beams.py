"""Frequencies of beams and plates, and the pressure at which a panel flutters.

Flutter, quasi-steady pressure without damping, lengths over the panel's: w'''' + l w' = q w. The w
are sums of exp(m x), m^4 + l m - q = 0. Flutter begins at the l at which two real q merge: 636.57
of a clamped panel, 343.36 of a simply supported one (E. H. Dowell, Aeroelasticity of Plates and
Shells, 1975; J. M. Hedgepeth, J. Aeronaut. Sci. 24 (1957) 381 has 343). Panels with a thickness and
with damping: Galerkin's method.

Vibration, Timoshenko: D t'' + S (w' - t) = -r I t.., S (w'' - t') = m w.., plane strain, with
S = 5/6 mu h, I = density h^3/12. Euler and Bernoulli: cos b cosh b = 1, w = b^2 sqrt(D/m).
"""

import numpy as np
from numpy.polynomial import Chebyshev, Legendre
from scipy.linalg import eigh
from scipy.optimize import brentq

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


def galerkin(thickness, ends, terms=16):
    """Squares of the frequencies of a panel, D = m = L = 1, lambda_e = 2 mu_e, and integrals of
    w_i w_j and w_i w_j' of its modes. Polynomials for w and, if it is thick, t; functions that are
    held vanish at the ends, forces and moments follow.
    """
    nodes, weights = np.polynomial.legendre.leggauss(3 * terms)
    bubble = Legendre.fit([0.0, 0.5, 1.0], [0.0, 0.25, 0.0], 2, domain=[0, 1])
    thin, clamped = thickness == 0.0, ends == "clamped"

    def values(factor, n):
        functions = (factor * Legendre.basis(k, domain=[0, 1]) for k in range(terms))
        return np.array([(f.deriv(n) if n else f)(0.5 * (nodes + 1.0)) for f in functions])

    def integrals(a, b):
        return (a * 0.5 * weights) @ b.T

    w, w_x, w_xx = (values(bubble**2 if thin and clamped else bubble, n) for n in range(3))
    K, M = integrals(w_xx, w_xx), integrals(w, w)
    if not thin:
        t, t_x = (values(bubble if clamped else 1.0, n) for n in range(2))
        S, inertia, zero = 5 / 6 * 4 / thickness**2, thickness**2 / 12, 0.0 * M
        bent = S * integrals(t, t) + integrals(t_x, t_x)
        K = np.block([[S * integrals(w_x, w_x), -S * integrals(w_x, t)], [zero, bent]])
        M = np.block([[M, zero], [zero, inertia * integrals(t, t)]])
    squares, vectors = eigh(K, M, lower=False)  # the upper halves count
    of_w = vectors[:terms]
    return squares, of_w.T @ integrals(w, w) @ of_w, of_w.T @ integrals(w, w_x) @ of_w


def modes(panel, l, mach=2.0, mass=10.0, damped=True):
    """s sqrt(m/D) with Im s >= 0, by frequency: s^2 w + c s w + ... + l w' = 0, with the damping of
    quasi-steady flow, c = (M^2 - 2)/(M^2 - 1) sqrt(l/(beta m)), m the mass over density and length.
    """
    squares, ww, ww_x = panel
    b, one, none = mach**2 - 1.0, np.eye(len(squares)), np.zeros(ww.shape)
    c = (b - 1.0) / b * np.sqrt(l / (np.sqrt(b) * mass)) if damped else 0.0
    s = np.linalg.eigvals(np.block([[none, one], [-np.diag(squares) - l * ww_x, -c * ww]]))
    return sorted(s[s.imag >= 0.0], key=lambda s: s.imag)


def onset(thickness, ends, damped=True):
    """Least l at which one of the two slowest modes grows."""
    panel, low, high = galerkin(thickness, ends), 200.0, 900.0
    noise = 0.0 if damped else 1e-4  # undamped modes neither grow nor decay below the onset
    while high - low > 1e-10 * high:
        middle = 0.5 * (low + high)
        growth = max(s.real for s in modes(panel, middle, damped=damped)[:2])
        low, high = (low, middle) if growth > noise else (middle, high)
    return high


def columns():
    """Of beam.csv: lambda_e = 0, the first frequencies over sqrt(D/m)."""
    d = [0.1, 0.05, 0.02, 0.01, 0.0]
    made = {"d": d}
    made["clamped"] = [timoshenko(v, 1, 0.0) for v in d[:-1]] + [euler_bernoulli()]
    made["hinged"] = [hinged_timoshenko(v, 1, 0.0) for v in d[:-1]] + [np.pi**2]
    return made


def flutter_columns():
    """Of panel_flutter.csv: l at flutter of panels of thickness d, without and with damping."""
    d = [0.0, 0.04, 0.1]
    made = {"d": d}
    for ends in ENDS:
        made[f"{ends} lambda"] = [flutter(ends), *(onset(v, ends, False) for v in d[1:])]
        made[f"{ends} damped"] = [onset(v, ends) for v in d]
    return made


if __name__ == "__main__":
    from csv_file import save

    about = "w sqrt(m/D) of beams of length 1 and thickness d, lambda_e = 0; d = 0: thin"
    save("beam", columns(), f"made by verify/beams.py: {about}")
    about = "2 q L^3/(D beta) at flutter of panels of thickness d (rows), quasi-steady"
    more = "lambda: without damping; damped: with that at Mach number 2, mass 10"
    save("panel_flutter", flutter_columns(), f"made by verify/beams.py: {about}", more)
