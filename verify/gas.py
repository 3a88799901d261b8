"""Gas alone: isentropic vortex, Sod's shock tube, Shu and Osher's problem.

Vortex: u = A r exp((1 - r^2)/2), the entropy p/rho^gamma = 1; momentum along the radius,
dp/dr = rho u^2/r, is integrated as an ODE. Sod: E. F. Toro, Riemann Solvers, 3rd ed., Sec. 4.
Shu and Osher (J. Comput. Phys. 83 (1989) 32), between the contact that begins at x = -4 and the
shock: fitted shock, Chebyshev collocation over the label X. Left of the contact waves go to the
left alone, so u + 2 c/(gamma - 1) is constant there, until the first of them becomes a shock, at
t = 1.114 and x = -3.045: at t = 1.8 nothing of that is beyond x = 0.16, and the contact at 0.73.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G = 1.4


def vortex(points, strength=0.4, end=8.0):
    """r, u, rho, p; rho = p = 1 far away."""
    slope = lambda r, q: (G - 1) / G * strength**2 * r * np.exp(1 - r * r)  # noqa: E731
    r = np.linspace(0, end, points)
    # q = p^((G-1)/G) has q' = (G-1)/G u^2/r, from outside inwards
    q = solve_ivp(slope, (end, 0), [1.0], "DOP853", r[::-1], rtol=1e-13, atol=1e-15).y[0][::-1]
    p = q ** (G / (G - 1))
    return r, strength * r * np.exp((1 - r * r) / 2), p ** (1 / G), p


def sod(x, t, left=(1.0, 1.0), right=(0.125, 0.1)):
    """rho, u, p; (rho, p) of gases at rest at first, apart at x = 0."""

    def side(p, state):
        rho, p0 = state
        c = np.sqrt(G * p0 / rho)
        if p > p0:
            return (p - p0) * np.sqrt(2 / ((G + 1) * rho) / (p + (G - 1) / (G + 1) * p0))
        return 2 * c / (G - 1) * ((p / p0) ** ((G - 1) / (2 * G)) - 1)

    p = brentq(lambda p: side(p, left) + side(p, right), 1e-3, 2.0, xtol=1e-15)
    u, c = side(p, right), np.sqrt(G * left[1] / left[0])
    inner = left[0] * (p / left[1]) ** (1 / G)
    ratio, a = p / right[1], (G - 1) / (G + 1)
    dense = right[0] * (ratio + a) / (a * ratio + 1)
    shock = dense * u / (dense - right[0])
    fan_c = 2 / (G + 1) * (c - (G - 1) / 2 * x / t)
    fan = left[0] * (fan_c / c) ** (2 / (G - 1))
    where = [x < -c * t, x < (u - np.sqrt(G * p / inner)) * t, x < u * t, x < shock * t]
    return (
        np.select(where, [left[0], fan, inner, dense], right[0]),
        np.select(where, [0, fan_c + x / t, u, u], 0.0),
        np.select(where, [left[1], left[1] * (fan / left[0]) ** G, p, p], right[1]),
    )


LEFT = 3.857143, 2.629369, 10.33333


def ahead(x):
    """Density before Shu and Osher's shock, and its slope."""
    return 1 + 0.2 * np.sin(5 * x), np.cos(5 * x)


def shocked(p, rho):
    """u, density, speed where a shock of pressure p goes into gas at rest under the pressure 1."""
    a = (G - 1) / (G + 1)
    dense, s = rho * (p + a) / (a * p + 1), np.sqrt(((G + 1) * p + G - 1) / (2 * rho))
    return s * (1 - rho / dense), dense, s


def left(p):
    """Density and speed of sound of the gas that comes from the left."""
    rho = LEFT[0] * (p / LEFT[2]) ** (1 / G)
    return rho, np.sqrt(G * p / rho)


def chebyshev(n):
    """Points from 0 to 1, weights to interpolate between them, matrix of the derivative."""
    k = np.arange(n + 1)
    at = (1 - np.cos(np.pi * k / n)) / 2
    w = np.where(k % n == 0, 0.5, 1.0) * (-1.0) ** k
    D = w / w[:, None] / (at[:, None] - at + np.eye(n + 1))
    return at, w, D - np.diag(D.sum(1))


def between(at, w, f, new):
    """The polynomials through the rows f at other points."""
    d = np.subtract.outer(new, at)
    q = w / np.where(d == 0, 1e-200, d)
    return f @ (q / q.sum(1)[:, None]).T


