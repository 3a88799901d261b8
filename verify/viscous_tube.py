"""Viscous shock tube, Re = 200, in the lower half of the box: finite volumes of equal squares.

WENO of fifth order (G.-S. Jiang, C.-W. Shu 1996) of rho, u, v, p at faces, Rusanov's flux, viscous
stress and heat flux of second order, RK3. Walls and the plane of symmetry by mirrored cells.
"""

import numpy as np

G, PR, MU = 1.4, 0.73, 1 / 200


def weno(a, b, c, d, e):
    """Of fifth order, at the face between c and d."""
    x = 13 / 12 * (a - 2 * b + c) ** 2 + (a - 4 * b + 3 * c) ** 2 / 4
    y = 13 / 12 * (b - 2 * c + d) ** 2 + (b - d) ** 2 / 4
    z = 13 / 12 * (c - 2 * d + e) ** 2 + (3 * c - 4 * d + e) ** 2 / 4
    x, y, z = 0.1 / (1e-6 + x) ** 2, 0.6 / (1e-6 + y) ** 2, 0.3 / (1e-6 + z) ** 2
    at = x * (2 * a - 7 * b + 11 * c) + y * (-b + 5 * c + 2 * d) + z * (2 * c + 5 * d - e)
    return at / 6 / (x + y + z)


def euler(rho, u, v, p):
    """What is conserved, its flux along x, and the speed of the fastest wave."""
    energy = p / (G - 1) + rho * (u * u + v * v) / 2
    U, flux = (rho, rho * u, rho * v, energy), (rho * u, rho * u * u + p, rho * v * u)
    return np.array(U), np.array([*flux, (energy + p) * u]), abs(u) + np.sqrt(G * p / rho)


def through(q, h):
    """Fluxes (4, n + 1, m) of rho, rho u, rho v, e through the faces across x, from what cells have
    (5, n + 6, m + 6), mirrored cells too.
    """
    n, m = q.shape[1] - 6, q.shape[2] - 6

    def cells(k, beside=0):
        """Those behind the faces, k on along x and some beside them along y."""
        return q[:, 2 + k : 3 + k + n, 3 + beside : 3 + beside + m]

    near = [cells(k)[:4] for k in range(-2, 4)]
    (U, f, fast), (V, g, faster) = euler(*weno(*near[:5])), euler(*weno(*near[:0:-1]))
    x = (cells(1) - cells(0)) / h
    y = (cells(0, 1) + cells(1, 1) - cells(0, -1) - cells(1, -1)) / (4 * h)
    div = 2 / 3 * (x[1] + y[2])
    tx, ty, (_, u, v, *_) = 2 * x[1] - div, y[1] + x[2], (cells(0) + cells(1)) / 2
    work = u * tx + v * ty + G / (PR * (G - 1)) * x[4]
    viscous = MU * np.array([0 * tx, tx, ty, work])
    return (f + g - np.maximum(fast, faster) * (V - U)) / 2 - viscous


def rates(w, h):
    """d/dt of (rho, rho u, rho v, e) in cells, and the largest speed over h and diffusivity."""
    n, m = w.shape[1:]
    i, j = np.arange(-3, n + 3), np.arange(-3, m + 3)
    I, J = (np.where(k < 0, -k - 1, np.where(k < N, k, 2 * N - 1 - k)) for k, N in ((i, n), (j, m)))
    rho, u, v = w[0], w[1] / w[0], w[2] / w[0]
    p = (G - 1) * (w[3] - rho * (u * u + v * v) / 2)
    fast = (abs(u) + abs(v) + 2 * np.sqrt(G * p / rho)) / h
    stiff = max(fast.max(), (5 * G * MU / (PR * rho * h * h)).max())
    q = np.array([rho, u, v, p, p / rho])[:, I][:, :, J]
    wall = (i < 0)[:, None] | (i >= n)[:, None] | (j < 0)
    q[1] *= np.where(wall, -1.0, 1.0)
    q[2] *= np.where(wall | (j >= m), -1.0, 1.0)
    swapped = q[[0, 2, 1, 3, 4]].swapaxes(1, 2)  # y is x there, and v is u
    along_y = through(swapped, h)[[0, 2, 1, 3]].swapaxes(1, 2)
    return -(np.diff(through(q, h), axis=1) + np.diff(along_y, axis=2)) / h, stiff


def solve(n):
    """(rho, rho u, rho v, e) of n * n/2 cells."""
    w, t = np.zeros((4, n, n // 2)), 0.0
    w[0] = np.where(np.arange(n) < n // 2, 120, 1.2)[:, None]
    w[3] = w[0] / G / (G - 1)
    while t < 1.0:
        f, stiff = rates(w, 1 / n)
        dt = min(0.8 / stiff, 1.0 - t)
        a = w + dt * f
        b = 0.75 * w + 0.25 * (a + dt * rates(a, 1 / n)[0])
        w, t = w / 3 + 2 / 3 * (b + dt * rates(b, 1 / n)[0]), t + dt
    return w


def columns(n=250):
    """Head -> numbers: density of the gas at the wall, at every 1/50 of it."""
    w = solve(n)
    wall = (9 * w[0, :, 0] - w[0, :, 1]) / 8  # even in y
    x = np.arange(51) / 50
    centres = np.concatenate([[-0.5 / n], (np.arange(n) + 0.5) / n, [1 + 0.5 / n]])
    return {"x": x, "rho": np.interp(x, centres, np.pad(wall, 1, "edge"))}


if __name__ == "__main__":
    from csv_file import save

    save(
        "viscous_tube",
        columns(),
        "t = 1, Re = 200, half box 1 x 1/2",
        "rho at the wall y = 0: made by verify/viscous_tube.py, 250 x 125 cells,",
        "not converged: on 125 x 62 rho differs by 8 %",
    )
