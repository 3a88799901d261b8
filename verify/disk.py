"""A St. Venant-Kirchhoff disk that spins in gas, reduced to the radius: a spectral Galerkin method.

The disk's point at radius R and angle Q is at z(R, t) exp(i Q), z = phi exp(i theta). With
a = z_R and b = i z/R, the columns of F, the action is that of

    int (m0/2 |z_t|^2 - W(a, b)) R dR
        + int (rho0/2 x_t^2 - p0/(gamma - 1) (x x_X/X)^(1 - gamma)) X dX,
    W = lambda/2 tr(E)^2 + mu |E|^2 - p_ref (J - 1),   E = (F^T F - 1)/2,   J = Im(conj(a) b),

x(X, t) the radius of the gas, which has no viscosity, does not turn, and touches the disk:
x(1) = |z(1)|, x(2.2) = 2.2. z = R sum c_k P_k(2 R^2 - 1), x by Lagrange's polynomials on the nodes
of Gauss and Lobatto; time by DOP853. The disk's angular velocity is at first spin (1 - R^2)^power.
With power 0, the rigid spin, the edge is not in balance at t = 0, weak waves with kinks run
from it, and the method converges slowly; with power 4 they are far weaker.
"""

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp

MU, LAMBDA, P, GAMMA, VESSEL = 1.0, 1.5, 1.0, 1.4, 2.2


class Disk:
    """n functions in the disk, m nodes in the gas."""

    def __init__(self, density: float, spin: float, power: int, n: int, m: int) -> None:
        self.n, self.m, self.density = n, m, density
        y, w = legendre.leggauss(2 * n + 8)
        s = (y + 1) / 2
        self.R, self.w = np.sqrt(s), w / 4  # R dR = ds/2
        eye = np.eye(n)
        f = np.array([legendre.legval(y, e) for e in eye])
        df = np.array(
            [legendre.legval(y, legendre.legder(e)) if k else 0 * y for k, e in enumerate(eye)]
        )
        self.over = f  # of w/R
        self.slope = f + 4 * s * df  # of w_R, d/dR = 4 R d/dy
        self.mass = density * (f * self.w * s) @ f.T
        self.edge = np.ones(n)  # P_k(1)
        # Gauss-Lobatto
        c = np.zeros(m)
        c[-1] = 1
        inner = legendre.legroots(legendre.legder(c))
        q = np.concatenate([[-1], inner, [1]])
        weights = 2 / (m * (m - 1) * legendre.legval(q, c) ** 2)
        half = (VESSEL - 1) / 2
        self.X = 1 + (q + 1) * half
        gap = q[:, None] - q + np.eye(m)
        order = np.prod(gap, axis=1)
        D = order[:, None] / order[None, :] / gap
        np.fill_diagonal(D, 0)
        D -= np.diag(D.sum(axis=1))
        self.D, self.gw = D / half, weights * half * self.X
        rate = spin * (1 - s) ** power
        v = np.linalg.solve((f * self.w) @ f.T, (f * self.w) @ (1j * rate))
        x = self.X.copy()
        self.start = self.pack(eye[0].astype(complex), v, x[1:-1], 0 * x[1:-1])

    @staticmethod
    def pack(*parts) -> np.ndarray:
        c, v, x, u = parts
        return np.concatenate([c.real, c.imag, v.real, v.imag, x, u])

    def parts(self, y):
        n, m = self.n, self.m - 2
        c, v = y[:n] + 1j * y[n : 2 * n], y[2 * n : 3 * n] + 1j * y[3 * n : 4 * n]
        return c, v, y[4 * n : 4 * n + m], y[4 * n + m :]

    def rate(self, t, y):
        c, v, inner, u = self.parts(y)
        a, b = c @ self.slope, 1j * (c @ self.over)
        e1, e2, e12 = (abs(a) ** 2 - 1) / 2, (abs(b) ** 2 - 1) / 2, (a.conj() * b).real / 2
        trace = LAMBDA * (e1 + e2)
        Pa = a * (trace + 2 * MU * e1) + b * 2 * MU * e12 + 1j * P * b
        Pb = b * (trace + 2 * MU * e2) + a * 2 * MU * e12 - 1j * P * a
        force = -(self.slope * self.w) @ Pa - (self.over * self.w) @ (-1j * Pb)
        z, vz = c.sum(), v.sum()
        n, r = z / abs(z), abs(z)
        x = np.concatenate([[r], inner, [VESSEL]])
        x_X = self.D @ x
        p = P * (x * x_X / self.X) ** -GAMMA
        push = self.gw * p * x_X / self.X + self.D.T @ (self.gw * p * x / self.X)  # -dV/dx
        turning = (vz * np.conj(n)).imag ** 2 / r
        right = force + self.edge * n * (push[0] - self.gw[0] * turning)
        free, by = np.linalg.solve(self.mass, right), np.linalg.solve(self.mass, self.edge)
        gain = self.gw[0] * by.sum()
        along = (free.sum() * np.conj(n)).real
        acc = free - by * n * self.gw[0] * along / (1 + gain)
        return self.pack(v, acc, u, push[1:-1] / self.gw[1:-1])

    def energy(self, y):
        c, v, inner, u = self.parts(y)
        a, b = c @ self.slope, 1j * (c @ self.over)
        e1, e2, e12 = (abs(a) ** 2 - 1) / 2, (abs(b) ** 2 - 1) / 2, (a.conj() * b).real / 2
        W = (
            LAMBDA / 2 * (e1 + e2) ** 2
            + MU * (e1**2 + e2**2 + 2 * e12**2)
            - P * ((a.conj() * b).imag - 1)
        )
        z, vz = c.sum(), v.sum()
        x = np.concatenate([[abs(z)], inner, [VESSEL]])
        ux = np.concatenate([[(vz * np.conj(z / abs(z))).real], u, [0]])
        kinetic = 0.5 * (v.conj() @ self.mass @ v).real + 0.5 * self.gw @ ux**2
        return (
            kinetic
            + self.w @ W
            + P / (GAMMA - 1) * self.gw @ (x * (self.D @ x) / self.X) ** (1 - GAMMA)
        )

    def at(self, y, R, X):
        """z/R and z_t/R at R, real and imaginary parts; x, p at X."""
        c, v, inner, _ = self.parts(y)
        f = np.array([legendre.legval(2 * np.square(R) - 1, e) for e in np.eye(self.n)])
        x = np.concatenate([[abs(c.sum())], inner, [VESSEL]])
        p = P * (x * (self.D @ x) / self.X) ** -GAMMA
        ones = [[X - b for b in self.X if b != a] for a in self.X]
        scale = [[a - b for b in self.X if b != a] for a in self.X]
        to = np.array([np.prod(np.array(one).T / w, axis=1) for one, w in zip(ones, scale)]).T
        z, vz = c @ f, v @ f
        return z.real, z.imag, vz.real, vz.imag, to @ x, to @ p