def motion(log_t, y, at, D):
    """d/d(log t) of p, u, K = p/rho^G of the gas that began at X = -4 + at (x_s + 4), and of the
    places x_c of the contact (at = 0) and x_s of the shock (at = 1).
    """
    p, u, K = f = y[:-2].reshape(3, -1)
    rho, L, a = (p / K) ** (1 / G), y[-1] + 4, (G - 1) / (G + 1)
    Z, (r, slope) = np.sqrt(G * p * rho), ahead(y[-1])
    U, _, s = shocked(p[-1], r)
    fX = f @ D.T / L
    rate = at * s * fX
    rate[:2] -= [Z * Z * fX[1], fX[0]] / ahead(at * L - 4)[0]
    # at the shock: what comes along u + c, and u = U(p, r), K = p / dense^G
    kept, r_t = rate[1, -1] + rate[0, -1] / Z[-1], slope * s
    U_p = U * (1 / (p[-1] - 1) - 0.5 * (G + 1) / ((G + 1) * p[-1] + G - 1))
    p_t = (kept + U / (2 * r) * r_t) / (U_p + 1 / Z[-1])
    grown = p_t * (1 / (p[-1] + a) - a / (a * p[-1] + 1)) + r_t / r
    rate[:, -1] = p_t, kept - p_t / Z[-1], K[-1] * (p_t / p[-1] - G * grown)
    # at the contact: what comes along u - c; the gas beyond keeps u + 2 c/(G - 1) and K
    kept, of_left = rate[1, 0] - rate[0, 0] / Z[0], np.prod(left(p[0]))
    p_t = -kept / (1 / Z[0] + 1 / of_left)
    rate[:, 0] = p_t, -p_t / of_left, 0
    return np.exp(log_t) * np.append(rate, [u[0], s])


def shu_osher(x, points=(32, 80, 200), times=(1e-13, 0.05, 0.4, 1.8)):
    """rho at x between contact and shock, and where these are."""
    c, r = left(LEFT[2])[1], ahead(-4.0)[0]

    def apart(p):
        """Speed behind the fan less that behind the shock."""
        return LEFT[1] + 2 / (G - 1) * (c - left(p)[1]) - shocked(p, r)[0]

    p = brentq(apart, 1, LEFT[2], xtol=1e-15)
    u, dense, s = shocked(p, r)
    old, w, f = [0.0], [1.0], np.array([[p], [u], [p / dense**G]])
    ends = np.array([u, s]) * times[0] - 4
    for n, begin, end in zip(points, times, times[1:]):
        at, new_w, D = chebyshev(n)
        y = np.append(between(old, w, f, at), ends)
        span = np.log([begin, end])
        given = {"args": (at, D), "rtol": 1e-11, "atol": 1e-13}
        with np.errstate(invalid="ignore"):  # where a step is tried that is too long
            y = solve_ivp(motion, span, y, "DOP853", **given).y[:, -1]
        old, w, f, ends = at, new_w, y[:-2].reshape(3, -1), y[-2:]
    rho, L = (f[0] / f[2]) ** (1 / G), ends[1] + 4
    slopes = np.append(0.0, (L * ahead(at * L - 4)[0] / rho)[1:])
    D[0] = np.eye(1, n + 1)
    place = ends[0] + np.linalg.solve(D, slopes)

    def beside(z, x):
        """How far the place of z is from x."""
        return between(at, w, place, np.array([z]))[0] - x

    z = np.array([brentq(beside, 0, 1, (v,), xtol=1e-15) for v in x])
    return between(at, w, rho, z), *ends


def columns():
    """Head -> numbers."""
    r, u, rho, p = vortex(201)
    X = np.linspace(-0.5, 0.5, 401)
    tube = sod(X, 0.2)
    x = np.arange(30, 96) / 40  # from the contact, 0.7299, to the shock, 2.3961
    rows = len(X)
    short = dict(zip(("r", "vortex u", "vortex rho", "vortex p"), (r, u, rho, p)))
    short |= {"X": X, **dict(zip(("sod rho", "sod u", "sod p"), tube))}
    short |= {"x": x, "shu_osher rho": shu_osher(x)[0]}
    return {name: np.append(v, np.full(rows - len(v), np.nan)) for name, v in short.items()}


if __name__ == "__main__":
    from csv_file import save

    save(
        "gas",
        columns(),
        "made by verify/gas.py; gamma = 1.4, no dimensions; columns that end in nan are shorter",
        "vortex: at the radius r; sod: at t = 0.2, X beside the diaphragm",
        "shu_osher rho at x: t = 1.8, between the contact at 0.729853512 and the shock at "
        "2.396141891; 240 instead of 200 functions change it by 3e-12",
    )
