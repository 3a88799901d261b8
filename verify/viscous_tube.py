"""Viscous shock tube, Re = 200, in the lower half of the box: finite volumes of equal squares.

WENO of fifth order (G.-S. Jiang, C.-W. Shu 1996) of rho, u, v, p at faces, Rusanov's flux, viscous
stress and heat flux of second order, RK3. Walls and the plane of symmetry by mirrored cells.
"""

import numpy as np
from numba import njit

G, PR, MU = 1.4, 0.73, 1 / 200


@njit(fastmath=True)
def weno(a, b, c, d, e):
    """Of fifth order, at the face between c and d."""
    x = 13 / 12 * (a - 2 * b + c) ** 2 + (a - 4 * b + 3 * c) ** 2 / 4
    y = 13 / 12 * (b - 2 * c + d) ** 2 + (b - d) ** 2 / 4
    z = 13 / 12 * (c - 2 * d + e) ** 2 + (3 * c - 4 * d + e) ** 2 / 4
    x, y, z = 0.1 / (1e-6 + x) ** 2, 0.6 / (1e-6 + y) ** 2, 0.3 / (1e-6 + z) ** 2
    at = x * (2 * a - 7 * b + 11 * c) + y * (-b + 5 * c + 2 * d) + z * (2 * c + 5 * d - e)
    return at / 6 / (x + y + z)


@njit(fastmath=True)
def both(q, i, j, di, dj):
    """q on both sides of the face between node (i, j) and the next one along x (di) or y (dj)."""
    a, b, c = q[i - 2 * di, j - 2 * dj], q[i - di, j - dj], q[i, j]
    d, e, f = q[i + di, j + dj], q[i + 2 * di, j + 2 * dj], q[i + 3 * di, j + 3 * dj]
    return weno(a, b, c, d, e), weno(f, e, d, c, b)


@njit(fastmath=True)
def euler(rho, u, v, p, di, dj):
    """What is conserved, its flux along x or y, and the speed of the fastest wave."""
    n, energy = u * di + v * dj, p / (G - 1) + rho * (u * u + v * v) / 2
    flux = rho * n, rho * u * n + p * di, rho * v * n + p * dj, (energy + p) * n
    return (rho, rho * u, rho * v, energy), flux, abs(n) + np.sqrt(G * p / rho)


@njit(fastmath=True)
def slope(q, i, j, di, dj, h):
    """(d/dx, d/dy) of q at the face."""
    along = (q[i + di, j + dj] - q[i, j]) / h
    across = q[i + dj, j + di] + q[i + 1, j + 1] - q[i - dj, j - di] - q[i + di - dj, j + dj - di]
    return (along, across / (4 * h)) if di else (across / (4 * h), along)


@njit(fastmath=True)
def through(q, i, j, di, dj, h):
    """Fluxes of rho, rho u, rho v, e between cell (i, j) and the next one along x (di) or y."""
    (r, R), (u, U) = both(q[0], i, j, di, dj), both(q[1], i, j, di, dj)
    (v, V), (p, P) = both(q[2], i, j, di, dj), both(q[3], i, j, di, dj)
    w, f, a = euler(r, u, v, p, di, dj)
    W, F, b = euler(R, U, V, P, di, dj)
    (ux, uy), (vx, vy) = slope(q[1], i, j, di, dj, h), slope(q[2], i, j, di, dj, h)
    Tx, Ty = slope(q[4], i, j, di, dj, h)
    div = 2 / 3 * (ux + vy)
    tx, ty, heat = (2 * ux - div, uy + vx, Tx) if di else (uy + vx, 2 * vy - div, Ty)
    u, v = 0.5 * (q[1, i, j] + q[1, i + di, j + dj]), 0.5 * (q[2, i, j] + q[2, i + di, j + dj])
    work, c = u * tx + v * ty + G / (PR * (G - 1)) * heat, max(a, b)
    return (
        0.5 * (f[0] + F[0] - c * (W[0] - w[0])),
        0.5 * (f[1] + F[1] - c * (W[1] - w[1])) - MU * tx,
        0.5 * (f[2] + F[2] - c * (W[2] - w[2])) - MU * ty,
        0.5 * (f[3] + F[3] - c * (W[3] - w[3])) - MU * work,
    )


@njit(fastmath=True)
def rates(w, h):
    """d/dt of (rho, rho u, rho v, e) in cells, and the largest speed over h and diffusivity."""
    n, m = w.shape[1:]
    q, f, stiff = np.empty((5, n + 6, m + 6)), np.zeros(w.shape), 0.0  # rho, u, v, p, p/rho
    for i in range(-3, n + 3):
        for j in range(-3, m + 3):
            I, J = min(max(i, -i - 1), n - 1), min(max(j, -j - 1), m - 1)
            I, J = min(I, 2 * n - 1 - i), min(J, 2 * m - 1 - j)
            rho, u, v = w[0, I, J], w[1, I, J] / w[0, I, J], w[2, I, J] / w[0, I, J]
            p = (G - 1) * (w[3, I, J] - rho * (u * u + v * v) / 2)
            stiff = max(stiff, (abs(u) + abs(v) + 2 * np.sqrt(G * p / rho)) / h)
            stiff = max(stiff, 5 * G * MU / (PR * rho * h * h))
            inside, wall = j < m, i < 0 or i >= n or j < 0
            sign, turned = -1.0 if wall else 1.0, -1.0 if wall or not inside else 1.0
            q[0, i + 3, j + 3], q[3, i + 3, j + 3], q[4, i + 3, j + 3] = rho, p, p / rho
            q[1, i + 3, j + 3], q[2, i + 3, j + 3] = sign * u, turned * v
    for i in range(n + 1):
        for j in range(m + 1):
            for di, dj in ((1, 0), (0, 1)):
                if (di and j == m) or (dj and i == n):
                    continue
                flux = through(q, i + 3 - di, j + 3 - dj, di, dj, h)
                for k in range(4):
                    if i >= di and j >= dj:
                        f[k, i - di, j - dj] -= flux[k] / h
                    if i < n and j < m:
                        f[k, i, j] += flux[k] / h
    return f, stiff


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