def solve(density, spin=0.8, power=4, t=0.5, n=24, m=24, rtol=1e-13):
    disk = Disk(density, spin, power, n, m)
    found = solve_ivp(disk.rate, (0, t), disk.start, method="DOP853", rtol=rtol, atol=1e-14)
    y = found.y[:, -1]
    return disk, y, disk.energy(y) - disk.energy(disk.start)


SPIN, POWER, END, DENSITIES = 2.0, 4, 0.5, (0.5, 2.0, 20.0)


def columns(
    n: int = 48, m: int = 36, points: int = 101, densities=DENSITIES
) -> dict[str, np.ndarray]:
    """Of the CSV file: of each density the disk at R, the gas at X."""
    R, X = np.linspace(0, 1, points), np.linspace(1, VESSEL, points)
    made = {"R": R, "X": X}
    for density in densities:
        disk, y, _ = solve(density, SPIN, POWER, END, n, m)
        for name, values in zip(("real", "imag", "v_real", "v_imag", "x", "p"), disk.at(y, R, X)):
            made[f"{name} {density:g}"] = values
    return made


if __name__ == "__main__":
    from csv_file import save

    save(
        "spinning_disk",
        columns(),
        "Spinning disk, made by verify/disk.py at t = 0.5; "
        "the number in a name: density of the disk",
        "disk: the point R at angle Q is at (real + i imag) R exp(i Q), "
        "its velocity (v_real + i v_imag) R exp(i Q)",
        "gas: the point that was at X is at x, under the pressure p",
        "with (36, 30) functions instead of (48, 36) they change by up to 7e-7 (real, imag), "
        "2e-5 (velocities), 1e-5 (p)",
    )
