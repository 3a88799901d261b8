"""Normal modes of a gas at rest over an elastic layer, by Chebyshev collocation: an eigenvalue
problem across the layers.

Disturbances of a gas of density rho, temperature T and pressure p between y = 0 and a rigid
adiabatic wall at y = height, and displacements (x, y) of a solid between a clamped end at
y = -depth and 0, all times exp(i k X + s t):

    s rho'       = -rho (i k u + v_y)                          m0 s (U, V) = Div sigma(x, y)
    rho s (u, v) = -grad p' + Div tau                          s (x, y)    = (U, V)
    rho cv s T'  = -p (i k u + v_y) + kappa (T'_yy - k^2 T'),  p' = R (rho T' + T rho')

with Hooke's law in plane strain. At y = 0 velocities and tractions are one and no heat passes;
where mu = 0 the gas slips, and only what is normal is one. The pressure at rest drops out, as the
solid is free of strain under it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from fsipetsc import Fluid, InputError
from fsipetsc.checks import Array
from fsipetsc.materials.solid import ElasticSolid

#: points of the collocation in either layer
POINTS = 36
#: eigenvalues larger than this times k c are those of the collocation itself; modes change less
#: than this with more points
LARGE, RESOLVED = 200.0, 1e-7
GAS, SOLID = ("rho", "u", "v", "T"), ("x", "y", "U", "V")


def chebyshev(n: int, low: float, high: float) -> tuple[Array, Array]:
    """(points from high to low, matrix of the derivative), n points (Trefethen, Spectral Methods in
    MATLAB, ch. 6)."""
    angles = np.pi * np.arange(n) / (n - 1)
    x = np.cos(angles)
    c = np.where((np.arange(n) % (n - 1)) == 0, 2.0, 1.0) * (-1.0) ** np.arange(n)
    gaps = x[:, None] - x[None, :] + np.eye(n)
    D = np.outer(c, 1 / c) / gaps
    D -= np.diag(D.sum(axis=1))
    return low + (x + 1) / 2 * (high - low), D * 2 / (high - low)


def interpolated(values: Array, low: float, high: float, y: Array) -> Array:
    """The polynomial through values at the points of ``chebyshev``, at y (barycentric formula)."""
    n = len(values)
    points = chebyshev(n, low, high)[0]
    weights = (-1.0) ** np.arange(n)
    weights[[0, -1]] /= 2
    gaps = np.asarray(y)[..., None] - points
    exact = gaps == 0
    terms = weights / np.where(exact, 1.0, gaps)
    terms = np.where(exact.any(axis=-1, keepdims=True), exact.astype(float), terms)
    return (terms * values).sum(axis=-1) / terms.sum(axis=-1)


@dataclass(frozen=True)
class Mode:
    """s [1/s], and across the layers the amplitudes of (rho, u, v, T) and of (x, y, U, V)."""

    s: complex
    gas: Array
    solid: Array


@dataclass(frozen=True)
class Layers:
    """What has the modes: a gas of density rho and temperature T [SI], height high, over a solid of
    this depth."""

    gas: Fluid
    solid: ElasticSolid
    height: float
    depth: float
    rho: float = 1.0
    T: float = 1.0

    def mode(self, k: float) -> Mode:
        """The slowest mode that swings more than it decays, its interface displaced by 1, where
        that is largest. InputError where the collocation resolves none."""
        finer = np.array([mode.s for mode in self._modes(k, POINTS * 4 // 3)])
        for mode in self._modes(k, POINTS):
            if np.min(np.abs(mode.s - finer)) < RESOLVED * abs(mode.s):
                return mode
        raise InputError("no normal mode of the layers is resolved")

    def _modes(self, k: float, n: int) -> list[Mode]:
        values, vectors = eig(*self._matrices(k, n))
        c = np.sqrt(self.gas.gamma * self.gas.R * self.T)
        found = []
        for i in np.argsort(values.imag):
            s, parts = complex(values[i]), vectors[:, i].reshape(8, n)
            swings = s.imag > max(abs(s.real), 1e-6 * k * c)
            if np.isfinite(s) and abs(s) < LARGE * k * c and swings:
                ends = parts[4:6, 0]
                parts = parts / ends[np.argmax(np.abs(ends))]
                found.append(Mode(s, parts[:4], parts[4:]))
        return found

    def _matrices(self, k: float, n: int) -> tuple[Array, Array]:
        """A z = s B z, z the four unknowns of the gas and the four of the solid, each at n points
        from above."""
        (_, D), (_, E) = chebyshev(n, 0.0, self.height), chebyshev(n, -self.depth, 0.0)
        gas, rho, T = self.gas, self.rho, self.T
        A, B = np.zeros((8, n, 8, n), complex), np.zeros((8, n, 8, n))
        one, ik, D2, E2 = np.eye(n), 1j * k, D @ D, E @ E
        mu, kappa, p = gas.mu, gas.kappa, rho * gas.R * T
        pressure = {0: gas.R * T, 3: gas.R * rho}
        for c, weight in ((0, 1.0), (1, rho), (2, rho), (3, rho * gas.R / (gas.gamma - 1.0))):
            B[c, :, c] = weight * one
        A[0, :, 1], A[0, :, 2] = -rho * ik * one, -rho * D
        A[3, :, 1], A[3, :, 2], A[3, :, 3] = -p * ik * one, -p * D, kappa * (D2 - k * k * one)
        for c, part in pressure.items():
            A[1, :, c], A[2, :, c] = -part * ik * one, -part * D
        A[1, :, 1], A[1, :, 2] = mu * (D2 - 4 / 3 * k * k * one), mu / 3 * ik * D
        A[2, :, 1], A[2, :, 2] = mu / 3 * ik * D, mu * (4 / 3 * D2 - k * k * one)
        m, lam, K = self.solid.mu_e, self.solid.lambda_e, self.solid.K
        for c in (4, 5):
            A[c, :, c + 2], B[c, :, c], B[c + 2, :, c + 2] = one, one, self.solid.m0 * one
        A[6, :, 4], A[6, :, 5] = m * E2 - K * k * k * one, (lam + m) * ik * E
        A[7, :, 4], A[7, :, 5] = (lam + m) * ik * E, K * E2 - m * k * k * one

        def condition(c: int, i: int, *terms: tuple[int, Array]) -> None:
            A[c, i], B[c, i] = 0.0, 0.0
            for which, row in terms:
                A[c, i, which] += row

        first, last = one[0], one[-1]
        condition(2, 0, (2, first))
        condition(2, -1, (2, last), (7, -first))
        condition(6, -1, (6, last))
        condition(7, -1, (7, last))
        normal = [(c, part * last) for c, part in pressure.items()]
        normal += [(2, -4 / 3 * mu * D[-1]), (1, 2 / 3 * mu * ik * last)]
        condition(7, 0, (5, K * E[0]), (4, lam * ik * first), *normal)
        shear = [(1, -mu * D[-1]), (2, -mu * ik * last)]
        condition(6, 0, (4, m * E[0]), (5, m * ik * first), *shear)
        if mu > 0:
            condition(1, 0, (1, first))
            condition(1, -1, (1, last), (6, -first))
        if kappa > 0:
            condition(3, 0, (3, D[0]))
            condition(3, -1, (3, D[-1]))
        return A.reshape(8 * n, 8 * n), B.reshape(8 * n, 8 * n)
